# SPDX-License-Identifier: GPL-3.0-or-later
r"""Meshes of blocks: uniform-strain tetrahedra in space, triangles of the block's outline where a scene moves in a plane.

gmsh meshes the faces of a block and what they enclose, no coarser than requested. Blocks of one shape share one mesh, whatever their place;
the mesh of a shape is the same in every run. In a plane the block is a prism across it, so that its mesh is that of an end face, in the
middle plane, and an element is as thick as the block.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.gmsh_session import gmsh_session
from masonry_cd.mechanics.model.geometry import Faces, Polyhedron, area_vectors

MOST_UNKNOWNS = 768  # of a block, which are solved for together: kernels are compiled for their number
HOPELESS = 20  # times MOST_UNKNOWNS: a given number of nodes are not meshed to be counted
DIGITS = 12  # of a coordinate over the size of the block: shapes that agree in these share a mesh
FILLED = 1e-6  # by what share of its volume a mesh may miss its block
ALONG = 1e-6  # normals this close to the normal of the plane are along it
SIMPLEX = {2: ((0, 1), (1, 2), (2, 0)), 3: ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))}  # its sides, seen from outside


@dataclass(frozen=True, eq=False)
class BlockMesh:
    """A mesh of simplices in d = 2 or 3 dimensions; nodes as seen from the centre of mass of the block, body frame."""

    axis: int  # normal to the plane; -1: in space
    nodes: np.ndarray  # (N, 3) [m]; in the middle plane of a plane scene
    elements: np.ndarray  # (E, d + 1) of positive volume
    facets: np.ndarray  # (T, d) those of the surface, counter-clockwise from outside

    @property
    def dims(self) -> np.ndarray:
        """(d,) the coordinates that nodes move along."""
        return np.array([d for d in range(3) if d != self.axis])

    @property
    def warps(self) -> int:
        """How many the block has, see ``warping.py``: motions of its nodes beyond those of a block of uniform strain."""
        d = len(self.dims)
        return d * (len(self.nodes) - d - 1)

    def shares(self) -> np.ndarray:
        """Volume of each element over that of the block, (E,)."""
        size = _sizes(self.nodes[:, self.dims], self.elements)
        return np.asarray(size / size.sum())


def block_mesh(name: str, shell: Polyhedron, size: float, axis: int) -> BlockMesh:
    """The mesh of a block; blocks of one shape get the same object.

    Args:
        name: of the block, for messages.
        shell: seen from its centre of mass.
        size: of the elements [m], as gmsh takes it.
        axis: normal to the plane of the scene; -1: in space.

    Raises:
        InputError: gmsh does not start, cannot mesh the block, or makes far too many nodes.
    """
    most = MOST_UNKNOWNS // (3 if axis < 0 else 2)
    likely = likely_nodes(shell, size, axis)
    if not likely <= HOPELESS * most:
        raise InputError(
            "material.mesh_size",
            f'block "{name}" would get about {likely:.2g} nodes with {size:g} m, and {most} are the most; give a larger size',
        )
    reach = float(f"{np.abs(shell.vertices).max():.{DIGITS}g}")
    unit = np.round(shell.vertices / reach, DIGITS) + 0.0  # no minus zero
    try:
        mesh = _mesh_of(unit.tobytes(), tuple(map(tuple, shell.faces)), size, axis, reach)
    except InputError:
        raise
    except Exception as failure:  # gmsh raises plain ones
        reason = str(failure).splitlines()[0] if str(failure) else type(failure).__name__
        raise InputError("material.deformable", f'block "{name}" cannot be meshed ({reason})') from None
    if len(mesh.nodes) > most:
        raise InputError(
            "material.mesh_size",
            f'block "{name}" gets {len(mesh.nodes)} nodes with {size:g} m, and {most} are the most; give a larger size',
        )
    content = _content(shell.vertices, shell.faces, axis)
    if abs(float(_sizes(mesh.nodes[:, mesh.dims], mesh.elements).sum()) - content) > FILLED * content:
        raise InputError("material.deformable", f'block "{name}" cannot be meshed: its faces are not plane')
    return mesh


@lru_cache(maxsize=4096)
def _mesh_of(vertices: bytes, faces: Faces, size: float, axis: int, reach: float) -> BlockMesh:
    """The mesh of a shape: coordinates (V, 3) over its ``reach`` [m], as bytes."""
    points = np.frombuffer(vertices).reshape(-1, 3)
    if axis < 0:
        nodes, elements = _simplices(points, faces, size / reach, 3)
    else:
        flat, ends = points.copy(), _end_faces(points, faces, axis)
        flat[:, axis] = 0.0
        nodes, elements = _simplices(flat, ends, size / reach, 2)
    dims = [d for d in range(3) if d != axis]
    turned = _sizes(nodes[:, dims], elements) < 0.0
    elements[turned] = elements[turned][:, [1, 0, *range(2, elements.shape[1])]]
    return BlockMesh(axis, reach * nodes, elements, _surface(elements))


def _end_faces(points: np.ndarray, faces: Faces, axis: int) -> Faces:
    """The faces at the upper end of a prism along an axis."""
    loops = np.array([i for face in faces for i in face])
    areas = area_vectors(points, loops, np.cumsum([0, *(len(face) for face in faces)]))
    along = areas[:, axis] > (1.0 - ALONG) * np.sqrt((areas**2).sum(axis=1))
    return tuple(face for face, ends in zip(faces, along, strict=True) if ends)


def _simplices(points: np.ndarray, faces: Faces, size: float, dimension: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (N, 3) and simplices (E, dimension + 1) of gmsh in what faces enclose, or in the faces themselves."""
    with gmsh_session() as gmsh:
        for option, value in (("Algorithm", 6), ("Algorithm3D", 1), ("MeshSizeMin", size), ("MeshSizeMax", size), ("MeshSizeFromPoints", 0),
                              ("MeshSizeExtendFromBoundary", 0), ("RandomSeed", 1), ("Optimize", 1)):  # fmt: skip
            gmsh.option.setNumber(f"Mesh.{option}", value)
        gmsh.option.setNumber("General.NumThreads", 1)
        _draw(gmsh, points, faces, dimension)
        gmsh.model.mesh.generate(dimension)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        kinds, _, corners = gmsh.model.mesh.getElements(dimension)
    if len(kinds) != 1:
        raise ValueError("gmsh makes no elements in it")
    used, elements = np.unique(corners[0], return_inverse=True)
    place = np.full(int(tags.max()) + 1, -1)
    place[tags] = np.arange(len(tags))
    return coordinates.reshape(-1, 3)[place[used]], elements.reshape(-1, dimension + 1).astype(np.int64)


