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
    Elimination,
    ProblemArrays,
    put_in_order,
    room_in_order,
    squared_size_of,
)
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor
from masonry_cd.mechanics.linalg.threads import SharedArena, ThreadTeam, own_arena, run_by_team, take, wait
from masonry_cd.mechanics.solvers.central_path import allocate_interior
from masonry_cd.mechanics.solvers.interior_kernels import interior_point, path_by_length
from masonry_cd.mechanics.solvers.linearised import (
    BestSolution,
    MethodSettings,
    Work,
    allocate_work,
    largest,
    law_velocity,
    map_norm,
)
from masonry_cd.mechanics.solvers.newton_kernels import allocate_newton, newton_points
from masonry_cd.mechanics.solvers.pivoting_kernels import allocate_pivoting, pivoting_points
from masonry_cd.mechanics.solvers.recall import Recalled
from masonry_cd.mechanics.solvers.shares import allocate_sums, copy_share, shares_of


class Common(NamedTuple):
    """Memory that each of these methods needs."""

    sums: np.ndarray  # of :class:`Shares`
    v: np.ndarray  # (B + 1, n) velocities of the answer
    q: np.ndarray  # (C, m) velocities of the contacts without impulses
    work: Work


@kernel()
def allocate_common(arena, problem, symbolic):
    """:class:`Common` for ProblemArrays."""
    shape, (bodies, n) = problem.offset.shape, problem.free.shape
    rows = (bodies + 1, n)
    work = allocate_work(arena, symbolic, problem.n, rows, len(problem.geometry.frame))
    return Common(allocate_sums(arena, shape[0], bodies), take(arena, rows), take(arena, shape), work)


@kernel()
def answer_of(shares, common, problem, impulse):
    """The answer to begin with: ``impulse`` (C, m) itself, and its velocities and error."""
    v, q, error = common.v, common.q, np.empty(1)
    copy_share(shares.rows, problem.free, v)
    law_velocity(shares, problem, v, q)
    square = squared_size_of(problem, v, 0, len(q))
    size = np.sqrt(square) if square > 0.0 else 1.0
    wait(shares.team)
    error[0] = map_norm(shares, problem, impulse, common.work.scratch, v) / size
    return BestSolution(impulse, v, error, size, largest(q))


@entry()
def room_needed(problem: ProblemArrays, elimination: Elimination, symbolic: SymbolicFactor) -> int:
    """Entries of the :class:`SharedArena` of a team, enough for each of these methods."""
    arena, shape = own_arena(), problem.offset.shape
    rows = allocate_common(arena, room_in_order(arena, problem, elimination, problem.coupling), symbolic).v.shape
    allocate_interior(arena, shape, rows)
    allocate_newton(arena, shape, rows)
    return int(arena.used[0])


class Given(NamedTuple):
    """Arrays that a method is given, and those that it overwrites."""

    problem: ProblemArrays
    elimination: Elimination
    symbolic: SymbolicFactor
    settings: MethodSettings
    impulse: np.ndarray  # (C, m) the start, and then the best answer found
    velocity: np.ndarray  # (B, n) its own
    values: np.ndarray  # of a :class:`SharedArena`


@kernel()
def improve(method, allocate, team, given):
    """Iterations and natural map error of a method, which works on what ``allocate`` makes, by a thread of a team."""
    problem, elimination, symbolic, settings, impulse, velocity, values = given
    arena, order = SharedArena(values, np.zeros(1, dtype=np.int64)), elimination.order
    ordered = room_in_order(arena, problem, elimination, problem.coupling)
    common = allocate_common(arena, ordered, symbolic)
    shares = shares_of(team, len(impulse), len(order), common.sums)
    put_in_order(problem, order, shares.rows[0], shares.rows[1], ordered)
    wait(team)
    answer = answer_of(shares, common, ordered, impulse)
    workspace = allocate(arena, impulse.shape, common.v.shape)
    iterations = method(shares, ordered, common.work, workspace, answer, settings)
    for b in range(shares.rows[0], shares.rows[1]):
        for i in range(len(ordered.n)):
            velocity[order[b], i] = answer.velocity[b, i]
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
    return improve(path_by_length, allocate_interior, team, given)


def over_bodies(
    by_team: Entry,
    problem: ProblemArrays,
    recalled: Recalled,
    settings: MethodSettings,
    impulse: np.ndarray,
    velocity: np.ndarray,
    threads: int = 1,
) -> tuple[int, float]:
    """One of these methods over ProblemArrays. ``impulse`` (C, m) holds the start and then the best answer found, velocity (B, n) its own.

    Returns iterations, one factorisation each, and the natural map error.
    """
    elimination, symbolic = recalled.elimination, recalled.factors.pattern.symbolic
    values = np.zeros(room_needed(problem, elimination, symbolic) if threads > 1 else 0)
    given = Given(problem, elimination, symbolic, settings, impulse, velocity, values)
    found: tuple[int, float] = run_by_team(by_team, threads, given)
    return found
