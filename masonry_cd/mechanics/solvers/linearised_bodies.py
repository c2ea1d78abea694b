# SPDX-License-Identifier: GPL-3.0-or-later
"""The methods that linearise the law: Newton, pivoting, the interior point method and the path by its length.

The matrix that all of them factorise is M + G B H, B from the linearised laws; see linearised.py for what they share, and shares.py for
what each thread of a team does of it. Each has an entry of its own, so that a run compiles and loads those that it comes to.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import Entry, entry, kernel
from masonry_cd.mechanics.friction.operators import (
    OrderedProblem,
    ProblemArrays,
    measure_scales,
    put_in_order,
    squared_size_of,
    widths_in_order,
)
from masonry_cd.mechanics.linalg.threads import SharedRoom, ThreadTeam, room_of_own, run_by_team, take, wait
from masonry_cd.mechanics.solvers.interior_kernels import allocate_interior, interior_point
from masonry_cd.mechanics.solvers.linearised import Answer, Elimination, Settings, Work, allocate_work, largest
from masonry_cd.mechanics.solvers.newton_kernels import allocate_newton, newton_points
from masonry_cd.mechanics.solvers.path_kernels import allocate_paths, path_by_length
from masonry_cd.mechanics.solvers.pivoting_kernels import allocate_pivoting, pivoting_points
from masonry_cd.mechanics.solvers.shared_operators import contact_velocity, map_norm
from masonry_cd.mechanics.solvers.shares import Shares, allocate_sums, copy_share, shares_of


@kernel()
def in_order(shares, room, problem, elimination):
    """The :class:`OrderedProblem` of ProblemArrays."""
    order, places, (first, end) = elimination.order, elimination.places, shares.rows
    inverse, mass, free, d = allocate_problem(room, problem)
    put_in_order(problem, order, first, end, inverse, mass, free)
    ordered = OrderedProblem(
        inverse, mass, free, places, elimination.block, problem.jacobian, elimination.frame, problem.offset, problem.mu, problem.compliance,
        widths_in_order(problem.width, order), d, problem.coupling, problem.m, problem.n,
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
    square, error = squared_size_of(problem, v, 0, len(q)), np.empty(1)
    size = np.sqrt(square) if square > 0.0 else 1.0
    wait(shares.team)
    error[0] = map_norm(shares, problem, impulse, scratch, v) / size
    return Answer(impulse, v, error, size, largest(q))


class Begun(NamedTuple):
    """What each method over bodies works with."""

    room: SharedRoom  # for what is its own
    shares: Shares
    problem: OrderedProblem
    work: Work
    answer: Answer


@entry()
def room_needed(problem: ProblemArrays, elimination: Elimination) -> int:
    """Entries of the :class:`SharedRoom` of a team, enough for each of these methods."""
    room, shape, rows, contacts = room_of_own(), problem.offset.shape, (len(elimination.order) + 1, len(problem.n)), len(problem.mu)
    allocate_sums(room, contacts, len(elimination.order))
    allocate_problem(room, problem)
    allocate_work(room, elimination.symbolic, problem.n, rows, len(elimination.frame))
    allocate_answer(room, shape, rows)
    allocate_interior(room, shape, rows)
    allocate_paths(room, shape, rows)
    allocate_newton(room, shape, rows)
    return int(room.used[0])


class Given(NamedTuple):
    """What a method is given, and what it overwrites."""

    problem: ProblemArrays
    elimination: Elimination
    settings: Settings
    impulse: np.ndarray  # (C, m) the start, and then the best answer found
    velocity: np.ndarray  # (B, n) its own
    values: np.ndarray  # of a :class:`SharedRoom`


@kernel()
def begin(team, given):
    """What a method begins with."""
    problem, elimination, _, impulse, _, values = given
    room, rows = SharedRoom(values, np.zeros(1, dtype=np.int64)), (len(elimination.order) + 1, len(problem.n))
    bodies = len(elimination.order)
    sums = allocate_sums(room, len(impulse), bodies)
    shares = shares_of(team, len(impulse), bodies, sums)
    ordered = in_order(shares, room, problem, elimination)
    work = allocate_work(room, elimination.symbolic, problem.n, rows, len(elimination.frame))
    return Begun(room, shares, ordered, work, answer_of(shares, room, ordered, work.room, impulse))


@kernel()
def improve(method, allocate, team, given):
    """Iterations and natural map error of a method, which works on what ``allocate`` makes, by a thread of a team."""
    room, shares, ordered, work, answer = begin(team, given)
    inside = allocate(room, given.impulse.shape, work.room.shape)
    iterations = method(shares, ordered, work, inside, answer, given.settings)
    for b in range(shares.rows[0], shares.rows[1]):
        for i in range(len(ordered.n)):
            given.velocity[given.elimination.order[b], i] = answer.velocity[b, i]
    return iterations, answer.error[0]


@entry()
def newton_by_team(team: ThreadTeam, given: Given) -> tuple[int, float]:
    """Proximal points with Newton's steps."""
    return improve(newton_points, allocate_newton, team, given)


@entry()
def pivoting_by_team(team: ThreadTeam, given: Given) -> tuple[int, float]:
    """Proximal points with pivoting, by a team of one thread."""
    return improve(pivoting_points, allocate_pivoting, team, given)


@entry()
def interior_by_team(team: ThreadTeam, given: Given) -> tuple[int, float]:
    """The interior point method."""
    return improve(interior_point, allocate_interior, team, given)


@entry()
def path_by_team(team: ThreadTeam, given: Given) -> tuple[int, float]:
    """The path by its length."""
    return improve(path_by_length, allocate_paths, team, given)


def over_bodies(
    by_team: Entry,
    problem: ProblemArrays,
    elimination: Elimination,
    settings: Settings,
    impulse: np.ndarray,
    velocity: np.ndarray,
    threads: int = 1,
) -> tuple[int, float]:
    """One of these methods over ProblemArrays. ``impulse`` (C, m) holds the start and then the best answer found, velocity (B, n) its own.

    Returns iterations, one factorisation each, and the natural map error.
    """
    values = np.zeros(room_needed(problem, elimination) if threads > 1 else 0)
    found: tuple[int, float] = run_by_team(by_team, threads, Given(problem, elimination, settings, impulse, velocity, values))
    return found
