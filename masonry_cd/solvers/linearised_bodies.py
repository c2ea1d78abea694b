"""Newton, the interior point method, proximal points and the path by its length over bodies, behind one entry.

The matrix that all of them factorise is M + H^T B H, B from the linearised laws; see linearised.py for what they share.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.friction import operators
from masonry_cd.friction.operators import (
    OrderedProblem,
    ProblemArrays,
    add_generalised_impulse,
    body_velocity,
    change_at,
    has_unit_masses,
    in_order,
    law_velocity,
    missing_momentum,
    put_back,
    relative_velocity,
    unknowns_at,
)
from masonry_cd.jit import borrower, entry, kernel
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.small_blocks import copy_flat, invert, multiply
from masonry_cd.linalg.triangular import solve_ldu
from masonry_cd.solvers.central_path import STIFFEST, interior_direction, missing_velocity
from masonry_cd.solvers.interior_kernels import interior_point
from masonry_cd.solvers.linearised import Elimination, Kind, Settings, allocate_work, augment_blocks, first_answer
from masonry_cd.solvers.newton_kernels import LinearisedLaw, linearise_law, newton
from masonry_cd.solvers.path_kernels import path_bodies
from masonry_cd.solvers.pivoting_kernels import pivoting_points
from masonry_cd.solvers.proximal_kernels import Patience, add_step, project_trial, proximal_points, softness

NEWTON, INTERIOR, PATH, PROXIMAL, PIVOTING = 0, 1, 2, 3, 4  # methods that linearise the law
PATIENCE = Patience(iterations=25, failures=8)


class LawWork(NamedTuple):
    """Room for the linearised law, of Newton."""

    law: LinearisedLaw
    w: np.ndarray  # (C, m) H v + b + C p


@borrower()
def map_norm(problem, p, room, v):
    """Norm of the natural map of impulses p (C, m); v (B + 1, n) <- their velocities."""
    body_velocity(problem, p, room, v)
    return operators.map_norm(problem, p, v)


@kernel()
def factorise(problem, work, blocks):
    """Factorise M + H^T B H, B the first rows of ``blocks`` (C, m or more, m); the sign of its determinant, 0 if that fails."""
    augment_blocks(problem, blocks, work.matrix)
    return factorise_ldu(work.matrix, work.factor)


# --- Newton -----------------------------------------------------------------------------------------------------------------------


@borrower()
def in_series(block, compliance, share, softer, work, size_m):
    """Put the contact's own spring in series with a linearised law p+ - p = r - B (w+ - w), where w+ - w = u+ - u + C (p+ - p).

    share = (I + B C)^-1 leaves p+ - p = share r - softer (u+ - u), softer = share B. False if it is singular.
    """
    m = len(size_m)
    for i in range(m):
        for j in range(m):
            softer[i, j] = block[i, j] * compliance[j] + (1.0 if i == j else 0.0)
    regular = invert(softer, share, work, size_m) != 0.0
    multiply(share, block, False, softer, size_m)
    return regular


@borrower()
def take_share(share, target, p0, p1, p2, size_m):
    """target <- p + share (target - p)."""
    m = len(size_m)
    r0, r1, r2 = target[0] - p0, target[1] - p1, target[m - 1] - p2 if m == 3 else 0.0
    for i in range(m):
        target[i] = (p0, p1, p2)[i] + share[i, 0] * r0 + share[i, 1] * r1 + share[i, m - 1] * r2


@kernel()
def linearise_contacts(problem, p, w, stiffness, law):
    """Linearise the law of all contacts at impulses p and velocities w (C, m), see :class:`LinearisedLaw`."""
    m, mu, d, compliance = len(problem.m), problem.mu, problem.d, problem.compliance
    share, softer, work = np.empty((m, m)), np.empty((m, m)), np.empty((m, m))
    for c in range(len(p)):
        p2, w2 = (p[c, 2], w[c, 2]) if m == 3 else (0.0, 0.0)
        linearise_law((p[c, 0], p[c, 1], p2), (w[c, 0], w[c, 1], w2), mu[c], d[c], stiffness, law, c)
        if len(compliance):
            in_series(law.block[c], compliance[c], share, softer, work, problem.m)
            take_share(share, law.target[c], p[c, 0], p[c, 1], p2, problem.m)
            copy_flat(softer, law.block[c])


@kernel()
def take_newton_step(problem, work, law_work, stiffness, p, v):
    """Impulses p and velocities v <- those that solve the linearised problem, see newton.py; returns the norm of their natural map."""
    law, w = law_work
    room, m = work.room, len(problem.m)
    law_velocity(problem, v, p, w)
    linearise_contacts(problem, p, w, stiffness, law)
    if factorise(problem, work, law.block) == 0.0:
        return np.inf
    missing_momentum(problem, v, room)
    add_generalised_impulse(problem, law.target, room)
    solve_ldu(work.factor, room)
    room[-1] = 0.0
    jacobian, index, target, block = problem.jacobian, problem.places, law.target, law.block
    for c in range(len(p)):
        for i in range(m):
            p[c, i] = target[c, i]
        for i in range(m):
            change = change_at(jacobian, index, c, i, room, unknowns_at(problem, index[c, 0], index[c, 1]))
            for k in range(m):
                p[c, k] -= block[c, k, i] * change
    return map_norm(problem, p, room, v)


# --- interior point -----------------------------------------------------------------------------------------------------------------


@borrower()
def interior_residuals(problem, here, linear, room):
    """What w and v miss: H v + b + C p - w, and H^T p - M (v - v_free), which goes to ``room``."""
    missing_velocity(problem, here, 0.0, linear)
    missing_momentum(problem, here.v, room)
    add_generalised_impulse(problem, here.p, room)


# --- proximal points ----------------------------------------------------------------------------------------------------------------


@kernel()
def movable(problem):
    """Room for the problem in the change of the velocities from those of a centre, which spares rounding."""
    return OrderedProblem(
        problem.inverse, problem.mass, np.empty(problem.free.shape), problem.places, problem.block, problem.jacobian,
        np.empty(problem.offset.shape), problem.mu, problem.compliance, problem.width, problem.d, problem.m, problem.n,
    )  # fmt: skip


@borrower()
def begin_at(problem, moved, centre, v):
    """Count velocities from ``centre`` (B + 1, n), and begin there: at v = 0."""
    add_step(problem.free, -1.0, centre, moved.free)
    relative_velocity(problem, centre, moved.offset)
    v[:] = 0.0


@borrower()
def move_centre(centre, v):
    """centre += v."""
    add_step(centre, 1.0, v, centre)


@borrower()
def stiffest(error):
    """K up to which stiff springs beside rigid contacts settle, at any error."""
    return STIFFEST


@borrower()
def spring_residual(problem, springs, stiffness, v, held, out):
    """Fill x and p of the springs at velocities v, and out = M (v_free - v) + H^T p (B + 1, n); returns the norm of that in M^-1."""
    m, n, compliance, d = len(problem.m), len(problem.n), problem.compliance, problem.d
    x, centre = springs.x, springs.centre
    relative_velocity(problem, v, x)
    for c in range(len(d)):
        soft_n, soft_t = softness(compliance, d[c] / stiffness, c, m)
        for i in range(m):
            soft = soft_n if i == 0 else soft_t
            own = compliance[c, i] if len(compliance) else 0.0
            x[c, i] = ((soft - own) * centre[c, i] - x[c, i]) / soft
        project_trial(springs, problem.mu, c, held, m)
    missing_momentum(problem, v, out)
    add_generalised_impulse(problem, springs.p, out)
    out[-1] = 0.0
    total = 0.0
    for b in range(len(problem.inverse)):
        for i in range(n):
            if has_unit_masses(problem):
                total += out[b, i] * out[b, i]
                continue
            for j in range(n):
                total += out[b, i] * problem.inverse[b, i, j] * out[b, j]
    return np.sqrt(max(total, 0.0))


@kernel()
def spring_direction(problem, work, springs, search):
    """The Newton step, (M + H^T B H) dv = r with the residual r, which it uses up."""
    residual, change = search.residual, search.change
    solve_ldu(work.factor, residual)
    copy_flat(residual[: len(residual) - 1], change)


@borrower()
def spring_changes(problem, springs, stiffness, change):
    """Change dx of the trial impulses with a change of the velocities (B + 1, n)."""
    m, n, d, jacobian, index = len(problem.m), len(problem.n), problem.d, problem.jacobian, problem.places
    for c in range(len(d)):
        soft_n, soft_t = softness(problem.compliance, d[c] / stiffness, c, m)
        for i in range(m):
            springs.dx[c, i] = -change_at(jacobian, index, c, i, change, n) / (soft_n if i == 0 else soft_t)


BODIES = Kind(
    map_norm, relative_velocity, factorise, interior_residuals, interior_direction, movable, begin_at, spring_residual,
    spring_direction, spring_changes, stiffest, move_centre,
)  # fmt: skip


@kernel()
def answer_of(problem, impulse):
    """The answer to begin with: ``impulse`` (C, m) itself, and its velocities and error."""
    rows = (len(problem.free) + 1, len(problem.n))
    v, room, q = np.zeros(rows), np.empty(rows), np.empty(impulse.shape)
    copy_flat(problem.free, v)
    relative_velocity(problem, v, q)
    norm = map_norm(problem, impulse, room, v)
    return first_answer(impulse, v, norm, q, problem.d)


@entry()
def linearised_bodies(
    method: int, problem: ProblemArrays, elimination: Elimination, settings: Settings, impulse: np.ndarray, velocity: np.ndarray
) -> tuple[int, float, float, float]:
    """One of these methods over ProblemArrays. ``impulse`` (C, m) holds the start and then the best answer found, velocity (B, n) its own.

    Python enters here alone, so that their factorisation, the larger part of each, is compiled once. Returns iterations, natural map
    error, and of Newton the error at the start and the stiffness at the end.
    """
    ordered = in_order(problem, elimination.order, elimination.places, elimination.block)
    answer, begin, stiffness = answer_of(ordered, impulse), np.nan, settings.stiffness
    work = allocate_work(elimination.symbolic, problem.n, answer.velocity)
    if method == NEWTON:
        law = LinearisedLaw(np.empty(impulse.shape), np.empty((len(impulse), len(problem.m), len(problem.m))), problem.m)
        iterations, begin, stiffness = newton(take_newton_step, ordered, work, LawWork(law, np.empty(impulse.shape)), answer, settings)
    elif method == INTERIOR:
        iterations = interior_point(BODIES, ordered, work, answer, settings)
    elif method == PATH:
        iterations = path_bodies(BODIES, ordered, work, answer, settings)
    elif method == PIVOTING:
        iterations = pivoting_points(BODIES, ordered, work, answer, settings)
    else:
        iterations = proximal_points(BODIES, ordered, work, PATIENCE, answer, settings)
    put_back(answer.velocity, elimination.order, velocity)
    return iterations, answer.error[0], begin, stiffness
