"""The natural map of Coulomb's law with Signorini's condition: its projection, its residual, and their norms.

The residual of a contact is r - P_K(r - (z + mu |z_t| n)) in the scaled variables r = p sqrt(d), z = w / sqrt(d), see problem.py.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.coulomb_law import tangent_length
from masonry_cd.mechanics.linalg.small_blocks import EPSILON


@kernel(inline="always")
def project_to_cone(xn: float, x1: float, x2: float, mu: float) -> tuple[float, float, float]:
    """Project (xn, x1, x2) onto Coulomb's cone |x_t| <= mu x_n."""
    tangent = tangent_length(x1, x2)
    if mu * tangent <= -xn:  # first, or else a frictionless contact that opens without sliding would pass for a point of the cone
        return 0.0, 0.0, 0.0
    if tangent <= mu * xn:
        return xn, x1, x2
    height = (xn + mu * tangent) / (1.0 + mu * mu)
    scale = mu * height / tangent
    return height, scale * x1, scale * x2


@kernel(inline="always")
def squared_residual(pn: float, p1: float, p2: float, un: float, u1: float, u2: float, mu: float, d: float) -> float:
    """Squared natural map residual of a contact in the scaled variables r = p sqrt(d), w = u / sqrt(d).

    What rounding hides counts as error: where p has grown beyond all bounds, r - w is r, and the residual alone would be zero.
    """
    xn, x1, x2 = project_to_cone(d * pn - un - mu * tangent_length(u1, u2), d * p1 - u1, d * p2 - u2, mu)
    en, e1, e2 = d * pn - xn, d * p1 - x1, d * p2 - x2
    hidden = EPSILON * d
    return (en * en + e1 * e1 + e2 * e2 + hidden * hidden * (pn * pn + p1 * p1 + p2 * p2)) / d


@entry()
def natural_map_norms(p: np.ndarray, u: np.ndarray, q: np.ndarray, mu: np.ndarray, d: np.ndarray) -> tuple[float, float]:
    """Norms of the natural map residual and of q / sqrt(d), for impulses p, velocities u, q (C, m) and scales d (C,)."""
    residual, size = 0.0, 0.0
    contacts, m = p.shape
    for c in range(contacts):
        p2 = p[c, 2] if m == 3 else 0.0
        u2 = u[c, 2] if m == 3 else 0.0
        residual += squared_residual(p[c, 0], p[c, 1], p2, u[c, 0], u[c, 1], u2, mu[c], d[c])
        for i in range(m):
            size += q[c, i] * q[c, i] / d[c]
    return np.sqrt(residual), np.sqrt(size)


@borrower()
def size_of(q: np.ndarray, d: np.ndarray) -> float:
    """|q / sqrt(d)|, by which errors are divided; 1 if it is zero."""
    total = 0.0
    for c in range(len(d)):
        for i in range(q.shape[1]):
            total += q[c, i] * q[c, i] / d[c]
    return np.sqrt(total) if total > 0.0 else 1.0
