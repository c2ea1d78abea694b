# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of contacts between rigid blocks in space: what their rows of H consist of, see contact_groups.py."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.linalg.small_blocks import size_tuple

FIT = 1e-12  # how far rows may be off those of a frame, relative to their largest arm: positions carry rounding
NUMBERS = 15  # of a frame: d_0, d_1, d_2, r_a, r_b


@entry()
def _frames_of(jacobian, bodies):
    """Frames (C, 15) of contacts of bodies (C, 2) whose rows (C, 2, 3, 6) are those of frames; (0, 15) if some are not."""
    frames, fitting = np.empty((len(jacobian), NUMBERS)), 0
    while fitting < len(jacobian) and fill_frame(jacobian, bodies, fitting, frames[fitting]):
        fitting += 1
    return frames if fitting == len(jacobian) else np.empty((0, NUMBERS))


def frames_of(jacobian: np.ndarray, bodies: np.ndarray) -> np.ndarray:
    """Frames (C, 15) of contacts with rows of H (C, 2, m, n), each as if it were a joint; (0, 15) if they are not all between rigid blocks
    in space."""
    if jacobian.shape[2:] != (3, 6):
        return np.empty((0, NUMBERS))
    frames: np.ndarray = _frames_of(jacobian, bodies)
    return frames


def size_of_twist(frames: np.ndarray, m: int) -> tuple[int, ...]:
    """As many zeros as the twists of contacts with these frames and m rows each have components, see small_blocks.py."""
    return size_tuple(6 if len(frames) else m)


@borrower()
def fill_frame(jacobian, bodies, c, frame):
    """Fill the frame (15,) of a joint from its contact c; False if its rows are not those of a frame."""
    known = False
    for side in range(2):
        sign, at = 1.0 - 2.0 * side, 9 + 3 * side
        frame[at], frame[at + 1], frame[at + 2] = 0.0, 0.0, 0.0
        if bodies[c, side] < 0:
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
def shares_frame(jacobian, bodies, first, c):
    """Whether contact c lies on the same faces as contact ``first``: equal bodies, not supports alone, and axes."""
    side = 0 if bodies[c, 0] >= 0 else 1
    if bodies[c, 0] != bodies[first, 0] or bodies[c, 1] != bodies[first, 1] or bodies[c, side] < 0:
        return False
    for i in range(3):
        for k in range(3):
            if jacobian[c, side, i, k] != jacobian[first, side, i, k]:
                return False
    return True


@borrower()
def fill_arm(jacobian, bodies, first, c, frame):
    """Put where contact c lies from contact ``first`` of its joint, in the axes of the frame (15,), in the place of r_a in it."""
    side = 0 if bodies[c, 0] >= 0 else 1
    sign = 1.0 - 2.0 * side
    for i in range(3):  # a_i = (a x d_j) . d_l
        j, l = (i + 1) % 3, (i + 2) % 3  # noqa: E741
        frame[9 + i] = 0.0
        for k in range(3):
            frame[9 + i] += sign * (jacobian[c, side, j, 3 + k] - jacobian[first, side, j, 3 + k]) * frame[3 * l + k]


@kernel(inline="always", fastmath={"contract"})
def into_frame(f, x, y, z):
    """The components of a vector in the axes of a frame (15,)."""
    return f[0] * x + f[1] * y + f[2] * z, f[3] * x + f[4] * y + f[5] * z, f[6] * x + f[7] * y + f[8] * z


@borrower(forceinline=True, fastmath={"contract"})
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
