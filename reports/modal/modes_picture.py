# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of the first modes: the deformed structure coloured by its displacement, over its outline at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.modal.modes import Modes
from masonry_cd.analysis.modal.shapes import RigidShapes, Skin
from masonry_cd.mechanics.model.blocks import Block
from reports.drawing.figure import FAINT, INK, MARGIN, TITLE, WIDTH, Layout, Sheet
from reports.drawing.palette import DISPLACED, PARTED, REST, SUPPORT
from reports.drawing.parts import BEHIND, Layer, Lines, Surface, View, Window, painted, view_named
from reports.drawing.render import render
from reports.drawing.scene import Scene
from reports.drawing.solids import drawn_in, window_around

AMPLITUDE = 0.08  # largest drawn displacement, as a share of the size of the structure
COLUMNS = 3
LIFT = 1.5e-3  # of edges before the skin, as a share of the picture's height
CAPTION = 74  # height of the text above a panel
BAR = 90  # height of the colour bar's strip
METHOD = {"continuum": "bonded elastic continuum", "joints": "rigid blocks on elastic joints"}


def modes_picture(
    modes: Modes, blocks: Sequence[Block], path: Path, title: str, captions: Sequence[str] = (), most: int = 6, view: str = "isometric"
) -> None:
    """Draw the first modes into a PNG.

    Args:
        modes: of one model.
        blocks: of the structure.
        path: of the PNG.
        title: of the picture.
        captions: a further line for each mode, such as the measured frequency.
        most: modes to draw.
        view: front, back, side, left, top or isometric.

    Raises:
        InputError: an unknown view, no off-screen OpenGL, or a path that cannot be written.
    """
    looking, blocks = view_named(view), drawn_in(blocks)
    skin, frame = modes.field.skin(), _frame(modes, blocks)
    reach = AMPLITUDE * float(np.ptp(skin.points, axis=0).max())
    count = min(most, modes.count)
    window = _window(skin, count, reach, looking, blocks)
    plan, cells = _plan(count, window)
    sheet = Sheet(plan)
    facts = f"{METHOD[modes.method]} · {_modulus(modes)} · largest displacement drawn as {reach:.3g} m · grey: at rest"
    sheet.head(title, facts)
    for k, (left, bottom, width, height) in enumerate(cells):
        scene = Scene(looking, window.fitted((width, height)), _layers(skin, frame, k, reach, blocks))
        image = render(scene, (width, height))
        axes = sheet.axes(left, bottom, width, height)
        axes.imshow(image, extent=(0, width, 0, height), interpolation="none", aspect="auto")
        _caption(sheet.axes(left, bottom + height, width, CAPTION), modes, k, captions[k] if k < len(captions) else "")
    _colour_bar(sheet, looking)
    sheet.save(path)


def _frame(modes: Modes, blocks: Sequence[Block]) -> Skin:
    """The edges of all free blocks, moved with the model."""
    if isinstance(modes.field, RigidShapes):
        return modes.field.skin()
    still = _still([block for block in blocks if not block.fixed])
    points, index = np.unique(still.points, axis=0, return_inverse=True)
    edges = np.unique(np.sort(index.ravel()[still.edges], axis=1), axis=0)
    return Skin(points, modes.field.at(points)[0], still.loops, still.loop_start, edges)


def _still(blocks: Sequence[Block]) -> Skin:
    """The skin of blocks that do not move."""
    nothing = np.zeros((1, len(blocks), 3))
    return RigidShapes(blocks, nothing[0], nothing, nothing).skin()


def _window(skin: Skin, count: int, reach: float, view: View, blocks: Sequence[Block]) -> Window:
    """Around the structure in all modes drawn, and its supports as far as they are near."""
    places = np.concatenate([skin.points] + [skin.points + reach * skin.shapes[k] for k in range(count)])
    return window_around(view, places, np.concatenate([places, *(block.vertices for block in blocks if block.fixed)]))


