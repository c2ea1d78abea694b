"""What the methods that linearise the law share: their settings, the best answer so far, and what they ask of a problem.

Newton, the interior point method and proximal points are written once, for problems over bodies and for those given by W alone. What
differs between these, such as the matrix that is factorised, are the kernels of a :class:`Kind`: linearised_bodies.py has those of the
one, linearised_local.py those of the other. A team of threads shares them, see shares.py; a problem given by W alone has one thread.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.joint_twists import frames_of
from masonry_cd.mechanics.friction.natural_map import size_of
from masonry_cd.mechanics.friction.operators import ProblemArrays
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.linalg.supernodes import BlockMatrix, Factor
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor
from masonry_cd.mechanics.linalg.threads import take
from masonry_cd.mechanics.solvers.augmented import NUMBERS
from masonry_cd.mechanics.solvers.shares import copy_share

Kernel = Any  # a compiled function


class Elimination(NamedTuple):
    """The order in which bodies are eliminated, and where the contacts stand in it."""

    order: np.ndarray  # (B,) body at each place
    symbolic: SymbolicFactor
    places: np.ndarray  # (C, 2) places of the bodies; B: a support
    block: np.ndarray  # (C,) the block that couples them, -1: none
    frame: np.ndarray  # (C, 15) the frames of the contacts or (0, 15), see :class:`OrderedProblem`


def elimination_of(problem: ProblemArrays, pattern: Pattern, places: np.ndarray, block: np.ndarray) -> Elimination:
    """The :class:`Elimination` of a problem whose contacts have these places (C, 2) of bodies and blocks (C,) in a pattern."""
    return Elimination(pattern.order, pattern.symbolic, places, block, frames_of(problem.jacobian, problem.bodies))


class Settings(NamedTuple):
    """What a method is to do. Not each of them needs all."""

    distance: float  # of the start from the walls of the cones, relative to the largest speed
    stiffness: float  # K to begin with
    wide: float  # how far products may be off the central path, relative to those on it
    tolerance: float  # natural map error at which to stop
    limit: int  # iterations, one factorisation each
    k: tuple[int, ...]  # m + 1 zeros: as many products as a contact has


class Answer(NamedTuple):
    """The best answer so far; its arrays are overwritten by a better one."""

    impulse: np.ndarray  # (C, m)
    velocity: np.ndarray  # (B + 1, n)
    error: np.ndarray  # (1,) natural map error; of each thread its own
    size: float  # |q / sqrt(d)|, by which errors are divided
    speed: float  # largest component of q


class Work(NamedTuple):
    """Room for the matrix of a problem whose law is linearised, for its factors, and for one more array."""

    matrix: BlockMatrix
    factor: Factor
    world: np.ndarray  # (C, NUMBERS) the blocks of contacts between rigid blocks in space, see augmented.py, or (0, NUMBERS)
    signs: np.ndarray  # (K,) of the determinants of the subtrees
    room: np.ndarray  # (B + 1, n) or (C, m), as velocities


class Kind(NamedTuple):
    """What the methods ask of a kind of problem, over bodies or given by W alone: kernels that theirs are given.

    Velocities v are those of the bodies (B + 1, n), or where W alone is given those of the contacts (C, m). Each kernel does the ``shares``
    of its thread; those that read what others have done wait for them first.
    """

    map_norm: Kernel  # (shares, problem, p, room, v): norm of the natural map of impulses p (C, m); v <- their velocities
    contact_velocity: Kernel  # (shares, problem, v, u): u (C, m) <- velocities of the contacts
    factorise: Kernel  # (shares, problem, work, blocks): for laws dp = -B du, B the first rows of blocks; the sign of the determinant or 0
    # interior point
    interior_residuals: Kernel  # (shares, problem, here, linear, room): what w and v miss
    interior_direction: Kernel  # (shares, problem, work, cones, linear, way): changes the products as wanted and takes these residuals away
    # proximal points
    movable: Kernel  # (problem, free, offset): ``moved``, the problem with velocities as they are counted while springs settle
    begin_at: Kernel  # (shares, problem, moved, centre, v): v <- the velocities of the centre
    spring_residual: Kernel  # (shares, moved, springs, stiffness, v, held, out): x and p of the springs, what v misses and its norm
    spring_direction: Kernel  # (shares, moved, work, springs, search): the Newton step
    spring_changes: Kernel  # (shares, moved, springs, stiffness, change): change dx of the trial impulses with one of the velocities
    stiffest: Kernel  # (error): the stiffest springs whose problem can be solved where rounding is felt
    move_centre: Kernel  # (shares, centre, v): centre <- the velocities v


@kernel()
def allocate_work(room, symbolic, size, velocity, world):
    """:class:`Work` for blocks of a size, see small_blocks.py, velocities of a shape, and as many contacts as ``world`` has."""
    n, nodes, pairs = len(size), len(symbolic.column) - 1, len(symbolic.row)
    matrix = BlockMatrix(take(room, (nodes, n, n)), take(room, (pairs, n, n)), take(room, (pairs, n, n)))
    panel = n * n * symbolic.panel[-1]
    factor = Factor(symbolic, take(room, (n * n * symbolic.square[-1],)), take(room, (panel,)), take(room, (panel,)), size)
    return Work(matrix, factor, take(room, (world, NUMBERS)), take(room, (len(symbolic.subtree) - 1,)), take(room, velocity))


@kernel(inline="always")
def first_answer(impulse, v, norm, q, d):
    """The :class:`Answer` with which a method begins: impulses (C, m), their velocities, and the norm of their natural map."""
    size, error = size_of(q, d), np.empty(1)
    error[0] = norm / size
    return Answer(impulse, v, error, size, largest(q))


@borrower()
def largest(x):
    """Largest size of an entry of x (C, m)."""
    most = 0.0
    for c in range(len(x)):
        for i in range(x.shape[1]):
            most = max(most, abs(x[c, i]))
    return most


@borrower()
def keep_better(shares, answer, p, v, error):
    """Take impulses p and velocities v as the answer if their error is less than that of the best so far."""
    if error < answer.error[0]:
        answer.error[0] = error
        copy_share(shares.contacts, p, answer.impulse)
        copy_share(shares.rows, v, answer.velocity)


@kernel()
def copies_of(shares, room, answer):
    """Impulses (C, m) and velocities to go on from, those of the answer."""
    p, v = take(room, answer.impulse.shape), take(room, answer.velocity.shape)
    copy_share(shares.contacts, answer.impulse, p)
    copy_share(shares.rows, answer.velocity, v)
    return p, v
