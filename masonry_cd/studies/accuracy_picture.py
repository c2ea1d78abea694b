# SPDX-License-Identifier: GPL-3.0-or-later
"""Work-precision diagrams: measured error over run time, both logarithmic; lower left is better.

Lines are named at the right, colours are those of Okabe & Ito with a marker each, so that the diagram reads in grey as well. Hollow points
missed their tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.figures import blank
from masonry_cd.studies.accuracy import RunRow, SolverRow
from reports.drawing.figure import COLOURS, FAINT, INK

MARKERS = ("o", "s", "^", "D", "v", "P", "X")
LEAST = 1e-17  # errors of nothing are drawn here
PITCH = 15.0  # of the names of lines [points]

End = tuple[float, float, str, str]  # of a line: time, error, its name and colour


def problem_picture(rows: Sequence[SolverRow], title: str, path: Path) -> None:
    """Draw the solvers on one problem.

    Raises:
        InputError: the file cannot be written.
    """
    figure, (axes,) = _figure(1, f"Error against run time: {title}", "each point a tolerance, from loose to tight along the line")
    names = list(dict.fromkeys(row.solver for row in rows))
    lines = [[row for row in rows if row.solver == name] for name in names]
    for tolerance in sorted({row.tolerance for row in rows}):
        axes.axhline(tolerance, color="#d5d9dd", linewidth=0.8, zorder=0)
    ends = []
    for k, line in enumerate(lines):
        ends.append(_line(axes, k, [row.seconds for row in line], [row.error for row in line], [row.reached for row in line], names[k]))
    _frame(axes, "time of one solve, median [s]", "natural map error (scaled)")
    _label(axes, ends)
    _save(figure, path)


def scene_picture(rows: Sequence[RunRow], title: str, path: Path) -> None:
    """Draw the runs of a scene: displacements and openings against their reference.

    Raises:
        InputError: the file cannot be written.
    """
    reference, runs = rows[0], rows[1:]
    facts = f"each point a time step; reference: dt {1e3 * reference.dt:g} ms, tolerance {_plain(reference.tolerance)}"
    figure, panels = _figure(2, f"Error against run time: {title}", facts)
    keys = list(dict.fromkeys((row.solver, row.tolerance) for row in runs))
    several = len({row.solver for row in runs}) > 1
    for axes, (field, words) in zip(panels, (("displacement_error", "displacement"), ("opening_error", "joint opening")), strict=True):
        ends = []
        for k, key in enumerate(keys):
            line = sorted((row for row in runs if (row.solver, row.tolerance) == key), key=lambda row: -row.dt)
            errors, name = (
                [100.0 * getattr(row, field) for row in line],
                f"{key[0]} {_plain(key[1])}" if several else f"tolerance {_plain(key[1])}",
            )
            ends.append(_line(axes, k, [row.stepping_seconds for row in line], errors, [row.reached for row in line], name))
            if k == len(keys) - 1:
                _steps(axes, line, errors)
        _frame(axes, "stepping time of the run [s]", f"{words} error, relative", percent=True)
        _label(axes, ends)
    _save(figure, path)


def _figure(count: int, title: str, facts: str) -> tuple[Any, Sequence[Any]]:
    """An empty sheet of some panels."""
    figure = blank((3.6 + 5.4 * count, 6.0), 110)
    figure.subplots_adjust(left=0.17 - 0.05 * count, right=0.93 - 0.03 * count, bottom=0.13, top=0.81, wspace=0.52)
    figure.text(0.02, 0.94, title, fontsize=15, fontweight="bold", color=INK, va="center")
    figure.text(0.02, 0.875, f"{facts}; hollow: tolerance missed", fontsize=11, color=FAINT, va="center")
    panels = figure.subplots(1, count, squeeze=False)[0]
    for axes in panels:
        axes.set_xscale("log")
        axes.set_yscale("log")
    return figure, panels


def _line(axes: Any, k: int, seconds: Sequence[float], errors: Sequence[float], reached: Sequence[bool], name: str) -> End:
    """Draw a line of points; return where its name goes, the name and the colour."""
    colour, marker = COLOURS[k % len(COLOURS)], MARKERS[k % len(MARKERS)]
    x, y = np.asarray(seconds, dtype=float), np.maximum(np.asarray(errors, dtype=float), LEAST)
    axes.plot(x, y, color=colour, linewidth=1.8, zorder=3)
    for point in range(len(x)):
        face = colour if reached[point] else "white"
        axes.plot(x[point], y[point], marker, markersize=8, markerfacecolor=face, markeredgecolor=colour, markeredgewidth=1.8, zorder=4)
    return float(x[-1]), float(y[-1]), name, colour


def _steps(axes: Any, line: Sequence[RunRow], errors: Sequence[float]) -> None:
    """Write the time steps to the points of a line."""
    from matplotlib.patheffects import withStroke

    for row, error in zip(line, errors, strict=True):
        axes.annotate(
            f"dt {1e3 * row.dt:g} ms", (row.stepping_seconds, max(error, LEAST)), (5.0, -17.0), textcoords="offset points", fontsize=9.5,
            color=FAINT, ha="right", path_effects=[withStroke(linewidth=3.0, foreground="white")], zorder=5,
        )  # fmt: skip


def _plain(value: float) -> str:
    """A tolerance as people write it: 1e-4."""
    return f"{value:.2g}" if value >= 0.01 else f"{value:.1e}".replace(".0e", "e").replace("e-0", "e-")


def _frame(axes: Any, across: str, up: str, percent: bool = False) -> None:
    """Axis titles, a faint grid, ticks in plain numbers."""
    axes.set_xlabel(across, fontsize=12, color=INK)
    axes.set_ylabel(up, fontsize=12, color=INK)
    _ticks(axes.xaxis, "")
    _ticks(axes.yaxis, " %" if percent else "")
    axes.tick_params(labelsize=11, colors=FAINT, which="both")
    axes.grid(which="major", color="#e8eaed", linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _ticks(axis: Any, unit: str) -> None:
    """Ticks at 1, 2, 5 where the axis is short, else at powers of ten; no more than can be read."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = sorted(axis.get_view_interval())
    if high < 30.0 * low:  # a short axis has two ticks at least
        middle = np.sqrt(low * high)
        low, high = min(low, middle / 3.0), max(high, middle * 3.0)
        (axis.axes.set_xlim if axis.axis_name == "x" else axis.axes.set_ylim)(low, high)
    axis.set_minor_formatter(NullFormatter())
    if high < 300.0 * low:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}{unit}"))
    elif unit:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.6g}{unit}"))


