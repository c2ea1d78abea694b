# SPDX-License-Identifier: GPL-3.0-or-later
"""The contacts of each body: what they give to it is added up in their order, whichever thread of a team does it.

Looped over contacts, two threads would add to one body at once; looped over bodies, each has its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.coupling import add_coupled, is_coupled
from masonry_cd.mechanics.friction.joint_twists import out_of_frame
from masonry_cd.mechanics.friction.operators import has_frames, unknowns_at

BODY = 2  # what a body costs beside its contacts, in sides of contacts
LATER = 2  # what a side costs for the blocks between its body and one that is eliminated later


class BodySides(NamedTuple):
    """The sides of the contacts that bodies have, of B bodies in order of elimination."""

    start: np.ndarray  # (B + 1,) starts of the sides of each body
    side: np.ndarray  # (S,) 2 c + s for side s of contact c, ascending for each body
    cost: np.ndarray  # (B + 1,) what the bodies before each cost in a pass over their sides
    matrix_cost: np.ndarray  # (B + 1,) in one that assembles their columns of M + H^T B H


@entry()
def sides_of_bodies(bodies, count):
    """The sides of contacts (C, 2) on each of ``count`` bodies: starts (B + 1,), and 2 c + side, contact by contact.

    Other numbers than 0 to B - 1 are supports.
    """
    start = np.zeros(count + 1, dtype=np.int64)
    for c in range(len(bodies)):
        for s in range(2):
            if 0 <= bodies[c, s] < count:
                start[bodies[c, s] + 1] += 1
    for b in range(count):
        start[b + 1] += start[b]
    side, at = np.empty(start[count], dtype=np.int64), start[:-1].copy()
    for c in range(len(bodies)):
        for s in range(2):
            b = bodies[c, s]
            if 0 <= b < count:
                side[at[b]] = 2 * c + s
                at[b] += 1
    return start, side


@kernel()
def weighed_sides(places, block, count):
    """:class:`BodySides` of contacts with the ``places`` (C, 2) of their bodies, ``count`` for supports, their blocks (C,) or -1."""
    start, side = sides_of_bodies(places, count)
    later = np.zeros(count + 1, dtype=np.int64)
    for c in range(len(places)):
        if block[c] >= 0:
            later[min(places[c, 0], places[c, 1]) + 1] += LATER
    for b in range(count):
        later[b + 1] += later[b]
    cost = start + BODY * np.arange(count + 1)
    return BodySides(start, side, cost, cost + later)


@kernel(inline="always")
def share_by_cost(team, cost):
    """First and end of the thread's share of items before each of which so much is spent, see :class:`BodySides`."""
    count = len(cost) - 1
    first, end = 0, 0
    for k in range(count):
        first += 1 if cost[k] * team.size < cost[count] * team.rank else 0
        end += 1 if cost[k] * team.size < cost[count] * (team.rank + 1) else 0
    return first, end


@borrower(fastmath={"contract"})
def add_impulse_of_sides(problem, sides, p, begin, stop, out):
    """out (B + 1, n) += G p of the bodies from begin to stop, for impulses p (C, m); each thread has its own when all have theirs."""
    jacobian, m = problem.jacobian, len(problem.m)
    if is_coupled(problem):
        add_coupled(problem, p, begin, stop, out)
        return
    for b in range(begin, stop):
        if has_frames(problem):
            add_wrench_of_sides(problem, sides, p, b, out)
            continue
        n = unknowns_at(problem, b, b)
        for e in range(sides.start[b], sides.start[b + 1]):
            c, s = sides.side[e] // 2, sides.side[e] % 2
            for i in range(m):
                x = p[c, i]
                for k in range(n):
                    out[b, k] += jacobian[c, s, i, k] * x


@borrower(fastmath={"contract"})
def add_wrench_of_sides(problem, sides, p, b, out):
    """out (B + 1, 6) += H^T p of a rigid body in space, by the frames of its contacts."""
    x, y, z, r0, r1, r2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for e in range(sides.start[b], sides.start[b + 1]):
        c, s = sides.side[e] // 2, sides.side[e] % 2
        f, sign, at = problem.frame[c], 1.0 - 2.0 * s, 9 + 3 * s
        f0, f1, f2 = out_of_frame(f, sign * p[c, 0], sign * p[c, 1], sign * p[c, 2])
        x, y, z = x + f0, y + f1, z + f2
        r0 += f[at + 1] * f2 - f[at + 2] * f1
        r1 += f[at + 2] * f0 - f[at] * f2
        r2 += f[at] * f1 - f[at + 1] * f0
    out[b, 0] += x
    out[b, 1] += y
    out[b, 2] += z
    out[b, 3] += r0
    out[b, 4] += r1
    out[b, 5] += r2
