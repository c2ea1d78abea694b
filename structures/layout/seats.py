# SPDX-License-Identifier: GPL-3.0-or-later
"""Seats cut into blocks: what of a block lies outside an upright box, as one stone where it hangs together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block, refuse_spheres
from masonry_cd.mechanics.model.components import connected_components
from masonry_cd.mechanics.model.geometry import Polyhedron
from structures.geometry.compound_block import GRID, compound_block
from structures.geometry.convex import halves

ON = 1e-9  # [m]: corners closer to a face of the box than this lie in it


def without_box(block: Block, low: np.ndarray, high: np.ndarray, least: float) -> list[Block]:
    """What remains of a block outside a box: itself where they do not meet, nothing where it lies inside.

    Args:
        low, high: (3,) corners of the box [m].
        least: thickness below which what remains is a sliver [m].

    Raises:
        InputError: a sliver would remain; says where.
    """
    if (block.vertices.max(axis=0) <= low + ON).any() or (block.vertices.min(axis=0) >= high - ON).any():
        return [block]
    refuse_spheres([block], "structure.floors: cutting seats")
    cells = [replace(block, vertices=part.vertices, faces=part.faces, parts=()) for part in block.convex_parts]
    for axis in range(3):
        for place in (low[axis], high[axis]):
            cells = [piece for cell in cells for piece in _cut(cell, axis, float(place)) if piece is not None]
    middle = [cell.vertices.mean(axis=0) for cell in cells]
    left = [cell for cell, at in zip(cells, middle, strict=True) if ((at < low) | (at > high)).any()]
    if len(left) == len(cells):
        return [block]
    for piece in left:
        _refuse_sliver(piece, block.name, low, high, least)
    groups = hanging_together(left) if left else []
    stones = [compound_block(block.name, [(left[i].vertices, left[i].faces) for i in own], block.density, block.group) for own in groups]
    if len(stones) == 1 and stones[0].parts:
        parts = [replace(block, vertices=part.vertices, faces=part.faces, parts=()) for part in block.convex_parts]
        stones = [replace(stones[0], parts=tuple(piece for part in parts for piece in _outside(part, low, high)))]
    return stones if len(stones) < 2 else [replace(stone, name=f"{block.name}.s{k + 1}") for k, stone in enumerate(stones)]


def _cut(cell: Block, axis: int, place: float) -> tuple[Block | None, Block | None]:
    """A convex cell below and above a plane across an axis, its new corners exactly in it; None where nothing of it is."""
    below, above = halves(cell, np.eye(3)[axis], place)
    return _flush(below, axis, place), _flush(above, axis, place)


def _flush(piece: Block | None, axis: int, place: float) -> Block | None:
    """A piece whose corners at a plane lie exactly in it."""
    if piece is None:
        return None
    vertices = piece.vertices.copy()
    vertices[np.abs(vertices[:, axis] - place) < ON, axis] = place
    return replace(piece, vertices=vertices)


def _refuse_sliver(piece: Block, name: str, low: np.ndarray, high: np.ndarray, least: float) -> None:
    """Refuse a piece that is thin beside a face of the box."""
    first, last = piece.vertices.min(axis=0), piece.vertices.max(axis=0)
    for axis, place in ((k, end[k]) for k in range(3) for end in (low, high)):
        if last[axis] - first[axis] < least and min(abs(first[axis] - place), abs(last[axis] - place)) < ON:
            edge = first[axis] if abs(last[axis] - place) < ON else last[axis]
            raise InputError(
                f'of block "{name}" a sliver of {1e3 * (last[axis] - first[axis]):.3g} mm would remain beside it at '
                f"{'xyz'[axis]} = {place:.4g} m; the face of the block is at {edge:.4g} m"
            )


def hanging_together(cells: Sequence[Block]) -> list[list[int]]:
    """The cells that hang together by whole faces, in groups."""
    owner = np.repeat(np.arange(len(cells)), [len(cell.faces) for cell in cells])
    centres = np.array([cell.vertices[list(face)].mean(axis=0) for cell in cells for face in cell.faces])
    first, second = np.nonzero(np.abs(centres[:, None] - centres[None]).max(axis=2) < GRID)
    label = connected_components(owner[first], owner[second], len(cells))
    return [np.flatnonzero(label == k).tolist() for k in dict.fromkeys(label.tolist())]


def _outside(cell: Block, low: np.ndarray, high: np.ndarray) -> Iterator[Polyhedron]:
    """What of a convex cell lies outside a box, in as few convex parts as its planes make one after another: two of an L."""
    for axis in (2, 1, 0):
        for place, above in ((low[axis], False), (high[axis], True)):
            below, beyond = _cut(cell, axis, float(place))
            out, rest = (beyond, below) if above else (below, beyond)
            if out is not None:
                yield Polyhedron(out.vertices, out.faces)
            if rest is None:
                return
            cell = rest
