"""What the methods that linearise the law share: their settings, the best answer so far, and what they ask of a problem.

Newton, the interior point method and proximal points are written once, for problems over bodies and for those given by W alone. What
differs between these, such as the matrix that is factorised, are the kernels of a :class:`Kind`: linearised_bodies.py has those of the
one, linearised_local.py those of the other.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from masonry_cd.friction.natural_map import size_of
from masonry_cd.friction.operators import has_unit_masses
from masonry_cd.jit import borrower, kernel
from masonry_cd.linalg.small_blocks import add_outer_product, copy_flat, is_wide
from masonry_cd.linalg.supernodes import BlockMatrix, Factor, allocate_factors, allocate_matrix
from masonry_cd.linalg.symbolic import SymbolicFactor
from masonry_cd.linalg.wide_columns import add_turned_product

Kernel = Any  # a compiled function


class Elimination(NamedTuple):
    """The order in which bodies are eliminated, and where the contacts stand in it."""

    order: np.ndarray  # (B,) body at each place
    symbolic: SymbolicFactor
    places: np.ndarray  # (C, 2) places of the bodies; B: a support
    block: np.ndarray  # (C,) the block that couples them, -1: none


class Settings(NamedTuple):
    """What a method is to do. Not each of them needs all."""

    distance: float  # of the start from the walls of the cones, relative to the largest speed
    stiffness: float  # K to begin with
    wide: float  # how far products may be off the central path, relative to those on it
    tolerance: float  # natural map error at which to stop
    limit: int  # iterations, one factorisation each
    k: tuple[int, ...]  # m + 1 zeros: as many products as a contact has
    accept: float = 0.0  # natural map error that will do
    enough: int = 0  # after so many iterations


class Answer(NamedTuple):
    """The best answer so far; its arrays are overwritten by a better one."""

    impulse: np.ndarray  # (C, m)
    velocity: np.ndarray  # (B + 1, n)
    error: np.ndarray  # (1,) natural map error
    size: float  # |q / sqrt(d)|, by which errors are divided
    speed: float  # largest component of q


class Work(NamedTuple):
    """Room for the matrix of a problem whose law is linearised, for its factors, and for one more array."""

    matrix: BlockMatrix
    factor: Factor
    room: np.ndarray  # (B + 1, n) or (C, m), as velocities


class Kind(NamedTuple):
    """What the methods ask of a kind of problem, over bodies or given by W alone: kernels that theirs are given.

    Velocities v are those of the bodies (B + 1, n), or where W alone is given those of the contacts (C, m).
    """

    map_norm: Kernel  # (problem, p, room, v): norm of the natural map of impulses p (C, m); v <- their velocities
    contact_velocity: Kernel  # (problem, v, u): u (C, m) <- velocities of the contacts
    factorise: Kernel  # (problem, work, blocks): for laws dp = -B du, B the first rows of blocks; the sign of the determinant or 0
    # interior point
    interior_residuals: Kernel  # (problem, here, linear, room): what w and v miss
    interior_direction: Kernel  # (problem, work, linear, way): changes the products as wanted and takes these residuals away
    # proximal points
    movable: Kernel  # (problem): ``moved``, the problem with velocities as they are counted while springs settle
    begin_at: Kernel  # (problem, moved, centre, v): v <- the velocities of the centre
    spring_residual: Kernel  # (moved, springs, stiffness, v, held, out): x and p of the springs, what v misses, and the norm of that
    spring_direction: Kernel  # (moved, work, springs, search): the Newton step
    spring_changes: Kernel  # (moved, springs, stiffness, change): change dx of the trial impulses with one of the velocities
    stiffest: Kernel  # (error): the stiffest springs whose problem can be solved where rounding is felt
    move_centre: Kernel  # (centre, v): centre <- the velocities v


@kernel(inline="always")
def allocate_work(symbolic, size, velocity):
    """:class:`Work` for blocks of a size, see small_blocks.py, and velocities like those given."""
    return Work(allocate_matrix(symbolic, size), allocate_factors(symbolic, size), np.empty(velocity.shape))


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
def keep_better(answer, p, v, error):
    """Take impulses p and velocities v as the answer if their error is less than that of the best so far."""
    if error < answer.error[0]:
        answer.error[0] = error
        copy_flat(p, answer.impulse)
        copy_flat(v, answer.velocity)


@kernel(fastmath={"contract"})
def augment_blocks(problem, blocks, matrix):
    """The :class:`BlockMatrix` of M + H^T B H; B has one (m, m) block per contact, the first rows of ``blocks`` (C, m or more, m)."""
    if is_wide(problem.n):
        augment_wide_blocks(problem, blocks, matrix)
        return
    jacobian, index, block, bodies = problem.jacobian, problem.places, problem.block, len(problem.mass)
    diagonal, lower, upper, m, n = matrix.diagonal, matrix.lower, matrix.upper, len(problem.m), len(problem.n)
    copy_flat(problem.mass, diagonal)
    lower[:] = 0.0
    upper[:] = 0.0
    turned = np.empty((2, m, n))
    for c in range(len(index)):
        a, b = index[c, 0], index[c, 1]
        for side in range(2):
            for i in range(m):
                for q in range(n):
                    total = 0.0
                    for k in range(m):
                        total += blocks[c, i, k] * jacobian[c, side, k, q]
                    turned[side, i, q] = total
            body = index[c, side]
            if body < bodies:
                add_outer_product(jacobian[c, side], turned[side], diagonal[body], problem.m, problem.n)
        if a == b < bodies:
            for p in range(n):
                for q in range(n):
                    for i in range(m):
                        diagonal[a, p, q] += jacobian[c, 0, i, p] * turned[1, i, q] + jacobian[c, 1, i, p] * turned[0, i, q]
        if block[c] >= 0:
            low = 1 if a > b else 0
            high = 1 - low
            add_outer_product(jacobian[c, high], turned[low], lower[block[c]], problem.m, problem.n)
            add_outer_product(turned[high], jacobian[c, low], upper[block[c]], problem.m, problem.n)


@kernel()
def augment_wide_blocks(problem, blocks, matrix):
    """:func:`augment_blocks` for wide blocks: as many rows and columns of each as its bodies have unknowns. All contacts of a joint, which
    stand one after another, are added at once, so that each block is read and written once a joint."""
    jacobian, index, block, bodies = problem.jacobian, problem.places, problem.block, len(problem.mass)
    m, n = len(problem.m), len(problem.n)
    unit, most = has_unit_masses(problem), longest_run(index)
    width, own, turned = np.zeros(2, dtype=np.int64), np.empty((2, most * m, n)), np.empty((2, most * m, n))
    matrix.lower[:] = 0.0
    matrix.upper[:] = 0.0
    if unit:
        matrix.diagonal[:] = 0.0
        for b in range(bodies):
            for i in range(n):
                matrix.diagonal[b, i, i] = 1.0
    else:
        copy_flat(problem.mass, matrix.diagonal)
    first = 0
    while first < len(index):
        a, b, end = index[first, 0], index[first, 1], end_of_run(index, first)
        rows = m * (end - first)
        for side in range(2):
            body = index[first, side]
            width[side] = 0 if body == bodies else problem.width[body] if unit else n
            take_rows(blocks, jacobian, (first, end, side), width[side], (own[side], turned[side]), problem.m)
            if body < bodies:
                add_turned_product(own[side], turned[side], rows, (width[side], width[side]), matrix.diagonal[body])
        if a == b < bodies:
            add_turned_product(own[0], turned[1], rows, (width[0], width[0]), matrix.diagonal[a])
            add_turned_product(own[1], turned[0], rows, (width[0], width[0]), matrix.diagonal[a])
        if block[first] >= 0:
            low = 1 if a > b else 0
            high, size = 1 - low, (width[1 - low], width[low])
            add_turned_product(own[high], turned[low], rows, size, matrix.lower[block[first]])
            add_turned_product(turned[high], own[low], rows, size, matrix.upper[block[first]])
        first = end


@borrower()
def end_of_run(places, first):
    """The end of the contacts from ``first`` on that lie one after another between the same two bodies, by their places (C, 2)."""
    end = first + 1
    while end < len(places) and places[end, 0] == places[first, 0] and places[end, 1] == places[first, 1]:
        end += 1
    return end


@borrower()
def longest_run(places):
    """The most contacts of such a run."""
    most, first = 0, 0
    while first < len(places):
        end = end_of_run(places, first)
        most, first = max(most, end - first), end
    return most


@borrower(fastmath={"contract"})
def take_rows(blocks, jacobian, contacts, width, out, size_m):
    """The rows H of some contacts on one of their sides, and B H, one after another into two arrays (K m, n)."""
    (first, end, side), (own, turned), m = contacts, out, len(size_m)
    for c in range(first, end):
        at = m * (c - first)
        for i in range(m):
            for q in range(width):
                total = 0.0
                for k in range(m):
                    total += blocks[c, i, k] * jacobian[c, side, k, q]
                own[at + i, q], turned[at + i, q] = jacobian[c, side, i, q], total
