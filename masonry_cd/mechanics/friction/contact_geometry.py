# SPDX-License-Identifier: GPL-3.0-or-later
"""Contacts by a frame and two arms, or else by their rows of H: u = H v and H^T p of one side of a contact.

A contact between rigid blocks in space has the axes d = (n, t1, t2), right-handed, and lies at r_a and r_b from the centres of its bodies:

    u_i = d_i . (v_a + omega_a x r_a) - d_i . (v_b + omega_b x r_b),        f = sum of p_i d_i,

and the impulse p adds (f, r_a x f) to the momenta of body a, and the opposite, at r_b, to those of body b. In a plane vectors have two
components, and in the place of an arm stands what it moves by at unit rotation, a = e x r with the normal e of the plane:

    u_i = d_i . (v_a + omega_a a_a) - d_i . (v_b + omega_b a_b),        (f, a_a . f).

These fifteen numbers, or eight, come from the detector, and stand for the 36, or twelve, of its rows of H. Blocks that deform, and problems
from files, have rows of H. Kernels learn from the frames which of the three it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.linalg.triples import cross, in_axes, minus, out_of_axes, plus, scaled

BY_ROWS, IN_PLANE, IN_SPACE = 0, 2, 3  # forms of a contact: rows of H, or the components of its vectors


class Geometry(NamedTuple):
    """Frames and arms of C contacts with k components, three in space and two in a plane, or their rows of H; the others are empty."""

    frame: np.ndarray  # (C, k, k) rows n, t1, t2, or in a plane n, t1; (0, 0, 0) by rows
    arm: np.ndarray  # (C, 2, k) r_a and r_b, in a plane e x r, zero on supports [m]; (0, 2, 0) by rows
    jacobian: np.ndarray  # (C, 2, m, n) H by contact and body; (0, 2, m, n) by arms

    @classmethod
    def by_arms(cls, frame: np.ndarray, arm: np.ndarray) -> Geometry:
        """Contacts between rigid blocks by frames (C, k, k), right-handed in space, and arms (C, 2, k) [m]."""
        k = frame.shape[1]
        return cls(frame, arm, np.empty((0, 2, k, 3 * (k - 1))))

    @classmethod
    def by_rows(cls, jacobian: np.ndarray) -> Geometry:
        """Contacts by their rows of H (C, 2, m, n)."""
        return cls(np.empty((0, 0, 0)), np.empty((0, 2, 0)), jacobian)

    @property
    def is_by_rows(self) -> bool:
        """True if the contacts have rows of H."""
        return self.frame.shape[1] == BY_ROWS

    def of(self, contacts: np.ndarray | slice) -> Geometry:
        """Some contacts, by a mask (C,), their indices or a slice."""
        return Geometry(*(array[contacts] if len(array) else array for array in self))

    def rows(self, bodies: np.ndarray) -> np.ndarray:
        """H (C, 2, m, n) of contacts between bodies (C, 2), zero on supports where it follows from arms."""
        if self.is_by_rows:
            return self.jacobian
        signs, arm = np.where(bodies >= 0, [1.0, -1.0], 0.0)[:, :, None, None], self.arm[:, :, None]
        axes = np.broadcast_to(self.frame[:, None], (len(self.frame), 2, *self.frame.shape[1:]))
        turned = np.cross(arm, axes) if axes.shape[3] == IN_SPACE else (arm * axes).sum(axis=3, keepdims=True)
        return signs * np.concatenate([axes, turned], axis=3)


@borrower(forceinline=True)
def form_of(contacts):
    """The form of contacts: IN_SPACE, IN_PLANE or BY_ROWS."""
    return contacts.frame.shape[1]


@borrower(forceinline=True)
def axes_at(contacts, c):
    """The axes n, t1, t2 of contact c in space."""
    f = contacts.frame
    return (f[c, 0, 0], f[c, 0, 1], f[c, 0, 2]), (f[c, 1, 0], f[c, 1, 1], f[c, 1, 2]), (f[c, 2, 0], f[c, 2, 1], f[c, 2, 2])


@borrower(forceinline=True)
def arm_at(contacts, c, side):
    """The arm of contact c in space on a side."""
    return contacts.arm[c, side, 0], contacts.arm[c, side, 1], contacts.arm[c, side, 2]


@borrower(forceinline=True, fastmath={"contract"})
def velocity_of_side(form, contacts, c, side, b, count, v):
    """The share of body b, on one side of contact c, in H v, for v (B, n): three numbers, the last zero in a plane.

    ``form`` is that of the contacts, ``count`` the unknowns of a body that has rows.
    """
    if form == IN_SPACE:
        move, turn = (v[b, 0], v[b, 1], v[b, 2]), (v[b, 3], v[b, 4], v[b, 5])
        return in_axes(axes_at(contacts, c), scaled(1.0 - 2.0 * side, plus(move, cross(turn, arm_at(contacts, c, side)))))
    if form == IN_PLANE:
        sign, frame, arm, turn = 1.0 - 2.0 * side, contacts.frame, contacts.arm, v[b, 2]
        x, y = sign * (v[b, 0] + turn * arm[c, side, 0]), sign * (v[b, 1] + turn * arm[c, side, 1])
        return frame[c, 0, 0] * x + frame[c, 0, 1] * y, frame[c, 1, 0] * x + frame[c, 1, 1] * y, 0.0
    jacobian, u0, u1, u2 = contacts.jacobian, 0.0, 0.0, 0.0
    for k in range(count):
        x = v[b, k]
        u0, u1 = u0 + jacobian[c, side, 0, k] * x, u1 + jacobian[c, side, 1, k] * x
        if jacobian.shape[2] == 3:
            u2 += jacobian[c, side, 2, k] * x
    return u0, u1, u2


@borrower(forceinline=True, fastmath={"contract"})
def velocity_between(bodies, contacts, c, v):
    """H v of contact c of bodies (C, 2), of which others than the B that have velocities v (B, n) are supports: three numbers."""
    u = (0.0, 0.0, 0.0)
    for side in range(2):
        if 0 <= bodies[c, side] < len(v):
            u = plus(u, velocity_of_side(form_of(contacts), contacts, c, side, bodies[c, side], v.shape[1], v))
    return u


@borrower(forceinline=True, fastmath={"contract"})
def add_impulse_of_side(form, contacts, c, side, b, count, p, out):
    """Row b of out (B, n) += H^T p of body b, on one side of contact c, for an impulse p of three numbers.

    ``form`` is that of the contacts, ``count`` the unknowns of a body that has rows.
    """
    if form == IN_SPACE:
        f = scaled(1.0 - 2.0 * side, out_of_axes(axes_at(contacts, c), p))
        moment = cross(arm_at(contacts, c, side), f)
        for k in range(3):
            out[b, k] += f[k]
            out[b, 3 + k] += moment[k]
        return
    if form == IN_PLANE:
        sign, frame, arm = 1.0 - 2.0 * side, contacts.frame, contacts.arm
        x, y = sign * (frame[c, 0, 0] * p[0] + frame[c, 1, 0] * p[1]), sign * (frame[c, 0, 1] * p[0] + frame[c, 1, 1] * p[1])
        out[b, 0] += x
        out[b, 1] += y
        out[b, 2] += arm[c, side, 0] * x + arm[c, side, 1] * y
        return
    jacobian = contacts.jacobian
    for k in range(count):
        gain = jacobian[c, side, 0, k] * p[0] + jacobian[c, side, 1, k] * p[1]
        if jacobian.shape[2] == 3:
            gain += jacobian[c, side, 2, k] * p[2]
        out[b, k] += gain


@borrower()
def fill_row(form, contacts, c, side, i, count, row):
    """Fill ``row`` (``count`` or more,) with row i of H of contact c, on one side, of which rows of H may have more."""
    sign = 1.0 - 2.0 * side
    if form == IN_SPACE:
        axis = scaled(sign, (contacts.frame[c, i, 0], contacts.frame[c, i, 1], contacts.frame[c, i, 2]))
        moment = cross(arm_at(contacts, c, side), axis)
        for k in range(3):
            row[k], row[3 + k] = axis[k], moment[k]
    elif form == IN_PLANE:
        x, y = sign * contacts.frame[c, i, 0], sign * contacts.frame[c, i, 1]
        row[0], row[1], row[2] = x, y, contacts.arm[c, side, 0] * x + contacts.arm[c, side, 1] * y
    else:
        for k in range(count):
            row[k] = contacts.jacobian[c, side, i, k]


@borrower(fastmath={"contract"})
def trace_by_arms(form, inverse, contacts, c, a, b):
    """trace(W_cc) of contact c between bodies a and b with M^-1 (B, n, n), where a body beyond the last one is a support.

    At r from the centre of a block with M^-1 = (A, B; B^T, K) it is tr A + tr K |r|^2 - r . K r + 2 b . r in any axes, with b that of
    which the skew part of B is a half; in a plane tr A + K |a|^2 + 2 B . a. Of two places on one block only the arm between them counts.
    """
    trace, arm = 0.0, contacts.arm
    for side in range(1 if a == b else 2):
        body = b if side else a
        if body >= len(inverse):
            continue
        own = inverse[body]
        if form == IN_PLANE:
            x, y = arm[c, side, 0], arm[c, side, 1]
            if a == b:
                x, y = x - arm[c, 1, 0], y - arm[c, 1, 1]
            else:
                trace += own[0, 0] + own[1, 1] + 2.0 * (x * own[0, 2] + y * own[1, 2])
            trace += own[2, 2] * (x * x + y * y)
            continue
        r = arm_at(contacts, c, side)
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
def shares_faces(contacts, places, supports, first, c):
    """True if contact c lies on the same faces as contact ``first``: bodies at equal places (C, 2), not supports alone, and equal axes."""
    if places[c, 0] != places[first, 0] or places[c, 1] != places[first, 1] or min(places[c, 0], places[c, 1]) >= supports:
        return False
    for i in range(form_of(contacts)):
        for k in range(form_of(contacts)):
            if contacts.frame[c, i, k] != contacts.frame[first, i, k]:
                return False
    return True
