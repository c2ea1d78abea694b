# SPDX-License-Identifier: GPL-3.0-or-later
r"""Coulomb's law at one contact, solved exactly.

One contact, all others held, sees u = W p + q with its own 3 x 3 block W of the Delassus operator, plus its compliance if it is elastic
(then u is what friction.py calls w). Signorini's condition and Coulomb's law then have one of three answers (Jean, Comput. Methods Appl.
Mech. Engrg. 177, 1999):

    separation   p = 0                              if q_n >= 0
    stick        p = -W^-1 q                        if that lies in the cone |p_t| <= mu p_n
    slip         u_n = 0,  u_t = -s p_t,  |p_t| = mu p_n   with s > 0

In slip the normal row is eliminated, p_n = -(q_n + w.p_t) / W_nn, which leaves (A + s I) p_t = -a with the Schur complement
A = W_tt - w w^T / W_nn and a = q_t - w q_n / W_nn. The one unknown s solves

    h(s) = mu p_n(s) / |p_t(s)| - 1 = 0,     h(0) < 0,  h(infinity) > 0,

which is exactly linear when W is diagonal and isotropic, and nearly so otherwise: Newton inside a shrinking bracket ends after two
or three steps (the idea of the secular equation of trust regions, More & Sorensen, SIAM J. Sci. Stat. Comput. 4, 1983).

Planar contacts (one tangent) use the same step with a second tangent that carries nothing.

Without friction the cone is its axis: p_n = max(0, -q_n / W_nn), p_t = 0. A mu below FRICTIONLESS counts as none. Methods that need a cone
with an inside give it one of NARROWEST, whatever mu is below.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel

OPEN, STICK, SLIP = 0, 1, 2  # status of a contact
INVERSE_NN, COUPLING, SCHUR, NN, SCALE, START, MU, Q, P, C = 0, 1, 3, 6, 7, 8, 9, 10, 13, 16  # columns of a table of contacts
ROW = 19
FRICTIONLESS = 1e-60  # |t| grows as 1 / mu, and its third power has to stay a number
NARROWEST = 1e-6


@kernel(inline="always")
def has_friction(mu: float) -> bool:
    """True if a contact with this coefficient counts as one with friction."""
    return mu >= FRICTIONLESS


@kernel(inline="always")
def tangent_length(x: float, y: float) -> float:
    """Length of a tangential vector."""
    return np.sqrt(x * x + y * y)


Vector = tuple[float, float, float]  # normal, first tangent, second tangent
Row = tuple[float, float, float, float, float, float]  # 1/W_nn, c = w/W_nn (2), A (3: 11, 12, 22), the first six of a row of the table


@borrower()
def slip_impulse(qn: float, a1: float, a2: float, row: Row, mu: float, s: float) -> tuple[float, float, float, float]:
    """Solve the slip equation from a first guess of s, see the head of this file; a = (a1, a2). Returns p and s.

    With t = det(A + s I) p_t, which is linear in s, and N = mu det(A + s I) p_n it reads N / |t| = 1: one root and one division a step.
    """
    winv, c1, c2, s11, s12, s22 = row
    low, high = 0.0, np.inf
    push = -qn * winv
    x1, x2 = s12 * a2 - s22 * a1, s12 * a1 - s11 * a2  # t at s = 0
    for _ in range(100):
        t1, t2 = x1 - s * a1, x2 - s * a2
        square = t1 * t1 + t2 * t2
        tangent = np.sqrt(square)
        normal = mu * (push * ((s11 + s) * (s22 + s) - s12 * s12) - c1 * t1 - c2 * t2)
        slope = mu * (push * (s11 + s22 + 2.0 * s) + c1 * a1 + c2 * a2)
        move = (tangent - normal) * square / (slope * square + normal * (t1 * a1 + t2 * a2))
        if abs(normal - tangent) <= 1e-8 * tangent:  # Newton is quadratic: one more step leaves 1e-16
            s += move
            break
        if normal < tangent:
            low = s
        else:
            high = s
        s += move
        if not (low < s < high):  # also when the slope is zero or not a number
            s = 0.5 * (low + high) if high < np.inf else 2.0 * low + s11 + s22
        if high < np.inf and high - low <= 4e-16 * high:
            break
    # the cone exactly, with the direction of slip found and u_n = 0: p_n (1 + mu c.t / |t|) = -q_n / W_nn
    t1, t2 = x1 - s * a1, x2 - s * a2
    tangent = tangent_length(t1, t2)
    share = push / (tangent + mu * (c1 * t1 + c2 * t2))
    if not (share >= 0.0 and share < np.inf and tangent < np.inf):  # never a NaN, never outside the cone; a push of 1e-170 has s near 1e170
        return push, 0.0, 0.0, 0.0
    return share * tangent, mu * share * t1, mu * share * t2, s


@kernel(inline="always")
def local_impulse(q: Vector, row: Row, mu: float, s: float) -> tuple[float, float, float, float]:
    """The exact answer (p, s) of one contact to the velocity q that it sees without its own impulse.

    The slip equation is solved from where the search of the last sweep ended: mostly one step, instead of three from s = 0.
    """
    (qn, q1, q2), (winv, c1, c2, s11, s12, s22) = q, row
    if qn >= 0.0:
        return 0.0, 0.0, 0.0, s
    a1 = q1 - c1 * qn
    a2 = q2 - c2 * qn
    inverse = 1.0 / (s11 * s22 - s12 * s12)
    p1 = (s12 * a2 - s22 * a1) * inverse
    p2 = (s12 * a1 - s11 * a2) * inverse
    pn = -qn * winv - c1 * p1 - c2 * p2
    if pn >= 0.0 and p1 * p1 + p2 * p2 <= mu * mu * pn * pn:
        return pn, p1, p2, s
    if not has_friction(mu):
        return -qn * winv, 0.0, 0.0, s
    return slip_impulse(qn, a1, a2, row, mu, s)


@borrower()
def prepare_law(w: np.ndarray, m: int, mu: float, law: np.ndarray, c: int) -> None:
    """Prepare the local law of contact c from W (3, 3) and mu: 1/W_nn, w/W_nn (2), A (3), W_nn, d = trace/m, s = 0, mu."""
    wnn = w[0, 0]
    w1, w2 = 0.5 * (w[0, 1] + w[1, 0]), 0.5 * (w[0, 2] + w[2, 0])
    tiny = 1e-14 * (w[0, 0] + w[1, 1] + w[2, 2])
    wnn = max(wnn, tiny)
    c1, c2 = w1 / wnn, w2 / wnn
    s11 = max(w[1, 1] - w1 * c1, tiny)
    s22 = max(w[2, 2] - w2 * c2, tiny) if m == 3 else s11
    s12 = 0.5 * (w[1, 2] + w[2, 1]) - w1 * c2 if m == 3 else 0.0
    bound = np.sqrt(s11 * s22) * (1.0 - 1e-14)
    s12 = min(max(s12, -bound), bound)
    law[c, 0], law[c, 1], law[c, 2] = 1.0 / wnn, c1, c2
    law[c, 3], law[c, 4], law[c, 5] = s11, s12, s22
    law[c, 6] = wnn
    law[c, SCALE] = (w[0, 0] + w[1, 1] + (w[2, 2] if m == 3 else 0.0)) / m
    law[c, START], law[c, MU] = 0.0, mu


@kernel(inline="always")
def own_velocity(
    pn: float, p1: float, p2: float, c1: float, c2: float, s11: float, s12: float, s22: float, wnn: float
) -> tuple[float, float, float]:
    """(W + C) p of a contact from its row of the table: with w = c W_nn and W_tt = A + w w^T / W_nn."""
    un = wnn * (pn + c1 * p1 + c2 * p2)
    return un, c1 * un + s11 * p1 + s12 * p2, c2 * un + s12 * p1 + s22 * p2
