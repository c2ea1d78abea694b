# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh formats that a library reads: STL by trimesh, VTU and MSH by meshio, VTP, VTM and VTKHDF by VTK. Each runs in a child, see
:mod:`structures.files.foreign`.

Every reader returns the shells of a file with the number and the name of the block that each belongs to; shells of one number are the
convex parts of one block. This module imports nothing but numpy and, in each reader, its library, so that the child starts at once.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.extras import require
from structures.files.foreign import Faces, FileContents, FileShell, Refused
from structures.files.shells import shells

HEAD, TRIANGLE = 84, 50  # bytes of binary STL
LOOKED_AT = 1024  # bytes of a text in which its first vertex is
VERTEX = re.compile(rb"(?:^|[\r\n])\s*vertex\s")
CELLS: dict[str, tuple[tuple[int, ...], ...]] = {  # faces of the volume cells of VTK, from outside
    "tetra": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)),
    "pyramid": ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
    "hexahedron": ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}
SURFACES = {"triangle": 3, "quad": 4}  # cells of surfaces, and their corners


def read_stl(path: Path) -> FileContents:
    """The closed shells of an STL, solids of a text apart.

    Raises:
        Refused: no triangles.
    """
    require("this format", "trimesh")
    import trimesh

    announced = _triangles_of(path)
    try:
        soup: Any = trimesh.load(path, file_type="stl", process=False)
    except ValueError:
        raise Refused(path.name, "not the facets and vertices of an STL; numbers have a decimal point") from None
    solids = list(soup.geometry.values()) if isinstance(soup, trimesh.Scene) else [soup]  # a text may hold several
    read = sum(len(solid.faces) for solid in solids if isinstance(solid, trimesh.Trimesh))
    if announced != read:
        raise Refused(path.name, f"{read} triangles could be read of {announced:.10g}: cut short or damaged")
    found: list[FileShell] = []
    for solid in solids:
        if not isinstance(solid, trimesh.Trimesh) or not len(solid.faces):
            raise Refused(path.name, "no triangles in it")
        for points, loops in shells(np.asarray(solid.vertices, dtype=float), np.asarray(solid.faces).tolist()):
            found.append(FileShell(len(found), f"b{len(found)}", points, loops))
    return FileContents(found)


def _triangles_of(path: Path) -> float:
    """The number of triangles that an STL announces: by the count of a binary one, by the vertices of a text, each a third.

    Raises:
        Refused: a binary file of another length than its count needs.
    """
    data = path.read_bytes()
    text = data.replace(b"\0", b"").lstrip(b"\xef\xbb\xff\xfe\xbf \r\n\t").lower()  # without the marks and second bytes of other encodings
    count = int.from_bytes(data[80:HEAD], "little")
    if len(data) != HEAD + TRIANGLE * count and text.startswith(b"solid") and VERTEX.search(text[:LOOKED_AT]):
        return len(VERTEX.findall(text)) / 3.0
    if len(data) != HEAD + TRIANGLE * count:
        raise Refused(
            path.name, f"announces {count} triangles and has bytes for {max(0, (len(data) - HEAD) // TRIANGLE)}: cut short or damaged"
        )
    return count


def read_vtu(path: Path) -> FileContents:
    """The volume cells of a VTU, by their array ``block`` where it has one.

    Raises:
        Refused: cells that are no volumes, or that name points that there are not.
    """
    require("this format", "meshio")
    import meshio

    mesh = meshio.read(path)
    points = np.asarray(mesh.points, dtype=float)
    found: list[FileShell] = []
    for k, cells in enumerate(mesh.cells):
        count = len(found)
        numbers = mesh.cell_data["block"][k] if "block" in mesh.cell_data else range(count, count + len(cells.data))
        for number, cell in zip(numbers, cells.data, strict=True):
            if cells.type in CELLS:
                loops: Sequence[Sequence[int]] = [[int(cell[i]) for i in face] for face in CELLS[cells.type]]
            elif cells.type.startswith("polyhedron"):
                loops = [[int(i) for i in face] for face in cell]
            else:
                raise Refused(path.name, f"cells of type {cells.type} are no volumes; a block is a volume cell")
            used = sorted({i for face in loops for i in face})
            if used[0] < 0 or used[-1] >= len(points):
                raise Refused(path.name, f'block "b{int(number)}": a cell names a point outside 0 to {len(points) - 1}')
            number_of = {old: new for new, old in enumerate(used)}
            faces: Faces = tuple(tuple(number_of[i] for i in face) for face in loops)
            found.append(FileShell(int(number), f"b{int(number)}", points[used], faces, *_marks(mesh.cell_data, k, len(found) - count)))
    return FileContents(sorted(found, key=lambda piece: piece.number))  # the file has cells of one number of corners together


