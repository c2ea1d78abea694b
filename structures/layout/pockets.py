# SPDX-License-Identifier: GPL-3.0-or-later
"""Pockets: stones of walls without what convex solids take of them, such as the stones of a vault or the seat of a floor.

A stone is cut by all planes of the solids that reach into it, and what remains is put together to few convex parts, as thick as can be
(:mod:`structures.geometry.cells`). A solid may pass a bed or a head joint by a millimetre: what is left of a stone there, a sliver, goes to
the stone next to it with which it makes the thickest part. Nothing is lost or added: only who a piece belongs to changes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Polyhedron
from structures.geometry.cells import AREA, ConvexCell, Planes, cut, joined, outside, planes, stone_of, together

CRUMB = 0.02  # of a stone: a piece of it that is smaller goes to the stones next to it, where it would be loose
SAME = 1e-6  # planes this close are one, their normals and their offsets [m]
ON = 1e-7  # solids that reach less than this into a stone do not meet it [m]
ROUNDS = 3  # in which slivers are given: what one stone has got may be a sliver that another one can take
THICKER = 1.5  # a sliver goes to a neighbour where it becomes a given number of times as thick


def with_pockets(blocks: Sequence[Block], solids: Sequence[Polyhedron], thin: float) -> list[Block]:
    """The blocks without what of them lies in convex solids; one that falls apart becomes ``NAME.s1``, ``NAME.s2`` ...

    Args:
        blocks: those that are fixed are not cut.
        solids: apart from each other.
        thin: thickness below which a part of a stone is a sliver [m].
    """
    low, high = (np.array([end(solid.vertices, axis=0) for solid in solids]) for end in (np.min, np.max))
    sides = [planes(solid) for solid in solids]
    stones: dict[int, list[ConvexCell]] = {}  # parts of those that are cut, by number
    for k, block in enumerate(blocks):
        meet = (low < block.vertices.max(axis=0) - ON).all(axis=1) & (high > block.vertices.min(axis=0) + ON).all(axis=1)
        left = None if block.fixed else _left(block, [sides[i] for i in np.flatnonzero(meet).tolist()])
        if left is not None:
            stones[k] = joined(left)
    _give_slivers(blocks, stones, thin)
    return [stone for k, block in enumerate(blocks) for stone in (_stones(block, stones[k]) if k in stones else [block])]


def width_of(block: Block) -> float:
    """Return the width of its thinnest convex part [m]."""
    return min(part.width for part in _own_parts(block))


def _stones(block: Block, parts: Sequence[ConvexCell]) -> list[Block]:
    """A block as what is left of it."""
    made = [stone_of(block, group) for group in together(parts)]
    return made if len(made) < 2 else [replace(stone, name=f"{block.name}.s{k + 1}") for k, stone in enumerate(made)]


def _left(block: Block, solids: Sequence[Planes]) -> list[ConvexCell] | None:
    """Return the rest of a block outside some convex solids; None where they do not meet it."""
    if not solids:
        return None
    whole = parts = _own_parts(block)
    for solid in solids:
        between = _on_others(solid, [other for other in solids if other is not solid])
        pieces = [(part, outside(part, solid, between)) for part in parts]
        if any(left is not None for _, left in pieces):
            parts = [one for part, left in pieces for one in ([part] if left is None else left)]
    return None if parts is whole else parts


def _on_others(solid: Planes, others: Sequence[Planes]) -> np.ndarray:
    """(F,) in which of its planes a solid lies on another one: beyond these that one's own faces cut, not those of the solid drawn on."""
    own, found = np.column_stack(solid), np.zeros(len(solid[1]), dtype=bool)
    for other in others:
        found |= (np.abs(own[:, None] + np.column_stack(other)[None]).max(axis=2) < SAME).any(axis=1)
    return found


def _own_parts(block: Block) -> list[ConvexCell]:
    """The convex parts of a block."""
    return [ConvexCell.of(replace(block, vertices=part.vertices, faces=part.faces, parts=())) for part in block.convex_parts]


@dataclass(frozen=True, eq=False)
class _Gift:
    """A piece as a part of a stone."""

    to: int  # number of the stone
    instead: ConvexCell  # its part that the piece lies on
    parts: list[ConvexCell]  # what both make
    width: float  # of the part that the piece is in [m]
    sound: bool  # whether none of these is a sliver
    contact: float  # area [m2]


