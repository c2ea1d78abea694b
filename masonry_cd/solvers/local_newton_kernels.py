"""Semismooth Newton for problems given by W alone; see newton.py."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.local_operators import LocalArrays, local_norm, place_blocks
from masonry_cd.friction.natural_map import size_of
from masonry_cd.jit import entry, kernel
from masonry_cd.linalg.ldu import factorise_ldu
from masonry_cd.linalg.single_columns import UNSYMMETRIC
from masonry_cd.linalg.small_blocks import copy_flat, invert, multiply
from masonry_cd.linalg.supernodes import allocate_factors, allocate_matrix
from masonry_cd.linalg.symbolic import SymbolicFactor
from masonry_cd.linalg.triangular import solve_ldu
from masonry_cd.solvers.linearised import Settings
from masonry_cd.solvers.newton_kernels import LinearisedLaw, damp, linearise_law


@kernel()
def scale_rows(problem, own, p, u, stiffness, unit, scale, right):
    """The system (I + B W) (p+ - p) = g - p with its rows scaled to unit diagonal blocks, by T = (I + B W_cc)^-1.

    own (C, m, m) are the blocks W_cc. Fills unit = T and right = T (g - p) in the order of elimination, scale = T B. False if a T does not
    exist.
    """
    m, size, place = len(problem.m), problem.m, problem.place
    law = LinearisedLaw(np.zeros((1, m)), np.zeros((1, m, m)), size)
    work, inverse, room, regular = np.empty((m, m)), np.empty((m, m)), np.empty((m, m)), True
    for c in range(len(p)):
        p2, u2 = (p[c, 2], u[c, 2]) if m == 3 else (0.0, 0.0)
        linearise_law((p[c, 0], p[c, 1], p2), (u[c, 0], u[c, 1], u2), problem.mu[c], problem.d[c], stiffness, law, 0)
        multiply(law.block[0], own[c], False, work, size)
        for i in range(m):
            work[i, i] += 1.0
        regular = regular and invert(work, inverse, room, size)
        multiply(inverse, law.block[0], False, scale[c], size)
        for i in range(m):
            total = 0.0
            for j in range(m):
                total += inverse[i, j] * (law.target[0, j] - p[c, j])
                unit[place[c], i, j] = inverse[i, j]
            right[place[c], i] = total
    return regular


@entry()
def newton_local(
    problem: LocalArrays, own: np.ndarray, symbolic: SymbolicFactor, settings: Settings, p: np.ndarray
) -> tuple[int, float, float]:
    """Semismooth Newton over LocalArrays. p (C, m) holds the start and then the best answer.

    Returns iterations, error, error at the start.
    """
    count, m, place = len(p), len(problem.m), problem.place
    matrix, factor = allocate_matrix(symbolic, problem.m), allocate_factors(symbolic, problem.m)
    scale, right, unit = np.empty((count, m, m)), np.empty(p.shape), np.empty((count, m, m))
    size = size_of(problem.q, problem.d)
    u, best, hold = np.empty(p.shape), p.copy(), p.copy()
    smallest = error = begin = local_norm(problem, p, u) / size
    stiffness, iterations, refused = settings.stiffness, 0, 0
    while iterations < settings.limit and smallest > settings.tolerance and refused < 8:
        regular = scale_rows(problem, own, p, u, stiffness, unit, scale, right)
        place_blocks(problem, scale, symbolic, UNSYMMETRIC, matrix)
        for i in range(count):
            for r in range(m):
                for s in range(m):
                    matrix.diagonal[i, r, s] += unit[i, r, s]
        iterations += 1
        new = np.inf
        if regular and factorise_ldu(matrix, factor):
            solve_ldu(factor, right)
            for c in range(count):
                for i in range(m):
                    p[c, i] += right[place[c], i]
            new = local_norm(problem, p, u) / size
        accepted, stiffness = damp(new, error, iterations == 1, stiffness)
        if accepted:
            error, refused = new, 0
            copy_flat(p, hold)
        else:
            refused += 1
            copy_flat(hold, p)
            local_norm(problem, p, u)
        if error < smallest:
            smallest = error
            copy_flat(p, best)
    copy_flat(best, p)
    return iterations, smallest, begin
