# SPDX-License-Identifier: GPL-3.0-or-later
"""What the threads of an ADMM solve share: the problem in the order of the subtrees, the iterates and the factor; see admm.py."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.friction.coupling import in_places
from masonry_cd.mechanics.friction.operators import ProblemArrays
from masonry_cd.mechanics.linalg.factor import BlockFactor
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.linalg.vectors import LANES
from masonry_cd.mechanics.solvers.contact_groups import ContactGroups


class AdmmSettings(NamedTuple):
    """How a solve begins and ends."""

    k: float  # R = diag(k / d)
    shares: tuple[float, float]  # of it for contacts that are open, and that slide, where much slides
    fresh: bool  # whether to factorise at the start; otherwise the factor at hand is used as it is
    moving: bool  # whether to start from given velocities where the impulses fit worse than none would
    rate: float  # error over the change of p, as measured last, or 1
    tolerance: float  # natural map error
    limit: int  # iterations


class Iterates(NamedTuple):
    """Impulses and velocities, and what leads from one to the other.

    Impulses are matrices of lanes of three fields, as the table of the groups: normal and tangents, the second one zero in a plane. Of the
    velocities there is, after the N bodies, a row for the supports, then E ghost rows.
    """

    even: np.ndarray  # (L, 3 * 4) p after an even number of iterations
    odd: np.ndarray  # (L, 3 * 4) p after an odd number
    carried: np.ndarray  # (L, 3 * 4) p^, the impulses that belong to the velocities
    best: np.ndarray  # (L, 3 * 4) the p^ of the smallest error
    v: np.ndarray  # (N + 1, n)
    trial: np.ndarray  # (N + 1, n) velocities of p^
    best_v: np.ndarray  # (N + 1, n) those of the smallest error
    momentum: np.ndarray  # (N + 1 + E, n) generalised impulses
    correction: np.ndarray  # (N + 1 + E, n) v+ - v, in the precision of the factors


class AdmmWorkspace(NamedTuple):
    """All that the threads of a team work on.

    The factors are in single precision, or in double where W alone is given, and last from step to step.
    """

    problem: ProblemArrays
    groups: ContactGroups
    iterates: Iterates
    factor: BlockFactor  # of M + H^T R H, with ghost rows after its N + 1 diagonal blocks, and a last lower block that nobody reads
    rho: np.ndarray  # (C,) R by contact
    sums: np.ndarray  # (3, K) partial sums of the subtrees: changes of p after even and odd iterations, squared residuals


def allocate_workspace(
    ordered: ProblemArrays, pattern: Pattern, groups: ContactGroups, kept: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> AdmmWorkspace:
    """Arrays to work in; untouched memory costs nothing.

    Args:
        ordered: the problem, with room for it in the order of the pattern.
        pattern: of M + H^T R H.
        groups: of its contacts.
        kept: squares, panels and rho of a factorisation.
    """
    symbolic, count, n = pattern.symbolic, pattern.nodes, ordered.free.shape[1]
    rows = count + 1 + len(symbolic.node_ghost)
    bodies, impulses, subtrees = (count + 1, n), (len(groups.table), 3 * LANES), len(symbolic.subtree) - 1
    problem = ordered._replace(coupling=in_places(ordered.coupling, pattern))
    iterates = Iterates(
        np.empty(impulses), np.empty(impulses), np.empty(impulses), np.empty(impulses), np.empty(bodies), np.empty(bodies),
        np.empty(bodies), np.empty((rows, n)), np.empty((rows, n), dtype=kept[0].dtype),
    )  # fmt: skip
    squares, panels, rho = kept
    factor = BlockFactor(
        symbolic, True, np.empty((rows, n, n)), np.empty((len(symbolic.row) + 1, n, n)), np.empty((0, n, n)), squares, panels, panels[:0],
        np.empty(subtrees), ordered.n,
    )  # fmt: skip
    return AdmmWorkspace(problem, groups, iterates, factor, rho, np.empty((3, subtrees)))
