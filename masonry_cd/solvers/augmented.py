"""The matrix of the methods that linearise the law over bodies: M + H^T B H, one block B per contact, column by column."""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.operators import has_unit_masses
from masonry_cd.jit import borrower, kernel
from masonry_cd.linalg.small_blocks import add_outer_product, is_wide
from masonry_cd.linalg.wide_columns import add_outer_products


@kernel()
def augment_blocks(problem, sides, blocks, symbolic, share, matrix):
    """The columns of a share (first, end) of the :class:`BlockMatrix` of M + H^T B H, from the sides of the contacts of their bodies.

    B has one (m, m) block per contact, the first rows of ``blocks`` (C, m or more, m). A block off the diagonal is in the column of that of
    its bodies that is eliminated first.
    """
    begin, stop = share
    turned = np.empty((2, len(problem.m), len(problem.n)))
    for b in range(begin, stop):
        load_mass(problem, b, matrix.diagonal)
        matrix.lower[symbolic.column[b] : symbolic.column[b + 1]] = 0.0
        matrix.upper[symbolic.column[b] : symbolic.column[b + 1]] = 0.0
        for e in range(sides.start[b], sides.start[b + 1]):
            add_side(problem, blocks, sides.side[e] // 2, sides.side[e] % 2, matrix, turned)


@borrower()
def load_mass(problem, b, diagonal):
    """The block of M of body b."""
    for i in range(len(problem.n)):
        for j in range(len(problem.n)):
            if has_unit_masses(problem):
                diagonal[b, i, j] = 1.0 if i == j else 0.0
            else:
                diagonal[b, i, j] = problem.mass[b, i, j]


@borrower()
def add_side(problem, blocks, c, own, matrix, turned):
    """What side ``own`` of contact c adds to the column of its body; ``turned`` (2, m, n) is scratch."""
    jacobian, k, other = problem.jacobian[c], problem.block[c], 1 - own
    b, beyond = problem.places[c, own], problem.places[c, other]
    turn_rows(problem, blocks[c], jacobian[own], b, turned[own])
    add_product(problem, jacobian[own], turned[own], b, b, matrix.diagonal[b])
    if b == beyond:  # each side adds its product with the other one
        turn_rows(problem, blocks[c], jacobian[other], b, turned[other])
        add_product(problem, jacobian[own], turned[other], b, b, matrix.diagonal[b])
    elif k >= 0 and b < beyond:
        turn_rows(problem, blocks[c], jacobian[other], beyond, turned[other])
        add_product(problem, jacobian[other], turned[own], beyond, b, matrix.lower[k])
        add_product(problem, turned[other], jacobian[own], beyond, b, matrix.upper[k])


@borrower(fastmath={"contract"})
def turn_rows(problem, block, rows, body, out):
    """out (m, n) = B H for the rows of H (m, n) of a body and the first rows of a block (m or more, m)."""
    m, n = len(problem.m), problem.width[body] if has_unit_masses(problem) else len(problem.n)
    for i in range(m):
        for q in range(n):
            total = 0.0
            for k in range(m):
                total += block[i, k] * rows[k, q]
            out[i, q] = total


@borrower()
def add_product(problem, x, y, one, other, out):
    """out += x^T y (n, n), for rows of H or B H (m, n) of two bodies."""
    m, n = len(problem.m), len(problem.n)
    if not is_wide(problem.n):
        add_outer_product(x, y, out, problem.m, problem.n)
    elif has_unit_masses(problem):
        add_outer_products(x, y, problem.width[one], problem.width[other], out, m)
    else:
        add_outer_products(x, y, n, n, out, m)
