# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshed blocks in a stress map: their surfaces as facets of the mesh, each with the stress of the element behind it.

In space the facets are those of the surface; in a plane the triangles of the mesh are drawn on both ends of the block, and its sides follow
their outer edges. Points are where the nodes are, with displacements amplified. The plane of a cut has the mean of the block.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.deformed import Pose, Solids, moved_nodes
from masonry_cd.foundation.extras import require
from masonry_cd.io.block_arrays import Meshes
from masonry_cd.io.results import Results
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
            own = np.flatnonzero(solids.vertex_block == b)
            vertices, node, offset = solids.vertices[own], np.full(len(own), -1), np.zeros((len(own), 3))
            if b in place:
                vertices, faces, node, element = _facets(meshes, place[b], vertices)
                offset = vertices - meshes.nodes[node]
            else:
                loops = np.split(solids.loops, solids.loop_start[1:-1])
                faces = [loops[face] - own[0] for face in np.flatnonzero(solids.face_block == b)]
                element = np.full(len(faces), WHOLE)
            shells.append(Polyhedron(vertices, tuple(tuple(face.tolist()) for face in faces)))
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


def _facets(meshes: Meshes, m: int, vertices: np.ndarray) -> tuple[np.ndarray, list[np.ndarray], np.ndarray, np.ndarray]:
    """The surface of mesh m of a block with vertices (., 3), as VTK has it.

    Returns:
        vertices (V, 3) and faces, the node of each vertex, and the element behind each face.
    """
    require("this", "pyvista")
    import pyvista
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

    first, last = meshes.element_start[m : m + 2]
    node, index = np.unique(meshes.elements[first:last], return_inverse=True)
    points, cells, kind = meshes.nodes[node], index.reshape(last - first, -1), pyvista.CellType.TETRA
    if cells.shape[1] == 3:  # in a plane: wedges from one end of the block to the other
        axis = int(np.argmin(np.ptp(points, axis=0)))
        points, cells, kind = np.tile(points, (2, 1)), np.hstack([cells, cells + len(node)]), pyvista.CellType.WEDGE
        points[:, axis] = np.repeat([vertices[:, axis].min(), vertices[:, axis].max()], len(node))
        node = np.tile(node, 2)
    surface = vtkDataSetSurfaceFilter()
    surface.SetInputData(pyvista.UnstructuredGrid({kind: cells}, points))
    surface.PassThroughPointIdsOn()
    surface.PassThroughCellIdsOn()
    surface.Update()
    skin = pyvista.PolyData(surface.GetOutput()).compute_normals(split_vertices=False, auto_orient_normals=True)
    of_point, of_cell = skin.point_data["vtkOriginalPointIds"], skin.cell_data["vtkOriginalCellIds"]
    return points[of_point], list(skin.irregular_faces), node[of_point], first + of_cell
