"""Newton, the interior point method, proximal points and the path by its length over bodies, behind one entry.

The matrix that all of them factorise is M + H^T B H, B from the linearised laws; see linearised.py for what they share, and shares.py for
what each thread of a team does of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.body_sides import weighed_sides
from masonry_cd.mechanics.friction.operators import (
    OrderedProblem,
    ProblemArrays,
    has_unit_masses,
    law_velocity_of,
    measure_scales,
    put_in_order,
    velocity_of_contact,
    widths_in_order,
)
from masonry_cd.mechanics.linalg.small_blocks import copy_flat, invert, multiply
from masonry_cd.mechanics.linalg.threads import SharedRoom, ThreadTeam, room_of_own, run_by_team, take, wait
from masonry_cd.mechanics.solvers.central_path import STIFFEST, interior_direction, missing_velocity
from masonry_cd.mechanics.solvers.interior_kernels import allocate_interior, interior_point
from masonry_cd.mechanics.solvers.linearised import Elimination, Kind, Settings, allocate_work, first_answer
from masonry_cd.mechanics.solvers.newton_kernels import LinearisedLaw, allocate_newton, linearise_law, newton
from masonry_cd.mechanics.solvers.path_kernels import allocate_paths, path_bodies
from masonry_cd.mechanics.solvers.pivoting_kernels import pivoting_points
from masonry_cd.mechanics.solvers.proximal_kernels import Patience, allocate_proximal, project_trial, proximal_points, softness
from masonry_cd.mechanics.solvers.shared_operators import contact_velocity, factorise, map_norm, missing_momentum, solve_by_first
from masonry_cd.mechanics.solvers.shares import add_share, allocate_sums, begin_sums, copy_share, shares_of, sum_of_rows

NEWTON, INTERIOR, PATH, PROXIMAL, PIVOTING = 0, 1, 2, 3, 4  # methods that linearise the law
PATIENCE = Patience(iterations=25, failures=8)


class LawWork(NamedTuple):
    """Room for the linearised law, of Newton."""

    law: LinearisedLaw
    w: np.ndarray  # (C, m) H v + b + C p


@kernel()
def allocate_law(room, shape, size_m):
    """:class:`LawWork` for contacts (C, m)."""
    contacts, m = shape
    return LawWork(LinearisedLaw(take(room, shape), take(room, (contacts, m, m)), size_m), take(room, shape))


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
def linearise_contacts(shares, problem, p, w, stiffness, law):
    """Linearise the law of the contacts at impulses p and velocities w (C, m), see :class:`LinearisedLaw`."""
    m, mu, d, compliance = len(problem.m), problem.mu, problem.d, problem.compliance
    share, softer, work = np.empty((m, m)), np.empty((m, m)), np.empty((m, m))
    first, end = shares.contacts
    for c in range(first, end):
        p2, w2 = (p[c, 2], w[c, 2]) if m == 3 else (0.0, 0.0)
        linearise_law((p[c, 0], p[c, 1], p2), (w[c, 0], w[c, 1], w2), mu[c], d[c], stiffness, law, c)
        if len(compliance):
            in_series(law.block[c], compliance[c], share, softer, work, problem.m)
            take_share(share, law.target[c], p[c, 0], p[c, 1], p2, problem.m)
            copy_flat(softer, law.block[c])


@kernel()
def take_newton_step(shares, problem, work, law_work, stiffness, p, v):
    """Impulses p and velocities v <- those that solve the linearised problem, see newton.py; returns the norm of their natural map."""
    (law, w), room, m, (first, end) = law_work, work.room, len(problem.m), shares.contacts
    wait(shares.team)
    law_velocity_of(problem, v, p, first, end, w)
    linearise_contacts(shares, problem, p, w, stiffness, law)
    if factorise(shares, problem, work, law.block) == 0.0:
        return np.inf
    missing_momentum(shares, problem, v, law.target, room)
    solve_by_first(shares, work.factor, room)
    target, block = law.target, law.block
    for c in range(first, end):
        u0, u1, u2 = velocity_of_contact(problem, room, c)
        for k in range(m):
            change = block[c, k, 0] * u0 + block[c, k, 1] * u1
            p[c, k] = target[c, k] - (change + block[c, k, 2] * u2 if m == 3 else change)
    return map_norm(shares, problem, p, room, v)


# --- interior point -----------------------------------------------------------------------------------------------------------------


@borrower()
def interior_residuals(shares, problem, here, linear, room):
    """What w and v miss: H v + b + C p - w, and H^T p - M (v - v_free), which goes to ``room``."""
    missing_velocity(shares, problem, here, 0.0, linear)
    missing_momentum(shares, problem, here.v, here.p, room)


# --- proximal points ----------------------------------------------------------------------------------------------------------------


@kernel()
def movable(problem, free, offset):
    """The problem in the change of the velocities from those of a centre, which spares rounding; free (B + 1, n) and offset (C, m) are
    room for what changes with it."""
    return OrderedProblem(
        problem.inverse, problem.mass, free, problem.places, problem.block, problem.jacobian, problem.frame, offset, problem.mu,
        problem.compliance, problem.width, problem.d, problem.m, problem.n,
    )  # fmt: skip


@borrower()
def begin_at(shares, problem, moved, centre, v):
    """Count velocities from ``centre`` (B + 1, n), and begin there: at v = 0."""
    first, end = shares.rows
    add_share(shares.rows, problem.free, -1.0, centre, moved.free)
    contact_velocity(shares, problem, centre, moved.offset)
    v[first:end] = 0.0


@borrower()
def move_centre(shares, centre, v):
    """centre += v."""
    add_share(shares.rows, centre, 1.0, v, centre)


@borrower()
def stiffest(error):
    """K up to which stiff springs beside rigid contacts settle, at any error."""
    return STIFFEST


@borrower()
def spring_residual(shares, problem, springs, stiffness, v, held, out):
    """Fill x and p of the springs at velocities v, and out = M (v_free - v) + H^T p (B + 1, n); returns the norm of that in M^-1."""
    m, compliance, d, x, centre = len(problem.m), problem.compliance, problem.d, springs.x, springs.centre
    first, end = shares.contacts
    contact_velocity(shares, problem, v, x)
    for c in range(first, end):
        soft_n, soft_t = softness(compliance, d[c] / stiffness, c, m)
        for i in range(m):
            soft = soft_n if i == 0 else soft_t
            own = compliance[c, i] if len(compliance) else 0.0
            x[c, i] = ((soft - own) * centre[c, i] - x[c, i]) / soft
        project_trial(springs, problem.mu, c, held, m)
    missing_momentum(shares, problem, v, springs.p, out)
    return norm_of_momentum(shares, problem, out)


@borrower()
def norm_of_momentum(shares, problem, momentum):
    """Norm of momenta (B + 1, n) in M^-1."""
    n, turn, (first, end) = len(problem.n), begin_sums(shares), shares.rows
    for b in range(first, end):
        total = 0.0
        for i in range(n):
            if has_unit_masses(problem):
                total += momentum[b, i] * momentum[b, i]
                continue
            for j in range(n):
                total += momentum[b, i] * problem.inverse[b, i, j] * momentum[b, j]
        shares.sums[turn, 0, b] = total
    wait(shares.team)
    return np.sqrt(max(sum_of_rows(shares, len(problem.inverse)), 0.0))


@kernel()
def spring_direction(shares, problem, work, springs, search):
    """The Newton step, (M + H^T B H) dv = r with the residual r, which it uses up."""
    solve_by_first(shares, work.factor, search.residual)
    copy_share(shares.rows, search.residual, search.change)


@borrower()
def spring_changes(shares, problem, springs, stiffness, change):
    """Change dx of the trial impulses with a change of the velocities (B + 1, n)."""
    dx, m, (first, end) = springs.dx, len(problem.m), shares.contacts
    wait(shares.team)
    for c in range(first, end):
        soft_n, soft_t = softness(problem.compliance, problem.d[c] / stiffness, c, m)
        u0, u1, u2 = velocity_of_contact(problem, change, c)
        dx[c, 0], dx[c, 1] = -u0 / soft_n, -u1 / soft_t
        if m == 3:
            dx[c, 2] = -u2 / soft_t


BODIES = Kind(
    map_norm, contact_velocity, factorise, interior_residuals, interior_direction, movable, begin_at, spring_residual,
    spring_direction, spring_changes, stiffest, move_centre,
)  # fmt: skip


# --- the entry ----------------------------------------------------------------------------------------------------------------------


@kernel()
def in_order(shares, room, problem, elimination):
    """The :class:`OrderedProblem` of ProblemArrays."""
    order, places, (first, end) = elimination.order, elimination.places, shares.rows
    inverse, mass, free, d = allocate_problem(room, problem)
    put_in_order(problem, order, first, end, inverse, mass, free)
    ordered = OrderedProblem(
        inverse, mass, free, places, elimination.block, problem.jacobian, elimination.frame, problem.offset, problem.mu, problem.compliance,
        widths_in_order(problem.width, order), d, problem.m, problem.n,
    )  # fmt: skip
    wait(shares.team)
    measure_scales(ordered, shares.contacts[0], shares.contacts[1])
    return ordered


@kernel()
def allocate_problem(room, problem):
    """Room for M^-1, M (B, n, n), v_free (B, n) and d (C,) of ProblemArrays."""
    bodies, n = problem.v_free.shape
    return take(room, (bodies, n, n)), take(room, (bodies, n, n)), take(room, (bodies, n)), take(room, (len(problem.mu),))


@kernel()
def allocate_answer(room, shape, rows):
    """Room for the velocities of the answer, and for those without impulses of the contacts (C, m)."""
    return take(room, rows), take(room, shape)


@kernel()
def answer_of(shares, room, problem, scratch, impulse):
    """The answer to begin with: ``impulse`` (C, m) itself, and its velocities and error."""
    v, q = allocate_answer(room, impulse.shape, scratch.shape)
    copy_share(shares.rows, problem.free, v)
    contact_velocity(shares, problem, v, q)
    norm = map_norm(shares, problem, impulse, scratch, v)
    return first_answer(impulse, v, norm, q, problem.d)


@entry()
def room_needed(method: int, problem: ProblemArrays, elimination: Elimination) -> int:
    """Entries of the :class:`SharedRoom` of a team for one of these methods."""
    room, shape, rows, contacts = room_of_own(), problem.offset.shape, (len(elimination.order) + 1, len(problem.n)), len(problem.mu)
    allocate_sums(room, contacts, len(elimination.order))
    allocate_problem(room, problem)
    allocate_work(room, elimination.symbolic, problem.n, rows, len(elimination.frame))
    allocate_answer(room, shape, rows)
    if method == NEWTON:
        allocate_newton(room, shape, rows)
        allocate_law(room, shape, problem.m)
    elif method == INTERIOR:
        allocate_interior(room, shape, rows)
    elif method == PATH:
        allocate_paths(room, shape, rows)
    else:
        allocate_proximal(room, shape, rows)
    return room.used[0]


@entry()
def linearised_by_team(
    team: ThreadTeam,
    method: int,
    problem: ProblemArrays,
    elimination: Elimination,
    settings: Settings,
    impulse: np.ndarray,
    velocity: np.ndarray,
    values: np.ndarray,
) -> tuple[int, float, float, float]:
    """:func:`linearised_bodies` by a team; ``values`` are those of its :class:`SharedRoom`.

    Python enters here alone, so that their factorisation, the larger part of each, is compiled once.
    """
    room, shape, rows = SharedRoom(values, np.zeros(1, dtype=np.int64)), impulse.shape, (len(elimination.order) + 1, len(problem.n))
    bodies = len(elimination.order)
    sums = allocate_sums(room, len(impulse), bodies)
    sides = weighed_sides(elimination.places, elimination.block, bodies)  # by each thread for itself: a small part of an iteration
    shares = shares_of(team, len(impulse), sides, sums)
    ordered = in_order(shares, room, problem, elimination)
    work = allocate_work(room, elimination.symbolic, problem.n, rows, len(elimination.frame))
    answer, begin, stiffness = answer_of(shares, room, ordered, work.room, impulse), np.nan, settings.stiffness
    if method == NEWTON:
        law, inside = allocate_law(room, shape, problem.m), allocate_newton(room, shape, rows)
        iterations, begin, stiffness = newton(take_newton_step, shares, ordered, work, law, inside, answer, settings)
    elif method == INTERIOR:
        iterations = interior_point(BODIES, shares, ordered, work, allocate_interior(room, shape, rows), answer, settings)
    elif method == PATH:
        iterations = path_bodies(shares, ordered, work, allocate_paths(room, shape, rows), answer, settings)
    elif method == PIVOTING:
        iterations = pivoting_points(BODIES, shares, ordered, work, allocate_proximal(room, shape, rows), answer, settings)
    else:
        iterations = proximal_points(BODIES, shares, ordered, work, allocate_proximal(room, shape, rows), PATIENCE, answer, settings)
    for b in range(shares.rows[0], shares.rows[1]):
        for i in range(len(problem.n)):
            velocity[elimination.order[b], i] = answer.velocity[b, i]
    return iterations, answer.error[0], begin, stiffness


def linearised_bodies(
    method: int,
    problem: ProblemArrays,
    elimination: Elimination,
    settings: Settings,
    impulse: np.ndarray,
    velocity: np.ndarray,
    threads: int = 1,
) -> tuple[int, float, float, float]:
    """One of these methods over ProblemArrays. ``impulse`` (C, m) holds the start and then the best answer found, velocity (B, n) its own.

    Returns iterations, natural map error, and of Newton the error at the start and the stiffness at the end.
    """
    values = np.zeros(room_needed(method, problem, elimination) if threads > 1 else 0)
    found: tuple[int, float, float, float] = run_by_team(
        linearised_by_team, threads, method, problem, elimination, settings, impulse, velocity, values
    )
    return found
