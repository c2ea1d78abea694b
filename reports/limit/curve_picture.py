# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a capacity curve: the factor over the displacement, and the structure at marked points with what moves there."""

from __future__ import annotations

import textwrap
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.analysis.limit.capacity import CapacityCurve
from masonry_cd.analysis.limit.mechanism import STATES
from masonry_cd.analysis.limit.stage import Stage
from reports.drawing.figure import COLOURS, FAINT, INK, blank, plain_axes, save, zero_line
from reports.drawing.palette import AT_WORK, PULLING
from reports.drawing.parts import Ties, View, Window
from reports.drawing.render import render
from reports.drawing.scene import Scene
from reports.drawing.solids import structure_window
from reports.limit.picture import DOT, dots, moving_layers, through, view_of_motion

LETTERS = "abcdefgh"
DOTTED = STATES[1:4]  # states of joints that are marked by a dot
LONGEST = 500.0  # of a tie that is drawn [m]: the bars by which fill resists are longer
SLACK = 1e-9  # tension, over the mean weight of a block, below which a tie pulls nothing
WIDE = 150  # letters of the line below the title
PIXELS = 460  # width of the picture of a marked point
DPI = 150
UNITS = ((0.02, 1e3, "mm"), (0.2, 1e2, "cm"), (np.inf, 1.0, "m"))  # displacements below, factor, name


def curve_picture(curve: CapacityCurve, judged: np.ndarray, path: Path, title: str, facts: str, view: str = "auto") -> None:
    """Draw a capacity curve into a PNG.

    Args:
        curve: what to draw.
        judged: (n, 3) displacement, and the factors between which that of the dynamics lies.
        path: of the PNG.
        title: of the picture.
        facts: the line below it.
        view: auto, front, back, side, left, top or isometric.

    Raises:
        InputError: an unknown view, no off-screen OpenGL, or a path that cannot be written.
    """
    marks = curve.marks
    images = _images(curve, view)
    tall = max(image.shape[0] / image.shape[1] for image in images)
    width, each = 12.0, 11.6 / len(marks)
    below = min(each * tall, 5.2) + 0.45
    height = 1.0 + 4.6 + 0.5 + below
    figure = blank((width, height), DPI)
    figure.text(
        0.02,
        1.0 - 0.32 / height,
        textwrap.shorten(title, 100, placeholder=" …"),
        fontsize=15,
        fontweight="bold",
        color=INK,
        va="center",
        parse_math=False,
    )
    figure.text(0.02, 1.0 - 0.55 / height, textwrap.fill(facts, WIDE), fontsize=10.5, color=FAINT, va="top", parse_math=False)
    axes = figure.add_axes((0.08, (below + 0.65) / height, 0.89, 4.35 / height))
    _curve(axes, curve, judged)
    for k, (mark, image) in enumerate(zip(marks, images, strict=True)):
        one = figure.add_axes((0.017 + k * each / width, 0.03 / height, 0.96 * each / width, (below - 0.4) / height))
        one.imshow(image, interpolation="antialiased")
        one.set_axis_off()
        words = f"{LETTERS[k]}   factor {curve.shown_factor(mark):.3g}"
        figure.text(0.017 + (k + 0.03) * each / width, (below - 0.18) / height, words, fontsize=11, color=INK, va="center")
    _key(figure, (below + 0.14) / height, curve)
    save(figure, path)


def _key(figure: Any, height: float, curve: CapacityCurve) -> None:
    """What the signs of the marked points mean, in a line that ends at the right edge."""
    worked = {state for mark in curve.marks for _, _, state in curve.stages[mark].at_work()}
    signs = [(f"● {state}", AT_WORK[state]) for state in DOTTED if state in worked]
    if len(curve.stages[0].loads.bars.strength):
        signs.append(("— tie, grey where it is slack", PULLING))
    right = 0.97
    for words, colour in reversed(signs):
        figure.text(right, height, words, fontsize=10, color=colour, va="center", ha="right")
        right -= 0.0068 * len(words) + 0.02


