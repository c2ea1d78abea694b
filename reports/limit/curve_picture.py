# SPDX-License-Identifier: GPL-3.0-or-later
"""The load factor over something: over the displacement, with the structure at marked points, and over where a vehicle stands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.deformed import Solids
from masonry_cd.analysis.limit.capacity import CapacityCurve
from masonry_cd.analysis.limit.mechanism import STATES
from masonry_cd.analysis.limit.stage import CurveStage
from masonry_cd.foundation.figures import blank
from reports.drawing.figure import COLOURS, INK, draw_zero_line, format_axes, save
from reports.drawing.palette import AT_WORK, PULLING
from reports.drawing.parts import Ties, View, Window
from reports.drawing.plots import DPI, add_heading
from reports.drawing.render import render
from reports.drawing.scene import PictureScene
from reports.drawing.solids import structure_window
from reports.limit.picture import DOT, dots, moving_layers, through, view_of_motion

LETTERS = "abcdefgh"
DOTTED = STATES[1:4]  # states of joints that are marked by a dot
LONGEST = 500.0  # of a tie that is drawn [m]: the bars by which fill resists are longer
SLACK = 1e-9  # tension, over the mean weight of a block, below which a tie pulls nothing
PIXELS = 460  # width of the picture of a marked point
UNITS = ((0.02, 1e3, "mm"), (0.2, 1e2, "cm"), (np.inf, 1.0, "m"))  # displacements below, factor, name
LINE, WORST, SPAN = "#20506f", "#b3261e", "#e9e4d8"
SHOWN = 4.0  # times the least factor: the plot ends there


def draw_curve(curve: CapacityCurve, path: Path, title: str, facts: str, view: str = "auto") -> None:
    """Draw a capacity curve into a PNG.

    Raises:
        InputError: an unknown view, no off-screen OpenGL, or a path that cannot be written.
    """
    images = _images(curve, view)
    below = min(11.6 / len(images) * max(image.shape[0] / image.shape[1] for image in images), 5.2)
    figure = blank((12.0, 6.4 + below), DPI, layout="constrained")
    add_heading(figure, title, facts)
    grid = figure.add_gridspec(2, len(images), height_ratios=(4.6, below))
    _draw_curve(figure.add_subplot(grid[0, :]), curve)
    for k, (mark, image) in enumerate(zip(curve.marks, images, strict=True)):
        axes = figure.add_subplot(grid[1, k])
        axes.imshow(image, interpolation="antialiased")
        axes.set_axis_off()
        axes.set_title(f"{LETTERS[k]}   factor {curve.shown_factor(mark):.3g}", fontsize=11, color=INK, loc="left")
    _draw_key(figure, curve)
    save(figure, path)


def _draw_key(figure: Any, curve: CapacityCurve) -> None:
    """Explain the signs of the marked points, in a line below them."""
    from matplotlib.lines import Line2D

    worked = {state for mark in curve.marks for _, _, state in curve.stages[mark].at_work()}
    signs = [Line2D([], [], marker="o", ls="", color=AT_WORK[state], label=state) for state in DOTTED if state in worked]
    if len(curve.stages[0].loads.bars.strength):
        signs.append(Line2D([], [], color=PULLING, label="tie, grey where it is slack"))
    figure.legend(handles=signs, loc="outside lower right", ncols=len(signs) or 1, fontsize=10, frameon=False)


def _draw_curve(axes: Any, curve: CapacityCurve) -> None:
    """The line, its marks, and where the mechanism changes."""
    largest = float(np.abs(curve.displacement).max())
    _, scale, unit = next(row for row in UNITS if largest < row[0])
    format_axes(axes, "load factor", f"displacement of the control block [{unit}]")
    draw_zero_line(axes)
    x = scale * curve.displacement
    for first, end in pairwise([0, *curve.jumps, len(x)]):
        label = "limit analysis of the moved blocks" if first == 0 else None
        axes.plot(x[first:end], curve.factor[first:end], color=COLOURS[0], linewidth=2.0, label=label)
    for jump in curve.jumps:  # where blocks move on without load
        label, there = "blocks move on without load" if jump == curve.jumps[0] else None, slice(jump - 1, jump + 1)
        axes.plot(x[there], curve.factor[there], color=COLOURS[0], linewidth=1.1, linestyle=":", label=label)
    upper = np.array([stage.associated for stage in curve.stages])
    above = upper > curve.factor + 1e-4 * abs(curve.factor[0])
    if above.any():
        shown = np.where(above, upper, np.nan)
        axes.plot(x, shown, "--x", color=COLOURS[0], linewidth=1.1, markersize=5, label="associated factor (upper bound)")
    for k, change in enumerate(curve.changes):
        label = "other joints are active" if k == 0 else None
        axes.plot(x[change], curve.factor[change], "|", color=INK, markersize=13, markeredgewidth=1.3, label=label)
    for k, mark in enumerate(curve.marks):
        axes.plot(x[mark], curve.factor[mark], "o", color=COLOURS[0], markersize=8, markeredgecolor="white")
        axes.annotate(
            LETTERS[k], (x[mark], curve.factor[mark]), xytext=(6, 8), textcoords="offset points", fontsize=12, fontweight="bold", color=INK
        )
    axes.margins(x=0.02)
    axes.set_ylim(bottom=min(0.0, float(curve.factor.min())) - 0.02 * float(curve.factor.max()), top=1.12 * float(curve.factor.max()))
    axes.legend(loc="best", fontsize=10, frameon=False)


def _images(curve: CapacityCurve, view: str) -> list[np.ndarray]:
    """The structure at the marked points, all in one framing: what stands, what moves, hinges and slips, outlines as built."""
    built = Solids.from_blocks(curve.stages[0].assembly.blocks)
    looking = view_of_motion(built, curve.stages[0].mechanism, view)
    solids = [Solids.from_blocks(curve.stages[mark].assembly.blocks) for mark in curve.marks]
    window = structure_window(built, looking, *(moved.vertices for moved in solids))
    pixels = PIXELS, round(float(np.clip(PIXELS * window.height / window.width, 0.4 * PIXELS, 2.2 * PIXELS)))
    scenes = (_scene(curve.stages[mark], moved, built, looking, window) for mark, moved in zip(curve.marks, solids, strict=True))
    return [render(replace(scene, window=window.fitted(pixels)), pixels) for scene in scenes]


def _scene(stage: CurveStage, solids: Solids, built: Solids, looking: View, window: Window) -> PictureScene:
    """The structure at a stage."""
    moves, joints, radius = stage.mechanism, stage.joints, 3.0 * DOT * window.height
    layers = moving_layers(solids, solids.vertices, moves.moving, built)
    at_work = {(a, b): state for a, b, state in stage.at_work()}
    for name in DOTTED:
        which = [j for j in range(joints.count) if at_work.get((int(joints.block_a[j]), int(joints.block_b[j]))) == name]
        layers.append(dots(moves.hinge[which], AT_WORK[name], looking, radius, through(looking)))
    tension = np.zeros(len(stage.pulling))
    tension[stage.pulling] = stage.best.bars
    ends = stage.loads.bars.points
    rods = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) < LONGEST
    pulls = np.where(tension > SLACK, tension, 0.0)[rods]  # those that are slack pull nothing
    return PictureScene(looking, window, layers, ties=Ties(ends[rods], ("",) * len(pulls), pulls))


def draw_crossing(position: np.ndarray, factor: np.ndarray, spans: Sequence[tuple[float, float]], path: Path, title: str) -> None:
    """Draw the factors (M,) of a vehicle over the places of its first axle along the road (M,) [m], and where arches begin and end.

    A factor is inf where any multiple is borne.
    """
    figure = blank((8.0, 4.0), DPI, layout="constrained")
    axes = figure.add_subplot()
    for k, (low, high) in enumerate(spans):
        axes.axvspan(low, high, color=SPAN, lw=0)
        axes.annotate(f"span {k + 1}", (0.5 * (low + high), 0.02), xycoords=("data", "axes fraction"), ha="center", color="#6d675a")
    worst = int(np.argmin(factor))
    axes.plot(position, np.where(np.isfinite(factor), factor, np.nan), color=LINE, marker=".", ms=4)
    if np.isfinite(factor[worst]):
        axes.plot(position[worst], factor[worst], "o", color=WORST)
        place = position[worst], factor[worst]
        axes.annotate(f"{place[1]:.4g} at {place[0]:.4g} m", place, (6, -14), textcoords="offset points", color=WORST)
        axes.set_ylim(0.0, SHOWN * factor[worst])
    format_axes(axes, "load factor", "first axle along the road [m]", grid="y")
    axes.set_title(title, color=INK, fontsize=11, loc="left")
    save(figure, path, title)
