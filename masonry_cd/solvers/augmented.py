r"""The matrix of the methods that linearise the law over bodies: M + H^T B H, one block B per contact, column by column.

Between rigid blocks in space a contact has rows (D, D [r]x^T) for a body whose centre it is r away from, with opposite signs for its two
bodies, D its frame. So all that it adds follows from D^T B D, in the axes of the world, by cross products,

    J_r^T B J_c = (I, [r]x)^T D^T B D (I, -[c]x),

in a third of the operations.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.operators import has_unit_masses
from masonry_cd.jit import borrower, kernel
from masonry_cd.linalg.small_blocks import add_outer_product, is_wide
from masonry_cd.linalg.wide_columns import add_outer_products

NUMBERS = 15  # of a contact between rigid blocks: D^T B D, and the arms r of both bodies


@kernel(inline="always")
def has_frames(problem, sides):
    """Whether all rows are those of frames between rigid blocks in space; known to be false elsewhere when kernels are compiled."""
    return len(problem.n) == 6 and len(problem.m) == 3 and sides.rigid


@borrower(fastmath={"contract"})
def turn_blocks(problem, sides, blocks, first, end, world):
    """Fill ``world`` (C, NUMBERS) for the contacts first to end of rigid blocks in space, from B, the first rows of ``blocks``."""
    if not has_frames(problem, sides):
        return
    for c in range(first, end):
        jacobian, block, out = problem.jacobian[c], blocks[c], world[c]
        side = 0 if problem.places[c, 0] < len(problem.mass) else 1
        for q in range(3):
            t0 = block[0, 0] * jacobian[side, 0, q] + block[0, 1] * jacobian[side, 1, q] + block[0, 2] * jacobian[side, 2, q]
            t1 = block[1, 0] * jacobian[side, 0, q] + block[1, 1] * jacobian[side, 1, q] + block[1, 2] * jacobian[side, 2, q]
            t2 = block[2, 0] * jacobian[side, 0, q] + block[2, 1] * jacobian[side, 1, q] + block[2, 2] * jacobian[side, 2, q]
            for p in range(3):
                out[3 * p + q] = jacobian[side, 0, p] * t0 + jacobian[side, 1, p] * t1 + jacobian[side, 2, p] * t2
        for s in range(2):  # r = sum of d_i x (r x d_i) / 2, of supports zero
            for k in range(3):
                j, l, total = (k + 1) % 3, (k + 2) % 3, 0.0  # noqa: E741
                for i in range(3):
                    total += jacobian[s, i, j] * jacobian[s, i, 3 + l] - jacobian[s, i, l] * jacobian[s, i, 3 + j]
                out[9 + 3 * s + k] = 0.5 * total


@kernel(fastmath={"contract"})
def augment_blocks(problem, sides, blocks, world, symbolic, share, matrix):
    """The columns of a share (first, end) of the :class:`BlockMatrix` of M + H^T B H, from the sides of the contacts of their bodies.

    B has one (m, m) block per contact, the first rows of ``blocks`` (C, m or more, m); ``world`` is what :func:`turn_blocks` made of them.
    A block off the diagonal is in the column of that of its bodies that is eliminated first.
    """
    begin, stop = share
    places, block, turned = problem.places, problem.block, np.empty((2, len(problem.m), len(problem.n)))
    diagonal, lower, upper = matrix.diagonal, matrix.lower, matrix.upper
    for b in range(begin, stop):
        load_mass(problem, b, diagonal)
        lower[symbolic.column[b] : symbolic.column[b + 1]] = 0.0
        upper[symbolic.column[b] : symbolic.column[b + 1]] = 0.0
        for e in range(sides.start[b], sides.start[b + 1]):
            c, own = sides.side[e] >> 1, sides.side[e] & 1
            k, beyond = block[c], places[c, 1 - own]
            later = k >= 0 and b < beyond
            if has_frames(problem, sides):
                add_turned(world[c], own, own, False, 1.0, diagonal[b])
                if b == beyond:
                    add_turned(world[c], own, 1 - own, False, -1.0, diagonal[b])
                elif later:
                    add_turned(world[c], 1 - own, own, False, -1.0, lower[k])
                    add_turned(world[c], 1 - own, own, True, -1.0, upper[k])
                continue
            one, other = problem.jacobian[c, own], problem.jacobian[c, 1 - own]
            turn_rows(problem, blocks[c], one, b, turned[0])
            add_product(problem, one, turned[0], b, b, diagonal[b])
            if b == beyond or later:
                turn_rows(problem, blocks[c], other, beyond, turned[1])
            if b == beyond:  # each side adds its product with the other one
                add_product(problem, one, turned[1], b, b, diagonal[b])
            elif later:
                add_product(problem, other, turned[0], beyond, b, lower[k])
                add_product(problem, turned[1], one, beyond, b, upper[k])


@borrower()
def load_mass(problem, b, diagonal):
    """The block of M of body b."""
    for i in range(len(problem.n)):
        for j in range(len(problem.n)):
            if has_unit_masses(problem):
                diagonal[b, i, j] = 1.0 if i == j else 0.0
            else:
                diagonal[b, i, j] = problem.mass[b, i, j]


@kernel(inline="always")
def add_turned(turned, row, column, transposed, sign, out):
    """out (6, 6) += sign J_r^T B J_c of a contact's NUMBERS, for its sides ``row`` and ``column``, with B^T if ``transposed``."""
    r0, r1, r2 = sign * turned[9 + 3 * row], sign * turned[10 + 3 * row], sign * turned[11 + 3 * row]
    c0, c1, c2 = turned[9 + 3 * column], turned[10 + 3 * column], turned[11 + 3 * column]
    along, across = (1, 3) if transposed else (3, 1)
    for j in range(3):  # column j of D^T B D, and of it times -[c]x
        x0, x1, x2 = turned[across * j], turned[along + across * j], turned[2 * along + across * j]
        k, l = (j + 1) % 3, (j + 2) % 3  # noqa: E741
        ck, cl = (c1, c2) if j == 0 else ((c2, c0) if j == 1 else (c0, c1))
        y0 = ck * turned[across * l] - cl * turned[across * k]
        y1 = ck * turned[along + across * l] - cl * turned[along + across * k]
        y2 = ck * turned[2 * along + across * l] - cl * turned[2 * along + across * k]
        out[0, j] += sign * x0
        out[1, j] += sign * x1
        out[2, j] += sign * x2
        out[3, j] += r1 * x2 - r2 * x1
        out[4, j] += r2 * x0 - r0 * x2
        out[5, j] += r0 * x1 - r1 * x0
        out[0, 3 + j] += sign * y0
        out[1, 3 + j] += sign * y1
        out[2, 3 + j] += sign * y2
        out[3, 3 + j] += r1 * y2 - r2 * y1
        out[4, 3 + j] += r2 * y0 - r0 * y2
        out[5, 3 + j] += r0 * y1 - r1 * y0


@kernel(inline="always")
def turn_rows(problem, block, rows, body, out):
    """out (m, n) = B H for the rows of H (m, n) of a body and the first rows of a block (m or more, m)."""
    m, n = len(problem.m), problem.width[body] if has_unit_masses(problem) else len(problem.n)
    for i in range(m):
        for q in range(n):
            total = 0.0
            for k in range(m):
                total += block[i, k] * rows[k, q]
            out[i, q] = total


@kernel(inline="always")
def add_product(problem, x, y, one, other, out):
    """out += x^T y (n, n), for rows of H or B H (m, n) of two bodies."""
    m, n = len(problem.m), len(problem.n)
    if not is_wide(problem.n):
        add_outer_product(x, y, out, problem.m, problem.n)
    elif has_unit_masses(problem):
        add_outer_products(x, y, problem.width[one], problem.width[other], out, m)
    else:
        add_outer_products(x, y, n, n, out, m)
