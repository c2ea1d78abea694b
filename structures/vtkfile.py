"""Blocks from and to VTK's own containers: VTM (multi-block: a data set per block) and VTKHDF (written only).

A data set of a multi-block is one block, whatever it is made of: a closed surface (PolyData), or volume cells, which are the block's
convex parts. Its name is that of the block; data sets within blocks within blocks are found too. VTKHDF holds one unstructured grid, a
polyhedron per convex part, with the arrays ``block``, ``fixed`` and ``group``, as the VTU has them.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.blocks import Block, Faces, Polyhedron
from masonry_cd.errors import InputError

Shell = tuple[np.ndarray, Faces]
POLYHEDRON = 42  # VTK's number of this type of cell


def read_vtm(path: Path) -> list[tuple[str, list[Shell]]]:
    """The shells of each data set of a multi-block file.

    Raises:
        InputError: no such file, one that it refers to is missing, or a data set without a surface or a volume.
    """
    import pyvista
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)  # what is wrong is told below, in one line
    try:
        with warnings.catch_warnings(action="ignore"):
            whole: Any = pyvista.read(path)
    except Exception as failure:
        raise InputError(f"{path.name}: no VTM file that can be read: {(str(failure).splitlines() or [''])[0]}") from None
    if not isinstance(whole, pyvista.MultiBlock):
        raise InputError(f"{path.name}: no multi-block data in it")
    found: list[tuple[str, list[Shell]]] = []
    for name, data in _leaves(whole, ""):
        if data is None or data.n_cells == 0:
            raise InputError(f'{path.name}: block "{name}": empty, or the file that it refers to is missing')
        shells = [_surface(data)] if isinstance(data, pyvista.PolyData) else _volumes(data)
        if not shells:
            raise InputError(f'{path.name}: block "{name}": neither a closed surface nor volume cells')
        found.append((name, shells))
    return found


def _leaves(whole: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    """Names and data sets, those of inner multi-blocks with the outer name before theirs."""
    import pyvista

    for number, (name, data) in enumerate(zip(whole.keys(), whole, strict=True)):
        own = f"{prefix}{name or f'b{number}'}"
        if isinstance(data, pyvista.MultiBlock):
            yield from _leaves(data, f"{own}/")
        else:
            yield own, data


def _surface(data: Any) -> Shell:
    """The polygons of a PolyData; its strips are triangles."""
    polygons = data.triangulate() if data.n_strips else data
    return _shell(np.asarray(data.points, dtype=float), [list(map(int, face)) for face in _split(polygons.faces)])


def _volumes(data: Any) -> list[Shell]:
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


def _shell(points: np.ndarray, loops: Sequence[Sequence[int]]) -> Shell:
    """The points that some loops use, each place once, and the loops counted over them."""
    used, index = np.unique(points[[i for loop in loops for i in loop]], axis=0, return_inverse=True)
    ends = np.cumsum([len(loop) for loop in loops])
    return used, tuple(tuple(map(int, part)) for part in np.split(index.ravel(), ends[:-1]))


def write_vtm(path: Path, blocks: Sequence[Block]) -> None:
    """Write a multi-block file, with a folder of its data sets beside it: a surface for a convex block, a grid for one with parts."""
    import pyvista

    whole = pyvista.MultiBlock()
    for block in blocks:
        if block.parts:
            whole[block.name] = _grid(block.parts)
        else:
            whole[block.name] = pyvista.PolyData(block.vertices, faces=_stream(block.faces))
    whole.save(path)


def write_vtkhdf(path: Path, blocks: Sequence[Block]) -> None:
    """Write an unstructured grid of polyhedra."""
    parts = [(number, part) for number, block in enumerate(blocks) for part in block.convex_parts]
    grid = _grid([part for _, part in parts])
    groups = list(dict.fromkeys(block.group for block in blocks))
    grid.cell_data["block"] = np.array([number for number, _ in parts])
    grid.cell_data["fixed"] = np.array([int(blocks[number].fixed) for number, _ in parts])
    grid.cell_data["group"] = np.array([groups.index(blocks[number].group) for number, _ in parts])
    grid.save(path)


def _grid(parts: Sequence[Polyhedron]) -> Any:
    """Polyhedra as an unstructured grid."""
    import pyvista

    cells, count = [], 0
    for part in parts:
        faces = tuple(tuple(i + count for i in face) for face in part.faces)
        stream = [len(faces), *_stream(faces)]
        cells.append([len(stream), *stream])
        count += len(part.vertices)
    kinds = np.full(len(parts), POLYHEDRON, dtype=np.uint8)
    return pyvista.UnstructuredGrid(np.concatenate(cells), kinds, np.concatenate([part.vertices for part in parts]))


def _stream(faces: Faces) -> np.ndarray:
    """Loops as VTK lists them: ``n, i, j, k ..., n, i, j, k ...``."""
    return np.concatenate([[len(face), *face] for face in faces])
