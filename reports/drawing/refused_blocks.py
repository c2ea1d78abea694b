# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of what is wrong: the faulty blocks in colour, with their names, among the others as through glass.

Shells may be open, reversed or bent here, so nothing is computed from them but where their corners are.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Polyhedron
from masonry_cd.mechanics.model.polygon import next_in_loop
from reports.drawing.figure import INK, Sheet
from reports.drawing.palette import EDGE, FAULTY, SOUND
from reports.drawing.parts import RULER, KeyPanel, Lines, Sign, Surface, Window, painted
from reports.drawing.scene import PictureScene
from reports.drawing.solids import looking_at, structure_window, within_sight

GLASS = 0.10  # opacity of the sound blocks
NAMES = 12  # most faulty blocks that are named in the picture
PITCH = 36.0  # of the names [pixels]


def draw_refused_blocks(blocks: Sequence[Block], faulty: Sequence[str], message: str, path: Path) -> None:
    """Draw a structure that was refused into a PNG, with the names of those at fault, and what is wrong, in a line.

    Raises:
        InputError: no off-screen OpenGL, or a path that cannot be written.
    """
    drawn = [block for block in blocks if _can_be_drawn(block)]
    shells = [Polyhedron(block.vertices, tuple(face for face in block.faces if len(face) >= 3)) for block in drawn]
    centre = np.array([block.vertices.mean(axis=0) for block in drawn])  # of blocks that may enclose no volume
    solids = Solids.of(shells, centre, np.array([block.fixed for block in drawn]))
    at_fault = np.array([block.name in set(faulty) for block in drawn])
    view, count, left_out = looking_at(solids), int(at_fault.sum()), len(blocks) - len(drawn)
    rows = [Sign("box", f"at fault ({count})", (FAULTY,)), Sign("box", f"others ({len(drawn) - count})", (SOUND,))]
    rows += [Sign("", f"the first {NAMES} are named")] if count > NAMES else []
    rows += [Sign("", f"{left_out} cannot be drawn")] if left_out else []
    window, red = structure_window(solids, view), within_sight(solids, solids.vertices)[at_fault[solids.vertex_block]]
    scene = PictureScene(
        view=view,
        window=window.joined(Window.around(view.plane(red), 0.06)) if len(red) else window,
        layers=_layers(solids, at_fault),
        title=f"Refused: {count} of {len(blocks)} blocks have errors",
        facts=textwrap.shorten(message, 150, placeholder=" …"),
        key=[KeyPanel(rows), RULER],
    )
    sheet = Sheet.drawn(scene)
    _draw_names(sheet, drawn, solids, at_fault, scene)
    sheet.save(path)


def _can_be_drawn(block: Block) -> bool:
    """Return True if a block has finite corners, and faces that name them."""
    whole = block.vertices.ndim == 2 and block.vertices.shape[1] == 3 and bool(np.isfinite(block.vertices).all())
    faces = [face for face in block.faces if len(face) >= 3]
    return whole and bool(faces) and all(min(face) >= 0 and max(face) < len(block.vertices) for face in faces)


def _layers(solids: Solids, at_fault: np.ndarray) -> list[Surface | Lines]:
    """Faulty blocks with their edges, then the others as glass."""
    pairs = np.stack([solids.loops, solids.loops[next_in_loop(solids.loop_start)]], axis=1)
    edges = np.unique(np.sort(pairs, axis=1), axis=0)  # an open shell has sides of one face
    vertices = within_sight(solids, solids.vertices)
    red = at_fault[solids.vertex_block[edges[:, 0]]]

    def faces(chosen: np.ndarray, colour: str, opacity: float) -> Surface:
        whole = Surface(vertices, solids.loops, solids.loop_start, painted(colour, len(solids.face_block)), opacity=opacity)
        return whole.some(chosen[solids.face_block])

    return [
        faces(at_fault, FAULTY, 1.0),
        Lines(vertices, edges[red], EDGE, 1.6, lift=5e-4),
        Lines(vertices, edges[~red], "#9aa2a7", 0.6),
        faces(~at_fault, SOUND, GLASS),
    ]


def _draw_names(sheet: Sheet, blocks: Sequence[Block], solids: Solids, at_fault: np.ndarray, scene: PictureScene) -> None:
    """The names of the first faulty blocks, in a column on either side, by height, with a line to each block."""
    axes = sheet.axes(*sheet.plan.model)
    width, height = sheet.plan.pixels
    window = scene.window.fitted(sheet.plan.pixels)
    places = (scene.view.plane(solids.centre) - [window.left, window.bottom]) * width / window.width
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
                arrowprops={"arrowstyle": "-", "color": INK, "linewidth": 0.9}, annotation_clip=False,
            )  # fmt: skip
