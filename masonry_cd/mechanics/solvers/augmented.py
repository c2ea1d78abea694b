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
from masonry_cd.mechanics.friction.contact_geometry import IN_SPACE, arm_at, axes_at, fill_row
from masonry_cd.mechanics.friction.coupling import add_coupled_blocks, is_coupled
from masonry_cd.mechanics.friction.operators import add_product, form_of_problem, load_mass, unknowns_at
from masonry_cd.mechanics.linalg.small_blocks import is_wide
from masonry_cd.mechanics.linalg.triples import out_of_axes
from masonry_cd.mechanics.linalg.vectors import add_six_times, load_six, pack_six, store_six

NUMBERS = 9  # of D^T B D


@borrower(fastmath={"contract"})
def rotate_blocks(problem, blocks, first, end, world):
    """world (C, 9) = D^T B D of the contacts first to end of rigid blocks in space, B the first rows of ``blocks``."""
    if form_of_problem(problem) != IN_SPACE:
        return
    for c in range(first, end):
        axes, block, out = axes_at(problem.geometry, c), blocks[c], world[c]
        for q in range(3):
            x, y, z = axes[0][q], axes[1][q], axes[2][q]
            t0 = block[0, 0] * x + block[0, 1] * y + block[0, 2] * z
            t1 = block[1, 0] * x + block[1, 1] * y + block[1, 2] * z
            t2 = block[2, 0] * x + block[2, 1] * y + block[2, 2] * z
            out[q], out[3 + q], out[6 + q] = out_of_axes(axes, (t0, t1, t2))


@kernel(fastmath={"contract"})
def augment_blocks(problem, blocks, world, share, factor):
    """The columns of a share (first, end) of M + G B H, the matrix of a :class:`BlockFactor`.

    B has one (m, m) block per contact, the first rows of ``blocks`` (C, m or more, m); ``world`` is from :func:`rotate_blocks`.
    A block off the diagonal is in the column of that of its bodies that is eliminated first.
    """
    (begin, stop), places, symbolic, c = share, problem.places, factor.symbolic, 0
    scratch = np.empty((4, len(problem.m) * (longest_run(places) if is_wide(problem.n) else 1), len(problem.n)))
    for b in range(begin, stop):
        load_mass(problem, b, factor.diagonal)
        factor.lower[symbolic.column[b] : symbolic.column[b + 1]] = 0.0
        factor.upper[symbolic.column[b] : symbolic.column[b + 1]] = 0.0
    if is_coupled(problem):
        add_coupled_blocks(problem, blocks, share, factor)
        return
    while c < len(places):
        a, b, k, first = places[c, 0], places[c, 1], problem.block[c], c
        c += 1
        while is_wide(problem.n) and c < len(places) and places[c, 0] == a and places[c, 1] == b:
            c += 1
        if not (begin <= a < stop or begin <= b < stop):
            continue
        if form_of_problem(problem) == IN_SPACE:
            add_rigid_contact(problem, world, first, share, factor)
            continue
        rows = take_rows(problem, blocks, first, c, scratch)
        for side in range(2):
            body = b if side else a
            if begin <= body < stop:
                add_pair(problem, scratch, first, rows, side, side, 0, factor.diagonal[body])
                if a == b:  # each side adds its product with the other one
                    add_pair(problem, scratch, first, rows, side, 1 - side, 0, factor.diagonal[body])
        early = 0 if a < b else 1
        if k >= 0 and begin <= min(a, b) < stop:
            add_pair(problem, scratch, first, rows, 1 - early, early, 0, factor.lower[k])
            add_pair(problem, scratch, first, rows, 1 - early, early, 1, factor.upper[k])


