"""The picture of a structure before any run: blocks coloured by group."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.mechanics.model.blocks import Block
from reports.drawing import palette
from reports.drawing.figure import TRIAD, Box, Paint, Sheet, in_metres, layout
from reports.drawing.render import Lines, Surface, View, Window, render, view_named
from reports.drawing.tie_lines import PULLING, ties_as_built

# light enough for black edges, apart in hue and in grey; supports are always the grey one
SUPPORT, EDGE = palette.SUPPORT, palette.EDGE
PALETTE = ("#e6d9bd", "#9fc3dd", "#e9a77c", "#b9d3a4", "#cbb3d9", "#f3dc84", "#8fb8b0", "#dba3ad", "#b7a58a", "#c6d9ea")
AROUND = 0.35  # of the structure's largest extent: how far a level ground is drawn around it
FAR = 1.25  # of the size of a structure: how far from it blocks still draw a wide ground out, a block across the end of a picture too
MOTTLE = 0.025  # blocks of one colour differ by this share, as stones do


def structure_picture(blocks: Sequence[Block], path: Path, title: str, view: str = "auto", ties: Sequence[np.ndarray] = ()) -> None:
    """Draw the blocks by group, and ties by their ends (2, 3) each [m], with a key and a scale bar, into a PNG.

    Args:
        blocks: of the structure.
        path: of the PNG.
        title: of the picture.
        view: auto (front where all blocks are prisms across y, else isometric), front, back, side, top or isometric.

    Raises:
        InputError: an unknown view, no off-screen OpenGL, or a path that cannot be written.
    """
    structure_sheet(blocks, title, view, ties).save(path)


def structure_sheet(blocks: Sequence[Block], title: str, view: str = "auto", ties: Sequence[np.ndarray] = ()) -> Sheet:
    """The sheet that :func:`structure_picture` writes.

    Raises:
        InputError: an unknown view, or no off-screen OpenGL.
    """
    solids = Solids.from_blocks(blocks)
    looking = view_named(auto_view(solids) if view == "auto" else view)
    window = structure_window(solids, looking)
    plan = layout(window.width / window.height)
    window = window.fitted(plan.pixels)
    families = families_of(blocks)
    layers = block_layers(solids, within_sight(solids, solids.vertices), _block_colours(len(blocks), families), looking, window)
    layers += ties_as_built(ties).layers(looking, float((solids.vertices @ looking.towards).max()) + 0.02 * window.height)
    sheet = Sheet(plan)
    sheet.model(render(layers, looking, window, plan.pixels))
    extent = " × ".join(in_metres(v) for v in np.ptp(solids.vertices[~solids.fixed[solids.vertex_block]], axis=0))
    sheet.head(title, f"{len(blocks)} blocks · {extent} (x, y, z) without supports · {looking.name} view")
    _keys(sheet, families, window, len(ties), looking)
    return sheet


def auto_view(solids: Solids) -> str:
    """``front`` for planar structures: free blocks that are prisms across y and span one common width; else ``isometric``."""
    free = ~solids.fixed if not solids.fixed.all() else solids.fixed
    across = np.abs(solids.face_normals[free[solids.face_block], 1])
    prisms = bool(((across < 1e-6) | (across > 1 - 1e-6)).all())
    y = solids.vertices[free[solids.vertex_block], 1]
    common = bool((solids.sizes[free, 1] > (1 - 1e-6) * np.ptp(y)).all())
    return "front" if prisms and common else "isometric"


def structure_window(solids: Solids, view: View) -> Window:
    """The window around the free blocks; wide supports, such as the ground, may run out of the picture."""
    whole = around(view.plane(solids.vertices), 0.03)
    if solids.fixed.all():
        return whole
    free = around(view.plane(solids.vertices[~solids.fixed[solids.vertex_block]]), 0.10)
    return Window(max(whole.left, free.left), min(whole.right, free.right), max(whole.bottom, free.bottom), min(whole.top, free.top))


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


def around(plane: np.ndarray, margin: float) -> Window:
    """The window around points (N, 2), with a margin as a share of the larger side."""
    (left, bottom), (right, top) = plane.min(axis=0), plane.max(axis=0)
    pad = margin * max(right - left, top - bottom)
    return Window(float(left - pad), float(right + pad), float(bottom - pad), float(top + pad))


def rgb(colour: str) -> np.ndarray:
    """``#rrggbb`` as (3,) in 0..1."""
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0


def mottle(count: int) -> np.ndarray:
    """(B,) factors on the colours of blocks, by which stones are distinguished."""
    return 1.0 + MOTTLE * (2.0 * ((np.arange(count) * 0.6180339887498949) % 1.0) - 1.0)  # golden ratio: neighbours differ