def _label(axes: Any, ends: Sequence[End]) -> None:
    """Write the names of the lines in a column at the right, each led to from its line's end."""
    axes.figure.canvas.draw()
    pitch = PITCH * axes.figure.dpi / 72.0
    order = sorted(range(len(ends)), key=lambda k: (ends[k][1], ends[k][0]))
    own = [float(axes.transData.transform(ends[k][:2])[1]) for k in order]
    places = np.array(own)
    for _ in range(200):  # neighbours push each other apart until all can be read
        for k in range(len(places) - 1):
            lack = pitch - (places[k + 1] - places[k])
            if lack > 0.0:
                places[k] -= lack / 2.0
                places[k + 1] += lack / 2.0
    for k, place in zip(order, places, strict=True):
        x, y, name, colour = ends[k]
        up = float(axes.transAxes.inverted().transform((0.0, place))[1])
        axes.annotate(
            name, (x, y), (1.02, up), textcoords="axes fraction", fontsize=12, fontweight="bold", color=colour, va="center",
            annotation_clip=False, arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 0.8, "linestyle": ":", "shrinkB": 7.0},
        )  # fmt: skip


def _save(figure: Any, path: Path) -> None:
    """Write the PNG."""
    try:
        with replacing(path) as part:
            figure.savefig(part)
    except OSError as error:
        raise InputError(path, f"cannot be written: {error.strerror}") from None
