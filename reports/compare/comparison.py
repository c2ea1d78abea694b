# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs side by side: what differs between their scenes, and what that did to the structure.

The columns of the table are the runs, its rows:

- the keys of the scenes that are not equal in all runs (``loads[0].amplitude``, ``material.friction``, ``run.seed`` ...),
- the damage of the structure, and the grade of each part that is damaged in any run (:mod:`masonry_cd.analysis.damage.part_damage`),
- the response: largest displacement and drift, and at the highest free block,
- how exact and how much it cost.

Damage is judged by the thresholds of the first run in all of them, or the numbers would not compare.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.analysis.damage.macro_elements import WHOLE
from masonry_cd.analysis.damage.part_damage import PartDamage, Row
from masonry_cd.analysis.outputs import COMPARE, numbers_in, values_in
from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.analysis.verdict import NOT_GRADED
from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import markdown as table
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.figures import blank
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary, read_summary
from masonry_cd.io.summary_tables import SummaryTable
from reports.damage import damage_of, damage_settings
from reports.drawing.figure import COLOURS, FAINT, INK, format_axes, save
from reports.drawing.palette import DARK, GRADES
from reports.drawing.plots import STROKES
from reports.settings import Report, report_of


@dataclass(frozen=True, eq=False)
class ComparedRun:
    """Values of a run for a comparison."""

    name: str
    scene: dict[str, Any]  # keys as the user writes them, e.g. loads[0].amplitude
    damage: PartDamage
    time: np.ndarray  # (F,) [s]
    top: np.ndarray  # (F,) horizontal displacement of the highest free block relative to the base, signed along its largest [m]
    numbers: dict[str, Any]  # of the response, by their keys
    height: float  # of the structure [m]
    summary: Summary


@dataclass(frozen=True, eq=False)
class ComparisonTable:
    """A table: rows of a heading, a unit and one value per run."""

    runs: list[ComparedRun]
    rows: list[tuple[str, str, list[Any]]]
    words: list[str] = field(default_factory=list)  # what is damaged in their results

    @property
    def header(self) -> list[str]:
        """Names of the columns."""
        return ["", "unit", *(run.name for run in self.runs)]


def compare(folders: Sequence[Path], names: Sequence[str] | None = None) -> ComparisonTable:
    """Compare the runs in some folders, called by names, or else by the shortest ends of their paths.

    Raises:
        InputError: fewer than two folders, one given twice, or one that holds no run.
    """
    if len(folders) < 2:
        raise InputError("compare", "give at least two folders of runs")
    twice = [folder for k, folder in enumerate(folders) if folder.resolve() in [other.resolve() for other in folders[:k]]]
    if twice:
        raise InputError("compare", f"{twice[0]} is named twice")
    settings: Report | None = None
    runs: list[ComparedRun] = []
    words: list[str] = []
    for folder, name in zip(folders, names or _names(folders), strict=True):
        with Results.open(folder / "result.h5") as results:
            settings = settings or report_of(results.tables)
            runs.append(_run(results, folder, name, settings))
            words += results.words
            if (whole := runs[-1].damage.parts[-1])["grade"] == NOT_GRADED:
                words.append(f"{name}: {NOT_GRADED}: {whole['grade_reason']}")
            if end := runs[-1].damage.provisional:
                words.append(f"{name}: grades, mechanisms and residual values are {end}")
    response = [(number.name, number.unit, [run.numbers[key] for run in runs]) for key, number in numbers_in(COMPARE).items()]
    rows = [*_scene_rows(runs), *_damage_rows(runs), *_part_rows(runs), *response, *_solver_rows(runs)]
    return ComparisonTable(runs, rows, words)


def _run(results: Results, folder: Path, name: str, settings: Report) -> ComparedRun:
    """Read what is compared."""
    run = Measured(results, damage_settings(settings), known=damage_of(results, settings))
    solids = run.solids
    return ComparedRun(
        name=name,
        scene=flat(results.tables),
        damage=run.damage,
        time=results.time,
        top=run.top,
        numbers=values_in(COMPARE, run),
        height=float(np.ptp(solids.vertices[~solids.fixed[solids.vertex_block], 2])),
        summary=read_summary(folder) or Summary(),
    )