@borrower(fastmath={"contract"})
def add_rigid_contact(problem, world, c, share, factor):
    """Add contact c between rigid bodies in space to the columns of a share (first, end)."""
    (begin, stop), places, k = share, problem.places, problem.block[c]
    for side in range(2):
        b, beyond = places[c, side], places[c, 1 - side]
        own, other = arm_at(problem.geometry, c, side), arm_at(problem.geometry, c, 1 - side)
        if not begin <= b < stop:
            continue
        lines = rotated_lines(world[c], own, False)
        add_turned(lines, own, 1.0, factor.diagonal[b])
        if k >= 0 and b < beyond:
            add_turned(lines, other, -1.0, factor.lower[k])
            add_turned(rotated_lines(world[c], own, True), other, -1.0, factor.upper[k])
        elif b == beyond:  # each side adds its product with the other one
            add_turned(rotated_lines(world[c], other, False), own, -1.0, factor.diagonal[b])


@borrower(forceinline=True)
def add_pair(problem, scratch, c, rows, one, other, turned, out):
    """out += J^T B K of contact c, or of the joint that begins there, with the rows H of two sides, J of ``one`` and K of ``other``.

    If ``turned`` it is J^T B^T K. ``scratch`` holds as many ``rows`` of :func:`take_rows`.
    """
    x, y, places = scratch[one + 2 * turned], scratch[other + 2 - 2 * turned], problem.places
    add_product(problem, x, y, rows, places[c, one], places[c, other], out)


@borrower(fastmath={"contract"})
def take_rows(problem, blocks, first, end, scratch):
    """Write the rows of the contacts first to end of a joint into ``scratch`` (4, K m, n): H of both sides, B H of both. Returns K m."""
    m, form = len(problem.m), form_of_problem(problem)
    for c in range(first, end):
        for side in range(2):
            at, body = m * (c - first), problem.places[c, side]
            count = unknowns_at(problem, body, body)
            for i in range(m):
                fill_row(form, problem.geometry, c, side, i, count, scratch[side, at + i])
            for i in range(m):
                for q in range(count):
                    total = 0.0
                    for k in range(m):
                        total += blocks[c, i, k] * scratch[side, at + k, q]
                    scratch[side + 2, at + i, q] = total
    return m * (end - first)


@borrower()
def longest_run(places):
    """The most contacts that lie one after another between the same two bodies, by their places (C, 2)."""
    most, run = 0, 0
    for c in range(len(places)):
        run = run + 1 if c > 0 and places[c, 0] == places[c - 1, 0] and places[c, 1] == places[c - 1, 1] else 1
        most = max(most, run)
    return most


@borrower(forceinline=True)
def rotated_lines(turned, arm, transposed):
    """The three lines of D^T B D (I, -[c]x), six numbers each, for an arm c, with B^T if ``transposed``."""
    along, across = (1, 3) if transposed else (3, 1)
    x = (turned[0], turned[across], turned[2 * across])
    y = (turned[along], turned[along + across], turned[along + 2 * across])
    z = (turned[2 * along], turned[2 * along + across], turned[2 * along + 2 * across])
    return line_of(x, arm), line_of(y, arm), line_of(z, arm)


@borrower(forceinline=True, fastmath={"contract"})
def line_of(x, c):
    """(x, c x x), six numbers, of a line x of D^T B D and an arm c."""
    return pack_six(x[0], x[1], x[2], c[1] * x[2] - c[2] * x[1], c[2] * x[0] - c[0] * x[2], c[0] * x[1] - c[1] * x[0])


@borrower(forceinline=True)
def add_turned(lines, arm, sign, out):
    """out (6, 6) += sign (I, [r]x)^T lines for an arm r."""
    r0, r1, r2, (x, y, z) = sign * arm[0], sign * arm[1], sign * arm[2], lines
    store_six(out, 0, 0, add_six_times(load_six(out, 0, 0), sign, x))
    store_six(out, 1, 0, add_six_times(load_six(out, 1, 0), sign, y))
    store_six(out, 2, 0, add_six_times(load_six(out, 2, 0), sign, z))
    store_six(out, 3, 0, add_six_times(add_six_times(load_six(out, 3, 0), r1, z), -r2, y))
    store_six(out, 4, 0, add_six_times(add_six_times(load_six(out, 4, 0), r2, x), -r0, z))
    store_six(out, 5, 0, add_six_times(add_six_times(load_six(out, 5, 0), r0, y), -r1, x))
