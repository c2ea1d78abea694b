# SPDX-License-Identifier: GPL-3.0-or-later
"""What the methods that linearise the law share: their settings, the best answer so far, and room for the matrix that they factorise.

Newton, the interior point method and proximal points are written once, for problems over bodies and for those given by W alone: what these
differ in are the operators of friction/operators.py, and the assembly of the matrix in augmented.py. A team of threads shares them, see
shares.py.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.linalg.supernodes import BlockMatrix, Factor
from masonry_cd.mechanics.linalg.symbolic import SymbolicFactor
from masonry_cd.mechanics.linalg.threads import take
from masonry_cd.mechanics.solvers.augmented import NUMBERS
from masonry_cd.mechanics.solvers.shares import copy_share

if TYPE_CHECKING:
    from masonry_cd.mechanics.friction.problem import Problem

STIFFEST = 1e12  # K of interior and proximal points; stiff springs beside rigid contacts settle where K exceeds d / C


class Elimination(NamedTuple):
    """The order in which bodies are eliminated, and where the contacts stand in it."""

    order: np.ndarray  # (B,) body at each place
    symbolic: SymbolicFactor
    places: np.ndarray  # (C, 2) places of the bodies; B: a support
    block: np.ndarray  # (C,) the block that couples them, -1: none
    frame: np.ndarray  # (C, 15) the frames of the contacts or (0, 15), see :class:`OrderedProblem`


def elimination_of(problem: Problem, pattern: Pattern, places: np.ndarray, block: np.ndarray) -> Elimination:
    """The :class:`Elimination` of a problem whose contacts have these places (C, 2) of bodies and blocks (C,) in a pattern."""
    return Elimination(pattern.order, pattern.symbolic, places, block, problem.frames)


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
    room: np.ndarray  # (B + 1, n), as velocities


@kernel()
def allocate_work(room, symbolic, size, velocity, world):
    """:class:`Work` for blocks of a size, see small_blocks.py, velocities of a shape, and as many contacts as ``world`` has."""
    n, nodes, pairs = len(size), len(symbolic.column) - 1, len(symbolic.row)
    matrix = BlockMatrix(take(room, (nodes, n, n)), take(room, (pairs, n, n)), take(room, (pairs, n, n)))
    panel = n * n * symbolic.panel[-1]
    factor = Factor(symbolic, take(room, (n * n * symbolic.square[-1],)), take(room, (panel,)), take(room, (panel,)), size)
    return Work(matrix, factor, take(room, (world, NUMBERS)), take(room, (len(symbolic.subtree) - 1,)), take(room, velocity))


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
