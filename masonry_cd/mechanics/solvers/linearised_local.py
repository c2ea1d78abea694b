"""The methods that linearise the law, for problems given by W alone: Newton and the interior point method.

In the impulses instead of the velocities of bodies: the matrix that all of them factorise is I + S W, S one block per contact; see
linearised.py for what they share with those over bodies. The problems come scaled, so that trace(W_cc) = m: a centre, and the centring,
then treat all contacts alike.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.local_blocks import in_elimination_order, local_arrays
from masonry_cd.mechanics.friction.local_operators import LocalArrays, delassus_product, local_norm, place_blocks
from masonry_cd.mechanics.friction.problem import LocalProblem
from masonry_cd.mechanics.linalg.ldu import factorise_ldu
from masonry_cd.mechanics.linalg.single_columns import UNSYMMETRIC
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor
from masonry_cd.mechanics.linalg.threads import room_of_own
from masonry_cd.mechanics.linalg.triangular import solve_ldu
from masonry_cd.mechanics.solvers.central_path import finish_direction, start_direction
from masonry_cd.mechanics.solvers.interior_kernels import allocate_interior, interior_point
from masonry_cd.mechanics.solvers.linearised import Kind, Settings, allocate_work, first_answer
from masonry_cd.mechanics.solvers.newton_kernels import NEWTON_LOCAL, allocate_newton, settle_springs
from masonry_cd.mechanics.solvers.proximal_kernels import project_trial, proximal_points
from masonry_cd.mechanics.solvers.shares import shares_of_one


@borrower()
def map_norm(shares, problem, p, room, u):
    """Norm of the natural map of impulses p (C, m); u (C, m) <- their velocities."""
    return local_norm(problem, p, u)


@kernel()
def answer_of(problem, impulse):
    """The answer to begin with: ``impulse`` (C, m) itself, and its velocities and error."""
    u = np.empty(impulse.shape)
    norm = local_norm(problem, impulse, u)
    return first_answer(impulse, u, norm, problem.q, problem.d)


@borrower()
def contact_velocity(shares, problem, v, u):
    """u = v (C, m)."""
    copy_flat(v, u)


@kernel()
def factorise(shares, problem, work, blocks):
    """Factorise I + S W, S the first rows of ``blocks`` (C, m or more, m); the sign of its determinant, 0 if that fails."""
    matrix = work.matrix
    place_blocks(problem, blocks, work.factor.symbolic, UNSYMMETRIC, matrix)
    for i in range(len(problem.place)):
        for r in range(len(problem.m)):
            matrix.diagonal[i, r, r] += 1.0
    return factorise_ldu(matrix, work.factor)


@kernel()
def divide(problem, work, x):
    """x <- (I + S W)^-1 x (C, m), by contact; ``room`` has x in the order of elimination."""
    m, place, right = len(problem.m), problem.place, work.room
    for c in range(len(place)):
        for i in range(m):
            right[place[c], i] = x[c, i]
    solve_ldu(work.factor, right)
    for c in range(len(place)):
        for i in range(m):
            x[c, i] = right[place[c], i]


# --- interior point -----------------------------------------------------------------------------------------------------------------


@borrower()
def interior_residuals(shares, problem, here, linear, room):
    """What w misses, W p + q - w."""
    delassus_product(problem, here.p, linear.miss)
    for c in range(len(here.p)):
        for i in range(len(problem.m)):
            linear.miss[c, i] += problem.q[c, i] - here.w[c, i]


@kernel()
def direction(shares, problem, work, cones, linear, way):
    """The direction that changes the products as wanted and takes this residual away: (I + G W) dp = r, G the gains."""
    start_direction(shares, cones, linear, way)
    divide(problem, work, way.p)
    delassus_product(problem, way.p, way.w)
    finish_direction(shares, cones, linear, way)


# --- proximal points ----------------------------------------------------------------------------------------------------------------


@kernel()
def as_it_is(problem, free, offset):
    """The problem: velocities are counted from zero."""
    return problem


@borrower()
def begin_at(shares, problem, moved, centre, u):
    """u = centre (C, m)."""
    copy_flat(centre, u)


@borrower()
def move_centre(shares, centre, u):
    """centre = u."""
    copy_flat(u, centre)


@borrower()
def stiffest(error):
    """K from which rounding, EPSILON times K, shows beside an error."""
    return max(1e13 * error, 1e4)


@borrower()
def spring_residual(shares, problem, springs, stiffness, u, held, out):
    """Fill x and p of the springs at velocities u (C, m), and out = W p + q - u (C, m); returns its norm."""
    m, total, x = len(problem.m), 0.0, springs.x
    for c in range(len(u)):
        for i in range(m):
            x[c, i] = springs.centre[c, i] - stiffness * u[c, i]
        project_trial(springs, problem.mu, c, held, m)
    delassus_product(problem, springs.p, out)
    for c in range(len(u)):
        for i in range(m):
            out[c, i] += problem.q[c, i] - u[c, i]
            total += out[c, i] * out[c, i]
    return np.sqrt(total)


@kernel()
def spring_direction(shares, problem, work, springs, search):
    """The Newton step of u, du = r + W dp with (I + B W) dp = -B r and r the residual."""
    m, residual, change, room = len(problem.m), search.residual, search.change, work.room
    for c in range(len(residual)):
        for i in range(m):
            change[c, i] = 0.0
            for j in range(m):
                change[c, i] -= springs.block[c, i, j] * residual[c, j]
    divide(problem, work, change)  # that of p
    delassus_product(problem, change, room)
    for c in range(len(residual)):
        for i in range(m):
            change[c, i] = residual[c, i] + room[c, i]


@borrower()
def spring_changes(shares, problem, springs, stiffness, change):
    """Change dx of the trial impulses with a change of u (C, m)."""
    for c in range(len(change)):
        for i in range(len(problem.m)):
            springs.dx[c, i] = -stiffness * change[c, i]


LOCAL = Kind(
    map_norm, contact_velocity, factorise, interior_residuals, direction, as_it_is, begin_at, spring_residual, spring_direction,
    spring_changes, stiffest, move_centre,
)  # fmt: skip


@entry()
def interior_local(problem: LocalArrays, symbolic: SymbolicFactor, settings: Settings, impulse: np.ndarray) -> tuple[int, float]:
    """Interior point method over scaled LocalArrays. impulse holds the start and then the best answer found.

    Returns iterations and natural map error.
    """
    answer = answer_of(problem, impulse)
    room, shares, shape = room_of_own(), shares_of_one(len(impulse)), impulse.shape
    work, inside = allocate_work(room, symbolic, problem.m, shape, 0), allocate_interior(room, shape, shape)
    return interior_point(LOCAL, shares, problem, work, inside, answer, settings), answer.error[0]


@entry()
def newton_local(problem: LocalArrays, symbolic: SymbolicFactor, settings: Settings, impulse: np.ndarray) -> tuple[int, float]:
    """Proximal points with Newton's steps over scaled LocalArrays. impulse holds the start and then the best answer found.

    Returns iterations (one factorisation each) and natural map error.
    """
    answer = answer_of(problem, impulse)
    room, shares, shape = room_of_own(), shares_of_one(len(impulse)), impulse.shape
    work, inside = allocate_work(room, symbolic, problem.m, shape, 0), allocate_newton(room, shape, shape)
    return proximal_points(settle_springs, LOCAL, shares, problem, work, inside, NEWTON_LOCAL, answer, settings), answer.error[0]


class ScaledLocal(NamedTuple):
    """A problem given by W alone in impulses p sqrt(d), so that all d = 1."""

    arrays: LocalArrays
    symbolic: SymbolicFactor
    root: np.ndarray  # (C, 1) sqrt(d)


def scaled_local(problem: LocalProblem) -> ScaledLocal:
    """The problem as these methods take it."""
    given, _ = local_arrays(problem)
    ordered, pattern = in_elimination_order(given)
    root, row = np.sqrt(problem.scales())[:, None], np.repeat(np.arange(problem.contacts), np.diff(given.indptr))
    scaled = given.data / (root[row] * root[given.indices])[:, :, None]
    return ScaledLocal(ordered._replace(data=scaled, q=problem.q / root, d=np.ones(problem.contacts)), pattern.symbolic, root)
