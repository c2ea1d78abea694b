# SPDX-License-Identifier: GPL-3.0-or-later
"""Polyhedra: one flat form for many of them, their mass properties, and the pose of one body as seen from another.

Volume, centre of mass and inertia are exact: the solid is the signed sum of the tetrahedra spanned by an inner point and the triangles of
the faces, and the second moments of a tetrahedron (0, a, b, c) are polynomials of its corners (Tonon, J. Math. Stat. 1(1), 2005).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.model.polygon import next_in_loop

Faces = tuple[tuple[int, ...], ...]
Shell = tuple[np.ndarray, Faces]
"""Corners (V, 3) and faces of a closed surface, counter-clockwise seen from outside."""


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A closed polyhedron: vertices (V, 3) [m] and faces as loops of vertex indices, counter-clockwise from outside."""

    vertices: np.ndarray
    faces: Faces


class Polyhedra(NamedTuple):
    """P polyhedra in flat arrays, as kernels read them: V vertices, F faces, L loop entries, E edges.

    ``*_start`` delimit the entries of a polyhedron, or those of a face; vertices and faces are counted over all polyhedra.
    """

    vertex_start: np.ndarray  # (P + 1,)
    vertices: np.ndarray  # (V, 3) [m]
    face_start: np.ndarray  # (P + 1,)
    normals: np.ndarray  # (F, 3) outward unit normals; zeros where a face has no area
    loop_start: np.ndarray  # (F + 1,)
    loops: np.ndarray  # (L,) vertices of each face, counter-clockwise from outside
    edge_start: np.ndarray  # (P + 1,)
    edges: np.ndarray  # (E, 4): its two vertices and its two faces, left face first; E = 0 before with_edges

    @classmethod
    def of(cls, shells: Sequence[Polyhedron]) -> Polyhedra:
        """Flatten polyhedra, which may be open or self-intersecting; without their edges, which are known of closed ones only."""
        vertex_start = np.cumsum([0, *(len(shell.vertices) for shell in shells)])
        loop_start = np.cumsum([0, *(len(face) for shell in shells for face in shell.faces)])
        face_start = np.cumsum([0, *(len(shell.faces) for shell in shells)])
        local = np.array([i for shell in shells for face in shell.faces for i in face], dtype=np.int64)
        loops = local + np.repeat(vertex_start[:-1], np.diff(loop_start[face_start]))
        vertices = np.concatenate([shell.vertices for shell in shells]).astype(float)
        areas = area_vectors(vertices, loops, loop_start)
        length = np.linalg.norm(areas, axis=1, keepdims=True)
        normals = np.divide(areas, length, out=np.zeros_like(areas), where=length > 0)
        none = np.zeros((0, 4), dtype=np.int64)
        return cls(vertex_start, vertices, face_start, normals, loop_start, loops, np.zeros_like(vertex_start), none)

    def with_edges(self) -> Polyhedra:
        """Closed polyhedra with their edges, each once."""
        after = self.loops[next_in_loop(self.loop_start)]
        face, total = self.face_of_entry(), len(self.vertices)
        key = self.loops * total + after  # of the directed edge; that of the face on its other side runs the other way
        order, once = np.argsort(key), self.loops < after
        reverse = after[once] * total + self.loops[once]
        right = face[order[np.searchsorted(key[order], reverse)]]
        edges = np.stack([self.loops[once], after[once], face[once], right], axis=1)
        counted = np.concatenate([[0], np.cumsum(once)])
        return self._replace(edge_start=counted[self.loop_start[self.face_start]], edges=edges)

    def face_of_entry(self) -> np.ndarray:
        """Face (L,) of each loop entry."""
        return np.repeat(np.arange(len(self.normals)), np.diff(self.loop_start))

    def owner_of_face(self) -> np.ndarray:
        """Polyhedron (F,) of each face."""
        return np.repeat(np.arange(len(self.face_start) - 1), np.diff(self.face_start))


def area_vectors(vertices: np.ndarray, loops: np.ndarray, loop_start: np.ndarray) -> np.ndarray:
    """Area times normal of each face, (F, 3) [m2], by Newell's sum about its first vertex.

    Args:
        vertices: (V, 3) [m].
        loops: (L,) vertices of the faces, one face after another.
        loop_start: (F + 1,)
    """
    spoke = vertices[loops] - np.repeat(vertices[loops[loop_start[:-1]]], np.diff(loop_start), axis=0)
    return 0.5 * np.add.reduceat(np.cross(spoke, spoke[next_in_loop(loop_start)]), loop_start[:-1])


