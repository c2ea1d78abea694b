r"""Contacts that give way in a finite step, where not all can be kept that bear: those whose giving way costs least work.

A mechanism of first order may ask more of its contacts than bodies at finite rotations can keep: Coulomb's law without dilation leaves some
that neither open nor slide, though their force is at the limit of friction. Such a step is corrected by the d of the bodies that, for the
forces r of the mechanism,

    min  sum_k  r_kn p_k + (mu r_kn |s_k| + r_kt . s_k)      g_k + H_kn d = p_k >= 0,      t_k + H_kt d = s_k,      a . d = 0,

with the gaps g and shifts t that the step has left, openings p, slips s, and a the mechanism, along which the step has gone already. By
virtual work the sum is what the step adds to the potential energy of the loads and to the heat of friction: a contact that bears little
opens, one at the limit of friction slides for nothing, and no blocks overlap. A linear programme, by
HiGHS in a plane and by Clarabel in space, where slips have SIDES directions.

**In space** some corrections cost so little that the interior point method cannot tell them from none: blocks would wander by hundredths of
the step from round to round, and meet others. So the largest correction that is looked for shrinks from round to round, which Newton's
method, whose corrections shrink faster, does not notice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_matrix, diags, hstack, identity, vstack

from masonry_cd.limit.problem import regular

SIDES = 8  # directions of slip in space
FAR = 4.0  # largest correction, over the step
MOST = 20_000  # iterations of the simplex method
TOLERANCE = 1e-9  # in space
IDLE = 1e-7  # cost of a correction, in space of half its square, over mean weights: what costs nothing stays where it is


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


@dataclass(frozen=True, eq=False)
class _Programme:
    """min (D,) cost . d + slip_cost . e over corrections d and slips e >= 0 by directions, of steps of length one."""

    equal: csr_matrix  # (E, D + slips) rows of shifts and ties, E of them
    wanted: np.ndarray  # (E,)
    closes: csr_matrix  # (N, D) -H_n
    gap: np.ndarray  # (N,) which these rows do not exceed
    cost: np.ndarray  # (D,) of openings, which are gaps and H_n d
    slip_cost: np.ndarray  # (slips,)


def least_work(
    matrix: csr_matrix, residual: np.ndarray, resistance: Resistance, along: np.ndarray, amount: float, far: float = FAR
) -> np.ndarray | None:
    """The correction d (D,) of a step, None where there is none.

    Args:
        matrix: (R, D) rows of gaps and shifts, and of ties, which keep their lengths.
        residual: (R,) [m].
        resistance: what they cost.
        along: (D,) the mechanism.
        amount: of the step [m].
        far: the largest that is looked for in space, over the step.
    """
    ways = _ways(resistance.slides.shape[1])
    sticks = len(resistance.slides)
    edge = np.arange(sticks * len(ways)).reshape(sticks, len(ways))
    row = np.repeat(resistance.slides[:, None], len(ways), axis=1)  # (S, E, m - 1)
    column = np.repeat(edge[:, :, None], ways.shape[1], axis=2)
    shifts = csr_matrix((np.broadcast_to(ways, row.shape).ravel(), (row.ravel(), column.ravel())), (matrix.shape[0], edge.size))
    asked = np.setdiff1d(np.arange(matrix.shape[0]), resistance.opens)
    first = hstack([matrix[asked], -shifts[asked]])
    second = hstack([csr_matrix(along[None]), csr_matrix((1, edge.size))])
    opens = matrix[resistance.opens]
    slip = np.maximum(resistance.limit[:, None] + resistance.traction @ ways.T, 0.0)
    programme = _Programme(
        equal=vstack([first, second], format="csr"), wanted=np.append(-residual[asked] / amount, 0.0), closes=-opens,
        gap=residual[resistance.opens] / amount, cost=opens.T @ resistance.normal, slip_cost=slip.ravel(),
    )  # fmt: skip
    found = _exactly(programme) if ways.shape[1] == 1 else _by_cones(programme, far)
    return None if found is None else amount * found


def _exactly(programme: _Programme) -> np.ndarray | None:
    """The best d with |d| <= FAR, by HiGHS; among several, that of least sum. None: there is none."""
    count, slips = len(programme.cost), len(programme.slip_cost)
    moves = programme.equal[:, :count]
    equal = hstack([moves, -moves, programme.equal[:, count:]], format="csr")
    below = hstack([programme.closes, -programme.closes, csr_matrix((len(programme.gap), slips))], format="csr")
    bounds = np.zeros((equal.shape[1], 2))
    bounds[:, 1] = np.inf
    bounds[: 2 * count, 1] = FAR
    whole = np.concatenate([IDLE + programme.cost, IDLE - programme.cost, programme.slip_cost])
    options = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10, "maxiter": MOST}
    answer = linprog(
        whole, A_ub=below, b_ub=programme.gap, A_eq=equal, b_eq=programme.wanted, bounds=bounds, method="highs-ds", options=options
    )  # fmt: skip
    return answer.x[:count] - answer.x[count : 2 * count] if answer.status == 0 else None


def _by_cones(programme: _Programme, far: float) -> np.ndarray | None:
    """The best d with |d| <= far by Clarabel, for programmes as large as those in space; among several, that of least norm."""
    import clarabel

    count, slips = len(programme.cost), len(programme.slip_cost)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    bends = diags(np.append(np.full(count, IDLE), np.zeros(slips))).tocsc()
    one = identity(count + slips, format="csc")
    closes = hstack([programme.closes, csr_matrix((len(programme.gap), slips))])
    matrix = vstack([programme.equal, closes, -one[count:], one[:count], -one[:count]], format="csc")
    right = np.concatenate([programme.wanted, programme.gap, np.zeros(slips), np.full(2 * count, far)])
    cones = [clarabel.ZeroConeT(len(programme.wanted)), clarabel.NonnegativeConeT(len(right) - len(programme.wanted))]
    cost = np.append(programme.cost, programme.slip_cost)
    answer = clarabel.DefaultSolver(bends, cost, matrix, right, cones, settings).solve()
    return np.array(answer.x)[:count] if str(answer.status) in ("Solved", "AlmostSolved") else None


def _ways(tangents: int) -> np.ndarray:
    """Directions of slip (E, m - 1)."""
    if tangents == 1:
        return np.array([[1.0], [-1.0]])
    return regular(SIDES)
