# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks in pictures: from where they are seen, what of them, in which colours, with their edges; and a structure before any run."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.fill import CoveredFaces, Fill
from reports.drawing.figure import in_metres
from reports.drawing.palette import EDGE, FILL, GROUPS, PULLING, SUPPORT
from reports.drawing.parts import RULER, KeyPanel, Layer, Lines, Sign, Surface, Ties, View, Window, rgb, view_named
from reports.drawing.scene import PictureScene

AROUND = 0.35  # of the structure's largest extent: how far a level ground is drawn around it
FAR = 1.25  # of the size of a structure: how far from it blocks still draw a wide ground out, a block across the end of a picture too
MOTTLE = 0.025  # blocks of one colour differ by this share, as stones do
MARGIN = 0.10  # around the free blocks, as a share of their larger side
MANY = 2000  # blocks from which on edges are drawn thin


def auto_view(solids: Solids) -> str:
    """``front`` for planar structures: free blocks that are prisms across y and span one common width; else ``isometric``."""
    free = ~solids.fixed if not solids.fixed.all() else solids.fixed
    across = np.abs(solids.face_normals[free[solids.face_block], 1])
    prisms = bool(((across < 1e-6) | (across > 1 - 1e-6)).all())
    y = solids.vertices[free[solids.vertex_block], 1]
    common = bool((solids.sizes[free, 1] > (1 - 1e-6) * np.ptp(y)).all())
    return "front" if prisms and common else "isometric"


def looking_at(solids: Solids, view: str = "auto") -> View:
    """The view of a name, which ``auto`` leaves to the structure.

    Raises:
        InputError: an unknown view.
    """
    return view_named(auto_view(solids) if view == "auto" else view)


def structure_window(solids: Solids, view: View, *moved: np.ndarray) -> Window:
    """The window around the free blocks, at rest and with vertices ``moved`` (V, 3); supports do not widen it, they may run out of it."""
    free = ~solids.fixed[solids.vertex_block]
    window = window_around(view, solids.vertices[free] if free.any() else solids.vertices, solids.vertices)
    for points in moved:
        window = window.joined(Window.around(view.plane(points[free]), 0.05))
    return window


def window_around(view: View, free: np.ndarray, every: np.ndarray) -> Window:
    """The window around the points (N, 3) of what is free, and of ``every`` other point (M, 3) as much as lies near [m]."""
    return Window.around(view.plane(every), 0.03).within(Window.around(view.plane(free), MARGIN))


def within_sight(solids: Solids, vertices: np.ndarray, seen: np.ndarray | None = None) -> np.ndarray:
    """Vertices (V, 3) of all blocks, level supports drawn in to what lies near the free blocks, at rest and where they are [m].

    A ground is made wide, for what falls; as wide as it is it would fill the picture. Blocks flung farther than the structure is large
    and a quarter do not draw it out. ``seen`` (N, 3) are other places of free blocks, instead of those where they are.
    """
    owner = solids.vertex_block
    free = ~solids.fixed[owner]
    if not free.any():
        return vertices
    rest, there = solids.vertices[free, :2], (vertices[free] if seen is None else seen)[:, :2]
    low, high = rest.min(axis=0), rest.max(axis=0)
    size = float(np.ptp(solids.vertices[free], axis=0).max())
    there = np.clip(there, low - FAR * size, high + FAR * size)
    low, high = np.minimum(low, there.min(axis=0)) - AROUND * size, np.maximum(high, there.max(axis=0)) + AROUND * size
    out = vertices.copy()
    for block in np.flatnonzero(solids.fixed):
        own = owner == block
        if len(np.unique(vertices[own, 2])) == 2:  # an upright prism, which stays one
            out[own, :2] = np.clip(vertices[own, :2], low, high)
    return out


def drawn_in(blocks: Sequence[Block]) -> list[Block]:
    """The blocks as built, wide level supports drawn in, see :func:`within_sight`."""
    solids = Solids.from_blocks(blocks)
    near = within_sight(solids, solids.vertices)
    return [replace(block, vertices=near[solids.vertex_block == k]) if block.fixed else block for k, block in enumerate(blocks)]


def mottled(colours: np.ndarray) -> np.ndarray:
    """Colours (B, 3) 0..1 of blocks, by which stones are distinguished."""
    share = 2.0 * ((np.arange(len(colours)) * 0.6180339887498949) % 1.0) - 1.0  # golden ratio: neighbours differ
    return np.asarray(np.clip(colours * (1.0 + MOTTLE * share)[:, None], 0.0, 1.0))


def two_colours(solids: Solids, chosen: np.ndarray, first: str, second: str) -> np.ndarray:
    """(B, 3) colours 0..1 of blocks, one of those chosen (B,), another of the others, and that of supports."""
    colours = np.where(chosen[:, None], rgb(first), rgb(second))
    colours[solids.fixed] = rgb(SUPPORT)
    return np.asarray(colours)