# --- mass properties -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class MassProperties:
    """Volume [m3], centre of mass (3,) [m], and second moments about it: inertia per density (3, 3) [m5]."""

    volume: float
    centre: np.ndarray
    unit_inertia: np.ndarray


def triangles(faces: Faces) -> np.ndarray:
    """Fan-triangulate convex face loops into an (n, 3) array of vertex indices."""
    fans = [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]
    return np.array(fans, dtype=np.int64).reshape(-1, 3)


def sixfold_volumes(corners: np.ndarray) -> np.ndarray:
    """Six times the signed volumes (n,) of tetrahedra of the origin and three corners each (n, 3 corners, 3), without LAPACK [m3]."""
    return np.asarray(np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2]), axis=1))


def mass_properties(vertices: np.ndarray, faces: Faces) -> MassProperties:
    """Integrate a closed polyhedron exactly.

    Args:
        vertices: (V, 3) [m].
        faces: convex loops, counter-clockwise from outside. A reversed shell gives a negative volume.
    """
    inner = vertices.mean(axis=0)  # integrate near the block: far from the origin the moments would cancel
    corners = (vertices - inner)[triangles(faces)]  # (n, 3 corners, 3)
    sixfold = sixfold_volumes(corners)
    volume = sixfold.sum() / 6.0
    total = corners.sum(axis=1)
    first = np.einsum("n,ni->i", sixfold, total) / 24.0
    second = (np.einsum("n,nki,nkj->ij", sixfold, corners, corners) + np.einsum("n,ni,nj->ij", sixfold, total, total)) / 120.0
    centre = first / volume
    second -= volume * np.outer(centre, centre)
    inertia = np.trace(second) * np.eye(3) - second
    return MassProperties(float(volume), inner + centre, inertia)


# --- relative pose -------------------------------------------------------------------------------------------------------------


@borrower()
def relative_pose(position, rotation, affine, a, b, pose):
    """Fill ``pose`` (12,) with that of body b in the frame of body a: R_a^-1 (x_b - x_a) [m], then R_a^-1 R_b row by row.

    ``position`` (B, 3) [m] and ``rotation`` (B, 3, 3), body to world; ``affine``: two zeros where it holds strains, else one. Whole arrays
    are indexed: a view of a row costs more.
    """
    dx, dy, dz = position[b, 0] - position[a, 0], position[b, 1] - position[a, 1], position[b, 2] - position[a, 2]
    for i in range(3):
        x, y, z = inverse_row(rotation, a, i) if len(affine) == 2 else (rotation[a, 0, i], rotation[a, 1, i], rotation[a, 2, i])
        pose[i] = x * dx + y * dy + z * dz
        for j in range(3):
            pose[3 + 3 * i + j] = x * rotation[b, 0, j] + y * rotation[b, 1, j] + z * rotation[b, 2, j]


@borrower()
def inverse_row(maps, b, i):
    """Row i of the inverse of maps[b], (B, 3, 3), as three numbers."""
    x, y, z = cofactor_column(maps, b, i)
    scale = 1.0 / (maps[b, 0, i] * x + maps[b, 1, i] * y + maps[b, 2, i] * z)
    return scale * x, scale * y, scale * z


@borrower()
def cofactor_column(maps, b, i):
    """Column i of the cofactors of maps[b], (B, 3, 3), as three numbers: the two other columns' cross product."""
    j, k = (i + 1) % 3, (i + 2) % 3
    return (
        maps[b, 1, j] * maps[b, 2, k] - maps[b, 2, j] * maps[b, 1, k],
        maps[b, 2, j] * maps[b, 0, k] - maps[b, 0, j] * maps[b, 2, k],
        maps[b, 0, j] * maps[b, 1, k] - maps[b, 1, j] * maps[b, 0, k],
    )


@borrower()
def turned_normal(maps, b, n):
    """The normal n (3,) of a plane of the body frame after maps[b], (B, 3, 3), as three numbers, and by what distances from it grow."""
    nx, ny, nz = 0.0, 0.0, 0.0
    for i in range(3):
        x, y, z = inverse_row(maps, b, i)
        nx, ny, nz = nx + x * n[i], ny + y * n[i], nz + z * n[i]
    scale = 1.0 / np.sqrt(nx * nx + ny * ny + nz * nz)
    return scale * nx, scale * ny, scale * nz, scale


@borrower()
def relative_angle(pose):
    """Angle of the rotation in a relative pose (12,) [rad], exact near zero."""
    x, y, z = pose[10] - pose[8], pose[5] - pose[9], pose[6] - pose[4]
    return math.atan2(0.5 * np.sqrt(x * x + y * y + z * z), 0.5 * (pose[3] + pose[7] + pose[11] - 1.0))
