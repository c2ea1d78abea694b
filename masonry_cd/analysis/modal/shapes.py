# SPDX-License-Identifier: GPL-3.0-or-later
"""Mode shapes as reports use them: at any point, and on a skin that pictures can draw."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.place_on_block import outside_block


@dataclass(frozen=True, eq=False)
class Skin:
    """The surface of the structure: S points that move, F polygons, and the edges to draw."""

    points: np.ndarray  # (S, 3) [m]
    shapes: np.ndarray  # (n, S, 3) displacements in each mode
    loops: np.ndarray  # (L,) corners of all polygons
    loop_start: np.ndarray  # (F + 1,)
    edges: np.ndarray  # (E, 2)


class ModeShapes(Protocol):
    """n mode shapes of one model."""

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacements (n, P, 3) at points (P, 3), and how far outside the structure the points lie (P,) [m]."""

    def skin(self) -> Skin:
        """The surface that pictures draw."""

    def scaled(self, factors: np.ndarray) -> ModeShapes:
        """Each mode multiplied by a factor, (n,)."""


@dataclass(frozen=True, eq=False)
class RigidShapes:
    """Blocks that move as rigid bodies: u(x) = d + theta x (x - c)."""

    blocks: Sequence[Block]  # the free ones, B
    centres: np.ndarray  # (B, 3) [m]
    translation: np.ndarray  # (n, B, 3)
    rotation: np.ndarray  # (n, B, 3) [1/m times the unit of the translation]

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Each point moves with the block that it lies in, or else with the nearest one."""
        nearest, outside = np.zeros(len(points), dtype=np.int64), np.full(len(points), np.inf)
        for b, block in enumerate(self.blocks):
            distance = outside_block(block, points)
            closer = distance < outside
            nearest[closer], outside[closer] = b, distance[closer]
        return self._moved(points, nearest), np.maximum(outside, 0.0)

    def skin(self) -> Skin:
        """The faces of all free blocks."""
        count = np.array([len(block.vertices) for block in self.blocks])
        first = np.concatenate([[0], np.cumsum(count)[:-1]])
        faces = [[first[b] + i for i in face] for b, block in enumerate(self.blocks) for face in block.faces]
        points = np.concatenate([block.vertices for block in self.blocks])
        edges = {(min(a, b), max(a, b)) for face in faces for a, b in zip(face, face[1:] + face[:1], strict=True)}
        return Skin(
            points=points,
            shapes=self._moved(points, np.repeat(np.arange(len(count)), count)),
            loops=np.array([i for face in faces for i in face]),
            loop_start=np.concatenate([[0], np.cumsum([len(face) for face in faces])]),
            edges=np.array(sorted(edges)),
        )

    def scaled(self, factors: np.ndarray) -> RigidShapes:
        """Each mode multiplied by a factor, (n,)."""
        factor = factors[:, None, None]
        return replace(self, translation=factor * self.translation, rotation=factor * self.rotation)

    def _moved(self, points: np.ndarray, owner: np.ndarray) -> np.ndarray:
        arm = points - self.centres[owner]
        return np.asarray(self.translation[:, owner] + np.cross(self.rotation[:, owner], arm[None]))


@dataclass(frozen=True, eq=False)
class QuadraticShapes:
    """Shapes given at corners and mid-edges of tetrahedra, interpolated as the finite elements do."""

    points: np.ndarray  # (N, 3) of the nodes [m]
    cells: np.ndarray  # (T, 10) or (T, 4) nodes: corners, then the middles of the edges 01 12 02 03 13 23
    values: np.ndarray  # (n, N, 3)

    def at(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Interpolated in the tetrahedron that a point lies in, or at the nearest place of the nearest one."""
        from scipy.spatial import cKDTree

        corner = self.points[self.cells[:, :4]]
        near = cKDTree(corner.mean(axis=1)).query(points, k=min(32, len(self.cells)))[1].reshape(len(points), -1)
        edges = np.moveaxis(corner[near, 1:] - corner[near, :1], -1, -2)  # (P, k, 3, 3) columns along the edges
        local = np.linalg.solve(edges, (points[:, None] - corner[near, 0])[..., None])[..., 0]
        weights = np.concatenate([1.0 - local.sum(axis=-1, keepdims=True), local], axis=-1)
        inside = np.clip(weights, 0.0, None)
        inside /= inside.sum(axis=-1, keepdims=True)
        away = np.linalg.norm(np.einsum("pkc,pkci->pki", inside, corner[near]) - points[:, None], axis=-1)
        best = np.argmin(away, axis=1)
        rows = np.arange(len(points))
        cell, weight = near[rows, best], inside[rows, best]
        functions = _quadratic(weight) if self.cells.shape[1] == 10 else weight
        return np.einsum("pc,npci->npi", functions, self.values[:, self.cells[cell]]), away[rows, best]

    def skin(self) -> Skin:
        """The boundary triangles, each in four where there are mid-edge nodes, and the edges where they meet at an angle."""
        triangles, middles = self._boundary()
        edges = self._creases(triangles, middles)
        if middles is not None:
            a, b, c = triangles.T
            ab, bc, ca = middles.T
            triangles = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
        used, flat = np.unique(np.concatenate([triangles.ravel(), edges.ravel()]), return_inverse=True)
        return Skin(
            points=self.points[used],
            shapes=self.values[:, used],
            loops=flat[: triangles.size],
            loop_start=np.arange(0, triangles.size + 1, 3),
            edges=flat[triangles.size :].reshape(-1, 2),
        )

    def scaled(self, factors: np.ndarray) -> QuadraticShapes:
        """Each mode multiplied by a factor, (n,)."""
        return replace(self, values=factors[:, None, None] * self.values)

    def _boundary(self) -> tuple[np.ndarray, np.ndarray | None]:
        """Triangles (F, 3) of one tetrahedron only, turned outwards, and the nodes in the middle of their sides 01, 12, 20."""
        sides = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
        between = {(0, 1): 4, (1, 2): 5, (0, 2): 6, (0, 3): 7, (1, 3): 8, (2, 3): 9}
        all_sides = self.cells[:, sides].reshape(-1, 3)
        _, first, times = np.unique(np.sort(all_sides, axis=1), axis=0, return_index=True, return_counts=True)
        once = np.sort(first[times == 1])
        cell, side = once // 4, once % 4
        corner = self.points[self.cells[cell, :4]]
        negative = np.linalg.det(corner[:, 1:] - corner[:, :1]) < 0
        middle = None
        if self.cells.shape[1] == 10:
            local = np.array([[between[min(s[k], s[k - 2]), max(s[k], s[k - 2])] for k in range(3)] for s in sides.tolist()])
            middle = self.cells[cell[:, None], local[side]]
            middle[negative] = middle[negative][:, ::-1]
        triangles = all_sides[once]
        triangles[negative] = triangles[negative][:, [0, 2, 1]]
        return triangles, middle  # turning a triangle round swaps its sides 01 and 20

    def _creases(self, triangles: np.ndarray, middles: np.ndarray | None) -> np.ndarray:
        """Sides whose two triangles differ in direction, halved at their middle nodes."""
        a, b, c = (self.points[triangles[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        owner = np.tile(np.arange(len(triangles)), 3)
        order = np.lexsort(np.sort(sides, axis=1).T)
        first, second = order[::2], order[1::2]  # each side of a closed surface occurs twice
        sharp = np.einsum("ei,ei->e", normal[owner[first]], normal[owner[second]]) < np.cos(np.radians(5.0))
        kept = first[sharp]
        if middles is None:
            return sides[kept]
        middle = middles.T.ravel()[kept]
        return np.concatenate([np.stack([sides[kept, 0], middle], axis=1), np.stack([middle, sides[kept, 1]], axis=1)])


def _quadratic(weight: np.ndarray) -> np.ndarray:
    """The ten shape functions (P, 10) at barycentric coordinates (P, 4)."""
    a, b, c, d = weight.T
    corners = weight * (2.0 * weight - 1.0)
    middles = 4.0 * np.stack([a * b, b * c, a * c, a * d, b * d, c * d], axis=1)
    return np.concatenate([corners, middles], axis=1)
