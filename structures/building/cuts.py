# SPDX-License-Identifier: GPL-3.0-or-later
"""Pockets: stones of walls without what convex solids, such as the stones of a vault, take of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Polyhedron
from masonry_cd.mechanics.model.polygon import loop_area, loop_planes
from structures.geometry.checks import Unsound
from structures.geometry.compound_block import compound_block
from structures.geometry.convex import halves, split
from structures.layout.seats import hanging_together

Planes = tuple[np.ndarray, np.ndarray]  # normals (F, 3) and offsets (F,) [m] of the faces of a solid
CRUMB = 0.02  # of a stone: a piece of it that is smaller moves with the largest one
SAME = 1e-6  # planes this close are one, their normals and their offsets [m]
ON = 1e-7  # solids that reach less than this into a stone do not meet it [m]


def with_pockets(blocks: Sequence[Block], solids: Sequence[Polyhedron]) -> Iterator[Block]:
    """The blocks without what of them lies in convex solids; one that falls apart becomes ``NAME.s1``, ``NAME.s2`` ..."""
    low, high = (np.array([end(solid.vertices, axis=0) for solid in solids]) for end in (np.min, np.max))
    for block in blocks:
        meet = (low < block.vertices.max(axis=0) - ON).all(axis=1) & (high > block.vertices.min(axis=0) + ON).all(axis=1)
        stones = _with_crumbs(block, without(block, [solids[k] for k in np.flatnonzero(meet).tolist()]))
        yield from stones if len(stones) < 2 else [replace(stone, name=f"{block.name}.s{k + 1}") for k, stone in enumerate(stones)]


def _with_crumbs(block: Block, stones: Sequence[Block]) -> list[Block]:
    """The pieces of a block, those that are crumbs moving with the largest one: alone they would be loose between the others."""
    volumes = [stone.mass_properties.volume for stone in stones]
    if len(stones) < 2 or min(volumes) >= CRUMB * sum(volumes):
        return list(stones)
    largest = int(np.argmax(volumes))
    joined = [stone for k, stone in enumerate(stones) if k == largest or volumes[k] < CRUMB * sum(volumes)]
    starts = np.cumsum([0, *(len(stone.vertices) for stone in joined)]).tolist()
    faces = tuple(tuple(i + start for i in face) for stone, start in zip(joined, starts, strict=False) for face in stone.faces)
    parts = tuple(part for stone in joined for part in stone.convex_parts)
    whole = replace(block, vertices=np.concatenate([stone.vertices for stone in joined]), faces=faces, parts=parts)
    return [whole, *(stone for k, stone in enumerate(stones) if k != largest and volumes[k] >= CRUMB * sum(volumes))]


def without(block: Block, solids: Sequence[Polyhedron]) -> list[Block]:
    """What remains of a block outside some convex solids: itself where they do not meet.

    All its cells are cut by all planes of the solids that reach into it, so that they share whole faces.
    """
    whole = [replace(block, vertices=part.vertices, faces=part.faces, parts=()) for part in block.convex_parts]
    sides = [_planes(solid) for solid in solids]
    sides = [side for side in sides if any(_inside(cell, side) for cell in whole)]
    if not sides:
        return [block]
    cells = whole
    for normal, offset in _distinct(sides):
        cells = [half for cell in cells for half in halves(cell, normal, offset) if half is not None]
    middle = np.array([cell.vertices.mean(axis=0) for cell in cells])
    taken = np.any([(middle @ normals.T - offsets < 0.0).all(axis=1) for normals, offsets in sides], axis=0)
    left = [cell for cell, gone in zip(cells, taken.tolist(), strict=True) if not gone]
    return [_stone(block, [left[i] for i in own]) for own in hanging_together(left)] if left else []


def _planes(solid: Polyhedron) -> Planes:
    """The planes of a solid, those of its largest faces first: of small ones rounding turns the normal."""
    loops = sorted((solid.vertices[list(face)] for face in solid.faces), key=loop_area, reverse=True)
    return loop_planes(loops)


def _distinct(sides: Sequence[Planes]) -> list[tuple[np.ndarray, float]]:
    """The planes of several solids, those that are one counted once, whichever way they face."""
    found: list[tuple[np.ndarray, float]] = []
    for normals, offsets in sides:
        for normal, offset in zip(normals, offsets.tolist(), strict=True):
            twins = (
                np.abs(np.concatenate([sign * (normal - n * sign), [sign * (offset - o * sign)]])).max()
                for n, o in found
                for sign in (1, -1)
            )
            if not any(off < SAME for off in twins):
                found.append((normal, offset))
    return found


def _inside(cell: Block, planes: Planes) -> bool:
    """Whether anything of a convex cell lies in a convex solid."""
    for normal, offset in zip(*planes, strict=True):
        below = halves(cell, normal, float(offset))[0]
        if below is None:
            return False
        cell = below
    return True


def _stone(block: Block, cells: Sequence[Block]) -> Block:
    """Cells as one stone, in as few convex parts as its shell needs."""
    whole = compound_block(block.name, [(cell.vertices, cell.faces) for cell in cells], block.density, block.group)
    if not whole.parts:
        return whole
    try:
        return split(replace(whole, parts=()))
    except Unsound:
        return whole
