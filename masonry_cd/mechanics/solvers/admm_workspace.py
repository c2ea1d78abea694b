# SPDX-License-Identifier: GPL-3.0-or-later
"""Data that the threads of an ADMM solve share: the problem in the order of the subtrees, the iterates and the factor; see admm.py."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry, kernel
from masonry_cd.mechanics.friction.coupling import in_places
from masonry_cd.mechanics.friction.operators import Elimination, ProblemArrays, room_in_order
from masonry_cd.mechanics.linalg.factor import BlockFactor
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor
from masonry_cd.mechanics.linalg.threads import own_arena, take
from masonry_cd.mechanics.linalg.vectors import LANES
from masonry_cd.mechanics.solvers.contact_groups import ContactGroups, group_contacts


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
    """All that the threads of a team work on."""

    problem: ProblemArrays
    groups: ContactGroups
    iterates: Iterates
    factor: BlockFactor  # of M + H^T R H, with ghost rows after its N + 1 diagonal blocks, and a last lower block that nobody reads
    rho: np.ndarray  # (C,) R by contact
    sums: np.ndarray  # (3, K) partial sums of the subtrees: changes of p after even and odd iterations, squared residuals


class KeptFactors(NamedTuple):
    """The factors of M + H^T R H, which last from step to step: in single precision, or in double where W alone is given."""

    symbolic: SymbolicFactor
    squares: np.ndarray  # of D^-1, flat
    panels: np.ndarray  # of L, flat
    rho: np.ndarray  # (C,) R by contact


@kernel()
def allocate_workspace(arena, given, elimination, kept):
    """Arrays to work in, for ProblemArrays that are to be put in order of elimination."""
    symbolic, coupling = kept.symbolic, in_places(given.coupling, elimination.order)
    problem = room_in_order(arena, given, elimination, coupling)
    groups, (count, n) = group_contacts(arena, problem, symbolic), problem.free.shape
    rows, bodies, impulses, subtrees = (
        (count + 1 + len(symbolic.node_ghost), n), (count + 1, n), (len(groups.table), 3 * LANES), len(symbolic.subtree) - 1,
    )  # fmt: skip
    # room is counted in doubles, of which single precision uses half
    correction = take(arena, (rows[0] * n,)).view(kept.panels.dtype)[: rows[0] * n].reshape(rows)
    iterates = Iterates(
        take(arena, impulses), take(arena, impulses), take(arena, impulses), take(arena, impulses), take(arena, bodies),
        take(arena, bodies), take(arena, bodies), take(arena, rows), correction,
    )  # fmt: skip
    factor = BlockFactor(
        symbolic, True, take(arena, (rows[0], n, n)), take(arena, (len(symbolic.row) + 1, n, n)), take(arena, (0, n, n)),
        kept.squares, kept.panels, kept.panels[:0], take(arena, (subtrees,)), given.n,
    )  # fmt: skip
    return AdmmWorkspace(problem, groups, iterates, factor, kept.rho, take(arena, (3, subtrees)))


@entry()
def room_of_workspace(given: ProblemArrays, elimination: Elimination, kept: KeptFactors) -> int:
    """Entries of the :class:`SharedArena` of a team."""
    arena = own_arena()
    allocate_workspace(arena, given, elimination, kept)
    return int(arena.used[0])
