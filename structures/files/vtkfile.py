# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks to VTK's own containers: VTM (multi-block: a data set per block) and VTKHDF.

VTKHDF holds one unstructured grid, a polyhedron per convex part, with the arrays ``block``, ``fixed`` and ``group``, as the VTU has them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.atomic import replacing
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces, Polyhedron

POLYHEDRON = 42  # VTK's number of this type of cell


def write_vtm(path: Path, blocks: Sequence[Block]) -> None:
    """Write a multi-block file, with a folder of its data sets next to it: a surface for a convex block, a grid for one with parts."""
    import pyvista

    whole = pyvista.MultiBlock()
    for block in blocks:
        if block.parts:
            whole[block.name] = _grid(block.parts)
        else:
            whole[block.name] = pyvista.PolyData(block.vertices, faces=_stream(block.faces))
    with replacing(path) as part:
        whole.save(part)


def write_vtu(path: Path, blocks: Sequence[Block]) -> None:
    """Write polyhedra, one for each convex part, with the arrays block, fixed and group."""
    import meshio

    points: list[np.ndarray] = []
    cells: dict[str, list[Any]] = {}
    owner: dict[str, list[int]] = {}
    count = 0
    parted = [(number, part) for number, block in enumerate(blocks) for part in block.convex_parts]
    for number, part in sorted(parted, key=lambda pair: len(pair[1].vertices)):  # meshio reads cells of fewer corners first
        kind = f"polyhedron{len(part.vertices)}"
        cells.setdefault(kind, []).append([np.array(face) + count for face in part.faces])
        owner.setdefault(kind, []).append(number)
        points.append(part.vertices)
        count += len(part.vertices)
    groups = list(dict.fromkeys(block.group for block in blocks))
    fixed, group = np.array([b.fixed for b in blocks], dtype=int), np.array([groups.index(b.group) for b in blocks])
    data = {
        "block": [np.array(numbers) for numbers in owner.values()],
        "fixed": [fixed[numbers] for numbers in owner.values()],
        "group": [group[numbers] for numbers in owner.values()],
    }
    meshio.Mesh(np.concatenate(points), list(cells.items()), cell_data=data).write(path)


def write_vtkhdf(path: Path, blocks: Sequence[Block]) -> None:
    """Write an unstructured grid of polyhedra."""
    parts = [(number, part) for number, block in enumerate(blocks) for part in block.convex_parts]
    grid = _grid([part for _, part in parts])
    groups = list(dict.fromkeys(block.group for block in blocks))
    grid.cell_data["block"] = np.array([number for number, _ in parts])
    grid.cell_data["fixed"] = np.array([int(blocks[number].fixed) for number, _ in parts])
    grid.cell_data["group"] = np.array([groups.index(blocks[number].group) for number, _ in parts])
    with replacing(path) as part:
        grid.save(part)


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
