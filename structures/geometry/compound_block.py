# SPDX-License-Identifier: GPL-3.0-or-later
"""Compound blocks: convex parts that lie face on face and act as one stone, such as the stones on the groin of a vault.

The shell of the block is made of the faces of its parts without those that two parts share; contact detection works on the
parts (``Block.parts``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces, Polyhedron

GRID = 1e-7  # corners of parts closer than this are one [m]


def compound_block(name: str, parts: Sequence[tuple[np.ndarray, Faces]], density: float, group: str) -> Block:
    """Join convex parts into one block; a single part makes a plain block.

    Args:
        parts: vertices (V, 3) [m] and faces of each; parts that touch share whole faces, corner by corner.

    Raises:
        InputError: names the block; two parts do not share a face, or all faces are shared.
    """
    if len(parts) == 1:
        return Block(name, *parts[0], density, group)
    vertices, faces = _welded(parts)
    loops = {frozenset(face): face for face in faces}
    if len(faces) - len(loops) < len(parts) - 1:
        raise InputError(f'block "{name}"', "its parts do not share whole faces")
    count: dict[frozenset[int], int] = {}
    for face in faces:
        count[frozenset(face)] = count.get(frozenset(face), 0) + 1
    outer = [face for face in faces if count[frozenset(face)] == 1]
    if not outer:
        raise InputError(f'block "{name}"', f"its parts have no face of their own; corners within {1e3 * GRID:g} mm are taken for one")
    used = sorted({i for face in outer for i in face})
    number = {old: new for new, old in enumerate(used)}
    shell = tuple(tuple(number[i] for i in face) for face in outer)
    return Block(name, vertices[used], shell, density, group, parts=tuple(Polyhedron(v, f) for v, f in parts))


def _welded(parts: Sequence[tuple[np.ndarray, Faces]]) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """All corners once, and the faces of all parts counted over them."""
    points, count = np.empty((sum(len(vertices) for vertices, _ in parts), 3)), 0
    faces: list[tuple[int, ...]] = []
    for vertices, own in parts:
        index = []
        for vertex in vertices:
            near = np.flatnonzero(np.abs(points[:count] - vertex).max(axis=1) < GRID)
            if not len(near):
                points[count], count = vertex, count + 1
            index.append(int(near[0]) if len(near) else count - 1)
        faces += [tuple(index[i] for i in face) for face in own]
    return points[:count], faces


def moved(block: Block, put: Callable[[np.ndarray], np.ndarray]) -> Block:
    """A block with its corners, and those of its parts, (V, 3) [m], put elsewhere."""
    return replace(block, vertices=put(block.vertices), parts=tuple(Polyhedron(put(part.vertices), part.faces) for part in block.parts))