def stone_colours(solids: Solids, colours: np.ndarray) -> np.ndarray:
    """(F, 3) colours of the faces of blocks of colours (B, 3), 0..1, by which stones are distinguished."""
    return np.asarray(np.clip(colours * mottle(len(colours))[:, None], 0.0, 1.0)[solids.face_block])


def block_layers(solids: Solids, vertices: np.ndarray, colours: np.ndarray, view: View, window: Window) -> list[Surface | Lines]:
    """The faces of all blocks, shaded in colours (B, 3) 0..1, and their edges, drawn thin just before them."""
    return face_layers(solids, vertices, stone_colours(solids, colours), view, window)


def face_layers(solids: Solids, vertices: np.ndarray, colours: np.ndarray, view: View, window: Window) -> list[Surface | Lines]:
    """The faces of all blocks, shaded in colours (F, 3) 0..1 of their own, and their edges, drawn thin just before them."""
    count = len(solids.centre)
    shade = (255.0 * colours).astype(np.uint8)
    lift = 5e-4 * window.height * view.towards
    thin = 1.2 if count < 2000 else 0.7
    return [
        Surface(vertices, solids.loops, solids.loop_start, shade),
        Lines(vertices + lift, solids.edges(), EDGE, thin),
    ]


def box_swatch(axes: Any, place: Box, colour: str) -> None:
    """A filled box of a key."""
    from matplotlib.patches import Rectangle

    axes.add_patch(Rectangle(place[:2], *place[2:], facecolor=colour, edgecolor=EDGE, linewidth=1.0))


def tie_swatch(axes: Any, place: Box) -> None:
    """A piece of a tie in a key."""
    left, bottom, width, height = place
    axes.plot([left, left + width], [bottom + height / 2] * 2, color=PULLING, linewidth=2.5)


@dataclass(frozen=True, eq=False)
class Family:
    """Blocks that one colour stands for: a group, or numbered groups (pier1, pier2 ...) taken together."""

    text: str
    members: np.ndarray  # indices of blocks
    colour: str


def families_of(blocks: Sequence[Block]) -> list[Family]:
    """The groups of blocks; where they outnumber the colours, numbered groups together. Groups of supports are grey."""
    named = [b.group for b in blocks]
    if len(set(named)) > len(PALETTE) + 1:
        named = [re.sub(r"\d+", "#", name) for name in named]
    names = np.array(named, dtype=object)
    out: list[Family] = []
    for name in dict.fromkeys(named):
        members = np.flatnonzero(names == name)
        groups = list(dict.fromkeys(blocks[int(i)].group for i in members))
        text = groups[0] if len(groups) == 1 else f"{groups[0]} to {groups[-1]}"
        support = all(blocks[int(i)].fixed for i in members)
        free = sum(family.colour != SUPPORT for family in out)
        out.append(Family(f"{text} ({len(members)})", members, SUPPORT if support else PALETTE[free % len(PALETTE)]))
    return out


def no_swatch(axes: Any, place: Box) -> None:
    """A row of a key without a sign."""


def _block_colours(count: int, families: Sequence[Family]) -> np.ndarray:
    """(B, 3) in 0..1."""
    out = np.empty((count, 3))
    for family in families:
        out[family.members] = rgb(family.colour)
    return out


def _keys(sheet: Sheet, families: Sequence[Family], window: Window, ties: int, view: View) -> None:
    """The families in columns, the ties, and the scale bar with the directions of the axes."""
    rows: list[tuple[Paint, str]] = [(partial(box_swatch, colour=family.colour), family.text) for family in families]
    rows += [(tie_swatch, f"ties ({ties})")] if ties else []
    boxes = sheet.plan.keys(3 if sheet.plan.beside else 5)
    per_column = int((boxes[0][3] - 6) // 32)
    room = (len(boxes) - 1) * per_column
    if len(rows) > room:
        rows = [*rows[: room - 1], (no_swatch, f"and {len(rows) - room + 1} more")]
    for k in range(len(boxes) - 1):
        sheet.swatches(sheet.axes(*boxes[k]), rows[k * per_column : (k + 1) * per_column], 0, boxes[k][3] - 6)
    axes, (wide, top) = sheet.axes(*boxes[-1]), boxes[-1][2:]
    sheet.scale_bar(axes, window.width / sheet.plan.pixels[0], 10, top - 44, wide - 60 - TRIAD)
    sheet.triad(axes, view, (wide - 0.5 * TRIAD, top - 58))