def _marks(data: Any, kind: int, place: int) -> tuple[str, bool]:
    """Group and support of a cell by the arrays ``group`` and ``fixed``, where they are whole numbers."""
    words = []
    for name in ("group", "fixed"):
        values = np.asarray(data[name][kind]) if name in data else np.zeros(0)
        words.append(int(values[place]) if values.ndim == 1 and values.dtype.kind in "iub" and place < len(values) else None)
    group, fixed = words
    return "" if group is None else f"group{group}", bool(fixed)


def read_msh(path: Path) -> FileContents:
    """The volumes of a mesh of gmsh, each by the faces that one of its cells has alone; its physical group is its group.

    Raises:
        Refused: no volume cells, or cells that name points that there are not.
    """
    require("this format", "meshio")
    import meshio

    with warnings.catch_warnings(action="ignore", category=UserWarning):
        mesh = meshio.read(path, file_format="gmsh")
    points = np.asarray(mesh.points, dtype=float)
    names = {int(tag): str(name) for name, (tag, dimension) in mesh.field_data.items() if dimension == 3}
    outer: dict[tuple[int, int], dict[tuple[int, ...], tuple[int, ...]]] = {}  # faces of a volume and physical group, by their corners
    flat, bounding = set[tuple[int, ...]](), set[tuple[int, ...]]()
    for k, cells in enumerate(mesh.cells):
        kind = cells.type.rstrip("0123456789")
        if kind in SURFACES:
            flat |= {tuple(sorted(map(int, cell[: SURFACES[kind]]))) for cell in cells.data}
        none = np.zeros(len(cells.data))
        tags = [mesh.cell_data[f"gmsh:{key}"][k] if f"gmsh:{key}" in mesh.cell_data else none for key in ("geometrical", "physical")]
        for cell, volume, group in zip(cells.data if kind in CELLS else (), *tags, strict=False):
            faces = outer.setdefault((int(volume), int(group)), {})
            for loop in (tuple(int(cell[i]) for i in face) for face in CELLS[kind]):
                key = tuple(sorted(loop))
                bounding.add(key)
                if faces.pop(key, None) is None:
                    faces[key] = loop
    if not outer:
        raise Refused(path.name, "no volume cells in it; a block is a volume of gmsh")
    found: list[FileShell] = []
    for (_, group), faces in sorted(outer.items()):
        for corners_of, loops in shells(points, list(faces.values())):
            found.append(FileShell(len(found), f"b{len(found)}", corners_of, loops, names.get(group, f"group{group}" if group else "")))
    bare = len(flat - bounding)
    return FileContents(found, (), [f"{path.name}: {bare} faces that bound no volume not read"] if bare else [])


def read_vtp(path: Path) -> FileContents:
    """The closed shells of a surface.

    Raises:
        Refused: no polygons.
    """
    require("this", "pyvista")
    import pyvista

    with warnings.catch_warnings(action="ignore", category=UserWarning):  # of readers; what is wrong is found below
        data: Any = pyvista.read(path)
    if not isinstance(data, pyvista.PolyData) or not data.n_cells:
        raise Refused(path.name, "no polygons in it")
    polygons = data.triangulate() if data.n_strips else data
    made = shells(np.asarray(data.points, dtype=float), [list(map(int, face)) for face in _split(polygons.faces)])
    return FileContents([FileShell(k, f"b{k}", *shell) for k, shell in enumerate(made)], (), _bare(path, "", data))


def _bare(path: Path, where: str, data: Any) -> list[str]:
    """A line on points and lines of a surface, which are not faces."""
    count = int(data.n_verts + data.n_lines)
    return [f"{path.name}: {where}{count} cells of points and lines not read"] if count else []


