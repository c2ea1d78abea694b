# SPDX-License-Identifier: GPL-3.0-or-later
"""Where contacts lie, by a frame and two arms, or else their rows of H: u = H v and H^T p of one side of a contact.

A contact between rigid blocks in space has the axes d = (n, t1, t2), right-handed, and lies at r_a and r_b from the centres of its bodies:

    u_i = d_i . (v_a + omega_a x r_a) - d_i . (v_b + omega_b x r_b),        f = sum of p_i d_i,

and the impulse p adds (f, r_a x f) to the momenta of body a, and the opposite, at r_b, to those of body b. These fifteen numbers come from
the detector, and stand for the 36 of its rows of H. In a plane nothing would be won; blocks that deform, and problems from files, have rows
of H. Kernels take what has these fields, whether it has frames or rows: a :class:`Geometry`, or the contacts of a step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.linalg.triples import cross, in_axes, minus, out_of_axes, plus, scaled


class Geometry(NamedTuple):
    """Frames and arms of C contacts, or their rows of H; of the two the other is empty."""

    frame: np.ndarray  # (C, 3, 3) rows n, t1, t2; (0, 3, 3) by rows
    arm: np.ndarray  # (C, 2, 3) r_a and r_b, zero on supports [m]; (0, 2, 3) by rows
    jacobian: np.ndarray  # (C, 2, m, n) H by contact and body; (0, 2, m, n) by arms

    @classmethod
    def by_arms(cls, frame: np.ndarray, arm: np.ndarray) -> Geometry:
        """Contacts between rigid blocks in space by frames (C, 3, 3) and arms (C, 2, 3)."""
        return cls(frame, arm, np.empty((0, 2, 3, 6)))

    @classmethod
    def by_rows(cls, jacobian: np.ndarray) -> Geometry:
        """Contacts by their rows of H (C, 2, m, n)."""
        return cls(np.empty((0, 3, 3)), np.empty((0, 2, 3)), jacobian)

    def of(self, contacts: np.ndarray) -> Geometry:
        """Some contacts, by a mask (C,) or their indices."""
        return Geometry(*(array[contacts] if len(array) else array for array in self))

    def rows(self, bodies: np.ndarray) -> np.ndarray:
        """H (C, 2, m, n) of contacts between bodies (C, 2), zero on supports where it follows from arms."""
        if not len(self.frame):
            return self.jacobian
        signs = np.where(bodies >= 0, [1.0, -1.0], 0.0)[:, :, None, None]
        axes = np.broadcast_to(self.frame[:, None], (len(self.frame), 2, 3, 3))
        return signs * np.concatenate([axes, np.cross(self.arm[:, :, None], axes)], axis=3)


@borrower(forceinline=True)
def is_by_arms(contacts):
    """Whether contacts have frames and arms."""
    return len(contacts.jacobian) == 0


@borrower(forceinline=True)
def axes_at(contacts, c):
    """The axes n, t1, t2 of contact c."""
    f = contacts.frame
    return (f[c, 0, 0], f[c, 0, 1], f[c, 0, 2]), (f[c, 1, 0], f[c, 1, 1], f[c, 1, 2]), (f[c, 2, 0], f[c, 2, 1], f[c, 2, 2])


@borrower(forceinline=True)
def arm_at(contacts, c, side):
    """The arm of contact c on a side."""
    return contacts.arm[c, side, 0], contacts.arm[c, side, 1], contacts.arm[c, side, 2]


@borrower(forceinline=True, fastmath={"contract"})
def velocity_of_side(contacts, c, side, b, count, v):
    """What body b, on one side of contact c, adds to H v, for v (B, n): three numbers, the last zero in a plane.

    ``count``: unknowns of a body that has rows.
    """
    if is_by_arms(contacts):
        move, turn = (v[b, 0], v[b, 1], v[b, 2]), (v[b, 3], v[b, 4], v[b, 5])
        return in_axes(axes_at(contacts, c), scaled(1.0 - 2.0 * side, plus(move, cross(turn, arm_at(contacts, c, side)))))
    jacobian, u0, u1, u2 = contacts.jacobian, 0.0, 0.0, 0.0
    if jacobian.shape[2] == 3:
        for k in range(count):
            x = v[b, k]
            u0, u1, u2 = u0 + jacobian[c, side, 0, k] * x, u1 + jacobian[c, side, 1, k] * x, u2 + jacobian[c, side, 2, k] * x
    else:
        for k in range(count):
            x = v[b, k]
            u0, u1 = u0 + jacobian[c, side, 0, k] * x, u1 + jacobian[c, side, 1, k] * x
    return u0, u1, u2


@borrower(forceinline=True, fastmath={"contract"})
def velocity_between(bodies, contacts, c, v):
    """H v of contact c of bodies (C, 2), -1 for supports, for body velocities v (B, n): three numbers."""
    u = (0.0, 0.0, 0.0)
    for side in range(2):
        if bodies[c, side] >= 0:
            u = plus(u, velocity_of_side(contacts, c, side, bodies[c, side], v.shape[1], v))
    return u


@borrower(forceinline=True, fastmath={"contract"})
def add_impulse_of_side(contacts, c, side, b, count, p, out):
    """Row b of out (B, n) += H^T p of body b, on one side of contact c, for an impulse p of three numbers.

    ``count``: unknowns of a body that has rows.
    """
    if is_by_arms(contacts):
        f = scaled(1.0 - 2.0 * side, out_of_axes(axes_at(contacts, c), p))
        moment = cross(arm_at(contacts, c, side), f)
        for k in range(3):
            out[b, k] += f[k]
            out[b, 3 + k] += moment[k]
        return
    jacobian = contacts.jacobian
    for k in range(count):
        gain = jacobian[c, side, 0, k] * p[0] + jacobian[c, side, 1, k] * p[1]
        if jacobian.shape[2] == 3:
            gain += jacobian[c, side, 2, k] * p[2]
        out[b, k] += gain


@borrower()
def fill_row(contacts, c, side, i, row):
    """Fill row (k,) with the first k entries of row i of H of contact c, on one side."""
    if is_by_arms(contacts):
        axis = contacts.frame[c, i, 0], contacts.frame[c, i, 1], contacts.frame[c, i, 2]
        axis = scaled(1.0 - 2.0 * side, axis)
        moment = cross(arm_at(contacts, c, side), axis)
        for k in range(3):
            row[k], row[3 + k] = axis[k], moment[k]
        return
    for k in range(len(row)):
        row[k] = contacts.jacobian[c, side, i, k]


@borrower(fastmath={"contract"})
def trace_by_arms(inverse, contacts, c, a, b):
    """trace(W_cc) of contact c between bodies a and b with M^-1 (B, 6, 6), where a body beyond the last one is a support.

    At r from the centre of a block with M^-1 = (A, B; B^T, K) it is tr A + tr K |r|^2 - r . K r + 2 b . r in any axes, with b that of
    which the skew part of B is a half. Of two places on one block only the arm between them counts.
    """
    trace = 0.0
    for side in range(1 if a == b else 2):
        body, r = b if side else a, arm_at(contacts, c, side)
        if body >= len(inverse):
            continue
        own = inverse[body]
        if a == b:
            r = minus(r, arm_at(contacts, c, 1))
        else:
            trace += own[0, 0] + own[1, 1] + own[2, 2]
            trace += 2.0 * (r[0] * (own[1, 5] - own[2, 4]) + r[1] * (own[2, 3] - own[0, 5]) + r[2] * (own[0, 4] - own[1, 3]))
        turns = (own[3, 3], own[3, 4], own[3, 5]), (own[4, 3], own[4, 4], own[4, 5]), (own[5, 3], own[5, 4], own[5, 5])
        kr = in_axes(turns, r)
        for i in range(3):
            trace += (own[3, 3] + own[4, 4] + own[5, 5]) * r[i] * r[i] - r[i] * kr[i]
    return trace


@borrower()
def shares_faces(contacts, bodies, first, c):
    """Whether contact c lies on the same faces as contact ``first``: equal bodies (C, 2), not supports alone, and equal axes."""
    if bodies[c, 0] != bodies[first, 0] or bodies[c, 1] != bodies[first, 1] or max(bodies[c, 0], bodies[c, 1]) < 0:
        return False
    for i in range(3):
        for k in range(3):
            if contacts.frame[c, i, k] != contacts.frame[first, i, k]:
                return False
    return True
