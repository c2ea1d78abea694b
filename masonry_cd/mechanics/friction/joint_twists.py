r"""Contacts of a joint share its twist: u = H v and H^T p, joint by joint instead of contact by contact.

All contacts of a joint in space lie on the same two rigid faces and have one frame d = (n, t1, t2). With the relative motion of the two
blocks at the first of them, r_a and r_b from their centres, its velocity t and rate of rotation omega in this frame are

    t_i = d_i . (v_a + omega_a x r_a - v_b - omega_b x r_b),        omega_i = d_i . (omega_a - omega_b),

and a contact that lies at a from there, in the frame too, has the velocity u = t + omega x a. Its impulse p adds (p, a x p) to the wrench
of the joint, which goes back to the blocks in the same way. So a contact needs three numbers in place of the 36 of its rows of H, and a
joint fifteen: of four contacts, a sixth of the data and a quarter of the operations.

In a plane, where a joint has two contacts, nothing would be won; blocks that deform, and problems from files whose H is not that of rigid
bodies, have no such frames. There each contact is a joint of its own, with its rows of H.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.linalg.small_blocks import size_tuple

FIT = 1e-12  # how far rows may be off those of a frame, relative to their largest arm: positions carry rounding
NUMBERS = 15  # of a frame: d_0, d_1, d_2, r_a, r_b


class JointTwists(NamedTuple):
    """C contacts by their J joints; a twist has s components: 6, or where each contact is a joint of its own as many as that has rows."""

    start: np.ndarray  # (J + 1,) first contact of each joint
    frame: np.ndarray  # (J, 15) where joints have frames, or else (0, 15)
    arm: np.ndarray  # (C, 3) a [m] likewise
    rows: np.ndarray  # (0, 2, m, n), or else (J, 2, m, n) H
    s: tuple[int, ...]  # s zeros


@entry()
def _frames_of(jacobian, bodies):
    """Frames (C, 15) of contacts of bodies (C, 2) whose rows (C, 2, 3, 6) are those of frames; (0, 15) if some are not."""
    frames, fitting = np.empty((len(jacobian), NUMBERS)), 0
    while fitting < len(jacobian) and fill_frame(jacobian, bodies, -1, fitting, frames[fitting]):
        fitting += 1
    return frames if fitting == len(jacobian) else np.empty((0, NUMBERS))


def frames_of(jacobian: np.ndarray, bodies: np.ndarray) -> np.ndarray:
    """Frames (C, 15) of contacts with rows of H (C, 2, m, n), each as if it were a joint; (0, 15) if they are not all between rigid blocks
    in space."""
    if jacobian.shape[2:] != (3, 6):
        return np.empty((0, NUMBERS))
    frames: np.ndarray = _frames_of(jacobian, bodies)
    return frames


def size_of_twist(jacobian: np.ndarray, bodies: np.ndarray) -> tuple[int, ...]:
    """As many zeros as the twists of contacts with rows (C, 2, m, n) have components, see small_blocks.py."""
    return size_tuple(6 if len(frames_of(jacobian, bodies)) else jacobian.shape[2])


@borrower()
def fill_frame(jacobian, bodies, support, c, frame):
    """Fill the frame (15,) of a joint from its contact c; False if its rows are not those of a frame. ``support`` stands for supports."""
    known = False
    for side in range(2):
        sign, at = 1.0 - 2.0 * side, 9 + 3 * side
        frame[at], frame[at + 1], frame[at + 2] = 0.0, 0.0, 0.0
        if bodies[c, side] == support:
            continue
        row, reach = jacobian[c, side], 0.0
        for i in range(3):
            for k in range(3):
                if not known:
                    frame[3 * i + k] = sign * row[i, k]
                elif frame[3 * i + k] != sign * row[i, k]:
                    return False
                reach = max(reach, abs(row[i, 3 + k]))
        known = True
        for i in range(3):  # r = sum of d_i x (r x d_i) / 2
            for k in range(3):
                j, l = (k + 1) % 3, (k + 2) % 3  # noqa: E741
                frame[at + k] += 0.5 * sign * (frame[3 * i + j] * row[i, 3 + l] - frame[3 * i + l] * row[i, 3 + j])
        for i in range(3):
            for k in range(3):
                j, l = (k + 1) % 3, (k + 2) % 3  # noqa: E741
                fit = frame[at + j] * frame[3 * i + l] - frame[at + l] * frame[3 * i + j]
                if not abs(sign * row[i, 3 + k] - fit) <= FIT * reach:
                    return False
    return True


@borrower()
def find_arm(jacobian, bodies, support, first, c, frame, arm):
    """Fill ``arm`` (3,) with where contact c lies from contact ``first`` of a joint; False if it is not one of the same joint."""
    side = 0 if bodies[c, 0] != support else 1
    if bodies[c, 0] != bodies[first, 0] or bodies[c, 1] != bodies[first, 1] or bodies[c, side] == support:
        return False
    sign = 1.0 - 2.0 * side
    for i in range(3):
        arm[i] = 0.0
        for k in range(3):
            if jacobian[c, side, i, k] != sign * frame[3 * i + k]:
                return False
    for i in range(3):  # a_i = (a x d_j) . d_l
        j, l = (i + 1) % 3, (i + 2) % 3  # noqa: E741
        for k in range(3):
            arm[i] += sign * (jacobian[c, side, j, 3 + k] - jacobian[first, side, j, 3 + k]) * frame[3 * l + k]
    return True


@kernel(inline="always", fastmath={"contract"})
def into_frame(f, x, y, z):
    """The components of a vector in the axes of a frame (15,)."""
    return f[0] * x + f[1] * y + f[2] * z, f[3] * x + f[4] * y + f[5] * z, f[6] * x + f[7] * y + f[8] * z


@kernel(inline="always", fastmath={"contract"})
def out_of_frame(f, x, y, z):
    """A vector of components in the axes of a frame (15,), in those of the world."""
    return f[0] * x + f[3] * y + f[6] * z, f[1] * x + f[4] * y + f[7] * z, f[2] * x + f[5] * y + f[8] * z


@kernel(inline="always", fastmath={"contract"})
def velocity_in(f, v, a, b):
    """The velocity of body a against body b where a frame (15,) is, in its axes."""
    w0, w1, w2, r0, r1, r2 = v[a, 3], v[a, 4], v[a, 5], v[b, 3], v[b, 4], v[b, 5]
    x = (v[a, 0] + (w1 * f[11] - w2 * f[10])) - (v[b, 0] + (r1 * f[14] - r2 * f[13]))
    y = (v[a, 1] + (w2 * f[9] - w0 * f[11])) - (v[b, 1] + (r2 * f[12] - r0 * f[14]))
    z = (v[a, 2] + (w0 * f[10] - w1 * f[9])) - (v[b, 2] + (r0 * f[13] - r1 * f[12]))
    return into_frame(f, x, y, z)


@kernel(inline="always", fastmath={"contract"})
def twist_of(joints, g, v, a, b, n):
    """The relative twist (t, omega) of bodies a and b at joint g, six numbers; of a single contact its velocity and zeros."""
    if len(joints.s) > 3:
        f = joints.frame[g]
        t0, t1, t2 = velocity_in(f, v, a, b)
        r0, r1, r2 = into_frame(f, v[a, 3] - v[b, 3], v[a, 4] - v[b, 4], v[a, 5] - v[b, 5])
        return t0, t1, t2, r0, r1, r2
    rows, t0, t1, t2 = joints.rows, 0.0, 0.0, 0.0
    for k in range(n):
        x, y = v[a, k], v[b, k]
        t0 += rows[g, 0, 0, k] * x + rows[g, 1, 0, k] * y
        t1 += rows[g, 0, 1, k] * x + rows[g, 1, 1, k] * y
        if len(joints.s) == 3:
            t2 += rows[g, 0, 2, k] * x + rows[g, 1, 2, k] * y
    return t0, t1, t2, 0.0, 0.0, 0.0


@kernel(inline="always", fastmath={"contract"})
def velocity_at(joints, twist, c):
    """t + omega x a, three numbers, of contact c of a joint with this twist."""
    if len(joints.s) <= 3:
        return twist[0], twist[1], twist[2]
    a0, a1, a2 = joints.arm[c, 0], joints.arm[c, 1], joints.arm[c, 2]
    t0, t1, t2, r0, r1, r2 = twist
    return t0 + (r1 * a2 - r2 * a1), t1 + (r2 * a0 - r0 * a2), t2 + (r0 * a1 - r1 * a0)


@kernel(inline="always", fastmath={"contract"})
def add_to_wrench(joints, wrench, c, p0, p1, p2):
    """The wrench (six numbers) of a joint and the impulse of its contact c."""
    f0, f1, f2, r0, r1, r2 = wrench
    if len(joints.s) > 3:
        a0, a1, a2 = joints.arm[c, 0], joints.arm[c, 1], joints.arm[c, 2]
        r0, r1, r2 = r0 + (a1 * p2 - a2 * p1), r1 + (a2 * p0 - a0 * p2), r2 + (a0 * p1 - a1 * p0)
    return f0 + p0, f1 + p1, f2 + p2, r0, r1, r2


@kernel(inline="always", fastmath={"contract"})
def add_wrench(joints, g, wrench, a, b, out, n):
    """out (., n) += H^T p of joint g, given by its wrench, in the rows a and b."""
    f0, f1, f2, r0, r1, r2 = wrench
    if len(joints.s) > 3:
        f = joints.frame[g]
        x, y, z = out_of_frame(f, f0, f1, f2)
        r0, r1, r2 = out_of_frame(f, r0, r1, r2)
        out[a, 0] += x
        out[a, 1] += y
        out[a, 2] += z
        out[a, 3] += r0 + (f[10] * z - f[11] * y)
        out[a, 4] += r1 + (f[11] * x - f[9] * z)
        out[a, 5] += r2 + (f[9] * y - f[10] * x)
        out[b, 0] -= x
        out[b, 1] -= y
        out[b, 2] -= z
        out[b, 3] -= r0 + (f[13] * z - f[14] * y)
        out[b, 4] -= r1 + (f[14] * x - f[12] * z)
        out[b, 5] -= r2 + (f[12] * y - f[13] * x)
        return
    rows = joints.rows
    for k in range(n):
        x, y = rows[g, 0, 0, k] * f0 + rows[g, 0, 1, k] * f1, rows[g, 1, 0, k] * f0 + rows[g, 1, 1, k] * f1
        if len(joints.s) == 3:
            x, y = x + rows[g, 0, 2, k] * f2, y + rows[g, 1, 2, k] * f2
        out[a, k] += x
        out[b, k] += y


@borrower()
def rows_of_twist(joints, g, rows):
    """Fill rows (2, s, n) of the twist of joint g by the velocities of its bodies."""
    if len(joints.s) <= 3:
        for side in range(2):
            for i in range(rows.shape[1]):
                for k in range(rows.shape[2]):
                    rows[side, i, k] = joints.rows[g, side, i, k]
        return
    frame = joints.frame[g]
    for side in range(2):
        sign, at = 1.0 - 2.0 * side, 9 + 3 * side
        for i in range(3):
            for k in range(3):
                j, l = (k + 1) % 3, (k + 2) % 3  # noqa: E741
                rows[side, i, k] = sign * frame[3 * i + k]
                rows[side, i, 3 + k] = sign * (frame[at + j] * frame[3 * i + l] - frame[at + l] * frame[3 * i + j])
                rows[side, 3 + i, k], rows[side, 3 + i, 3 + k] = 0.0, sign * frame[3 * i + k]


@borrower(fastmath={"contract"})
def add_up_stiffness(joints, g, rho, stiffness):
    """S (s, s), the sum of A_c^T R_c A_c over the contacts of joint g: u = A_c (t, omega), A_c = (I, -a x) or I, R_c (C,) of each."""
    s, arm = len(joints.s), joints.arm
    for i in range(s):
        for k in range(s):
            stiffness[i, k] = 0.0
    for c in range(joints.start[g], joints.start[g + 1]):
        r = rho[c]
        for i in range(min(s, 3)):
            stiffness[i, i] += r
        if s > 3:
            a0, a1, a2 = arm[c, 0], arm[c, 1], arm[c, 2]
            stiffness[0, 4] += r * a2
            stiffness[0, 5] -= r * a1
            stiffness[1, 5] += r * a0
            stiffness[1, 3] -= r * a2
            stiffness[2, 3] += r * a1
            stiffness[2, 4] -= r * a0
            stiffness[3, 3] += r * (a1 * a1 + a2 * a2)
            stiffness[4, 4] += r * (a2 * a2 + a0 * a0)
            stiffness[5, 5] += r * (a0 * a0 + a1 * a1)
            stiffness[3, 4] -= r * a0 * a1
            stiffness[3, 5] -= r * a0 * a2
            stiffness[4, 5] -= r * a1 * a2
    for i in range(s):
        for k in range(i):
            stiffness[i, k] = stiffness[k, i]
