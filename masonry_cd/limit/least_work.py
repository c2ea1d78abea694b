r"""Contacts that give way in a finite step, where not all can be kept that bear: those whose giving way costs least work.

A mechanism of first order may ask more of its contacts than bodies at finite rotations can keep: Coulomb's law without dilation leaves some
that neither open nor slide, though their force is at the limit of friction. Such a step is corrected by the d of the bodies that, for the
forces r of the mechanism,

    min  sum_k  r_kn p_k + (mu r_kn |s_k| + r_kt . s_k)      g_k + H_kn d = p_k >= 0,      t_k + H_kt d = s_k,      a . d = 0,

with the gaps g and shifts t that the step has left, openings p, slips s, and a the mechanism, along which the step has gone already. By
virtual work the sum is what the step adds to the potential energy of the loads and to the heat of friction: a contact that bears little
opens, one at the limit of friction slides for nothing, and no blocks overlap. A linear programme, by
HiGHS in a plane and by Clarabel in space, where slips have SIDES directions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csc_matrix, csr_matrix, diags, hstack, identity, vstack

SIDES = 8  # directions of slip in space
FAR = 4.0  # largest correction, over the step
MOST = 20_000  # iterations of the simplex method
TOLERANCE = 1e-9  # in space
IDLE = 1e-7  # cost of a correction, over mean weights: what costs nothing stays where it is


@dataclass(frozen=True, eq=False)
class Resistance:
    """What the R rows of a step's equations are, and what giving way costs there."""

    opens: np.ndarray  # (N,) rows of gaps
    normal: np.ndarray  # (N,) forces there, over the mean weight of a block
    slides: np.ndarray  # (S, m - 1) rows of shifts of points that stick
    traction: np.ndarray  # (S, m - 1) forces along them
    limit: np.ndarray  # (S,) mu r_n

    @classmethod
    def of_points(cls, rows: np.ndarray, force: np.ndarray, mu: np.ndarray) -> Resistance:
        """Of points whose ``rows`` (N, 3, 3) are asked for where they are not zero, with forces (N, m) in their frames."""
        asked = np.asarray(rows.any(axis=2))
        number = np.cumsum(asked.ravel()).reshape(asked.shape) - 1
        opens, sticks, ways = np.flatnonzero(asked[:, 0]), np.flatnonzero(asked[:, 1:].any(axis=1)), slice(1, force.shape[1])
        normal = np.maximum(force[:, 0], 0.0)
        return cls(number[opens, 0], normal[opens], number[sticks, ways], force[sticks, ways], (mu * normal)[sticks])


def least_work(matrix: np.ndarray, residual: np.ndarray, resistance: Resistance, along: np.ndarray, amount: float) -> np.ndarray | None:
    """The correction d (D,) of a step, None where there is none.

    Args:
        matrix: (R, D) rows of gaps and shifts, and of ties, which keep their lengths.
        residual: (R,) [m].
        resistance: what they cost.
        along: (D,) the mechanism.
        amount: of the step [m].
    """
    ways = _ways(resistance.slides.shape[1])
    count, opens, sticks = matrix.shape[1], len(resistance.opens), len(resistance.slides)
    gaps = csr_matrix((np.ones(opens), (resistance.opens, np.arange(opens))), (len(matrix), opens))
    edge = np.arange(sticks * len(ways)).reshape(sticks, len(ways))
    row = np.repeat(resistance.slides[:, None], len(ways), axis=1)  # (S, E, m - 1)
    column = np.repeat(edge[:, :, None], ways.shape[1], axis=2)
    shifts = csr_matrix((np.broadcast_to(ways, row.shape).ravel(), (row.ravel(), column.ravel())), (len(matrix), edge.size))
    first = hstack([csr_matrix(matrix), -gaps, -shifts])
    second = hstack([csr_matrix(along[None]), csr_matrix((1, opens + edge.size))])
    rows, wanted = vstack([first, second], format="csc"), np.append(-residual / amount, 0.0)
    slip = np.maximum(resistance.limit[:, None] + resistance.traction @ ways.T, 0.0)
    cost = np.concatenate([resistance.normal, slip.ravel()])
    found = _exactly(rows, wanted, cost) if ways.shape[1] == 1 else _by_cones(rows, wanted, cost)
    return None if found is None else amount * found[:count]


def _exactly(rows: csc_matrix, wanted: np.ndarray, cost: np.ndarray) -> np.ndarray | None:
    """Least cost . y with rows (d, y) = wanted, y >= 0 and |d| <= FAR, by HiGHS; among several, d of least sum. None: there is none."""
    count = rows.shape[1] - len(cost)
    both = hstack([rows[:, :count], -rows[:, :count], rows[:, count:]], format="csr")
    bounds = np.zeros((both.shape[1], 2))
    bounds[:, 1] = np.inf
    bounds[: 2 * count, 1] = FAR
    whole = np.concatenate([np.full(2 * count, IDLE), cost])
    options = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10, "maxiter": MOST}
    answer = linprog(whole, A_eq=both, b_eq=wanted, bounds=bounds, method="highs-ds", options=options)
    return answer.x[:count] - answer.x[count : 2 * count] if answer.status == 0 else None


def _by_cones(rows: csc_matrix, wanted: np.ndarray, cost: np.ndarray) -> np.ndarray | None:
    """The same by Clarabel, for programmes as large as those in space; among several, d of least norm."""
    import clarabel

    size, more = rows.shape[1], len(cost)
    count = size - more
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    bends = diags(np.append(np.full(count, IDLE), np.zeros(more))).tocsc()
    one = identity(size, format="csc")
    matrix = vstack([rows, -one[count:], one[:count], -one[:count]], format="csc")
    right = np.concatenate([wanted, np.zeros(more), np.full(2 * count, FAR)])
    cones = [clarabel.ZeroConeT(len(wanted)), clarabel.NonnegativeConeT(more + 2 * count)]
    answer = clarabel.DefaultSolver(bends, np.append(np.zeros(count), cost), matrix, right, cones, settings).solve()
    return np.array(answer.x)[:count] if str(answer.status) in ("Solved", "AlmostSolved") else None


def _ways(tangents: int) -> np.ndarray:
    """Directions of slip (E, m - 1)."""
    if tangents == 1:
        return np.array([[1.0], [-1.0]])
    turn = 2.0 * math.pi * np.arange(SIDES) / SIDES
    return np.array([[math.cos(a), math.sin(a)] for a in turn])