def read_vtkhdf(path: Path) -> FileContents:
    """The volume cells of an unstructured grid, by its array ``block`` where it has one.

    Raises:
        Refused: another kind of data, or no volumes.
    """
    require("this", "pyvista")
    import pyvista

    with warnings.catch_warnings(action="ignore", category=UserWarning):  # of readers; what is wrong is found below
        data: Any = pyvista.read(path)
    if not isinstance(data, pyvista.UnstructuredGrid) or not data.n_cells:
        raise Refused(path.name, "no unstructured grid of volumes in it")
    cells = _volumes(data)
    if len(cells) != data.n_cells:
        raise Refused(path.name, "cells that are no volumes; a block is a volume cell")
    arrays = {name: [data.cell_data[name]] for name in ("block", "group", "fixed") if name in data.cell_data}
    numbers = np.asarray(arrays.get("block", [np.arange(len(cells))])[0]).astype(int)
    return FileContents(
        [FileShell(int(n), f"b{n}", *cell, *_marks(arrays, 0, k)) for k, (n, cell) in enumerate(zip(numbers, cells, strict=True))]
    )


def read_vtm(path: Path) -> FileContents:
    """The shells of each data set of a multi-block file: a closed surface, or volume cells, which are the block's convex parts.

    Its name is that of the block; data sets within blocks within blocks are found too.

    Raises:
        Refused: no multi-block data, a file that it refers to is missing, or a data set without a surface or a volume.
    """
    require("this", "pyvista")
    import pyvista

    with warnings.catch_warnings(action="ignore", category=UserWarning):  # of files that it refers to, each of which is looked for below
        whole: Any = pyvista.read(path)
    if not isinstance(whole, pyvista.MultiBlock):
        raise Refused(path.name, "no multi-block data in it")
    found: list[FileShell] = []
    unread: list[str] = []
    for number, (name, data) in enumerate(_leaves(whole, "")):
        if data is None or data.n_cells == 0:
            raise Refused(path.name, f'block "{name}": empty, or the file that it refers to is missing or damaged')
        is_surface = isinstance(data, pyvista.PolyData)
        made = [_surface(data)] if is_surface else _volumes(data)
        unread += _bare(path, f'block "{name}": ', data) if is_surface else []
        if not made or (not is_surface and len(made) < data.n_cells):
            raise Refused(path.name, f'block "{name}": neither a closed surface nor volume cells alone')
        found += [FileShell(number, name, *shell) for shell in made]
    return FileContents(found, (), unread)


def _leaves(whole: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    """Names and data sets, those of inner multi-blocks with the outer name before theirs."""
    import pyvista

    for number, (name, data) in enumerate(zip(whole.keys(), whole, strict=True)):
        own = f"{prefix}{name or f'b{number}'}"
        if isinstance(data, pyvista.MultiBlock):
            yield from _leaves(data, f"{own}/")
        else:
            yield own, data


def _surface(data: Any) -> tuple[np.ndarray, Faces]:
    """The polygons of a PolyData; its strips are triangles."""
    polygons = data.triangulate() if data.n_strips else data
    return _shell(np.asarray(data.points, dtype=float), [list(map(int, face)) for face in _split(polygons.faces)])


def _volumes(data: Any) -> list[tuple[np.ndarray, Faces]]:
    """A shell for each volume cell of a grid, turned to face outwards as VTK orders them."""
    points = np.asarray(data.points, dtype=float)
    cells = [data.get_cell(k) for k in range(data.n_cells)]
    return [_shell(points, [list(map(int, face.point_ids)) for face in cell.faces]) for cell in cells if cell.dimension == 3]


def _split(stream: np.ndarray) -> Iterator[np.ndarray]:
    """The loops of VTK's list ``n, i, j, k ..., n, i, j, k ...``."""
    at = 0
    while at < len(stream):
        yield stream[at + 1 : at + 1 + stream[at]]
        at += 1 + stream[at]


def _shell(points: np.ndarray, loops: Sequence[Sequence[int]]) -> tuple[np.ndarray, Faces]:
    """The points that some loops use, each place once, and the loops counted over them."""
    corners = [i for loop in loops for i in loop]
    if min(corners) < 0:
        raise ValueError("a face names a point below 0")
    used, index = np.unique(points[corners], axis=0, return_inverse=True)
    ends = np.cumsum([len(loop) for loop in loops])
    return used, tuple(tuple(map(int, part)) for part in np.split(index.ravel(), ends[:-1]))