def flat(table: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Nested tables by the keys that a user writes."""
    out: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            out |= flat(value, f"{before}{key}.")
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            for k, item in enumerate(value):
                out |= flat(item, f"{before}{key}[{k}].")
        else:
            out[before + key] = value
    return out


def _names(folders: Sequence[Path]) -> list[str]:
    """The shortest ends of the folders' paths that tell them apart."""
    parts = [folder.resolve().parts for folder in folders]
    for depth in range(1, max(map(len, parts)) + 1):
        names = ["/".join(part[-depth:]) for part in parts]
        if len(set(names)) == len(names):
            return names
    return [str(folder) for folder in folders]


def _scene_rows(runs: Sequence[ComparedRun]) -> list[tuple[str, str, list[Any]]]:
    """The keys that differ; titles last, since they are long."""
    keys = dict.fromkeys(key for run in runs for key in run.scene)
    rows = []
    for key in sorted(keys, key=lambda key: key == "title"):
        values = [run.scene.get(key) for run in runs]
        if any(value != values[0] for value in values):
            rows.append((key, "", values))
    return rows


def _damage_rows(runs: Sequence[ComparedRun]) -> list[tuple[str, str, list[Any]]]:
    """The structure as a whole."""
    whole = [run.damage.parts[-1] for run in runs]
    rows = [
        ("grade", "", "grade"),
        ("grade given by", "", "grade_reason"),
        ("provisional", "", "provisional"),
        ("mechanism", "", "mechanism"),
        ("joints opened", "", "only_opened"),
        ("joints slid", "", "only_slid"),
        ("joints opened and slid", "", "opened_and_slid"),
        ("joints separated", "", "separated"),
        ("first opening", "s", "first_opening_time"),
        ("hinges, ever", "", "hinges_ever"),
        ("hinges, left", "", "hinges"),
        ("largest opening", "m", "max_opening"),
        ("residual opening", "m", "residual_opening"),
        ("largest sliding", "m", "max_sliding"),
        ("residual sliding", "m", "residual_sliding"),
        ("lost blocks", "", "lost_blocks"),
        ("lost volume", "share", "lost_share"),
    ]
    return [(name, unit, [row[key] for row in whole]) for name, unit, key in rows]


def _part_rows(runs: Sequence[ComparedRun]) -> list[tuple[str, str, list[Any]]]:
    """The parts that are damaged in any run."""
    names = dict.fromkeys(row["part"] for run in runs for row in run.damage.parts if row["part"] != WHOLE)
    rows = []
    for name in names:
        found = [next((row for row in run.damage.parts if row["part"] == name), None) for run in runs]
        if any(row is not None and row["grade"] not in ("D0", NOT_GRADED) for row in found):
            rows.append((f"part {name}", "", [f"{row['grade']} {row['mechanism']}" if row else None for row in found]))
    return rows


def _solver_rows(runs: Sequence[ComparedRun]) -> list[tuple[str, str, list[Any]]]:
    """From summary.json, which a run that was killed has not written."""
    found = [run.summary for run in runs]
    columns: tuple[tuple[str, str, list[SummaryTable], str], ...] = (
        ("solver", "", [one.solver for one in found], "name"),
        ("largest error", "", [one.solver for one in found], "error_max"),
        ("steps missed", "", [one.solver for one in found], "steps_missed"),
        ("energy balance", "share", [one.energy for one in found], "balance_error"),
        ("stepping", "s", [*found], "stepping_seconds"),
    )
    return [(name, unit, [getattr(one, key) if one.has(key) else None for one in tables]) for name, unit, tables, key in columns]


MISSING = "–"


def write_comparison(comparison: ComparisonTable, folder: Path) -> list[Path]:
    """Write comparison.csv, comparison.md and comparison.png into a folder, which is created if missing."""
    paths = [folder / f"comparison.{ending}" for ending in ("csv", "md", "png")]
    own_files.begin(folder, [path.name for path in paths])
    exact = ([*row[:2], *(v if v is None or isinstance(v, float) else str(v) for v in row[2])] for row in comparison.rows)
    write_csv(paths[0], comparison.header, exact, digits=9)
    with replacing(paths[1]) as part:
        part.write_text(markdown(comparison), encoding="utf-8")
    save(comparison_figure(comparison), paths[2])
    return paths


def markdown(comparison: ComparisonTable) -> str:
    """The table in Markdown, its columns aligned so that it reads well as plain text; lengths in millimetres."""
    cells = [comparison.header]
    for name, unit, values in comparison.rows:
        cells.append([name, "mm", *map(_millimetres, values)] if unit == "m" else [name, unit, *map(_short, values)])
    return table(cells)


def _short(value: Any) -> str:
    """A cell for reading: three digits."""
    if value is None or (isinstance(value, float) and np.isnan(value)):
        return MISSING
    if isinstance(value, (float, np.floating)):
        return f"{value:.3g}"
    return str(value)


def _millimetres(value: float | None) -> str:
    """A cell of a length [m] for reading; what is below a micrometre is as good as nothing, as on the page."""
    if value is None or np.isnan(value):
        return MISSING
    if 0.0 < abs(value) < 1e-6:
        return "<0.001"
    return f"{1e3 * value:.0f}" if abs(value) >= 1.0 else f"{1e3 * value:.3g}"


HATCHES = ("", "///", "...", "xxx")
SHOWN = 0.1  # displacements up to this share of the height are shown
HEAD: dict[str, Any] = {"loc": "left", "fontsize": 13, "fontweight": "bold", "color": INK}
PARTS = 30  # shown at most


def comparison_figure(comparison: ComparisonTable) -> Any:
    """A comparison as a figure of matplotlib."""
    runs = comparison.runs
    parts = _rows_by_part(runs)
    tall = 7.6 + max(1.6, 0.32 * len(parts) + 1.0)
    figure = blank((13.0, tall), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.2, h_pad=0.15)
    rows = figure.add_gridspec(3, 2, height_ratios=(3.6, 3.4, tall - 7.6))
    _draw_response(figure.add_subplot(rows[0, :]), runs)
    draw_states(figure.add_subplot(rows[1, 0]), runs)
    _draw_widths(figure.add_subplot(rows[1, 1]), runs)
    _draw_grades(figure.add_subplot(rows[2, :]), runs, parts)
    return figure


def _draw_response(axes: Any, runs: list[ComparedRun]) -> None:
    """Displacement of the highest block over time."""
    reach = max(float(np.abs(run.top).max()) for run in runs)
    shown = min(1.1 * reach, SHOWN * max(run.height for run in runs))  # a fallen block must not flatten the others to a line
    factor, unit = (1000.0, "mm") if shown < 0.5 else (1.0, "m")
    for k, run in enumerate(runs):
        left = " (left the picture)" if np.abs(run.top).max() > shown else ""
        look = {"color": COLOURS[k % len(COLOURS)], "linestyle": STROKES[(k // len(COLOURS) + k) % len(STROKES)]}
        axes.plot(run.time, factor * run.top, label=run.name + left, linewidth=1.8, **look)
    if reach > shown:
        axes.set_ylim(-factor * shown, factor * shown)
    axes.axhline(0.0, color=FAINT, linewidth=0.6)
    axes.set_title("Highest block: horizontal displacement relative to the base", **HEAD)
    axes.legend(fontsize=10, frameon=False, ncols=min(4, len(runs)), loc="upper left", bbox_to_anchor=(0.0, -0.13))
    format_axes(axes, f"[{unit}]", "time [s]", "y")


def draw_states(axes: Any, runs: list[ComparedRun]) -> None:
    """Joints by state, and lost blocks, side by side."""
    labels = {
        "only_opened": "joints\nopened",
        "only_slid": "joints\nslid",
        "opened_and_slid": "opened\nand slid",
        "separated": "joints\nseparated",
        "hinges": "hinges\nleft",
        "lost_blocks": "blocks\nlost",
    }
    for bars in _bars(axes, runs, labels, "Damage of the structure") if len(runs) <= 6 else ():
        axes.bar_label(bars, fontsize=9, color=INK)
    format_axes(axes, "number", grid="y")


def _draw_widths(axes: Any, runs: list[ComparedRun]) -> None:
    """Cracks left at the end by class of width."""
    keys = [key for key in runs[0].damage.parts[-1] if key.startswith("crack_")]
    bounds = [f"{1000 * bound:.3g}" for bound in runs[0].damage.width_classes]
    _bars(axes, runs, dict(zip(keys, bounds, strict=True)), "Crack widths")
    format_axes(axes, "joints", "residual opening of joints, from ... mm to the next class", "y")


def _bars(axes: Any, runs: list[ComparedRun], labels: Mapping[str, str], title: str) -> list[Any]:
    """Numbers of the structure, by their keys with labels, side by side for all runs."""
    width, place = 0.8 / len(runs), np.arange(len(labels))
    bars = []
    for k, run in enumerate(runs):
        look = {"color": COLOURS[k % len(COLOURS)], "hatch": HATCHES[k % len(HATCHES)], "edgecolor": "white", "linewidth": 0.5}
        values = [run.damage.parts[-1][key] for key in labels]
        bars.append(axes.bar(place + (k - (len(runs) - 1) / 2) * width, values, width, **look))
    axes.set_xticks(place, list(labels.values()))
    axes.set_title(title, **HEAD)
    axes.yaxis.get_major_locator().set_params(integer=True)
    return bars


def _rows_by_part(runs: list[ComparedRun]) -> dict[str, list[Row | None]]:
    """The rows of the damage by part, the structure first, then from the worst grade on; None where a run has no such part."""
    named = [{row["part"]: row for row in run.damage.parts} for run in runs]
    found = {part: [rows.get(part) for rows in named] for part in dict.fromkeys(part for rows in named for part in rows)}
    whole = runs[0].damage.parts[-1]["part"]
    worst = {part: max(_rank(row) for row in rows) for part, rows in found.items()}
    return {part: found[part] for part in sorted(found, key=lambda part: (part != whole, -worst[part]))[:PARTS]}


def _rank(row: Row | None) -> int:
    """Number of a part's grade; -1 where there is none."""
    return NAMES.index(row["grade"]) if row and row["grade"] in NAMES else -1


def _draw_grades(axes: Any, runs: list[ComparedRun], parts: Mapping[str, list[Row | None]]) -> None:
    """A row per part and a column per run, the grade written in and shaded."""
    from matplotlib.patches import Rectangle

    for i, rows in enumerate(parts.values()):
        for k, row in enumerate(rows):
            grade = row["grade"] if row else ""
            axes.add_patch(Rectangle((k, i), 1, 1, facecolor=GRADES.get(grade, "white"), edgecolor="#c9cdd1", linewidth=1.0))
            text = f"{grade}  {row['mechanism'].removeprefix('none')}" if row and grade in NAMES else grade or "no such part"
            text += ", provisional" if grade in NAMES and runs[k].damage.provisional else ""
            axes.text(k + 0.03, i + 0.5, text, va="center", fontsize=10, color="white" if grade in DARK else INK, clip_on=True)
    axes.set_xlim(0, len(runs))
    axes.set_ylim(len(parts), 0)
    axes.set_xticks(np.arange(len(runs)) + 0.5, [run.name for run in runs])
    axes.xaxis.tick_top()
    axes.set_yticks(np.arange(len(parts)) + 0.5, list(parts))
    axes.tick_params(length=0, labelsize=10, colors=FAINT)
    for side in axes.spines.values():
        side.set_visible(False)
    axes.set_xlabel("grade and mechanism of the structure and its parts; thresholds: those of the first run", fontsize=10, color=FAINT)
