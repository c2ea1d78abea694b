# SPDX-License-Identifier: GPL-3.0-or-later
"""Spheres: their mass properties, exact, and the facetted ball by which they are drawn.

A block that is a sphere of radius R has V = 4/3 pi R^3, and about any axis through its centre the second moment 2/5 V R^2. Contact
detection sees its centre and its radius alone. What draws blocks, writes them for other programs or bounds them sees a ball of 80 triangles
whose 42 corners are on the sphere: an icosahedron, each side halved. Before these corners comes the centre itself, in no triangle.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from masonry_cd.mechanics.model.geometry import Faces, MassProperties

POINTS = 43  # of a facetted ball: its centre, then its corners


def sphere_properties(vertices: np.ndarray, radius: float) -> MassProperties:
    """Volume, centre and inertia per density of the sphere of a radius [m] about the centre of a facetted ball (POINTS, 3)."""
    volume = 4.0 / 3.0 * math.pi * radius**3
    return MassProperties(volume, ball_centre(vertices), 0.4 * volume * radius**2 * np.eye(3))


def ball_centre(vertices: np.ndarray) -> np.ndarray:
    """Centre (3,) of a facetted ball (POINTS, 3) [m]."""
    return np.asarray(vertices[0])


def facetted_ball(centre: np.ndarray, radius: float) -> tuple[np.ndarray, Faces]:
    """Centre and corners (POINTS, 3) of a ball whose corners are on a sphere [m], and the triangles, counter-clockwise from outside."""
    corners, faces = _unit_ball()
    return np.asarray(centre + radius * corners), faces


@cache
def _unit_ball() -> tuple[np.ndarray, Faces]:
    """The ball of radius one round the origin; all spheres share its faces."""
    golden = 0.5 * (1.0 + math.sqrt(5.0))
    corners = [[0.0, golden, 1.0], [0.0, -golden, -1.0], [0.0, golden, -1.0], [0.0, -golden, 1.0]]
    points = np.array([np.roll(corner, turn) for turn in range(3) for corner in corners])
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    near = np.isclose(apart, 2.0)  # its sides are two long
    triangles = [
        (i, j, k) for i in range(12) for j in range(i + 1, 12) for k in range(j + 1, 12) if near[i, j] and near[j, k] and near[i, k]
    ]
    middle: dict[tuple[int, int], int] = {}
    for i in range(12):
        for j in range(i + 1, 12):
            if near[i, j]:
                middle[i, j] = middle[j, i] = 12 + len(middle) // 2
    sides = sorted({(min(pair), max(pair)) for pair in middle})
    points = np.concatenate([points, [0.5 * (points[i] + points[j]) for i, j in sides]])
    points /= np.linalg.norm(points, axis=1)[:, None]
    faces = []
    for i, j, k in triangles:
        a, b, c = middle[j, k], middle[k, i], middle[i, j]
        for face in ((i, c, b), (j, a, c), (k, b, a), (a, b, c)):
            p, q, r = points[list(face)]
            outward = float(np.sum(np.cross(q - p, r - p) * (p + q + r))) > 0.0
            faces.append(face if outward else face[::-1])
    return np.concatenate([np.zeros((1, 3)), points]), tuple(tuple(1 + i for i in face) for face in faces)