def _curve(axes: Any, curve: CapacityCurve, judged: np.ndarray) -> None:
    """The line, its marks, what the dynamics says, and where the mechanism changes."""
    largest = float(np.abs(curve.displacement).max())
    _, scale, unit = next(row for row in UNITS if largest < row[0])
    plain_axes(axes, "load factor", f"displacement of the control block [{unit}]")
    zero_line(axes)
    x = scale * curve.displacement
    _line(axes, x, curve)
    upper = np.array([stage.associated for stage in curve.stages])
    above = upper > curve.factor + 1e-4 * abs(curve.factor[0])
    if above.any():
        shown = np.where(above, upper, np.nan)
        axes.plot(x, shown, "--x", color=COLOURS[0], linewidth=1.1, markersize=5, label="associated factor, an upper value")
    for k, change in enumerate(curve.changes):
        label = "other joints are at work" if k == 0 else None
        axes.plot(x[change], curve.factor[change], "|", color=INK, markersize=13, markeredgewidth=1.3, label=label)
    for k, (place, low, high) in enumerate(judged):
        label = "dynamics: falls back below, goes on above" if k == 0 else None
        axes.plot([scale * place] * 2, [low, high], "_-", color=COLOURS[1], linewidth=2.2, markersize=17, markeredgewidth=1.6, label=label)
    for k, mark in enumerate(curve.marks):
        axes.plot(x[mark], curve.factor[mark], "o", color=COLOURS[0], markersize=8, markeredgecolor="white")
        axes.annotate(
            LETTERS[k], (x[mark], curve.factor[mark]), xytext=(6, 8), textcoords="offset points", fontsize=12, fontweight="bold", color=INK
        )
    axes.margins(x=0.02)
    axes.set_ylim(bottom=min(0.0, float(curve.factor.min())) - 0.02 * float(curve.factor.max()), top=1.12 * float(curve.factor.max()))
    axes.legend(loc="best", fontsize=10, frameon=False)


def _line(axes: Any, x: np.ndarray, curve: CapacityCurve) -> None:
    """The factor over the displacement (K,) in the unit of the axes; dotted where blocks go on by themselves."""
    borne = [0, *curve.jumps, len(x)]
    for first, end in pairwise(borne):
        label = "limit analysis of the moved blocks" if first == 0 else None
        axes.plot(x[first:end], curve.factor[first:end], color=COLOURS[0], linewidth=2.0, label=label)
    for jump in curve.jumps:
        label = "blocks go on by themselves" if jump == curve.jumps[0] else None
        axes.plot(x[jump - 1 : jump + 1], curve.factor[jump - 1 : jump + 1], color=COLOURS[0], linewidth=1.1, linestyle=":", label=label)


def _images(curve: CapacityCurve, view: str) -> list[np.ndarray]:
    """The structure at the marked points, all in one framing: what stands, what moves, hinges and slips, outlines as built."""
    built = Solids.from_blocks(curve.stages[0].assembly.blocks)
    looking = view_of_motion(built, curve.stages[0].mechanism, view)
    solids = [Solids.from_blocks(curve.stages[mark].assembly.blocks) for mark in curve.marks]
    window = structure_window(built, looking, *(moved.vertices for moved in solids))
    pixels = PIXELS, round(float(np.clip(PIXELS * window.height / window.width, 0.4 * PIXELS, 2.2 * PIXELS)))
    scenes = (_scene(curve.stages[mark], moved, built, looking, window) for mark, moved in zip(curve.marks, solids, strict=True))
    return [render(replace(scene, window=window.fitted(pixels)), pixels) for scene in scenes]


def _scene(stage: Stage, solids: Solids, built: Solids, looking: View, window: Window) -> Scene:
    """The structure at a stage."""
    moves, joints, radius = stage.mechanism, stage.joints, 3.0 * DOT * window.height
    layers = moving_layers(solids, solids.vertices, moves.moving, built)
    at_work = {(a, b): state for a, b, state in stage.at_work()}
    for name in DOTTED:
        which = [j for j in range(joints.count) if at_work.get((int(joints.block_a[j]), int(joints.block_b[j]))) == name]
        layers.append(dots(moves.hinge[which], AT_WORK[name], looking, radius, through(looking)))
    return Scene(looking, window, layers, ties=_ties(stage))


def _ties(stage: Stage) -> Ties:
    """The ties where they are, without labels; those that are slack pull nothing."""
    tension = np.zeros(len(stage.pulling))
    tension[stage.pulling] = stage.best.bars
    ends = stage.loads.bars.points
    rods = np.sqrt(((ends[:, 1] - ends[:, 0]) ** 2).sum(axis=1)) < LONGEST
    return Ties(ends[rods], ("",) * int(rods.sum()), np.where(tension > SLACK, tension, 0.0)[rods])
