# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the solvers' memory from step to step when it comes from a checkpoint.

The symbolic factor tells compiled kernels where to write. It follows from the pairs of bodies that touch, so it is rebuilt from these,
and has to be the same to the last entry.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.arrays import Stored
from masonry_cd.mechanics.friction.solver_state import LEARNT, NUMBERS, OWN
from masonry_cd.mechanics.linalg.ordering import FIELDS, Pattern
from masonry_cd.mechanics.linalg.small_blocks import STEP
from masonry_cd.mechanics.solvers.options import MOST_ITERATIONS

MOST = {"stale": 1.0, "steps": 2.0**53, "budget": float(MOST_ITERATIONS)}  # of what was learnt; other numbers may be any
WHOLE = ("stale", "steps", "budget")


def check_memory(stored: Stored, bodies: int, unknowns: int) -> None:
    """Check the memory of one group of blocks; the arrays of solvers from elsewhere are theirs to check.

    Args:
        stored: the arrays of a :class:`masonry_cd.mechanics.friction.solver_state.SolverState`, by their names.
        bodies: most there may be in the group.
        unknowns: n of each.

    Raises:
        InputError: one that is not what a solver leaves.
    """
    if stored.holds("kept"):
        stored.flags("kept", None)
        unknowns = int(stored.whole("unknowns", 1, low=1, high=unknowns + STEP)[0])
    for name in LEARNT:
        _check_learnt(stored, name)
    if any(stored.holds(name) for name in (*FIELDS, *NUMBERS)):
        _check_factors(stored, bodies, unknowns)
    for name in stored.names():
        if not name.startswith(OWN):
            stored.refuse(name, "unknown")


def _check_learnt(stored: Stored, name: str) -> None:
    """A number that was learnt: not negative, where it counts something a whole one, and a stiffness more than zero."""
    number = float(stored.real(name, 1)[0])
    if not 0.0 <= number <= MOST.get(name, np.inf) or (name in WHOLE and number != int(number)) or (name == "k" and number == 0.0):
        stored.refuse(name, "out of range")


def _check_factors(stored: Stored, bodies: int, unknowns: int) -> None:
    """The pattern and the factors of ADMM; their values are recomputed where they do not belong to the contacts of the step."""
    nodes = len(stored.whole("order", None, high=bodies))
    pairs = stored.whole("pairs", None, high=nodes * nodes)
    if (np.diff(pairs) <= 0).any() or (pairs // max(nodes, 1) >= pairs % max(nodes, 1)).any():
        stored.refuse("pairs", "not in order")
    pattern = Pattern.of(nodes, pairs // max(nodes, 1), pairs % max(nodes, 1))
    for name, own in zip(FIELDS, pattern.arrays(), strict=True):
        if not np.array_equal(stored.whole(name, *own.shape, low=-1), own):
            stored.refuse(name, "not that of the contacts")
    contacts = len(stored.whole("bodies", None, 2, low=-1, high=nodes))
    for name, starts in (("squares", pattern.symbolic.square), ("panels", pattern.symbolic.panel)):
        stored.real(name, unknowns * unknowns * int(starts[-1]), finite=False, kind=np.float32)
    stored.real("rho", contacts, finite=False)
