# SPDX-License-Identifier: GPL-3.0-or-later
"""Scratch arrays of contact detection, made once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.contact.manifold import Manifold
from masonry_cd.mechanics.model.blocks import ConvexShapes


class Workspace(NamedTuple):
    """Scratch arrays for one pair after another."""

    now: np.ndarray  # (12,) pose of b in the frame of a
    vertices: np.ndarray  # (V, 3) of b in the frame of a [m]
    normals: np.ndarray  # (F, 3)
    manifold: Manifold
    place: np.ndarray  # (N,) contacts of the last set that its points continue
    crushed: np.ndarray  # (N,) by how much the joint is shorter at them for good [m]
    ahead_position: np.ndarray  # (2, 3) of both bodies a step later [m]
    ahead_rotation: np.ndarray  # (2, 3, 3)
    unexplained: np.ndarray  # (3,) a pair with an overlap that no motion explains, or -1; its gap, and the least that is explained [m]

    @classmethod
    def allocate(cls, shapes: ConvexShapes, corners: int, more: int = 0) -> Workspace:
        """Room for parts, by the largest number of corners of a face, and for more points between facets."""
        manifold = Manifold.allocate(corners, more)
        vertices, faces = (int(np.diff(start).max()) for start in (shapes.solids.vertex_start, shapes.solids.face_start))
        place, crushed = np.empty(len(manifold.point), dtype=np.int64), np.empty(len(manifold.point))
        ahead = np.empty((2, 3)), np.empty((2, 3, 3)), np.array([-1.0, 0.0, 0.0])
        return cls(np.empty(12), np.empty((vertices, 3)), np.empty((faces, 3)), manifold, place, crushed, *ahead)
