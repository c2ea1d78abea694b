# SPDX-License-Identifier: GPL-3.0-or-later
r"""Contacts side by side: u = H v and H^T p of four joints at once, in the lanes of the processor's registers (linalg/vectors.py).

Contacts wait for divisions and roots; four joints in lanes take hardly longer than one. All contacts of a joint in space lie on the same
two rigid faces and have one frame d = (n, t1, t2). With the relative motion of the two blocks at the first of them, r_a and r_b from their
centres, its velocity t and rate of rotation omega in this frame, its twist, are

    t_i = d_i . (v_a + omega_a x r_a - v_b - omega_b x r_b),        omega_i = d_i . (omega_a - omega_b),

and a contact that lies at a from there, in the frame too, has the velocity u = t + omega x a. Its impulse p adds (p, a x p) to the wrench
of the joint, which goes back to the blocks in the same way. So a contact needs three numbers in place of the 36 of its rows of H, and a
joint fifteen: of four contacts, a sixth of the data and a quarter of the operations.

Contacts that have rows of H (contact_geometry.py) are joints of their own, and their twist is their velocity.

A matrix of lanes has four columns for each of its fields. Where a group has fewer than four joints, or a joint fewer contacts than its
neighbours, places stay empty: they have no number, scale, stiffness or impulse, and stand for contacts between supports.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.friction.contact_geometry import Geometry, arm_at, axes_at
from masonry_cd.mechanics.friction.natural_map import squared_residual
from masonry_cd.mechanics.friction.operators import trace_of_contact, unknowns_at
from masonry_cd.mechanics.linalg.small_blocks import size_tuple
from masonry_cd.mechanics.linalg.triples import cross, in_axes, inner, minus, out_of_axes, plus, scaled, times
from masonry_cd.mechanics.linalg.vectors import (
    LANES,
    fill_four,
    gather,
    gather_six,
    load_four,
    pack,
    scatter,
    scatter_six,
    store_lanes,
    where_at_most,
)

# Fields of the table of contacts: a [m], b [m/s], C, mu, d = trace(W_cc + C_cc) / m, R; then what the law needs of them, see put_stiffness
ARM, OFFSET, COMPLIANCE, MU, SCALE, STIFFNESS, NORMAL, TANGENT, STRETCH, SHARE, FIELDS = 0, 3, 6, 9, 10, 11, 12, 13, 14, 15, 16
AXES, ARMS, NUMBERS = 0, 9, 15  # fields of a frame: d_0, d_1, d_2, and r_a, r_b


class ContactGroups(NamedTuple):
    """C contacts by their joints, and these by fours: G groups, whose contacts have L rows of the table, four in each.

    A twist has s components: 6, or where each contact is a joint of its own as many as that has rows.
    """

    subtree: np.ndarray  # (K + 1,) first group of each subtree; a joint belongs to that of the one of its two bodies eliminated first
    start: np.ndarray  # (G + 1,) first row of each group in the table
    contact: np.ndarray  # (L, 4) number of each contact in the problem, -1: none
    place: np.ndarray  # (G, 2 * 4) places of the bodies of each joint in the order of elimination; supports: N
    target: np.ndarray  # (G, 2 * 4) rows that stand for them: the bodies themselves, or their ghosts in the subtree
    block: np.ndarray  # (G, 4) blocks of the matrix that couple them, of B; B: none
    frame: np.ndarray  # (G, 15 * 4) where joints have frames, or else (0, 60)
    rows: np.ndarray  # (G, 2 s n * 4) H where they have none, or else (0, ...)
    table: np.ndarray  # (L, 16 * 4)
    s: tuple[int, ...]  # s zeros


@borrower(forceinline=True)
def field(matrix, row, k):
    """Field k of a row of a matrix of lanes."""
    return load_four(matrix, row, LANES * k)


@borrower(forceinline=True)
def three(matrix, row, k):
    """Three fields of a row of a matrix of lanes from field k on."""
    return field(matrix, row, k), field(matrix, row, k + 1), field(matrix, row, k + 2)


@borrower(forceinline=True)
def put_three(matrix, row, k, values):
    """Store what :func:`three` gives."""
    for i in range(3):
        store_lanes(matrix, row, LANES * (k + i), values[i])


@borrower(forceinline=True)
def axes_of(groups, g):
    """The axes n, t1, t2 of the joints of group g."""
    return three(groups.frame, g, AXES), three(groups.frame, g, AXES + 3), three(groups.frame, g, AXES + 6)


@borrower(forceinline=True)
def row_of_h(groups, g, side, i, k, n):
    """Component i of the twists by unknown k, of n, of their bodies on one side, where joints have no frames."""
    return field(groups.rows, g, (side * len(groups.s) + i) * n + k)


@borrower(fastmath={"contract"})
def twist_of(groups, g, v, problem):
    """The relative twists t, omega of the bodies of group g, three components each, for body velocities v (N + 1, n)."""
    t0 = t1 = t2 = nothing = fill_four(0.0)
    if len(groups.s) > 3:
        a, b, frame = gather_six(v, groups.place, g, 0), gather_six(v, groups.place, g, LANES), groups.frame
        axes = axes_of(groups, g)
        moves_a, turns_a, moves_b, turns_b = (a[0], a[1], a[2]), (a[3], a[4], a[5]), (b[0], b[1], b[2]), (b[3], b[4], b[5])
        moves_a, moves_b = plus(moves_a, cross(turns_a, three(frame, g, ARMS))), plus(moves_b, cross(turns_b, three(frame, g, ARMS + 3)))
        return in_axes(axes, minus(moves_a, moves_b)), in_axes(axes, minus(turns_a, turns_b))
    n = len(problem.n)
    for side in range(2):
        for k in range(unknowns_of(groups, g, problem)):
            x = gather(v, groups.place, g, LANES * side, k)
            t0 += row_of_h(groups, g, side, 0, k, n) * x
            t1 += row_of_h(groups, g, side, 1, k, n) * x
            if len(groups.s) == 3:
                t2 += row_of_h(groups, g, side, 2, k, n) * x
    return (t0, t1, t2), (nothing, nothing, nothing)


@borrower(fastmath={"contract"})
def add_wrench(groups, g, wrench, out, problem):
    """out (., n) += H^T p of the joints of group g, given by their wrenches: force and moment."""
    force, moment = wrench
    if len(groups.s) > 3:
        frame = groups.frame
        axes = axes_of(groups, g)
        force, moment = out_of_axes(axes, force), out_of_axes(axes, moment)
        of_a, of_b = plus(moment, cross(three(frame, g, ARMS), force)), plus(moment, cross(three(frame, g, ARMS + 3), force))
        scatter_six(out, groups.target, g, 0, (force[0], force[1], force[2], of_a[0], of_a[1], of_a[2]))
        force, of_b = scaled(-1.0, force), scaled(-1.0, of_b)
        scatter_six(out, groups.target, g, LANES, (force[0], force[1], force[2], of_b[0], of_b[1], of_b[2]))
        return
    n = len(problem.n)
    for side in range(2):
        for k in range(unknowns_of(groups, g, problem)):
            x = row_of_h(groups, g, side, 0, k, n) * force[0] + row_of_h(groups, g, side, 1, k, n) * force[1]
            if len(groups.s) == 3:
                x += row_of_h(groups, g, side, 2, k, n) * force[2]
            scatter(out, groups.target, g, LANES * side, k, x)


@borrower(forceinline=True)
def unknowns_of(groups, g, problem):
    """Unknowns that the bodies of group g have, the most of all."""
    most, place = 0, groups.place
    for lane in range(LANES):
        most = max(most, unknowns_at(problem, place[g, lane], place[g, LANES + lane]))
    return most


@borrower(forceinline=True, fastmath={"contract"})
def velocity_at(groups, row, twist):
    """H v of the contacts of a row, whose joints have these twists."""
    return plus(twist[0], cross(twist[1], three(groups.table, row, ARM))) if len(groups.s) > 3 else twist[0]


@borrower(forceinline=True, fastmath={"contract"})
def law_velocity(groups, row, twist, p):
    """w = H v + b + C p of the contacts of a row with impulses p."""
    u = plus(velocity_at(groups, row, twist), three(groups.table, row, OFFSET))
    return plus(u, times(three(groups.table, row, COMPLIANCE), p))


@borrower(forceinline=True, fastmath={"contract"})
def add_to_wrench(groups, row, wrench, p):
    """Wrenches of joints and the impulses p of their contacts of a row."""
    moment = plus(wrench[1], cross(three(groups.table, row, ARM), p)) if len(groups.s) > 3 else wrench[1]
    return plus(wrench[0], p), moment


@borrower(forceinline=True)
def no_wrench():
    """Wrenches of joints without impulses."""
    x = fill_four(0.0)
    return (x, x, x), (x, x, x)


@borrower(forceinline=True, fastmath={"contract"})
def squared_residuals(groups, row, w, p):
    """Squared natural map residuals of the contacts of a row, none of empty places."""
    d = field(groups.table, row, SCALE)
    return where_at_most(d, 0.0, 0.0, squared_residual(p, w, field(groups.table, row, MU), d))


@borrower(forceinline=True, fastmath={"contract"})
def put_stiffness(table, row, r):
    """Set R of a row of contacts, and S^-1 = R^-1 + C of the normal and of the tangents, the softer one for both.

    The projection in the norm of S^-1 stretches a cone by S_n / S_t.
    """
    c0, c1, c2 = three(table, row, COMPLIANCE)
    normal, tangent, mu = 1.0 + r * c0, 1.0 + r * where_at_most(c1, c2, c2, c1), field(table, row, MU)
    stretch = mu * tangent / normal
    store_lanes(table, row, LANES * STIFFNESS, r)
    store_lanes(table, row, LANES * NORMAL, r / normal)
    store_lanes(table, row, LANES * TANGENT, r / tangent)
    store_lanes(table, row, LANES * STRETCH, stretch)
    store_lanes(table, row, LANES * SHARE, 1.0 / (1.0 + mu * stretch))


@borrower()
def fill_group(problem, groups, g):
    """Fill the frames or rows and the table of group g, but for the stiffness; ``problem`` has its bodies in order."""
    table, contact, geometry, place = groups.table, groups.contact, problem.geometry, groups.place
    first, end, n, m, shared = groups.start[g], groups.start[g + 1], len(problem.n), len(problem.m), len(groups.s) > 3
    table[first:end] = 0.0
    for lane in range(LANES):
        one = contact[first, lane]
        if shared:
            fill_frame(geometry, one, groups.frame, g, lane)
        else:
            for k in range(2 * m * n):
                groups.rows[g, LANES * k + lane] = geometry.jacobian[one, k // (m * n), k // n % m, k % n] if one >= 0 else 0.0
        for row in range(first, end):
            c = contact[row, lane]
            if c < 0:
                break
            if shared:
                side = 0 if place[g, lane] < len(problem.free) else 1
                arm = in_axes(axes_at(geometry, one), minus(arm_at(geometry, c, side), arm_at(geometry, one, side)))
                for i in range(3):
                    table[row, LANES * (ARM + i) + lane] = arm[i]
            else:
                table[row, LANES * SCALE + lane] = trace_of_contact(problem, c, place[g, lane], place[g, LANES + lane])
            table[row, LANES * MU + lane] = problem.mu[c]
            for i in range(m):
                table[row, LANES * (OFFSET + i) + lane] = problem.offset[c, i]
                if len(problem.compliance):
                    table[row, LANES * (COMPLIANCE + i) + lane] = problem.compliance[c, i]
    if shared:
        add_rigid_traces(groups, g, problem.inverse)
    for row in range(first, end):
        c0, c1, c2 = three(table, row, COMPLIANCE)
        store_lanes(table, row, LANES * SCALE, (field(table, row, SCALE) + c0 + c1 + c2) * (1.0 / m))
        for lane in range(LANES):
            if contact[row, lane] < 0:
                table[row, LANES * SCALE + lane] = 0.0


@borrower()
def fill_frame(geometry, c, frame, g, lane):
    """Fill one lane of group g with the frame and the arms of contact c, or with zeros if that is -1."""
    for k in range(9):
        frame[g, LANES * (AXES + k) + lane] = geometry.frame[c, k // 3, k % 3] if c >= 0 else 0.0
    for k in range(6):
        frame[g, LANES * (ARMS + k) + lane] = geometry.arm[c, k // 3, k % 3] if c >= 0 else 0.0


@borrower(forceinline=True, fastmath={"contract"})
def arm_in_world(groups, row, axes):
    """Where contacts of a row lie from the first of their joint, in the axes of the world."""
    return out_of_axes(axes, three(groups.table, row, ARM))


@borrower(fastmath={"contract"})
def add_rigid_traces(groups, g, inverse):
    """Add trace(W_cc) to the scales of the contacts of group g, joints between rigid blocks with M^-1 (N + 1, 6, 6).

    At r from the centre of a block with M^-1 = (A, B; B^T, K) it is tr A + tr K |r|^2 - r . K r + 2 b . r in any axes, with b that of
    which the skew part of B is a half.
    """
    entries, at = inverse.reshape((len(inverse), 36)), groups.place
    axes = axes_of(groups, g)
    for side in range(2):
        first, centre = LANES * side, three(groups.frame, g, ARMS + 3 * side)
        moves = gather(entries, at, g, first, 0) + gather(entries, at, g, first, 7) + gather(entries, at, g, first, 14)
        k0 = gather(entries, at, g, first, 21), gather(entries, at, g, first, 22), gather(entries, at, g, first, 23)
        k1 = k0[1], gather(entries, at, g, first, 28), gather(entries, at, g, first, 29)
        k2 = k0[2], k1[2], gather(entries, at, g, first, 35)
        turns = k0[0] + k1[1] + k2[2]
        skew = (
            gather(entries, at, g, first, 11) - gather(entries, at, g, first, 16),
            gather(entries, at, g, first, 15) - gather(entries, at, g, first, 5),
            gather(entries, at, g, first, 4) - gather(entries, at, g, first, 9),
        )
        for row in range(groups.start[g], groups.start[g + 1]):
            r = plus(centre, arm_in_world(groups, row, axes))
            trace = moves + turns * inner(r, r) - inner(r, in_axes((k0, k1, k2), r)) + 2.0 * inner(skew, r)
            store_lanes(groups.table, row, LANES * SCALE, field(groups.table, row, SCALE) + trace)


@borrower(fastmath={"contract"})
def add_rigid_stiffness(groups, g, diagonal, lower):
    """Add H^T R H of group g, joints between rigid blocks, to the blocks of a matrix: diagonal (., 36) and lower (., 36).

    R is one number for a contact, so H^T R H needs no axes: with r and s from the centres of two blocks to the contact the block of the
    rows of the one and the columns of the other is plus or minus R (I, -s x; r x, -(r x)(s x)).
    """
    frame, axes, place = groups.frame, axes_of(groups, g), groups.place
    weights, (first, squares, products) = fill_four(0.0), (no_wrench()[0], no_wrench()[0], no_wrench()[0])
    for row in range(groups.start[g], groups.start[g + 1]):
        r, a = field(groups.table, row, STIFFNESS), arm_in_world(groups, row, axes)
        b = scaled(r, a)
        weights, first, squares = weights + r, plus(first, b), plus(squares, times(b, a))
        products = plus(products, times(b, (a[1], a[2], a[0])))
    moments, one, other = (weights, first, squares, products), three(frame, g, ARMS), three(frame, g, ARMS + 3)
    scatter_stiffness(diagonal, groups.target, g, 0, 1.0, moments, one, one)
    scatter_stiffness(diagonal, groups.target, g, LANES, 1.0, moments, other, other)
    order = pack(
        (place[g, 4] - place[g, 0] + 0.5, place[g, 5] - place[g, 1] + 0.5, place[g, 6] - place[g, 2] + 0.5, place[g, 7] - place[g, 3] + 0.5)
    )
    zero = fill_four(0.0)
    later = (
        where_at_most(order, zero, one[0], other[0]),
        where_at_most(order, zero, one[1], other[1]),
        where_at_most(order, zero, one[2], other[2]),
    )
    scatter_stiffness(lower, groups.block, g, 0, -1.0, moments, later, minus(plus(one, other), later))


@borrower(fastmath={"contract"})
def scatter_stiffness(matrix, rows, g, at, sign, moments, r, s):
    """Add sign times the sum of R (I, -s x; r x, -(r x)(s x)) to rows of a matrix (., 36), of points at a from r and s.

    ``moments`` are the sums of R, R a, R a_i a_i and R a_i a_j with j after i.
    """
    weight, first = sign * moments[0], scaled(sign, moments[1])
    squares, products = scaled(sign, moments[2]), scaled(sign, moments[3])
    of_r, of_s = plus(scaled(weight, r), first), plus(scaled(weight, s), first)
    trace = inner(s, of_r) + inner(first, r) + squares[0] + squares[1] + squares[2]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        scatter(matrix, rows, g, at, 7 * i, weight)
        scatter(matrix, rows, g, at, 6 * i + 3 + j, of_s[k])
        scatter(matrix, rows, g, at, 6 * j + 3 + i, -1.0 * of_s[k])
        scatter(matrix, rows, g, at, 6 * j + 18 + i, of_r[k])
        scatter(matrix, rows, g, at, 6 * i + 18 + j, -1.0 * of_r[k])
        scatter(matrix, rows, g, at, 21 + 7 * i, trace - s[i] * of_r[i] - first[i] * r[i] - squares[i])
        scatter(matrix, rows, g, at, 21 + 6 * i + j, -1.0 * (s[i] * of_r[j] + first[i] * r[j] + products[i]))
        scatter(matrix, rows, g, at, 21 + 6 * j + i, -1.0 * (s[j] * of_r[i] + first[j] * r[i] + products[i]))


def size_of_twist(geometry: Geometry, m: int) -> tuple[int, ...]:
    """As many zeros as the twists of contacts with m rows each have components, see small_blocks.py."""
    return size_tuple(6 if len(geometry.frame) else m)