def _draw(gmsh: Any, points: np.ndarray, faces: Faces, dimension: int) -> None:
    """Put the faces, and in space what they enclose, into gmsh's model."""
    geo, lines = gmsh.model.geo, {}
    corners = {i: geo.addPoint(*points[i]) for i in sorted({i for face in faces for i in face})}
    surfaces = []
    for face in faces:
        loop = []
        for i, j in zip(face, (*face[1:], face[0]), strict=True):
            if (j, i) not in lines:
                lines[i, j] = geo.addLine(corners[i], corners[j])
            loop.append(lines[i, j] if (i, j) in lines else -lines[j, i])
        surfaces.append(geo.addPlaneSurface([geo.addCurveLoop(loop)]))
    if dimension == 3:
        geo.addVolume([geo.addSurfaceLoop(surfaces)])
    geo.synchronize()


def _surface(elements: np.ndarray) -> np.ndarray:
    """The sides (T, d) of simplices (E, d + 1) that belong to one of them alone."""
    sides = np.concatenate([elements[:, side] for side in SIMPLEX[elements.shape[1] - 1]])
    _, first, count = np.unique(np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True)
    return sides[np.sort(first[count == 1])]


def _sizes(nodes: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Signed volumes or areas (E,) of simplices on nodes (N, d)."""
    spans = nodes[elements[:, 1:]] - nodes[elements[:, :1]]
    if spans.shape[1] == 2:
        return 0.5 * (spans[:, 0, 0] * spans[:, 1, 1] - spans[:, 0, 1] * spans[:, 1, 0])
    return np.asarray(np.sum(spans[:, 0] * np.cross(spans[:, 1], spans[:, 2]), axis=1) / 6.0)


def likely_nodes(shell: Polyhedron, size: float, axis: int) -> float:
    """About how many nodes a mesh of regular simplices has, half as many as triangles and a sixth of tetrahedra; never far too few."""
    content = _content(shell.vertices, shell.faces, axis) / size / size
    return 1.2 * content if axis >= 0 else 1.4 * content / size


def _content(points: np.ndarray, faces: Sequence[Sequence[int]], axis: int) -> float:
    """Volume of a shell, or the area of its end faces."""
    loops, start = np.array([i for face in faces for i in face]), np.cumsum([0, *(len(face) for face in faces)])
    areas = area_vectors(points, loops, start)
    if axis >= 0:
        return float(0.5 * np.abs(areas[np.abs(areas[:, axis]) > (1.0 - ALONG) * np.sqrt((areas**2).sum(axis=1)), axis]).sum())
    return float(np.sum(areas * points[loops[start[:-1]]]) / 3.0)
