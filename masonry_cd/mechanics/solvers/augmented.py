# SPDX-License-Identifier: GPL-3.0-or-later
r"""The matrix of the methods that linearise the law: M + G B H, one block B per contact, column by column; over bodies G = H^T.

Between rigid blocks in space a contact has rows (D, D [r]x^T) for a body whose centre it is r away from, with opposite signs for its two
bodies, D its frame. So all that it adds follows from D^T B D, in the axes of the world, by cross products,

    J_r^T B J_c = (I, [r]x)^T D^T B D (I, -[c]x),

in a third of the operations. Where blocks are wide the contacts of a joint, which stand one after another, are added at once, so that each
block is read and written once a joint.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.coupling import add_coupled_blocks, is_coupled
from masonry_cd.mechanics.friction.joint_twists import out_of_frame
from masonry_cd.mechanics.friction.operators import has_frames, has_unit_masses
from masonry_cd.mechanics.linalg.small_blocks import add_outer_product, is_wide
from masonry_cd.mechanics.linalg.vectors import add_six_times, load_six, pack_six, store_six
from masonry_cd.mechanics.linalg.wide_blocks import add_turned_product

NUMBERS = 9  # of D^T B D


@borrower(fastmath={"contract"})
def turn_blocks(problem, blocks, first, end, world):
    """world (C, 9) = D^T B D of the contacts first to end of rigid blocks in space, B the first rows of ``blocks``."""
    if not has_frames(problem):
        return
    for c in range(first, end):
        f, block, out = problem.frame[c], blocks[c], world[c]
        for q in range(3):
            x, y, z = f[q], f[3 + q], f[6 + q]
            t0 = block[0, 0] * x + block[0, 1] * y + block[0, 2] * z
            t1 = block[1, 0] * x + block[1, 1] * y + block[1, 2] * z
            t2 = block[2, 0] * x + block[2, 1] * y + block[2, 2] * z
            out[q], out[3 + q], out[6 + q] = out_of_frame(f, t0, t1, t2)


@kernel(fastmath={"contract"})
def augment_blocks(problem, sides, blocks, world, symbolic, share, matrix):
    """The columns of a share (first, end) of the :class:`BlockMatrix` of M + G B H, from the sides of the contacts of their bodies.

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
        while e < sides.start[b + 1] and not is_coupled(problem):
            if is_wide(problem.n):
                e = add_wide_joint(problem, sides, blocks, b, e, room, matrix)
                continue
            c, own = sides.side[e] >> 1, sides.side[e] & 1
            k, beyond = block[c], places[c, 1 - own]
            later, e = k >= 0 and b < beyond, e + 1
            if has_frames(problem):
                own_arm, other_arm = arm_of(problem.frame[c], own), arm_of(problem.frame[c], 1 - own)
                lines = turn_lines(world[c], own_arm, False)
                add_turned(lines, own_arm, 1.0, diagonal[b])
                if later:
                    add_turned(lines, other_arm, -1.0, lower[k])
                    add_turned(turn_lines(world[c], own_arm, True), other_arm, -1.0, upper[k])
                elif b == beyond:
                    add_turned(turn_lines(world[c], other_arm, False), own_arm, -1.0, diagonal[b])
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
    if is_coupled(problem):
        add_coupled_blocks(problem, blocks, symbolic, share, matrix)


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
def arm_of(frame, side):
    """The arm r of a side in a frame (15,), three numbers."""
    at = 9 + 3 * side
    return frame[at], frame[at + 1], frame[at + 2]


@kernel(inline="always")
def turn_lines(turned, arm, transposed):
    """The three lines of D^T B D (I, -[c]x), six numbers each, for an arm c, with B^T if ``transposed``."""
    along, across = (1, 3) if transposed else (3, 1)
    x = (turned[0], turned[across], turned[2 * across])
    y = (turned[along], turned[along + across], turned[along + 2 * across])
    z = (turned[2 * along], turned[2 * along + across], turned[2 * along + 2 * across])
    return line_of(x, arm), line_of(y, arm), line_of(z, arm)


@kernel(inline="always", fastmath={"contract"})
def line_of(x, c):
    """(x, c x x), six numbers, of a line x of D^T B D and an arm c."""
    return pack_six(x[0], x[1], x[2], c[1] * x[2] - c[2] * x[1], c[2] * x[0] - c[0] * x[2], c[0] * x[1] - c[1] * x[0])


@kernel(inline="always")
def add_turned(lines, arm, sign, out):
    """out (6, 6) += sign (I, [r]x)^T lines for an arm r."""
    r0, r1, r2, (x, y, z) = sign * arm[0], sign * arm[1], sign * arm[2], lines
    store_six(out, 0, 0, add_six_times(load_six(out, 0, 0), sign, x))
    store_six(out, 1, 0, add_six_times(load_six(out, 1, 0), sign, y))
    store_six(out, 2, 0, add_six_times(load_six(out, 2, 0), sign, z))
    store_six(out, 3, 0, add_six_times(add_six_times(load_six(out, 3, 0), r1, z), -r2, y))
    store_six(out, 4, 0, add_six_times(add_six_times(load_six(out, 4, 0), r2, x), -r0, z))
    store_six(out, 5, 0, add_six_times(add_six_times(load_six(out, 5, 0), r0, y), -r1, x))


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
