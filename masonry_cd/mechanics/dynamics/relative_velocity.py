# SPDX-License-Identifier: GPL-3.0-or-later
"""The relative velocity at a contact, u = H v + the velocity of the supports, row by row: the one place where the step computes it.

Each kernel adds to ``start`` what its sides contribute, side after side and unknown after unknown, so that its rounding does not depend on
who asks. A side on a free block contributes J v with its part of H, one on a support sign * (t . v_support) with the row's unit vector t.
"""

from __future__ import annotations

from masonry_cd.foundation.jit import borrower


@borrower()
def of_bodies(bodies, jacobian, c, i, v, start):
    """start + (H v) of row i of contact c; ``bodies`` (C, 2) with -1 for supports, ``jacobian`` (C, 2, m, n), ``v`` (F, n)."""
    u = start
    for side in range(2):
        b = bodies[c, side]
        if b >= 0:
            for j in range(v.shape[1]):
                u += jacobian[c, side, i, j] * v[b, j]
    return u


@borrower()
def all_of_bodies(bodies, jacobian, c, v):
    """H v of contact c, all rows, three numbers, zero for one that it does not have; arguments as of :func:`of_bodies`.

    The rows are added up side by side, not one after the other: three times as quick.
    """
    u0, u1, u2, m = 0.0, 0.0, 0.0, jacobian.shape[2]
    for side in range(2):
        b = bodies[c, side]
        if b < 0:
            continue
        if m == 3:
            for j in range(v.shape[1]):
                x = v[b, j]
                u0 += jacobian[c, side, 0, j] * x
                u1 += jacobian[c, side, 1, j] * x
                u2 += jacobian[c, side, 2, j] * x
        else:
            for j in range(v.shape[1]):
                x = v[b, j]
                u0 += jacobian[c, side, 0, j] * x
                u1 += jacobian[c, side, 1, j] * x
    return u0, u1, u2


@borrower()
def of_supports(supports, frame, c, i, velocity, start):
    """start + what supports move along row i of contact c; ``supports`` (C, 2) with -1 for free blocks, ``velocity`` (S, 3)."""
    u = start
    for side in range(2):
        s, sign = supports[c, side], 1.0 - 2.0 * side
        if s >= 0:
            for d in range(3):
                u += sign * frame[c, i, d] * velocity[s, d]
    return u


@borrower()
def of_both(bodies, supports, jacobian, frame, c, i, v, velocity, start):
    """start + the relative velocity along row i of contact c; arguments as of :func:`of_bodies` and :func:`of_supports`."""
    u = start
    for side in range(2):
        b, s, sign = bodies[c, side], supports[c, side], 1.0 - 2.0 * side
        if b >= 0:
            for j in range(v.shape[1]):
                u += jacobian[c, side, i, j] * v[b, j]
        else:
            for d in range(3):
                u += sign * frame[c, i, d] * velocity[s, d]
    return u
