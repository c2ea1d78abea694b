r"""The matrix of the methods that linearise the law over bodies: M + H^T B H, one block B per contact, column by column.

Between rigid blocks in space a contact has rows (D, D [r]x^T) for a body whose centre it is r away from, with opposite signs for its two
bodies, D its frame. So all that it adds follows from D^T B D, in the axes of the world, by cross products,

    J_r^T B J_c = (I, [r]x)^T D^T B D (I, -[c]x),

in a third of the operations. Where blocks are wide the contacts of a joint, which stand one after another, are added at once, so that each
block is read and written once a joint.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.friction.operators import has_unit_masses
from masonry_cd.jit import borrower, kernel
from masonry_cd.linalg.small_blocks import add_outer_product, is_wide
from masonry_cd.linalg.wide_columns import add_turned_product

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
    room = np.empty((4, len(problem.m) * longest_run(places), len(problem.n))) if is_wide(problem.n) else np.empty((0, 0, 0))
    for b in range(begin, stop):
        load_mass(problem, b, diagonal)
        lower[symbolic.column[b] : symbolic.column[b + 1]] = 0.0
        upper[symbolic.column[b] : symbolic.column[b + 1]] = 0.0
        e = sides.start[b]
        while e < sides.start[b + 1]:
            if is_wide(problem.n):
                e = add_wide_joint(problem, sides, blocks, b, e, room, matrix)
                continue
            c, own = sides.side[e] >> 1, sides.side[e] & 1
            k, beyond = block[c], places[c, 1 - own]
            later, e = k >= 0 and b < beyond, e + 1
            if has_frames(problem, sides):
                add_turned(world[c], own, own, False, 1.0, diagonal[b])
                if b == beyond:
                    add_turned(world[c], own, 1 - own, False, -1.0, diagonal[b])
                elif later:
                    add_turned(world[c], 1 - own, own, False, -1.0, lower[k])
                    add_turned(world[c], 1 - own, own, True, -1.0, upper[k])
                continue
            one, other = problem.jacobian[c, own], problem.jacobian[c, 1 - own]
            turn_rows(blocks[c], one, turned[0], problem.m, problem.n)
            add_outer_product(one, turned[0], diagonal[b], problem.m, problem.n)
            if b == beyond or later:
                turn_rows(blocks[c], other, turned[1], problem.m, problem.n)
            if b == beyond:  # each side adds its product with the other one
                add_outer_product(one, turned[1], diagonal[b], problem.m, problem.n)
            elif later:
                add_outer_product(other, turned[0], lower[k], problem.m, problem.n)
                add_outer_product(turned[1], one, upper[k], problem.m, problem.n)


@borrower(fastmath={"contract"})
def add_wide_joint(problem, sides, blocks, b, e, room, matrix):
    """What a joint of body b adds where blocks are wide, from the e-th of the sides on; returns the end of its sides.

    ``room`` (4, K m, n) is for the rows of the contacts, H on the side of b and on the other one, and B H likewise.
    """
    first, own, m = sides.side[e] >> 1, sides.side[e] & 1, len(problem.m)
    beyond, k, end = problem.places[first, 1 - own], problem.block[first], e
    later, width, other = k >= 0 and b < beyond, width_of(problem, b), width_of(problem, beyond)
    while end < sides.start[b + 1] and sides.side[end] == sides.side[e] + 2 * (end - e):
        c, at = first + end - e, m * (end - e)
        if problem.places[c, 1 - own] != beyond:
            break
        take_rows(blocks[c], problem.jacobian[c, own], at, width, room[0], room[2], problem.m)
        if later or b == beyond:
            take_rows(blocks[c], problem.jacobian[c, 1 - own], at, other, room[1], room[3], problem.m)
        end += 1
    rows = m * (end - e)
    add_turned_product(room[0], room[2], rows, (width, width), matrix.diagonal[b])
    if b == beyond:  # each side adds its product with the other one
        add_turned_product(room[0], room[3], rows, (width, width), matrix.diagonal[b])
    elif later:
        add_turned_product(room[1], room[2], rows, (other, width), matrix.lower[k])
        add_turned_product(room[3], room[0], rows, (other, width), matrix.upper[k])
    return end


@kernel(inline="always")
def width_of(problem, b):
    """Unknowns of the body at a place, where blocks are wide."""
    return problem.width[b] if has_unit_masses(problem) else len(problem.n)


@borrower()
def longest_run(places):
    """The most contacts that lie one after another between the same two bodies, by their places (C, 2)."""
    most, run = 0, 0
    for c in range(len(places)):
        run = run + 1 if c > 0 and places[c, 0] == places[c - 1, 0] and places[c, 1] == places[c - 1, 1] else 1
        most = max(most, run)
    return most


@borrower(fastmath={"contract"})
def take_rows(block, rows, at, width, own, turned, size_m):
    """The rows H of a contact (m, n) for a body, and B H, into two arrays from row ``at`` on."""
    m = len(size_m)
    for i in range(m):
        for q in range(width):
            total = 0.0
            for k in range(m):
                total += block[i, k] * rows[k, q]
            own[at + i, q], turned[at + i, q] = rows[i, q], total


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
def turn_rows(block, rows, out, size_m, size_n):
    """out (m, n) = B H for the rows of H (m, n) of a body and the first rows of a block (m or more, m)."""
    m, n = len(size_m), len(size_n)
    for i in range(m):
        for q in range(n):
            total = 0.0
            for k in range(m):
                total += block[i, k] * rows[k, q]
            out[i, q] = total
