# SPDX-License-Identifier: GPL-3.0-or-later
"""G p, the generalised impulses of the bodies: over bodies H^T p, where W alone is given see coupling.py.

Two threads may not add to one body at once. So each of a team passes over all contacts, and adds to bodies of its own: what a body gets is
added up in the order of the contacts, whichever thread does it.
"""

from __future__ import annotations

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.friction.coupling import add_coupled, is_coupled
from masonry_cd.mechanics.friction.joint_twists import out_of_frame
from masonry_cd.mechanics.friction.operators import has_frames, unknowns_at


@borrower(fastmath={"contract"})
def add_impulse(problem, p, begin, stop, out):
    """out (B or more, n) += G p of the bodies at the places from begin to stop, for impulses p (C, m)."""
    if is_coupled(problem):
        add_coupled(problem, p, begin, stop, out)
        return
    if has_frames(problem):
        add_wrenches(problem, p, begin, stop, out)
        return
    for c in range(len(p)):
        for side in range(2):
            b = problem.places[c, side]
            if begin <= b < stop:
                for i in range(len(problem.m)):
                    x = p[c, i]
                    for k in range(unknowns_at(problem, b, b)):
                        out[b, k] += problem.jacobian[c, side, i, k] * x


@borrower(fastmath={"contract"})
def add_wrenches(problem, p, begin, stop, out):
    """:func:`add_impulse` of rigid bodies in space, by the frames of the contacts, those of a joint at once."""
    c, places = 0, problem.places
    while c < len(p):
        a, b = places[c, 0], places[c, 1]
        is_own, x, y, z, r0, r1, r2, s0, s1, s2 = begin <= a < stop or begin <= b < stop, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        while c < len(p) and places[c, 0] == a and places[c, 1] == b:
            if is_own:
                f = problem.frame[c]
                f0, f1, f2 = out_of_frame(f, p[c, 0], p[c, 1], p[c, 2])
                x, y, z = x + f0, y + f1, z + f2
                r0, r1, r2 = r0 + f[10] * f2 - f[11] * f1, r1 + f[11] * f0 - f[9] * f2, r2 + f[9] * f1 - f[10] * f0
                s0, s1, s2 = s0 + f[13] * f2 - f[14] * f1, s1 + f[14] * f0 - f[12] * f2, s2 + f[12] * f1 - f[13] * f0
            c += 1
        if begin <= a < stop:
            add_wrench(out, a, 1.0, (x, y, z, r0, r1, r2))
        if begin <= b < stop:
            add_wrench(out, b, -1.0, (x, y, z, s0, s1, s2))


@kernel(inline="always")
def add_wrench(out, b, sign, wrench):
    """out (B, 6) += sign times a wrench of six numbers, on body b."""
    out[b, 0] += sign * wrench[0]
    out[b, 1] += sign * wrench[1]
    out[b, 2] += sign * wrench[2]
    out[b, 3] += sign * wrench[3]
    out[b, 4] += sign * wrench[4]
    out[b, 5] += sign * wrench[5]
