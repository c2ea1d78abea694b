# SPDX-License-Identifier: GPL-3.0-or-later
"""Results of a test as a laboratory gives them: curves of force against displacement and histories of gauges, as tables and plots."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.gauge_histories import (
    History,
    crack_histories,
    joint_gauge_histories,
    point_histories,
    support_histories,
    unit_of_column,
)
from masonry_cd.analysis.pushover import PushCurve, push_curves
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.errors import InputError, in_a_line
from masonry_cd.foundation.fields import finite_number
from masonry_cd.foundation.figures import blank
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.io.summary_tables import Cycle
from reports.drawing.figure import COLOURS, FAINT, INK, format_axes, save

CURVES, CYCLES = "force_displacement.csv", "push_cycles.csv"
CURVE_PLOT, GAUGE_PLOT = "force_displacement.png", "gauges.png"
TABLES = {
    "points.csv": ("point", point_histories),
    "joint_gauges.csv": ("joint", joint_gauge_histories),
    "cracks.csv": ("crack", crack_histories),
    "supports.csv": ("support", support_histories),
}
FILES = (CURVES, CYCLES, *TABLES, CURVE_PLOT, GAUGE_PLOT)
CURVE_COLUMNS = ("push", "time", "displacement", "force", "moment", "inertia")
FORCES = (("displacement [mm]", 1e3), ("force [kN]", 1e-3))
POINTS = 4000  # of a curve that are drawn
SHOWN = {"points": ("ux", "uy", "uz"), "joint_gauges": ("opening", "sliding", "normal_force", "depth"), "cracks": ("opening", "slip")}
WORDS = {"points": "displacement", "joint_gauges": "joint", "cracks": "crack gauge", "supports": "reaction"}
MEASURED = (("displacement", "displacement [m]", "u", "d"), ("force", "force [N]", "f", "v"))  # heads of columns, without regard to case
FEW = 8  # points up to which a computed curve is shown by them
INSIDE = 5  # curves at most whose legend goes into the plot

Curve = tuple[str, np.ndarray, np.ndarray]  # name, displacement [m], force [N]


def write_laboratory(results: Results, folder: Path, pictures: bool = True) -> Summary:
    """Write the tables and, with ``pictures``, the plots; return the summary's share, nothing of a run without pushes."""
    if not results.gauges.any:
        return Summary()
    curves = push_curves(results)
    if curves:
        of_curves = [(curve.name, {name: getattr(curve, name) for name in CURVE_COLUMNS[1:]}) for curve in curves]
        write_csv(folder / CURVES, CURVE_COLUMNS, _rows(of_curves), digits=10)
    pushes = tuple(curve.numbers() for curve in curves if curve.kind == "push")
    columns = tuple(Cycle.model_fields)
    cycles = [[push.name, k, *(getattr(cycle, name) for name in columns)] for push in pushes for k, cycle in enumerate(push.cycles, 1)]
    if cycles:
        write_csv(folder / CYCLES, ("push", "cycle", *columns), cycles, digits=10)
    gauges = histories_of(results, asked=False)
    for kind, found in gauges.items():
        write_csv(folder / f"{kind}.csv", [TABLES[f"{kind}.csv"][0], *next(iter(found.values()))], _rows(found.items()), digits=10)
    if curves and pictures:
        save(push_figure([curve for curve in curves if curve.kind == "push"] or curves, title=results.title), folder / CURVE_PLOT)
    if gauges and pictures:
        save(gauges_figure(gauges, results.title), folder / GAUGE_PLOT)
    return Summary(pushes=pushes) if pushes else Summary()


def histories_of(results: Results, asked: bool = True) -> dict[str, dict[str, History]]:
    """Histories by kind, ``points`` and so on, and name; those that there are.

    Raises:
        InputError: they are ``asked`` for, and the run recorded none.
    """
    kinds = {name.removesuffix(".csv"): read(results) for name, (_, read) in TABLES.items()}
    found = {kind: histories for kind, histories in kinds.items() if histories}
    if asked and not found:
        words = "[[output.point]], [[output.joint]], [[output.crack]] or [[output.support]]"
        raise InputError("gauges", f"the run recorded no gauges; add {words} to its scene and run it again")
    return found


def _rows(found: Iterable[tuple[str, History]]) -> Iterable[list[object]]:
    """The rows of a table, of columns of some names."""
    for name, columns in found:
        for row in zip(*(values.tolist() for values in columns.values()), strict=True):
            yield [name, *row]


def curves_figure(
    curves: Sequence[Curve],
    measured: Sequence[Curve] = (),
    title: str = "",
    axes_of: tuple[tuple[str, float], tuple[str, float]] = FORCES,
    points: Sequence[Curve] = (),
) -> Any:
    """Curves over each other, those that were measured or come from others in grey, and points of these with no line between.

    ``axes_of`` are what the axes are called, and the factors into their units. As many sets of points as curves are taken for
    theirs, in their order, and have their colours.
    """
    figure = blank((7.0, 4.4), layout="constrained")
    axes = figure.add_subplot()
    (across, along_x), (up, along_y) = axes_of
    for k, (name, x, y) in enumerate([*measured, *points]):
        own = k - len(measured) if len(points) == len(curves) else -1
        colour = COLOURS[own % len(COLOURS)] if own >= 0 else FAINT
        look = {"marker": "os^vD<>"[k % 7], "ms": 4.0, "markevery": max(1, len(x) // 12), "color": colour, "lw": 1.0, "label": name}
        axes.plot(along_x * x, along_y * y, ls="--" if k < len(measured) and len(x) > 1 else "none", **look)
    for k, (name, x, y) in enumerate(curves):
        every, few = max(1, len(x) // POINTS), len(x) <= FEW
        look = {"marker": "x" if few else "", "ls": "none" if few else "-", "color": COLOURS[k % len(COLOURS)], "lw": 1.3, "label": name}
        axes.plot(along_x * x[::every], along_y * y[::every], **look)
    format_axes(axes, up, across)
    axes.axhline(0.0, color=FAINT, lw=0.6)
    count = len(curves) + len(measured) + len(points)
    if count > 1:
        (figure if count > INSIDE else axes).legend(frameon=False, fontsize=8, loc="outside right upper" if count > INSIDE else "best")
    axes.set_title(title, color=INK, fontsize=11, loc="left")
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
        format_axes(axes, f"{column}\n[{unit_of_column(column)}]", "time [s]" if axes is grid[-1] else "")
        axes.ticklabel_format(axis="y", useOffset=False)
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
        raise InputError(path, f"the measured curve cannot be read: {in_a_line(reason)}") from None
    head = [cell.strip().lower() for cell in rows[0]] if rows and not all(finite_number(cell) is not None for cell in rows[0]) else []
    places = [next((head.index(name) for name in names if name in head), k) for k, names in enumerate(MEASURED)]
    values: list[list[float]] = []
    for number, row in enumerate(rows[1 if head else 0 :], 2 if head else 1):
        if not any(cell.strip() for cell in row):
            continue
        found = [finite_number(row[place]) if place < len(row) else None for place in places]
        if None in found:
            raise InputError(f"{path}:{number}", "the line must have two numbers, displacement [m] and force [N]")
        values.append([float(value or 0.0) for value in found])
    if not values:
        raise InputError(path, "has no measured curve: no line has two numbers")
    table = np.array(values)
    return [(path.stem, table[:, 0], table[:, 1])]