def block_layers(solids: Solids, vertices: np.ndarray, colours: np.ndarray, faces: np.ndarray | None = None) -> list[Layer]:
    """The faces of all blocks in colours (B, 3) 0..1, where ``faces`` (F, 3) are finite in those, and their edges just before them."""
    own = mottled(colours)[solids.face_block]
    shade = own if faces is None else np.where(np.isnan(faces), own, faces)
    inside = (255.0 * colours).astype(np.uint8)
    return [
        Surface(vertices, solids.loops, solids.loop_start, (255.0 * shade).astype(np.uint8), owner=solids.face_block, inside=inside),
        Lines(vertices, solids.edges(), EDGE, 1.2 if len(colours) < MANY else 0.7, lift=5e-4, outline=True),
    ]


def fill_layer(fill: CoveredFaces, moved: Callable[[np.ndarray, np.ndarray], np.ndarray], count: int) -> Surface:
    """The fill of bridges on ``count`` blocks: a prism over each face that it lies on, up to the road, which moves with its block.

    ``moved`` returns where points (n, 3) of blocks (n,) are drawn [m].
    """
    corners, tops = (moved(points, fill.owner) for points in (fill.corners, tops_of(fill)))
    loops, owner = list[np.ndarray](), list[int]()
    for block, (first, end) in zip(fill.block.tolist(), pairwise(fill.start.tolist()), strict=True):
        ring = np.arange(first, end)
        top = ring + len(corners)
        sides = [np.array([ring[k - 1], ring[k], top[k], top[k - 1]]) for k in range(len(ring))]
        loops += [ring[::-1], top, *sides]
        owner += [block] * (2 + len(ring))
    colour, start = (255.0 * rgb(FILL)).astype(np.uint8), np.cumsum([0, *map(len, loops)])
    inside, colours = np.tile(colour, (count, 1)), np.tile(colour, (len(loops), 1))
    return Surface(np.concatenate([corners, tops]), np.concatenate(loops), start, colours, owner=np.array(owner), inside=inside)


def tops_of(fill: CoveredFaces) -> np.ndarray:
    """The corners (n, 3) of the faces on which fill lies, drawn up to its level [m]."""
    return np.column_stack([fill.corners[:, :2], np.repeat(fill.level, np.diff(fill.start))])


def structure_scene(
    blocks: Sequence[Block], title: str, view: str = "auto", ties: Sequence[np.ndarray] = (), fills: Sequence[Fill] = ()
) -> PictureScene:
    """The blocks by group, ties by their ends (2, 3) each [m], and fill; in a view by name, or ``auto``, see :func:`auto_view`.

    Raises:
        InputError: an unknown view.
    """
    solids, families = Solids.from_blocks(blocks), families_of(blocks)
    looking, colours = looking_at(solids, view), np.empty((len(blocks), 3))
    for family in families:
        colours[family.members] = rgb(family.colour)
    extent = " × ".join(in_metres(v) for v in np.ptp(solids.vertices[~solids.fixed[solids.vertex_block]], axis=0))
    rows = [Sign("box", family.text, (family.colour, EDGE)) for family in families]
    rows += [Sign("line", f"ties ({len(ties)})", (PULLING,))] if ties else []
    fill = CoveredFaces.of(fills, [block.name for block in blocks])
    rows += [Sign("box", "fill", (FILL, EDGE))] if fill is not None else []
    window, layers = structure_window(solids, looking), block_layers(solids, within_sight(solids, solids.vertices), colours)
    if fill is not None:
        layers.append(fill_layer(fill, lambda points, block: points, len(blocks)))
        window = window.joined(Window.around(looking.plane(layers[-1].points), MARGIN))
    return PictureScene(
        view=looking,
        window=window,
        layers=layers,
        ties=Ties(np.array(ties, dtype=float).reshape(-1, 2, 3), ("",) * len(ties), np.ones(len(ties))),
        title=title,
        facts=f"{len(blocks)} blocks · {extent} (x, y, z) without supports · {looking.name} view",
        key=[KeyPanel(rows, wide=4), RULER],
    )


@dataclass(frozen=True, eq=False)
class ColourFamily:
    """Blocks that one colour stands for: a group, or numbered groups (pier1, pier2 ...) taken together."""

    text: str
    members: np.ndarray  # indices of blocks
    colour: str


def families_of(blocks: Sequence[Block]) -> list[ColourFamily]:
    """The groups of blocks; where they outnumber the colours, numbered groups together. Groups of supports are grey."""
    named = [b.group for b in blocks]
    if len(set(named)) > len(GROUPS) + 1:
        named = [re.sub(r"\d+", "#", name) for name in named]
    names = np.array(named, dtype=object)
    out: list[ColourFamily] = []
    for name in dict.fromkeys(named):
        members = np.flatnonzero(names == name)
        groups = list(dict.fromkeys(blocks[int(i)].group for i in members))
        text = groups[0] if len(groups) == 1 else f"{groups[0]} to {groups[-1]}"
        support = all(blocks[int(i)].fixed for i in members)
        free = sum(family.colour != SUPPORT for family in out)
        out.append(ColourFamily(f"{text} ({len(members)})", members, SUPPORT if support else GROUPS[free % len(GROUPS)]))
    return out
