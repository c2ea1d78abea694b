# SPDX-License-Identifier: GPL-3.0-or-later
"""The natural map of Coulomb's law with Signorini's condition: the projection onto its cone, and its residual.

The residual of a contact is r - P_K(r - (z + mu |z_t| n)) in the scaled variables r = p sqrt(d), z = w / sqrt(d), see problem.py. A vector
is three numbers, each a float or lanes of floats (linalg/vectors.py): what is written here serves one contact or four side by side.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.small_blocks import EPSILON
from masonry_cd.mechanics.linalg.triples import inner, minus, scaled
from masonry_cd.mechanics.linalg.vectors import root_of, where_at_most


@borrower(forceinline=True, fastmath={"contract"})
def length_of(x, y):
    """Length of a tangential vector."""
    return root_of(x * x + y * y)


@borrower(forceinline=True, fastmath={"contract"})
def project_to_cone(x, mu, stretch, share):
    """Project x onto Coulomb's cone |x_t| <= mu x_n in the norm sqrt(mu x_n^2 + stretch |x_t|^2); ``share`` is 1 / (1 + mu stretch).

    With stretch = mu it is the nearest point. All three answers are computed, with one division and one root.
    """
    tangent = length_of(x[1], x[2])
    reach = stretch * tangent + x[0]
    height = reach * share
    scale = mu * height / tangent
    height, scale = where_at_most(tangent, mu * x[0], x[0], height), where_at_most(tangent, mu * x[0], 1.0, scale)
    # last, or else a frictionless contact that opens without sliding would pass for a point of the cone
    height, scale = where_at_most(reach, 0.0, 0.0, height), where_at_most(reach, 0.0, 0.0, scale)
    return height, scale * x[1], scale * x[2]


@borrower(forceinline=True, fastmath={"contract"})
def squared_residual(p, w, mu, d):
    """Squared natural map residual of a contact with impulse p, velocity w and scale d.

    What rounding hides counts as error: where p has grown beyond all bounds, r - z is r, and the residual alone would be zero.
    """
    r = scaled(d, p)
    e = minus(r, project_to_cone(minus(r, (w[0] + mu * length_of(w[1], w[2]), w[1], w[2])), mu, mu, 1.0 / (1.0 + mu * mu)))
    hidden = EPSILON * d
    return (inner(e, e) + hidden * hidden * inner(p, p)) / d


@kernel(inline="always")
def error_of(residual: float, size: float) -> float:
    """The natural map error, by the squared norms of the residual and of q / sqrt(d); that of the residual alone if q is zero."""
    return np.sqrt(residual / size) if size > 0.0 else np.sqrt(residual)
