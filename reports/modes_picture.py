# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of the first modes: the deformed structure coloured by its displacement, over its outline at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from masonry_cd.analysis.modal.modes import Modes
from masonry_cd.analysis.modal.shapes import RigidShapes, Skin
from masonry_cd.foundation.extras import require
from masonry_cd.mechanics.model.blocks import Block
from reports.drawing.figure import INK, draw_triad, save
from reports.drawing.palette import DISPLACED, PARTED, REST, SUPPORT
from reports.drawing.parts import BEHIND, Layer, Lines, Surface, painted, view_named
from reports.drawing.plots import DPI, sheet
from reports.drawing.render import render
from reports.drawing.scene import PictureScene
from reports.drawing.solids import drawn_in, window_around

AMPLITUDE = 0.08  # largest drawn displacement, as a share of the size of the structure
COLUMNS = 3
LIFT = 1.5e-3  # of edges before the skin, as a share of the picture's height
METHOD = {"continuum": "bonded elastic continuum", "joints": "rigid blocks on elastic joints"}


def draw_modes(
    modes: Modes, blocks: Sequence[Block], path: Path, title: str, captions: Sequence[str] = (), most: int = 6, view: str = "isometric"
) -> None:
    """Draw the first modes of a model into a PNG, each with a further line where ``captions`` has one, such as the measured frequency.

    Raises:
        InputError: an unknown view, no off-screen OpenGL, or a path that cannot be written.
    """
    from matplotlib.cm import ScalarMappable

    looking, blocks = view_named(view), drawn_in(blocks)
    skin, frame = modes.field.skin(), _frame(modes, blocks)
    reach = AMPLITUDE * float(np.ptp(skin.points, axis=0).max())
    count = min(most, modes.count)
    places = np.concatenate([skin.points] + [skin.points + reach * skin.shapes[k] for k in range(count)])
    window = window_around(looking, places, np.concatenate([places, *(block.vertices for block in blocks if block.fixed)]))
    rows, columns = math.ceil(count / COLUMNS), min(COLUMNS, count)
    tall = float(np.clip(window.height / window.width, 0.45, 1.5))
    young = {"": modes.young} if isinstance(modes.young, (int, float)) else modes.young
    modulus = ", ".join(f"{group} {value / 1e9:.4g}".strip() for group, value in young.items())
    facts = f"{METHOD[modes.method]} · E = {modulus} GPa · largest displacement drawn as {reach:.3g} m · grey: at rest"
    size = max(4.0 * columns, 8.0), 1.6 + rows * (0.7 + 4.0 * tall)
    figure, panels = sheet(title, facts, count, size, rows)
    pixels = round(4.0 * DPI), round(4.0 * DPI * tall)
    for k, axes in enumerate(panels):
        image = render(PictureScene(looking, window.fitted(pixels), _layers(skin, frame, k, reach, blocks)), pixels)
        axes.imshow(image, extent=(0, pixels[0], 0, pixels[1]))
        axes.set_axis_off()
        share = "   ".join(f"{axis} {100 * value:.0f} %" for axis, value in zip("xyz", modes.participation[k], strict=True))
        more = captions[k] if k < len(captions) else ""
        words = f"{k + 1}   {modes.frequencies[k]:.4g} Hz   mass  {share}\n{more}"
        axes.set_title(words, fontsize=11, color=INK, loc="left")
    draw_triad(panels[0], looking, (60, 60), 40.0)
    bar = figure.colorbar(ScalarMappable(cmap=DISPLACED), ax=panels, location="bottom", fraction=0.02, aspect=40, ticks=(0.0, 0.5, 1.0))
    bar.set_label("displacement over the largest of the mode", color=INK)
    save(figure, path)


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


def _layers(skin: Skin, frame: Skin, mode: int, reach: float, blocks: Sequence[Block]) -> list[Layer]:
    """Deformed skin and the edges of its blocks, supports, and the outline at rest behind."""
    require("a picture", "matplotlib")
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
