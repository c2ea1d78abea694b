# SPDX-License-Identifier: GPL-3.0-or-later
r"""Contacts by subtree, by joint, and by groups of four joints: u = H v and H^T p of four at once, in the lanes of registers (vectors.py).

Contacts wait for divisions and roots; four joints in lanes take hardly longer than one. All contacts of a joint in space lie on the same
two rigid faces and have one frame d = (n, t1, t2). With the relative motion of the two blocks at the first of them, r_a and r_b from their
centres, its velocity t and rate of rotation omega in this frame, its twist, are

    t_i = d_i . (v_a + omega_a x r_a - v_b - omega_b x r_b),        omega_i = d_i . (omega_a - omega_b),

and a contact that lies at a from there, in the frame too, has the velocity u = t + omega x a. Its impulse p adds (p, a x p) to the wrench
of the joint, which goes back to the blocks in the same way. So a contact needs three numbers in place of the 36 of its rows of H, and a
joint fifteen: of four contacts, a sixth of the data and a quarter of the operations.

In a plane there is one rotation, and a is what the contact moves by at unit rotation: u = t + omega a, and p adds (p, a . p). Contacts that
have rows of H (contact_geometry.py) are joints of their own, and their twist is their velocity.

A matrix of lanes has four columns for each of its fields. Where a group has fewer than four joints, or a joint fewer contacts than its
neighbours, places stay empty: they have no number, scale, stiffness or impulse, and stand for contacts between supports.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.contact_geometry import shares_faces
from masonry_cd.mechanics.friction.operators import has_arms, unknowns_at
from masonry_cd.mechanics.linalg.ghost_rows import nodes_of
from masonry_cd.mechanics.linalg.sorting import sorted_by
from masonry_cd.mechanics.linalg.threads import take
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
NUMBERS = 15  # fields of a frame: d_0, d_1, d_2, and from ARMS on r_a, r_b; in a plane eight: d_0, d_1, and from PLANE_ARMS on a_a, a_b
AXES, ARMS, PLANE_ARMS = 0, 9, 4


class ContactGroups(NamedTuple):
    """C contacts by their joints, and these by fours: G groups, whose contacts have L rows of the table, four in each."""

    subtree: np.ndarray  # (K + 1,) first group of each subtree; a joint belongs to that of the one of its two bodies eliminated first
    start: np.ndarray  # (G + 1,) first row of each group in the table
    contact: np.ndarray  # (L, 4) number of each contact in the problem, -1: none
    place: np.ndarray  # (G, 2 * 4) places of the bodies of each joint in the order of elimination; supports: N
    target: np.ndarray  # (G, 2 * 4) rows that stand for them: the bodies themselves, or their ghosts in the subtree
    block: np.ndarray  # (G, 4) blocks of the matrix that couple them, of B; B: none
    frame: np.ndarray  # (G, 15 * 4) where joints have frames, or else (0, 60)
    rows: np.ndarray  # (G, 2 m n * 4) H where they have none, or else (0, ...)
    table: np.ndarray  # (L, 16 * 4)
    m: tuple[int, ...]  # as those of ProblemArrays
    n: Any  # likewise; a tuple where joints have frames


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
def rotations(groups):
    """Rotations in a twist: three in space, one in a plane, none where contacts have rows of H."""
    return 2 * len(groups.m) - 3 if has_arms(groups) else 0


@borrower(forceinline=True)
def axes_of(groups, g):
    """The axes n, t1, t2 of the joints of group g."""
    return three(groups.frame, g, AXES), three(groups.frame, g, AXES + 3), three(groups.frame, g, AXES + 6)


@borrower(forceinline=True)
def row_of_h(groups, g, side, i, k, n):
    """Component i of the twists by unknown k, of n, of their bodies on one side, where joints have no frames."""
    return field(groups.rows, g, (side * len(groups.m) + i) * n + k)


@borrower(fastmath={"contract"})
def twist_of(groups, g, v, problem):
    """The relative twists t, omega of the bodies of group g, three components each, for body velocities v (N + 1, n)."""
    t0 = t1 = t2 = nothing = fill_four(0.0)
    if rotations(groups) == 3:
        a, b, frame = gather_six(v, groups.place, g, 0), gather_six(v, groups.place, g, LANES), groups.frame
        axes = axes_of(groups, g)
        moves_a, turns_a, moves_b, turns_b = (a[0], a[1], a[2]), (a[3], a[4], a[5]), (b[0], b[1], b[2]), (b[3], b[4], b[5])
        moves_a, moves_b = plus(moves_a, cross(turns_a, three(frame, g, ARMS))), plus(moves_b, cross(turns_b, three(frame, g, ARMS + 3)))
        return in_axes(axes, minus(moves_a, moves_b)), in_axes(axes, minus(turns_a, turns_b))
    if rotations(groups) == 1:
        frame, place = groups.frame, groups.place
        turn_a, turn_b = gather(v, place, g, 0, 2), gather(v, place, g, LANES, 2)
        x = gather(v, place, g, 0, 0) + turn_a * field(frame, g, 4) - (gather(v, place, g, LANES, 0) + turn_b * field(frame, g, 6))
        y = gather(v, place, g, 0, 1) + turn_a * field(frame, g, 5) - (gather(v, place, g, LANES, 1) + turn_b * field(frame, g, 7))
        t0, t1 = field(frame, g, 0) * x + field(frame, g, 1) * y, field(frame, g, 2) * x + field(frame, g, 3) * y
        return (t0, t1, nothing), (nothing, nothing, turn_a - turn_b)
    n = len(problem.n)
    for side in range(2):
        for k in range(unknowns_of(groups, g, problem)):
            x = gather(v, groups.place, g, LANES * side, k)
            t0 += row_of_h(groups, g, side, 0, k, n) * x
            t1 += row_of_h(groups, g, side, 1, k, n) * x
            if len(groups.m) == 3:
                t2 += row_of_h(groups, g, side, 2, k, n) * x
    return (t0, t1, t2), (nothing, nothing, nothing)


@borrower(fastmath={"contract"})
def add_wrench(groups, g, wrench, out, problem):
    """out (., n) += H^T p of the joints of group g, given by their wrenches: force and moment."""
    force, moment = wrench
    frame, target = groups.frame, groups.target
    if rotations(groups) == 3:
        axes = axes_of(groups, g)
        force, moment = out_of_axes(axes, force), out_of_axes(axes, moment)
        of_a, of_b = plus(moment, cross(three(frame, g, ARMS), force)), plus(moment, cross(three(frame, g, ARMS + 3), force))
        scatter_six(out, target, g, 0, (force[0], force[1], force[2], of_a[0], of_a[1], of_a[2]))
        force, of_b = scaled(-1.0, force), scaled(-1.0, of_b)
        scatter_six(out, target, g, LANES, (force[0], force[1], force[2], of_b[0], of_b[1], of_b[2]))
        return
    if rotations(groups) == 1:
        x = field(frame, g, 0) * force[0] + field(frame, g, 2) * force[1]
        y = field(frame, g, 1) * force[0] + field(frame, g, 3) * force[1]
        for side in range(2):
            sign, arm = 1.0 - 2.0 * side, PLANE_ARMS + 2 * side
            turned = moment[2] + (field(frame, g, arm) * x + field(frame, g, arm + 1) * y)
            scatter(out, target, g, LANES * side, 0, sign * x)
            scatter(out, target, g, LANES * side, 1, sign * y)
            scatter(out, target, g, LANES * side, 2, sign * turned)
        return
    n = len(problem.n)
    for side in range(2):
        for k in range(unknowns_of(groups, g, problem)):
            x = row_of_h(groups, g, side, 0, k, n) * force[0] + row_of_h(groups, g, side, 1, k, n) * force[1]
            if len(groups.m) == 3:
                x += row_of_h(groups, g, side, 2, k, n) * force[2]
            scatter(out, target, g, LANES * side, k, x)


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
    (t, omega), arm = twist, three(groups.table, row, ARM)
    if rotations(groups) == 3:
        return plus(t, cross(omega, arm))
    return (t[0] + omega[2] * arm[0], t[1] + omega[2] * arm[1], t[2]) if rotations(groups) == 1 else t


@borrower(forceinline=True, fastmath={"contract"})
def law_velocity(groups, row, twist, p):
    """w = H v + b + C p of the contacts of a row with impulses p."""
    u = plus(velocity_at(groups, row, twist), three(groups.table, row, OFFSET))
    return plus(u, times(three(groups.table, row, COMPLIANCE), p))


@borrower(forceinline=True, fastmath={"contract"})
def add_to_wrench(groups, row, wrench, p):
    """Wrenches of joints and the impulses p of their contacts of a row."""
    (force, moment), arm = wrench, three(groups.table, row, ARM)
    if rotations(groups) == 3:
        moment = plus(moment, cross(arm, p))
    elif rotations(groups) == 1:
        moment = moment[0], moment[1], moment[2] + (arm[0] * p[0] + arm[1] * p[1])
    return plus(force, p), moment


@borrower(forceinline=True)
def no_wrench():
    """Wrenches of joints without impulses."""
    x = fill_four(0.0)
    return (x, x, x), (x, x, x)


@borrower()
def fill_group(problem, groups, g):
    """Fill the frames or rows and the table of group g, but for the stiffness; ``problem`` has its bodies in order."""
    table, contact, geometry = groups.table, groups.contact, problem.geometry
    first, end, n, m = groups.start[g], groups.start[g + 1], len(problem.n), len(problem.m)
    table[first:end] = 0.0
    for lane in range(LANES):
        one = contact[first, lane]
        if rotations(groups) == 0:
            for k in range(2 * m * n):
                groups.rows[g, LANES * k + lane] = geometry.jacobian[one, k // (m * n), k // n % m, k % n] if one >= 0 else 0.0
        for k in range(m * m if rotations(groups) > 0 else 0):
            groups.frame[g, LANES * k + lane] = geometry.frame[one, k // m, k % m] if one >= 0 else 0.0
        for k in range(2 * m if rotations(groups) > 0 else 0):
            groups.frame[g, LANES * (m * m + k) + lane] = geometry.arm[one, k // m, k % m] if one >= 0 else 0.0
        side = 0 if groups.place[g, lane] < len(problem.free) else 1
        for row in range(first, end):
            c = contact[row, lane]
            if c < 0:
                break
            table[row, LANES * MU + lane], table[row, LANES * SCALE + lane] = problem.mu[c], problem.d[c]
            for i in range(m):
                for k in range(m if rotations(groups) > 0 else 0):
                    apart = geometry.arm[c, side, k] - geometry.arm[one, side, k]
                    table[row, LANES * (ARM + i) + lane] += geometry.frame[one, i, k] * apart
                table[row, LANES * (OFFSET + i) + lane] = problem.offset[c, i]
                if len(problem.compliance):
                    table[row, LANES * (COMPLIANCE + i) + lane] = problem.compliance[c, i]


@borrower(forceinline=True, fastmath={"contract"})
def arm_in_world(groups, row, axes):
    """Where contacts of a row lie from the first of their joint, in the axes of the world."""
    return out_of_axes(axes, three(groups.table, row, ARM))


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


@kernel()
def group_contacts(arena, given, symbolic):
    """Assign contacts to groups of joints, within subtrees; contacts between supports go to the last subtree.

    The problem is in order of elimination, ``symbolic`` of its matrix. The frames and the table are to be filled by :func:`fill_group`.
    """
    index, block, shared, size = given.places, given.block, has_arms(given), len(symbolic.column) - 1
    contact, begin = sort_by_subtree(index, symbolic)
    first, joint = split_into_joints(given.geometry, index, size, contact, begin, shared)
    order, subtree, start = group_joints(first, joint)
    groups, rows = len(start) - 1, start[-1]
    contact_of, block_of = np.full((rows, LANES), -1, dtype=np.int64), np.full((groups, LANES), len(symbolic.row), dtype=np.int64)
    place, target = np.full((groups, 2 * LANES), size, dtype=np.int64), np.full((groups, 2 * LANES), size, dtype=np.int64)
    row = np.arange(size + 1)  # that stands for each place, seen from subtree q
    for q in range(len(begin) - 1):
        _, end = nodes_of(symbolic, q)
        for t in range(symbolic.start[symbolic.subtree[q]], symbolic.start[symbolic.subtree[q + 1]]):
            row[symbolic.below[t]] = symbolic.target[t]
        for k in range(joint[q], joint[q + 1]):
            g, lane, j = subtree[q] + (k - joint[q]) // LANES, (k - joint[q]) % LANES, order[k]
            for t in range(first[j + 1] - first[j]):
                contact_of[start[g] + t, lane] = contact[first[j] + t]
            c = contact[first[j]]
            block_of[g, lane] = block[c] if block[c] >= 0 else len(symbolic.row)
            for side in range(2):
                b = index[c, side]
                place[g, LANES * side + lane] = b
                target[g, LANES * side + lane] = row[b] if b >= end else b
    of_h = 0 if shared else groups
    return ContactGroups(
        subtree, start, contact_of, place, target, block_of, take(arena, (groups - of_h, NUMBERS * LANES)),
        take(arena, (of_h, 2 * len(given.m) * len(given.n) * LANES)), take(arena, (rows, FIELDS * LANES)), given.m, given.n,
    )  # fmt: skip


@kernel()
def split_into_joints(geometry, index, size, contact, begin, shared):
    """First contact (J + 1,) of each joint, of contacts in the order of ``contact`` (C,), and the first joint (K + 1,) of each subtree.

    Each contact is a joint of its own if they are not ``shared``.
    """
    contacts = len(contact)
    first, joint, joints = np.empty(contacts + 1, dtype=np.int64), np.empty(len(begin), dtype=np.int64), 0
    for q in range(len(begin) - 1):
        joint[q] = joints
        for c in range(begin[q], begin[q + 1]):
            if not shared or c == begin[q] or not shares_faces(geometry, index, size, contact[first[joints - 1]], contact[c]):
                first[joints] = c
                joints += 1
    first[joints] = contacts
    joint[-1] = joints
    return first[: joints + 1], joint


@kernel()
def group_joints(first, joint):
    """Joints (J,) subtree by subtree, those of most contacts first, and ``subtree`` and ``start`` of the groups that fours of them make."""
    key, subtree, groups, most = np.empty(len(first) - 1, dtype=np.int64), np.zeros(len(joint), dtype=np.int64), 0, 0
    for j in range(len(key)):
        most = max(most, first[j + 1] - first[j])
    for q in range(len(joint) - 1):
        subtree[q + 1] = subtree[q] + (joint[q + 1] - joint[q] + LANES - 1) // LANES
        for j in range(joint[q], joint[q + 1]):
            key[j] = (q + 1) * most - (first[j + 1] - first[j])
    order, _ = sorted_by(key, (len(joint) - 1) * most)
    start = np.zeros(subtree[-1] + 1, dtype=np.int64)
    for q in range(len(joint) - 1):
        for k in range(joint[q], joint[q + 1], LANES):
            start[groups + 1] = start[groups] + first[order[k] + 1] - first[order[k]]
            groups += 1
    return order, subtree, start


@kernel()
def sort_by_subtree(index, symbolic):
    """Contacts (C,) sorted by the subtree of their first body, in order within each, and the starts (K + 1,) of the subtrees."""
    count, size = len(symbolic.subtree) - 1, len(symbolic.column) - 1
    subtree_of, own = np.full(size + 1, count - 1, dtype=np.int64), np.zeros(len(index), dtype=np.int64)
    for q in range(count):
        first, end = nodes_of(symbolic, q)
        subtree_of[first:end] = q
    for c in range(len(index) if count > 1 else 0):
        own[c] = subtree_of[min(index[c, 0], index[c, 1])]
    return sorted_by(own, count)
