# SPDX-License-Identifier: GPL-3.0-or-later
"""What the threads of an ADMM solve share: the problem in the order of the subtrees, the iterates and the factor; see admm.py."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.friction.contact_groups import ContactGroups
from masonry_cd.mechanics.friction.coupling import in_places
from masonry_cd.mechanics.friction.operators import OrderedProblem, ProblemArrays
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.linalg.small_blocks import FULL
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor
from masonry_cd.mechanics.linalg.vectors import LANES


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


class AdmmFactor(NamedTuple):
    """M + H^T R H and its factors, which are in single precision, or in double where W alone is given, and last from step to step."""

    symbolic: SymbolicFactor
    squares: np.ndarray  # of D^-1, flat, in single precision
    panels: np.ndarray  # of L, flat, in single precision
    rho: np.ndarray  # (C,) R by contact
    diagonal: np.ndarray  # (N + 1 + E, n n) blocks of the matrix
    lower: np.ndarray  # (B + 1, n, n) below the diagonal, and what couples with supports, which nobody reads
    double_squares: np.ndarray  # in double precision, for single columns only; otherwise empty
    double_panels: np.ndarray


class AdmmWorkspace(NamedTuple):
    """All that the threads of a team work on."""

    problem: OrderedProblem
    groups: ContactGroups
    iterates: Iterates
    factor: AdmmFactor
    sums: np.ndarray  # (3, K) partial sums of the subtrees: changes of p after even and odd iterations, squared residuals


def allocate_workspace(
    given: ProblemArrays, pattern: Pattern, groups: ContactGroups, places: np.ndarray, kept: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> AdmmWorkspace:
    """Arrays to work in; untouched memory costs nothing.

    Args:
        given: the problem.
        pattern: of M + H^T R H.
        groups: of its contacts.
        places: of their bodies, (C, 2).
        kept: squares, panels and rho of a factorisation.
    """
    symbolic, count, n = pattern.symbolic, pattern.nodes, given.v_free.shape[1]
    rows = count + 1 + len(symbolic.node_ghost)
    bodies, impulses, subtrees = (count + 1, n), (len(groups.table), 3 * LANES), len(symbolic.subtree) - 1
    width = np.append(symbolic.width, 0) if len(symbolic.width) else symbolic.width
    doubles = [n * n * int(starts[-1]) if pattern.has_single_columns else 0 for starts in (symbolic.square, symbolic.panel)]
    problem = OrderedProblem(  # the groups have what is missing
        np.empty((count + 1, n, n)), np.empty((count, n, n)), np.empty((count, n)), places, FULL, given.geometry,
        given.offset, given.mu, given.compliance, width, np.empty(0), in_places(given.coupling, pattern), given.m, given.n,
    )  # fmt: skip
    iterates = Iterates(
        np.empty(impulses), np.empty(impulses), np.empty(impulses), np.empty(impulses), np.empty(bodies), np.empty(bodies),
        np.empty(bodies), np.empty((rows, n)), np.empty((rows, n), dtype=kept[0].dtype),
    )  # fmt: skip
    matrix = np.empty((rows, n * n)), np.empty((len(symbolic.row) + 1, n, n))
    factor = AdmmFactor(symbolic, *kept, *matrix, *(np.empty(size) for size in doubles))
    return AdmmWorkspace(problem, groups, iterates, factor, np.empty((3, subtrees)))
