# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of a comparison: response over time, joints by damage, crack widths, and the grades of the parts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.analysis.verdict import NOT_GRADED
from reports.compare.comparison import Comparison, Run
from reports.drawing.figure import COLOURS, FAINT, INK, blank, plain_axes, save
from reports.drawing.palette import DARK, GRADES

STROKES = ("-", "--", ":", "-.")
HATCHES = ("", "///", "...", "xxx")
SHOWN = 0.1  # displacements up to this share of the height are shown
HEAD: dict[str, Any] = {"loc": "left", "fontsize": 13, "fontweight": "bold", "color": INK}
WITHOUT_GRADE = {-1: "no such part", -2: NOT_GRADED}
PARTS = 30  # shown at most


def comparison_picture(comparison: Comparison, path: Path) -> None:
    """Draw a comparison into a PNG.

    Raises:
        InputError: the file cannot be written.
    """
    save(comparison_figure(comparison), path)


def comparison_figure(comparison: Comparison) -> Any:
    """A comparison as a figure of matplotlib."""
    runs = comparison.runs
    names, grid = _grades(runs)
    tall = 7.6 + max(1.6, 0.32 * len(names) + 1.0)
    figure = blank((13.0, tall), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.2, h_pad=0.15)
    rows = figure.add_gridspec(3, 2, height_ratios=(3.6, 3.4, tall - 7.6))
    _response(figure.add_subplot(rows[0, :]), runs)
    draw_states(figure.add_subplot(rows[1, 0]), runs)
    _widths(figure.add_subplot(rows[1, 1]), runs)
    _grade_table(figure.add_subplot(rows[2, :]), runs, names, grid)
    return figure


def _look(k: int) -> dict[str, Any]:
    """Colour and stroke of a run."""
    return {"color": COLOURS[k % len(COLOURS)], "linestyle": STROKES[(k // len(COLOURS) + k) % len(STROKES)]}


def _bar(k: int) -> dict[str, Any]:
    """Colour and hatching of a run."""
    return {"color": COLOURS[k % len(COLOURS)], "hatch": HATCHES[k % len(HATCHES)], "edgecolor": "white", "linewidth": 0.5}


def _response(axes: Any, runs: list[Run]) -> None:
    """Displacement of the highest block over time."""
    reach = max(float(np.abs(run.top).max()) for run in runs)
    shown = min(1.1 * reach, SHOWN * max(run.height for run in runs))  # a fallen block must not flatten the others to a line
    factor, unit = (1000.0, "mm") if shown < 0.5 else (1.0, "m")
    for k, run in enumerate(runs):
        left = " (left the picture)" if np.abs(run.top).max() > shown else ""
        axes.plot(run.time, factor * run.top, label=run.name + left, linewidth=1.8, **_look(k))
    if reach > shown:
        axes.set_ylim(-factor * shown, factor * shown)
    axes.axhline(0.0, color=FAINT, linewidth=0.6)
    axes.set_title("Highest block: horizontal displacement relative to the base", **HEAD)
    axes.legend(fontsize=10, frameon=False, ncols=min(4, len(runs)), loc="upper left", bbox_to_anchor=(0.0, -0.13))
    plain_axes(axes, f"[{unit}]", "time [s]", "y")


def draw_states(axes: Any, runs: list[Run]) -> None:
    """Joints by state, and lost blocks, side by side."""
    labels = (
        ("only_opened", "joints\nopened"),
        ("only_slid", "joints\nslid"),
        ("opened_and_slid", "opened\nand slid"),
        ("separated", "joints\nseparated"),
        ("hinges", "hinges\nleft"),
        ("lost_blocks", "blocks\nlost"),
    )
    width = 0.8 / len(runs)
    for k, run in enumerate(runs):
        values = [run.damage.parts[-1][key] for key, _ in labels]
        place = np.arange(len(labels)) + (k - (len(runs) - 1) / 2) * width
        bars = axes.bar(place, values, width, **_bar(k))
        if len(runs) <= 6:
            axes.bar_label(bars, fontsize=9, color=INK)
    axes.set_xticks(np.arange(len(labels)), [text for _, text in labels])
    axes.set_title("Damage of the structure", **HEAD)
    axes.yaxis.get_major_locator().set_params(integer=True)
    plain_axes(axes, "number", grid="y")


def _widths(axes: Any, runs: list[Run]) -> None:
    """Cracks left at the end by class of width."""
    width = 0.8 / len(runs)
    bounds = runs[0].damage.width_classes
    for k, run in enumerate(runs):
        keys = [key for key in run.damage.parts[-1] if key.startswith("crack_")]
        values = [run.damage.parts[-1][key] for key in keys]
        axes.bar(np.arange(len(values)) + (k - (len(runs) - 1) / 2) * width, values, width, **_bar(k))
    axes.set_xticks(np.arange(len(bounds)), [f"{1000 * bound:.3g}" for bound in bounds])
    axes.set_title("Crack widths", **HEAD)
    axes.yaxis.get_major_locator().set_params(integer=True)
    plain_axes(axes, "joints", "residual opening of joints, from ... mm to the next class", "y")


def _grades(runs: list[Run]) -> tuple[list[str], np.ndarray]:
    """Parts in the order of their worst grade, and their grade in each run (parts, runs), or a key of WITHOUT_GRADE."""
    found = dict.fromkeys(row["part"] for run in runs for row in run.damage.parts)
    table = {name: [_grade(run, name) for run in runs] for name in found}
    order = sorted(found, key=lambda name: (name != runs[0].damage.parts[-1]["part"], -max(table[name])))[:PARTS]
    return order, np.array([table[name] for name in order])


def _grade(run: Run, part: str) -> int:
    """Number of a part's grade."""
    row = next((row for row in run.damage.parts if row["part"] == part), None)
    return -1 if row is None else NAMES.index(row["grade"]) if row["grade"] != NOT_GRADED else -2


def _grade_table(axes: Any, runs: list[Run], names: list[str], grid: np.ndarray) -> None:
    """A row per part and a column per run, the grade written in and shaded."""
    from matplotlib.patches import Rectangle

    for i in range(len(names)):
        for k in range(len(runs)):
            grade = int(grid[i, k])
            colour, ink = "white", INK
            if grade >= 0:
                colour, ink = GRADES[NAMES[grade]], "white" if NAMES[grade] in DARK else INK
            axes.add_patch(Rectangle((k, i), 1, 1, facecolor=colour, edgecolor="#c9cdd1", linewidth=1.0))
            text = f"{NAMES[grade]}  {_mechanism(runs[k], names[i])}" if grade >= 0 else WITHOUT_GRADE[grade]
            text += ", provisional" if grade >= 0 and runs[k].damage.provisional else ""
            axes.text(k + 0.03, i + 0.5, text, va="center", fontsize=10, color=ink, clip_on=True)
    axes.set_xlim(0, len(runs))
    axes.set_ylim(len(names), 0)
    axes.set_xticks(np.arange(len(runs)) + 0.5, [run.name for run in runs])
    axes.xaxis.tick_top()
    axes.set_yticks(np.arange(len(names)) + 0.5, names)
    axes.tick_params(length=0, labelsize=10, colors=FAINT)
    for side in axes.spines.values():
        side.set_visible(False)
    axes.set_xlabel("grade and mechanism of the structure and its parts; thresholds: those of the first run", fontsize=10, color=FAINT)


def _mechanism(run: Run, part: str) -> str:
    """The mechanism of a part, empty for none."""
    name = next(row["mechanism"] for row in run.damage.parts if row["part"] == part)
    return "" if name == "none" else str(name)
