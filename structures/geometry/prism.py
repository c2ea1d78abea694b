# SPDX-License-Identifier: GPL-3.0-or-later
"""Prisms: a convex polygon of the x-z plane (x along the structure, z up) drawn out along y."""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.model.geometry import Faces
from masonry_cd.mechanics.model.polygon import polygon_area


def prism_xz(polygon: np.ndarray, y0: float, y1: float) -> tuple[np.ndarray, Faces]:
    """Extrude a polygon of the x-z plane along y.

    Args:
        polygon: (n, 2) corners x, z [m] in either sense of rotation.
        y0, y1: the two end planes [m], in either order.

    Returns:
        The (2 n, 3) vertices, first those at the smaller y, and the faces, counter-clockwise from outside.
    """
    corners = np.asarray(polygon, dtype=float)
    if polygon_area(corners) < 0:  # seen from -y with x to the right and z up, the loop must run counter-clockwise
        corners = corners[::-1]
    n = len(corners)
    vertices = np.empty((2 * n, 3))
    vertices[:, [0, 2]] = np.concatenate([corners, corners])
    vertices[:n, 1], vertices[n:, 1] = min(y0, y1), max(y0, y1)
    front, back = tuple(range(n)), tuple(range(2 * n - 1, n - 1, -1))
    sides = tuple(((i + 1) % n, i, n + i, n + (i + 1) % n) for i in range(n))
    return vertices, (front, back, *sides)


def rectangle(x0: float, x1: float, z0: float, z1: float) -> np.ndarray:
    """The corners (4, 2) of an upright rectangle [m]."""
    return np.array([[x0, z0], [x1, z0], [x1, z1], [x0, z1]])


def between(first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, Faces]:
    """The solid between two polygons (n, 3) with as many corners, side by side: frusta, voussoirs of domes.

    Either polygon is plane and so is every quadrilateral between corresponding sides; the sense of rotation does not matter.
    """
    n = len(first)
    vertices = np.concatenate([first, second]).astype(float)
    sides = tuple((i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n))
    faces: Faces = (tuple(range(n - 1, -1, -1)), tuple(range(n, 2 * n)), *sides)
    corners = first - first.mean(axis=0)
    area = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    if area @ (second.mean(axis=0) - first.mean(axis=0)) < 0:
        faces = tuple(tuple(reversed(face)) for face in faces)
    return vertices, faces


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> tuple[np.ndarray, Faces]:
    """The cuboid between two corners [m]."""
    return prism_xz(rectangle(low[0], high[0], low[2], high[2]), low[1], high[1])
