# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshed blocks in a stress map: their surfaces as facets of the mesh, each with the stress of the element behind it.

In space the facets are those of the surface; in a plane the triangles of the mesh are drawn on both ends of the block, and its sides follow
their outer edges. Points are where the nodes are, with displacements amplified. The plane of a cut has the mean of the block.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.deformed import Pose, Solids, moved_nodes
from masonry_cd.io.meshes import Meshes
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.block_mesh import SIMPLEX
from masonry_cd.mechanics.model.geometry import Polyhedron

WHOLE = -1  # element of a face of a block that has no mesh


@dataclass(frozen=True, eq=False)
class Facetted:
    """The blocks of a structure, meshed ones by the facets of their meshes: V vertices, F faces."""

    solids: Solids
    node: np.ndarray  # (V,) node of each vertex; -1: a vertex of a block as built
    offset: np.ndarray  # (V, 3) from the node, as built: half of the thickness of a block in a plane [m]
    element: np.ndarray  # (F,) behind each face; WHOLE: the block has none

    @classmethod
    def of(cls, solids: Solids, meshes: Meshes) -> Facetted:
        """Those of blocks, of which some are meshed."""
        shells, nodes, offsets, elements = [], [], [], []
        place = {int(b): m for m, b in enumerate(meshes.block)}
        for b in range(len(solids.centre)):
            vertices = np.flatnonzero(solids.vertex_block == b)
            if b in place:
                shell, node, element = _facets(meshes, place[b], solids.vertices[vertices])
                offset = shell.vertices - meshes.nodes[node]
            else:
                shell = Polyhedron(solids.vertices[vertices], _faces(solids, b, vertices))
                node, element = np.full(len(vertices), -1), np.full(len(shell.faces), WHOLE)
                offset = np.zeros((len(vertices), 3))
            shells.append(shell)
            nodes.append(node)
            offsets.append(offset)
            elements.append(element)
        flat = Solids.of(shells, solids.centre, solids.fixed)
        return cls(flat, np.concatenate(nodes), np.concatenate(offsets), np.concatenate(elements))

    def moved(self, results: Results, pose: Pose, frame: int, factor: float) -> np.ndarray:
        """(V, 3) vertices at a frame, with displacements amplified [m]."""
        out = pose.moved(self.solids, self.solids.vertices, self.solids.vertex_block, factor)
        own = self.node >= 0
        turn = np.eye(3) + factor * (pose.rotation[self.solids.vertex_block[own]] - np.eye(3))
        out[own] = moved_nodes(results, pose, frame, factor)[self.node[own]] + np.einsum("nij,nj->ni", turn, self.offset[own])
        return out


def _faces(solids: Solids, block: int, vertices: np.ndarray) -> tuple[tuple[int, ...], ...]:
    """The faces of a block, by its own vertices."""
    first = int(vertices[0])
    faces = np.flatnonzero(solids.face_block == block)
    return tuple(tuple((solids.loops[solids.loop_start[f] : solids.loop_start[f + 1]] - first).tolist()) for f in faces)


def _facets(meshes: Meshes, m: int, vertices: np.ndarray) -> tuple[Polyhedron, np.ndarray, np.ndarray]:
    """The surface of mesh m of a block with vertices (., 3); the node of each vertex, and the element behind each face."""
    first, last = meshes.element_start[m : m + 2]
    elements = meshes.elements[first:last]
    sides = [(int(e), tuple(elements[e, list(side)].tolist())) for e in range(last - first) for side in SIMPLEX[elements.shape[1] - 1]]
    count: dict[tuple[int, ...], int] = {}
    for _, side in sides:
        key = tuple(sorted(side))
        count[key] = count.get(key, 0) + 1
    outer = [(first + e, side) for e, side in sides if count[tuple(sorted(side))] == 1]
    if elements.shape[1] == 4:
        node = np.unique([k for _, side in outer for k in side])
        at = {int(k): i for i, k in enumerate(node)}
        faces = tuple(tuple(at[k] for k in side) for _, side in outer)
        return Polyhedron(meshes.nodes[node], faces), node, np.array([e for e, _ in outer])
    return _prism(meshes, (first, elements), outer, vertices)


def _prism(
    meshes: Meshes, own: tuple[int, np.ndarray], outer: list[tuple[int, tuple[int, ...]]], vertices: np.ndarray
) -> tuple[Polyhedron, np.ndarray, np.ndarray]:
    """A block in a plane: its triangles, from number ``own[0]`` on, on both ends, and a side for each outer edge."""
    first, triangles = own
    node = np.unique(triangles)
    flat = meshes.nodes[node]
    axis = int(np.argmin(np.ptp(flat, axis=0)))
    low, high = flat.copy(), flat.copy()
    low[:, axis], high[:, axis] = vertices[:, axis].min(), vertices[:, axis].max()
    at = {int(k): i for i, k in enumerate(node)}
    count = len(node)
    spans = meshes.nodes[triangles[:, 1:]] - meshes.nodes[triangles[:, :1]]
    upwards = np.cross(spans[:, 0], spans[:, 1])[:, axis] > 0.0  # seen from the high end counter-clockwise
    faces: list[tuple[int, ...]] = []
    behind: list[int] = []
    for k, corners in enumerate(triangles.tolist()):
        a, b, c = (at[n] for n in (corners if upwards[k] else corners[::-1]))
        faces += [(count + a, count + b, count + c), (c, b, a)]
        behind += [first + k, first + k]
    for e, (one, two) in outer:
        a, b = (at[one], at[two]) if upwards[e - first] else (at[two], at[one])
        faces.append((a, b, count + b, count + a))
        behind.append(e)
    return Polyhedron(np.concatenate([low, high]), tuple(faces)), np.concatenate([node, node]), np.array(behind)
