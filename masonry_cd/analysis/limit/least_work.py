# SPDX-License-Identifier: GPL-3.0-or-later
r"""Contacts that give way in a finite step, where not all can be kept that bear: those whose giving way costs least work.

A mechanism of first order may ask more of its contacts than bodies at finite rotations can keep: Coulomb's law without dilation leaves some
that neither open nor slide, though their force is at the limit of friction. Such a step is corrected by the d of the bodies that, for the
forces r of the mechanism,

    min  sum_k  r_kn p_k + (mu r_kn |s_k| + r_kt . s_k)      g_k + H_kn d = p_k >= 0,      t_k + H_kt d = s_k,      a . d = 0,

with the gaps g and shifts t that the step has left, openings p, slips s, and a the mechanism, along which the step has gone already. By
virtual work the sum is what the step adds to the potential energy of the loads and to the heat of friction: a contact that bears little
opens, one at the limit of friction slides for nothing, and no blocks overlap. A point that slides in the mechanism goes on for nothing,
too, but not back: what it has slipped in all, s_k, it has slipped along its direction, or it costs 2 mu r_kn. In a plane that is a linear
programme, by HiGHS; in space one with circular cones, |s_k| <= e_k, by Clarabel. Points without force slide for nothing, and are left out.

**In space** some corrections cost so little that the interior point method cannot tell them from none: blocks would wander by hundredths of
the step from round to round, and meet others. So the largest correction that is looked for shrinks from round to round, which Newton's
method, whose corrections shrink faster, does not notice.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csr_matrix, diags, hstack, identity, vstack

from masonry_cd.foundation.extras import require

FAR = 4.0  # largest correction, over the step
MOST = 20_000  # iterations of the simplex method
TOLERANCE = 1e-9  # in space
NOTHING = 1e-9  # force, over mean weights, at which a point costs nothing to slide
IDLE = 1e-7  # cost of a correction, in space of half its square, over mean weights: what costs nothing stays where it is


@dataclass(frozen=True, eq=False)
class Resistance:
    """Meaning of the R rows of a step's equations, and the work of giving way there, N gaps, S points that stick and Q that slide."""

    opens: np.ndarray  # (N,) rows of gaps
    normal: np.ndarray  # (N,) forces there, over the mean weight of a block
    slides: np.ndarray  # (S, m - 1) rows of shifts of points that stick
    traction: np.ndarray  # (S, m - 1) forces along them
    limit: np.ndarray  # (S,) mu r_n
    goes_on: np.ndarray  # (Q,) rows of slips along their directions in the mechanism
    back: np.ndarray  # (Q,) what it costs to slip the other way: 2 mu r_n
    free: np.ndarray  # rows of shifts that cost nothing

    @classmethod
    def of_points(cls, rows: np.ndarray, force: np.ndarray, mu: np.ndarray, slides: np.ndarray) -> Resistance:
        """Return the resistance of points whose ``rows`` (N, 3, 3) are used where they are not zero, with forces (N, m) in their frames.

        Those that slide, ``slides`` (N,), have the direction of their slip in the second row and none in the third.
        """
        asked = np.asarray(rows.any(axis=2))
        number = np.cumsum(asked.ravel()).reshape(asked.shape) - 1
        opens, tangential, ways = np.flatnonzero(asked[:, 0]), asked[:, 1:].any(axis=1), slice(1, force.shape[1])
        normal = np.maximum(force[:, 0], 0.0)
        limit = mu * normal
        costs = limit > NOTHING
        sticks, goes_on = np.flatnonzero(tangential & ~slides & costs), np.flatnonzero(tangential & slides)
        free = number[:, 1:][asked[:, 1:] & (~slides & ~costs)[:, None]]
        stuck = number[sticks, ways], force[sticks, ways], limit[sticks]
        return cls(number[opens, 0], normal[opens], *stuck, number[goes_on, 1], 2.0 * limit[goes_on], free)


@dataclass(frozen=True, eq=False)
class _Programme:
    """The programme of a step of length one."""

    matrix: csr_matrix  # (R, D)
    residual: np.ndarray  # (R,)
    resistance: Resistance
    along: np.ndarray  # (D,)
    far: float

    @cached_property
    def keeps(self) -> tuple[csr_matrix, np.ndarray]:
        """Rows (E, D) of ties, which keep their lengths, and of the mechanism, and what they are (E,)."""
        made = self.resistance
        ties = np.setdiff1d(np.arange(len(self.residual)), np.concatenate([made.opens, made.slides.ravel(), made.goes_on, made.free]))
        return vstack([self.matrix[ties], csr_matrix(self.along[None])], format="csr"), np.append(-self.residual[ties], 0.0)

    @cached_property
    def cost(self) -> np.ndarray:
        """(D,) of openings, g_k + H_kn d, but for what they are where d is zero."""
        return np.asarray(self.matrix[self.resistance.opens].T @ self.resistance.normal)


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
    solve = _exactly if resistance.slides.shape[1] == 1 else _by_cones
    found = solve(_Programme(matrix, residual / amount, resistance, along, far))
    return None if found is None else amount * found