def _plan(count: int, window: Window) -> tuple[Layout, list[tuple[int, int, int, int]]]:
    """The sheet and the boxes of the panels (left, bottom, width, height)."""
    columns = min(COLUMNS, count)
    rows = math.ceil(count / columns)
    width = (WIDTH - 2 * MARGIN - (columns - 1) * MARGIN) // columns
    height = int(np.clip(width * window.height / window.width, 0.45 * width, 1.5 * width))
    pitch = height + CAPTION
    total = TITLE + rows * pitch + BAR
    cells = [(MARGIN + (k % columns) * (width + MARGIN), total - TITLE - (k // columns + 1) * pitch, width, height) for k in range(count)]
    return Layout((WIDTH, total), (MARGIN, BAR, WIDTH - 2 * MARGIN, rows * pitch), beside=False), cells


def _layers(skin: Skin, frame: Skin, mode: int, reach: float, blocks: Sequence[Block]) -> list[Layer]:
    """Deformed skin and the edges of its blocks, supports, and the outline at rest behind."""
    from matplotlib import colormaps

    length = np.linalg.norm(skin.shapes[mode], axis=1)
    mean = np.add.reduceat(length[skin.loops], skin.loop_start[:-1]) / np.diff(skin.loop_start)
    colours = (255 * colormaps[DISPLACED](np.clip(mean, 0.0, 1.0))[:, :3]).astype(np.uint8)
    layers: list[Layer] = [
        Surface(skin.points + reach * skin.shapes[mode], skin.loops, skin.loop_start, colours),
        Lines(frame.points + reach * frame.shapes[mode], frame.edges, PARTED, 0.8 if len(blocks) < 500 else 0.4, lift=LIFT),
        Lines(skin.points, skin.edges, REST, 1.2, BEHIND),
    ]
    if supports := [block for block in blocks if block.fixed]:
        still = _still(supports)
        layers.append(Surface(still.points, still.loops, still.loop_start, painted(SUPPORT, len(still.loop_start) - 1)))
    return layers


def _caption(axes: Any, modes: Modes, mode: int, more: str) -> None:
    """Number, frequency and participating masses of a mode."""
    share = "   ".join(f"{axis} {100 * value:.0f} %" for axis, value in zip("xyz", modes.participation[mode], strict=True))
    axes.text(0, 44, f"{mode + 1}", fontsize=17, weight="bold", color=INK, va="center")
    axes.text(34, 44, f"{modes.frequencies[mode]:.4g} Hz", fontsize=17, color=INK, va="center")
    axes.text(200, 44, f"mass  {share}", fontsize=12, color=FAINT, va="center")
    axes.text(34, 16, more, fontsize=12, color=FAINT, va="center", parse_math=False)


def _colour_bar(sheet: Sheet, view: View) -> None:
    """What the colours mean, and where the axes point."""
    axes = sheet.axes(MARGIN, 0, WIDTH - 2 * MARGIN, BAR)
    ramp = np.linspace(0.0, 1.0, 256)[None, :]
    axes.imshow(ramp, extent=(0, 320, 34, 50), cmap=DISPLACED, aspect="auto")
    axes.set_xlim(0, WIDTH - 2 * MARGIN)
    axes.set_ylim(0, BAR)
    for x, text in ((0, "0"), (160, "0.5"), (320, "1")):
        axes.text(x, 18, text, fontsize=12, color=INK, ha="center", va="center")
    axes.text(350, 42, "displacement over the largest of the mode", fontsize=12, color=INK, va="center")
    sheet.triad(axes, view, (WIDTH - 2 * MARGIN - 60, 30))


def _modulus(modes: Modes) -> str:
    """The modulus in words."""
    if isinstance(modes.young, (int, float)):
        return f"E = {modes.young / 1e9:.4g} GPa"
    return "E = " + ", ".join(f"{group} {value / 1e9:.4g}" for group, value in modes.young.items()) + " GPa"
