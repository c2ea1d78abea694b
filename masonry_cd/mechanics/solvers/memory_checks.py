"""What solvers remember from step to step, checked when it comes from a checkpoint.

The symbolic factor tells compiled kernels where to write. It follows from the pairs of bodies that touch, so it is made again from these,
and has to be the same to the last entry.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.arrays import Stored
from masonry_cd.mechanics.linalg.ordering import FIELDS, Pattern
from masonry_cd.mechanics.linalg.small_blocks import NARROW, STEP
from masonry_cd.mechanics.solvers.admm import NAMES
from masonry_cd.mechanics.solvers.condensed import KEPT, UNKNOWNS

TALLIES = {"admm_tally": 8, "auto_tally": 14}  # numbers in each
COUNTS = {"admm_tally": (1, 3), "auto_tally": (2, 3, 8, 10, 11, 13)}  # those of them that are whole numbers or flags
POSITIVE = {"admm_tally": (0, 5), "auto_tally": ()}  # and those that a matrix is scaled by


def check_memory(stored: Stored, bodies: int, unknowns: int) -> None:
    """Check the memory of one group of blocks; arrays of other solvers than those here are theirs to check.

    Args:
        stored: the arrays, by the names that solvers give them.
        bodies: most there may be in the group.
        unknowns: n of each.

    Raises:
        InputError: one that is not what a solver leaves.
    """
    if stored.holds(KEPT):
        stored.flags(KEPT, None)
    if stored.holds(UNKNOWNS):
        unknowns = int(stored.whole(UNKNOWNS, 1, low=1, high=max(unknowns, NARROW) + STEP + 1)[0])
    for name in TALLIES:
        if stored.holds(name):
            _check_tally(stored, name)
    if any(stored.holds(name) for name in NAMES if name not in TALLIES):
        _check_factors(stored, bodies, unknowns)


def _check_tally(stored: Stored, name: str) -> None:
    """Numbers that were learnt; those not known yet are not finite."""
    tally = stored.real(name, TALLIES[name], finite=False)
    counts, scales = tally[list(COUNTS[name])], tally[list(POSITIVE[name])]
    if not ((np.abs(counts) < 2**53) & (counts == np.floor(counts))).all() or not ((scales > 0) & np.isfinite(scales)).all():
        stored.refuse(name, "out of range")


def _check_factors(stored: Stored, bodies: int, unknowns: int) -> None:
    """The pattern and the factors of ADMM; their values are made anew where they are not of the contacts of the step."""
    nodes = len(stored.whole("admm_order", None, high=bodies))
    pairs = stored.whole("admm_pairs", None, high=nodes * nodes)
    if (np.diff(pairs) <= 0).any() or (pairs // max(nodes, 1) >= pairs % max(nodes, 1)).any():
        stored.refuse("admm_pairs", "not in order")
    pattern = Pattern.of(nodes, pairs // max(nodes, 1), pairs % max(nodes, 1))
    for name, own in zip(FIELDS, pattern.arrays(), strict=True):
        if not np.array_equal(stored.whole(f"admm_{name}", *own.shape, low=-1), own):
            stored.refuse(f"admm_{name}", "not that of the contacts")
    contacts = len(stored.whole("admm_bodies", None, 2, low=-1, high=nodes))
    for name, starts in (("admm_squares", pattern.symbolic.square), ("admm_panels", pattern.symbolic.panel)):
        stored.real(name, unknowns * unknowns * int(starts[-1]), finite=False, kind=np.float32)
    stored.real("admm_rho", contacts, finite=False)