def _exactly(programme: _Programme) -> np.ndarray | None:
    """The best d with |d| <= FAR in a plane, by HiGHS; among several, that of least sum. None: there is none.

    The unknowns are d and -d, slips along and against the tangents of points that stick, and slips back of those that slide, all >= 0.
    """
    made, matrix, residual = programme.resistance, programme.matrix, programme.residual
    (keeps, kept), slides = programme.keeps, made.slides.ravel()
    count, sticks, back = matrix.shape[1], len(slides), len(made.goes_on)
    one, none = identity(sticks), csr_matrix((keeps.shape[0], 2 * sticks + back))
    shifts = hstack([matrix[slides], -matrix[slides], -one, one, csr_matrix((sticks, back))])
    equal = vstack([hstack([keeps, -keeps, none]), shifts], format="csr")
    opens, goes_on = matrix[made.opens], matrix[made.goes_on]
    gaps = hstack([-opens, opens, csr_matrix((len(made.opens), 2 * sticks + back))])
    below = vstack([gaps, hstack([-goes_on, goes_on, csr_matrix((back, 2 * sticks)), -identity(back)])], format="csr")
    bounds = np.zeros((equal.shape[1], 2))
    bounds[:, 1] = np.inf
    bounds[: 2 * count, 1] = FAR
    slip = np.concatenate([np.maximum(made.limit + way * made.traction[:, 0], 0.0) for way in (1.0, -1.0)])
    whole = np.concatenate([IDLE + programme.cost, IDLE - programme.cost, slip, made.back])
    options = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10, "maxiter": MOST}
    answer = linprog(
        whole, A_ub=below, b_ub=residual[np.concatenate([made.opens, made.goes_on])], A_eq=equal,
        b_eq=np.concatenate([kept, -residual[slides]]), bounds=bounds, method="highs-ds", options=options,
    )  # fmt: skip
    return answer.x[:count] - answer.x[count : 2 * count] if answer.status == 0 else None


def _by_cones(programme: _Programme) -> np.ndarray | None:
    """The best d with |d| <= far in space, by Clarabel; among several, that of least norm. None: there is none.

    The unknowns are d, the sizes e of slips of points that stick, and slips back of those that slide.
    """
    require("a limit analysis in space", "clarabel")
    import clarabel

    made, matrix, residual = programme.resistance, programme.matrix, programme.residual
    (keeps, kept), slides = programme.keeps, made.slides.ravel()
    count, sticks, back = matrix.shape[1], len(made.slides), len(made.goes_on)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    bends = diags(np.append(np.full(count, IDLE), np.zeros(sticks + back))).tocsc()
    one, other = identity(count), sticks + back
    below = [
        hstack([-matrix[made.opens], csr_matrix((len(made.opens), other))]),
        hstack([-matrix[made.goes_on], csr_matrix((back, sticks)), -identity(back)]),
        hstack([csr_matrix((back, count + sticks)), -identity(back)]),
        hstack([vstack([one, -one]), csr_matrix((2 * count, other))]),
    ]
    right = np.concatenate([kept, residual[made.opens], residual[made.goes_on], np.zeros(back), np.full(2 * count, programme.far)])
    sizes = hstack([csr_matrix((sticks, count)), -identity(sticks), csr_matrix((sticks, back))])
    tangents = matrix[slides]
    shifts = hstack([-tangents, csr_matrix((2 * sticks, other))])
    order = np.column_stack([np.arange(sticks), sticks + 2 * np.arange(sticks), sticks + 2 * np.arange(sticks) + 1]).ravel()
    discs = vstack([sizes, shifts], format="csr")[order]
    matrix = vstack([hstack([keeps, csr_matrix((len(kept), other))]), *below, discs], format="csc")
    cones = [clarabel.ZeroConeT(len(kept)), clarabel.NonnegativeConeT(len(right) - len(kept)), *[clarabel.SecondOrderConeT(3)] * sticks]
    right = np.concatenate([right, np.concatenate([np.zeros(sticks), residual[slides]])[order]])
    within = np.minimum(1.0, made.limit / np.maximum(np.linalg.norm(made.traction, axis=1), 1e-300))  # but for rounding
    drawn = tangents.T @ (within[:, None] * made.traction).ravel()
    cost = np.concatenate([programme.cost + drawn, made.limit, made.back])
    answer = clarabel.DefaultSolver(bends, cost, matrix, right, cones, settings).solve()
    return np.array(answer.x)[:count] if str(answer.status) in ("Solved", "AlmostSolved") else None
