# SPDX-License-Identifier: GPL-3.0-or-later
"""Stones in pieces, which crack along the planes between them: blocks cut as ``[material.stones]`` asks.

    mid        one plane through the centre of mass, across the longest extent of the stone
    cross      two, across its two longest extents
    voronoi    the cells of points, spread through the stone by moving each into the middle of its cell (Lloyd, IEEE Trans. Inf. Theory 28,
               1982); with axes to cut across, cells are prisms along the others

The extents are those along the principal axes of inertia; of equal ones that which is nearer to x, then y, comes first. Stone ``v1`` has
the pieces ``v1/1``, ``v1/2`` ..., and each knows its stone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import counted
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties
from masonry_cd.mechanics.model.polygon import loop_planes
from masonry_cd.mechanics.model.stones import AXES, KEY, PIECES, Stones, stones_of
from structures import size
from structures.geometry.checks import check_shells
from structures.geometry.convex import below, halves

if TYPE_CHECKING:
    from structures import MadeStructure
    from structures.ties import PlacedBar

SAMPLES = 400  # points per piece by which cells are measured
MOVES = 12  # of points into the middles of their cells
ALIKE = 1e-6  # of the moments of inertia: extents closer than this are equal


def in_pieces(made: MadeStructure, stones: Mapping[str, Stones]) -> MadeStructure:
    """The blocks of a structure with its stones in pieces.

    Raises:
        InputError: a name that is not a group, no block to cut, one that fill touches, more pieces than blocks are allowed, or none where
            blocks of a file are pieces.
    """
    if not stones:
        piece = next(block for block in made.blocks if block.stone)
        raise InputError(KEY, f'missing: "{piece.name}" is a piece of the stone "{piece.stone}", and nothing says how strong that is')
    groups = tuple(dict.fromkeys(block.group for block in made.blocks))
    laws = {group: stones_of(stones, group, groups) for group in groups}
    chosen = {block.name: laws[block.group] for block in made.blocks if laws[block.group] and not (block.fixed or block.stone)}
    touched = {face.block for fill in made.fills for face in fill.faces} | {block.name for block in made.blocks if block.carried}
    first = next((block for block in made.blocks if block.name in chosen and block.name in touched), None)
    if first is not None:
        raise InputError(f"{KEY}.{first.group}", f'fill lies on "{first.name}", and stones below fill cannot be cut; name other groups')
    whole = [block.name for block in made.blocks if block.name in chosen and (block.parts or block.radius)]
    size.check_size(len(made.blocks) + sum((own.pieces or PIECES) - 1 for own in chosen.values() if own is not None), size.KEY)
    pieces = {
        block.name: _pieces(block, own, number)
        for number, block in enumerate(made.blocks)
        if (own := chosen.get(block.name)) is not None and block.name not in whole
    }
    if not pieces and not any(block.stone for block in made.blocks):
        raise InputError(KEY, "no block can crack: those that move in these groups are not convex" if whole else "no block of it moves")
    if pieces:
        check_shells([piece for own in pieces.values() for piece in own])
    blocks = [piece for block in made.blocks for piece in pieces.get(block.name, [block])]
    left = f", {len(whole)} that are not convex stay whole, the first is {whole[0]}" if whole else ""
    cut = sum(len(own) for own in pieces.values())
    notes = [*made.notes, f"{KEY}: {counted(len(pieces), 'stone')} in {cut} pieces, which crack from each other{left}"]
    notes += dict.fromkeys(line for own in stones.values() for line in own.notes())
    return made._replace(blocks=blocks, notes=notes, ties=[_moved(bar, pieces) for bar in made.ties])


def _pieces(block: Block, stones: Stones, number: int) -> list[Block]:
    """The pieces of a convex block, which has a number among the others."""
    if stones.planes == "voronoi":
        with np.errstate(invalid="ignore"):  # faces without area on the way, which the check of the pieces refuses, have no plane
            found = _cells(block, stones, np.random.default_rng([stones.seed, number]))
    else:
        found, centre = [block], block.mass_properties.centre
        for normal in _normals(block, stones):
            offset = float(np.sum(normal * centre))
            found = [half for piece in found for half in halves(piece, normal, offset) if half is not None]
    return [replace(piece, name=f"{block.name}/{k}", stone=block.name) for k, piece in enumerate(found, 1)]


def _normals(block: Block, stones: Stones) -> np.ndarray:
    """Normals (1, 3) or (2, 3) of the planes through the centre of a block."""
    if stones.across is not None:
        return np.eye(3)[[AXES.index(axis) for axis in stones.across]]
    inertia = block.mass_properties.unit_inertia
    _, axes = np.linalg.eigh(inertia + ALIKE * np.trace(inertia) * np.diag([0.0, 1.0, 2.0]))
    out = axes.T[: 1 if stones.planes == "mid" else 2]
    return np.asarray(out * np.sign(out[np.arange(len(out)), np.abs(out).argmax(axis=1)])[:, None])


def _cells(block: Block, stones: Stones, random: np.random.Generator) -> list[Block]:
    """The cells of points in a block."""
    count, points = stones.pieces or PIECES, _samples(block, stones.pieces or PIECES, random)
    mask = np.isin(list(AXES), stones.across or tuple(AXES)).astype(float)
    seeds = points[:count]
    for _ in range(MOVES):
        nearest = (((points[:, None] - seeds) * mask) ** 2).sum(axis=2).argmin(axis=1)
        sums = np.stack([np.bincount(nearest, points[:, d], count) for d in range(3)], axis=1)
        seeds = sums / np.maximum(np.bincount(nearest, minlength=count), 1)[:, None]
    out = []
    for i, own in enumerate(seeds):
        cell: Block | None = block
        for other in np.delete(seeds, i, axis=0):
            if cell is not None:
                between = (other - own) * mask
                normal = between / np.sqrt(np.sum(between**2))
                cell = below(cell, normal, float(np.sum(normal * 0.5 * (own + other))))
        out += [] if cell is None else [cell]
    return out


def _samples(block: Block, count: int, random: np.random.Generator) -> np.ndarray:
    """Points (n, 3) spread at random over a convex block, SAMPLES for each of a count of pieces [m]."""
    normals, offsets = loop_planes([block.vertices[list(face)] for face in block.faces])
    low, high = block.vertices.min(axis=0), block.vertices.max(axis=0)
    share = mass_properties(block.vertices, block.faces).volume / float(np.prod(high - low))
    points = low + (high - low) * random.random((round(SAMPLES * count / share), 3))
    heights = (points[:, None] * normals).sum(axis=2) - offsets
    return np.asarray(points[(heights <= 0.0).all(axis=1)])


def _moved(bar: PlacedBar, pieces: Mapping[str, Sequence[Block]]) -> PlacedBar:
    """A tie whose ends hold the pieces that they lie on."""
    ends = [_piece_at(pieces[name], point) if name in pieces else name for name, point in zip(bar.blocks, bar.points, strict=True)]
    return bar._replace(blocks=(ends[0], ends[1]))


def _piece_at(pieces: Sequence[Block], point: np.ndarray) -> str:
    """The name of the piece that a point is in, or nearest to."""
    outside = []
    for piece in pieces:
        normals, offsets = loop_planes([piece.vertices[list(face)] for face in piece.faces])
        outside.append(float((np.sum(normals * point, axis=1) - offsets).max()))
    return pieces[int(np.argmin(outside))].name
