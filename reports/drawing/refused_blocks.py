"""A picture of what is wrong: the faulty blocks in colour, with their names, among the others as through glass.

Shells may be open, reversed or bent here, so nothing is computed from them but where their corners are.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Polyhedron
from masonry_cd.mechanics.model.polygon import next_in_loop
from reports.drawing.figure import INK, Sheet, layout
from reports.drawing.render import Layer, Lines, Surface, View, Window, render, view_named
from reports.drawing.structure_picture import EDGE, around, auto_view, box_swatch, no_swatch, rgb

FAULTY = "#c2410c"
SOUND = "#c9ced1"
GLASS = 0.10  # opacity of the sound blocks
NAMES = 12  # most faulty blocks that are named in the picture
PITCH = 36.0  # of the names [pixels]


def problem_picture(blocks: Sequence[Block], faulty: Sequence[str], message: str, path: Path) -> None:
    """Draw a structure that was refused into a PNG.

    Args:
        blocks: of the structure, sound or not.
        faulty: names of those at fault.
        message: what is wrong, in a line.
        path: of the PNG.

    Raises:
        InputError: no off-screen OpenGL, or a path that cannot be written.
    """
    drawn = [block for block in blocks if _can_be_drawn(block)]
    solids = _solids(drawn)
    at_fault = np.array([block.name in set(faulty) for block in drawn])
    view = view_named(auto_view(solids))
    window = around(view.plane(solids.vertices), 0.06)
    plan = layout(window.width / window.height)
    window = window.fitted(plan.pixels)
    sheet = Sheet(plan)
    sheet.model(render(_layers(solids, at_fault, view, window), view, window, plan.pixels))
    count = int(at_fault.sum())
    sheet.head(
        f"Refused: {count} of {len(blocks)} blocks at fault", textwrap.shorten(message, 150 if plan.beside else 190, placeholder=" …")
    )
    _names(sheet, drawn, solids, at_fault, view, window)
    _key(sheet, len(blocks), count, len(blocks) - len(drawn), window)
    sheet.save(path)


def _can_be_drawn(block: Block) -> bool:
    """Whether a block has finite corners, and faces that name them."""
    whole = block.vertices.ndim == 2 and block.vertices.shape[1] == 3 and bool(np.isfinite(block.vertices).all())
    faces = [face for face in block.faces if len(face) >= 3]
    return whole and bool(faces) and all(min(face) >= 0 and max(face) < len(block.vertices) for face in faces)


def _solids(blocks: Sequence[Block]) -> Solids:
    """The flat arrays of blocks that may enclose no volume: the mean of their corners stands for the centre of mass."""
    shells = [Polyhedron(block.vertices, tuple(face for face in block.faces if len(face) >= 3)) for block in blocks]
    centre = np.array([block.vertices.mean(axis=0) for block in blocks])
    return Solids.of(shells, centre, np.array([block.fixed for block in blocks]))


def _layers(solids: Solids, at_fault: np.ndarray, view: View, window: Window) -> list[Layer]:
    """Faulty blocks with their edges, then the others as glass."""
    lift = 5e-4 * window.height * view.towards
    edges = _sides(solids)
    red = at_fault[solids.vertex_block[edges[:, 0]]]
    return [
        _faces(solids, at_fault, FAULTY, 1.0),
        Lines(solids.vertices + lift, edges[red], EDGE, 1.6),
        Lines(solids.vertices, edges[~red], "#9aa2a7", 0.6),
        _faces(solids, ~at_fault, SOUND, GLASS),
    ]


def _sides(solids: Solids) -> np.ndarray:
    """(E, 2) all sides of all faces, each once; an open shell has sides of one face only."""
    following = next_in_loop(solids.loop_start)
    pairs = np.stack([solids.loops, solids.loops[following]], axis=1)
    return np.unique(np.sort(pairs, axis=1), axis=0)


def _faces(solids: Solids, chosen: np.ndarray, colour: str, opacity: float) -> Surface:
    """The faces of some blocks."""
    kept, sides = chosen[solids.face_block], np.diff(solids.loop_start)
    colours = np.tile((255 * rgb(colour)).astype(np.uint8), (int(kept.sum()), 1))
    loops = solids.loops[np.repeat(kept, sides)]
    return Surface(solids.vertices, loops, np.cumsum([0, *sides[kept]]), colours, opacity=opacity)


def _names(sheet: Sheet, blocks: Sequence[Block], solids: Solids, at_fault: np.ndarray, view: View, window: Window) -> None:
    """The names of the first faulty blocks, in a column on either side, by height, with a line to each block."""
    axes = sheet.axes(*sheet.plan.model)
    width, height = sheet.plan.pixels
    places = (view.plane(solids.centre) - [window.left, window.bottom]) * width / window.width
    named = np.flatnonzero(at_fault)[:NAMES]
    left = places[named, 0] <= 0.5 * width
    for side, members in ((0.0, named[left]), (float(width), named[~left])):
        members = members[np.argsort(-places[members, 1])]
        top = np.inf
        for k in members:
            top = min(float(places[k, 1]), top - PITCH, height - PITCH)
            axes.plot(*places[k], "o", color=INK, markersize=4)
            axes.annotate(
                blocks[k].name, places[k], (side, top), fontsize=14, weight="bold", color=INK, ha="right" if side else "left", va="center",
                bbox={"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": FAULTY},
                arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.9}, annotation_clip=False, parse_math=False,
            )  # fmt: skip


def _key(sheet: Sheet, blocks: int, faulty: int, left_out: int, window: Window) -> None:
    """The two kinds of blocks, how many have no name or cannot be drawn, and the scale bar."""
    rows: list[tuple[Any, str]] = [
        (partial(box_swatch, colour=FAULTY), f"at fault ({faulty})"),
        (partial(box_swatch, colour=SOUND), f"others ({blocks - faulty - left_out})"),
    ]
    if faulty > NAMES:
        rows.append((no_swatch, f"the first {NAMES} are named"))
    if left_out:
        rows.append((no_swatch, f"{left_out} cannot be drawn"))
    boxes = sheet.plan.keys(2)
    sheet.swatches(sheet.axes(*boxes[0]), rows, 0, boxes[0][3] - 6)
    sheet.scale_bar(sheet.axes(*boxes[1]), window.width / sheet.plan.pixels[0], 10, boxes[1][3] - 44)
