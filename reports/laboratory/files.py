# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of pushes and gauges in the folder of a run: force_displacement.csv, push_cycles.csv, points.csv, joint_gauges.csv, cracks.csv,
supports.csv, and two plots."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from masonry_cd.analysis.gauge_histories import (
    History,
    crack_histories,
    joint_gauge_histories,
    point_histories,
    support_histories,
)
from masonry_cd.analysis.pushover import push_curves
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from reports.drawing.figure import save
from reports.laboratory.plots import gauges_figure, push_figure

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
CYCLE_COLUMNS = (
    "push", "cycle", "begin", "end", "displacement_max", "displacement_min", "force_max", "force_min", "dissipated", "damping",
)  # fmt: skip


def write_laboratory(results: Results, folder: Path, drawn: bool = True) -> dict[str, Any]:
    """Write the tables and, where they are to be ``drawn``, the plots; return the summary's share, empty of a run without any of them."""
    if not results.gauges.any:
        return {}
    curves = push_curves(results)
    if curves:
        write_csv(folder / CURVES, CURVE_COLUMNS, _curve_rows(curves), digits=10)
    pushes = [curve.numbers() for curve in curves if curve.kind == "push"]
    cycles = [[row["name"], k + 1, *(c[name] for name in CYCLE_COLUMNS[2:])] for row in pushes for k, c in enumerate(row["cycles"])]
    if cycles:
        write_csv(folder / CYCLES, CYCLE_COLUMNS, cycles, digits=10)
    gauges = _histories(results)
    for kind, found in gauges.items():
        head, columns = TABLES[f"{kind}.csv"][0], list(next(iter(found.values())))
        write_csv(folder / f"{kind}.csv", [head, *columns], _history_rows(found), digits=10)
    if drawn and curves:
        save(push_figure([curve for curve in curves if curve.kind == "push"] or curves, title=results.title), folder / CURVE_PLOT)
    if drawn and gauges:
        save(gauges_figure(gauges, results.title), folder / GAUGE_PLOT)
    return {"pushes": pushes} if pushes else {}


def _histories(results: Results) -> dict[str, dict[str, History]]:
    """Histories by kind, ``points`` and so on, and name; those that there are."""
    found = {name.removesuffix(".csv"): read(results) for name, (_, read) in TABLES.items()}
    return {kind: histories for kind, histories in found.items() if histories}


def histories_of(results: Results) -> dict[str, dict[str, History]]:
    """Histories by kind, ``points`` and so on, and name.

    Raises:
        InputError: the run kept none.
    """
    found = _histories(results)
    if not found:
        raise InputError(
            "gauges: the run kept none; [[output.point]], [[output.joint]], [[output.crack]] and [[output.support]] ask for them"
        )
    return found


def _curve_rows(curves: Iterable[Any]) -> Iterable[list[object]]:
    for curve in curves:
        columns = (curve.time, curve.displacement, curve.force, curve.moment, curve.inertia)
        for row in zip(*(values.tolist() for values in columns), strict=True):
            yield [curve.name, *row]


def _history_rows(found: Mapping[str, History]) -> Iterable[list[object]]:
    for name, columns in found.items():
        for row in zip(*(values.tolist() for values in columns.values()), strict=True):
            yield [name, *row]