@dataclass(frozen=True, eq=False)
class _Stones:
    """Blocks as parts that may change hands."""

    blocks: Sequence[Block]
    cut: dict[int, list[ConvexCell]]  # parts of those that are cut or have been given a piece, by number
    whole: dict[int, list[ConvexCell]]  # of others that were looked at
    low: np.ndarray  # (B, 3) of the boxes about them [m]
    high: np.ndarray

    def parts(self, k: int) -> list[ConvexCell]:
        """Return the convex parts of a block."""
        if k not in self.cut and k not in self.whole:
            self.whole[k] = _own_parts(self.blocks[k])
        return self.cut[k] if k in self.cut else self.whole[k]

    def neighbours(self, k: int, part: ConvexCell) -> Iterator[tuple[int, ConvexCell]]:
        """Numbers and parts of other blocks on which a part lies."""
        near = (self.low < part.corners.max(axis=0) + SAME).all(axis=1) & (self.high > part.corners.min(axis=0) - SAME).all(axis=1)
        for j in np.flatnonzero(near).tolist():
            if j != k and not self.blocks[j].fixed and not self.blocks[j].radius:
                yield from ((j, one) for one in self.parts(j) if one.contact(part) > AREA)

    def take(self, gift: _Gift) -> None:
        """Put a gift in the place of the part that it is joined to."""
        self.cut[gift.to] = joined([*(one for one in self.parts(gift.to) if one is not gift.instead), *gift.parts])
        for part in gift.parts:
            self.low[gift.to] = np.minimum(self.low[gift.to], part.box[0])
            self.high[gift.to] = np.maximum(self.high[gift.to], part.box[1])


def _give_slivers(blocks: Sequence[Block], cut: dict[int, list[ConvexCell]], thin: float) -> None:
    """Give slivers and crumbs of stones to those next to them, the thinnest first."""
    stones = _Stones(blocks, cut, {}, *(np.array([end(block.vertices, axis=0) for block in blocks]) for end in (np.min, np.max)))
    for _ in range(ROUNDS):
        found = sorted(_slivers(blocks, cut, thin), key=lambda item: (item[2].width, item[0]))
        if not sum(_give(stones, *item, thin) for item in found):  # of all of them
            return


def _give(stones: _Stones, k: int, loose: bool, part: ConvexCell, thin: float) -> bool:
    """Give a part of stone k, piece by piece, to those on which it lies where it gets thicker there; whether any was given."""
    if part not in stones.cut[k]:  # another one has been joined to it
        return False
    stones.cut[k].remove(part)
    kept = list[ConvexCell]()
    pieces = _at_joints(part, [one for _, one in stones.neighbours(k, part)])
    for piece in pieces:
        gifts = [_gift(j, one, piece, thin) for j, one in stones.neighbours(k, piece)]
        best = max(gifts, key=lambda gift: (gift.sound, 0.0 if gift.sound else gift.width, gift.contact), default=None)
        if best is not None and (best.sound or loose or best.width > THICKER * piece.width):
            stones.take(best)
        else:
            kept.append(piece)
    given = len(kept) < len(pieces)
    stones.cut[k] = joined([*stones.cut[k], *kept]) if given else [*stones.cut[k], part]
    return given


def _at_joints(part: ConvexCell, neighbours: Sequence[ConvexCell]) -> list[ConvexCell]:
    """A part cut by the planes of those that it lies on, but for the ones between them."""
    pieces = [part]
    for other in neighbours:
        pieces = cut(pieces, *_free_planes(other, part))
    return pieces


def _free_planes(part: ConvexCell, other: ConvexCell) -> Planes:
    """The planes of a part but for those in which it lies on another one."""
    between = {i for i, _ in part.faces_on(other)}
    kept = [i for i in range(len(part.offsets)) if i not in between]
    return part.normals[kept], part.offsets[kept]


def _gift(j: int, one: ConvexCell, piece: ConvexCell, thin: float) -> _Gift:
    """A piece joined to a part of stone j that it lies on."""
    made = joined([*cut([one], *_free_planes(piece, one)), piece])
    own = next(part for part in made if part.holds(piece))
    sound = min(part.width for part in made) > min(thin, 0.999 * one.width)
    return _Gift(j, one, made, own.width, sound, one.contact(piece))


def _slivers(blocks: Sequence[Block], stones: dict[int, list[ConvexCell]], thin: float) -> list[tuple[int, bool, ConvexCell]]:
    """Number of the stone of each, whether it is loose, and the part."""
    found = []
    for k, parts in stones.items():
        volume = blocks[k].mass_properties.volume
        for group in together(parts):
            loose = sum(part.block.mass_properties.volume for part in group) < CRUMB * volume or max(part.width for part in group) < thin
            found += [(k, loose, part) for part in group if loose or part.width < thin]
    return found
