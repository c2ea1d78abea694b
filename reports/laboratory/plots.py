# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots of pushes and gauges: curves laid over each other with a measured one beside, and histories."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.gauge_histories import History, unit_of_column
from masonry_cd.analysis.pushover import PushCurve
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import finite_number
from reports.drawing.figure import COLOURS, FAINT, INK, blank, plain_axes

POINTS = 4000  # of a curve that are drawn
SHOWN = {"points": ("ux", "uy", "uz"), "joint_gauges": ("opening", "sliding", "normal_force", "depth"), "cracks": ("opening", "slip")}
WORDS = {"points": "displacement", "joint_gauges": "joint", "cracks": "crack gauge", "supports": "reaction"}
MEASURED = (("displacement", "displacement [m]", "u", "d"), ("force", "force [N]", "f", "v"))  # heads of columns, without regard to case

FEW = 8  # points up to which a computed curve is shown by them
INSIDE = 5  # curves at most whose legend goes into the plot

Curve = tuple[str, np.ndarray, np.ndarray]  # name, displacement [m], force [N]


def curves_figure(curves: Sequence[Curve], measured: Sequence[Curve] = (), title: str = "", size: tuple[float, float] = (7.0, 4.6)) -> Any:
    """Curves of force against displacement; measured ones in grey, with points."""
    figure = blank(size, layout="constrained")
    axes = figure.add_subplot()
    for name, u, f in measured:
        axes.plot(1e3 * u, 1e-3 * f, color=FAINT, lw=1.2, marker="o", ms=3.0, label=name)
    for k, (name, u, f) in enumerate(curves):
        every = max(1, len(u) // POINTS)
        axes.plot(1e3 * u[::every], 1e-3 * f[::every], color=COLOURS[k % len(COLOURS)], lw=1.3, label=name)
    plain_axes(axes, "force [kN]", "displacement [mm]")
    axes.axhline(0.0, color=FAINT, lw=0.6)
    if len(curves) + len(measured) > 1:
        axes.legend(frameon=False, fontsize=8)
    if title:
        axes.set_title(title, color=INK, fontsize=11, loc="left")
    return figure


def beside_figure(
    computed: Sequence[Curve], others: Sequence[Curve], labels: tuple[str, str], title: str, points: Sequence[Curve] = ()
) -> Any:
    """Curves over any axis, those that were measured or come from others, and points of these with no line between.

    As many sets of points as computed curves are taken for theirs, in their order, and have their colours.
    """
    figure = blank((7.0, 4.2), layout="constrained")
    axes = figure.add_subplot()
    for k, (name, x, y) in enumerate([*others, *points]):
        look = {"marker": "os^vD<>"[k % 7], "ms": 4.0, "markevery": max(1, len(x) // 12)}
        of_curve = k - len(others) if len(points) == len(computed) else -1  # points that belong to curves have their colours
        colour = COLOURS[of_curve % len(COLOURS)] if of_curve >= 0 else FAINT
        axes.plot(x, y, color=colour, lw=1.0, ls="--" if k < len(others) and len(x) > 1 else "none", label=name, **look)
    for k, (name, x, y) in enumerate(computed):
        marker, line = ("x", "none") if len(x) <= FEW else ("", "-")
        axes.plot(x, y, color=COLOURS[k % len(COLOURS)], lw=1.4, label=name, marker=marker, ls=line)
    plain_axes(axes, labels[1], labels[0])
    axes.set_title(title, color=INK, fontsize=11, loc="left")
    if len(computed) + len(others) + len(points) > INSIDE:
        figure.legend(frameon=False, fontsize=7, loc="outside right upper")
    else:
        axes.legend(frameon=False, fontsize=7)
    return figure


def push_figure(curves: Sequence[PushCurve], measured: Sequence[Curve] = (), title: str = "") -> Any:
    """The pushes of a run, means over short windows."""
    return curves_figure([(curve.name, *curve.means[:2]) for curve in curves], measured, title)


def gauges_figure(gauges: Mapping[str, Mapping[str, History]], title: str = "") -> Any:
    """Histories by kind and name."""
    rows = [(kind, column) for kind, found in gauges.items() for column in _shown(kind, found)]
    figure = blank((8.0, 0.8 + 1.7 * len(rows)), layout="constrained")
    grid = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (kind, column) in zip(grid, rows, strict=True):
        for k, (name, columns) in enumerate(gauges[kind].items()):
            every = max(1, len(columns["time"]) // POINTS)
            axes.plot(columns["time"][::every], columns[column][::every], color=COLOURS[k % len(COLOURS)], lw=1.0, label=name)
        plain_axes(axes, f"{column}\n[{unit_of_column(column)}]", "time [s]" if axes is grid[-1] else "")
        axes.legend(frameon=False, fontsize=7, loc="upper right", title=WORDS[kind], title_fontsize=7)
    if title:
        figure.suptitle(title, color=INK, fontsize=11, x=0.01, ha="left")
    return figure


def _shown(kind: str, found: Mapping[str, History]) -> list[str]:
    """The columns that are drawn: those that are not zero throughout."""
    names = SHOWN.get(kind, ("fx", "fy", "fz"))
    size = max(float(np.abs(columns[name]).max(initial=0.0)) for columns in found.values() for name in names)
    return [name for name in names if any(np.abs(columns[name]).max(initial=0.0) > 1e-9 * size for columns in found.values())] or [names[0]]


def read_measured(path: Path) -> list[Curve]:
    """A measured curve of a CSV file: columns of displacement [m] and force [N], by name or as the first two.

    Raises:
        InputError: no such file, or no two columns of numbers; names file and line.
    """
    try:
        rows = list(csv.reader(path.read_text(encoding="utf-8-sig").splitlines()))
    except (OSError, UnicodeDecodeError) as reason:
        raise InputError(f"{path}: no measured curve can be read: {' '.join(str(reason).split())}") from None
    head = [cell.strip().lower() for cell in rows[0]] if rows and not all(finite_number(cell) is not None for cell in rows[0]) else []
    places = [next((head.index(name) for name in names if name in head), k) for k, names in enumerate(MEASURED)]
    values: list[list[float]] = []
    for number, row in enumerate(rows[1 if head else 0 :], 2 if head else 1):
        if not any(cell.strip() for cell in row):
            continue
        found = [finite_number(row[place]) if place < len(row) else None for place in places]
        if None in found:
            raise InputError(f"{path}:{number}: displacement [m] and force [N] are expected, two numbers")
        values.append([float(value or 0.0) for value in found])
    if not values:
        raise InputError(f"{path}: no measured curve: no line with two numbers")
    table = np.array(values)
    return [(path.stem, table[:, 0], table[:, 1])]
