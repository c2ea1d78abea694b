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

from masonry_cd.analysis.damage.macro_elements import WHOLE
from masonry_cd.analysis.damage.part_damage import PartDamage
from masonry_cd.analysis.outputs import COMPARE, numbers_in, values_in
from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.analysis.verdict import NOT_GRADED
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary, read_summary
from masonry_cd.io.summary_tables import SummaryTable
from reports.damage import damage_of, damage_settings
from reports.settings import Report, report_of


@dataclass(frozen=True, eq=False)
class Run:
    """What a comparison takes from a run."""

    name: str
    scene: dict[str, Any]  # keys as the user writes them, e.g. loads[0].amplitude
    damage: PartDamage
    time: np.ndarray  # (F,) [s]
    top: np.ndarray  # (F,) horizontal displacement of the highest free block relative to the base, signed along its largest [m]
    numbers: dict[str, Any]  # of the response, by their keys
    height: float  # of the structure [m]
    summary: Summary


@dataclass(frozen=True, eq=False)
class Comparison:
    """A table: rows of a heading, a unit and one value per run."""

    runs: list[Run]
    rows: list[tuple[str, str, list[Any]]]
    words: list[str] = field(default_factory=list)  # what is damaged in their results

    @property
    def header(self) -> list[str]:
        """Names of the columns."""
        return ["", "unit", *(run.name for run in self.runs)]


def compare(folders: Sequence[Path], names: Sequence[str] | None = None) -> Comparison:
    """Compare the runs in some folders, called by names, or else by the shortest ends of their paths.

    Raises:
        InputError: fewer than two folders, one given twice, or one that holds no run.
    """
    if len(folders) < 2:
        raise InputError("compare", "name two folders of runs at least")
    twice = [folder for k, folder in enumerate(folders) if folder.resolve() in [other.resolve() for other in folders[:k]]]
    if twice:
        raise InputError("compare", f"{twice[0]} is named twice")
    settings: Report | None = None
    runs: list[Run] = []
    words: list[str] = []
    for folder, name in zip(folders, names or _names(folders), strict=True):
        with Results.open(folder / "result.h5") as results:
            settings = settings or report_of(results.tables)
            runs.append(_run(results, folder, name, settings))
            words += results.words
            if (whole := runs[-1].damage.parts[-1])["grade"] == NOT_GRADED:
                words.append(f"{name}: {NOT_GRADED}: {whole['grade_reason']}")
            if end := runs[-1].damage.provisional:
                words.append(f"{name}: grades, mechanisms and what is left are {end}")
    response = [(number.name, number.unit, [run.numbers[key] for run in runs]) for key, number in numbers_in(COMPARE).items()]
    rows = [*_scene_rows(runs), *_damage_rows(runs), *_part_rows(runs), *response, *_solver_rows(runs)]
    return Comparison(runs, rows, words)


def _run(results: Results, folder: Path, name: str, settings: Report) -> Run:
    """Read what is compared."""
    run = Measured(results, damage_settings(settings), known=damage_of(results, settings))
    solids = run.solids
    return Run(
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


def _scene_rows(runs: Sequence[Run]) -> list[tuple[str, str, list[Any]]]:
    """The keys that differ; titles last, since they are long."""
    keys = dict.fromkeys(key for run in runs for key in run.scene)
    rows = []
    for key in sorted(keys, key=lambda key: key == "title"):
        values = [run.scene.get(key) for run in runs]
        if any(value != values[0] for value in values):
            rows.append((key, "", values))
    return rows


def _damage_rows(runs: Sequence[Run]) -> list[tuple[str, str, list[Any]]]:
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


def _part_rows(runs: Sequence[Run]) -> list[tuple[str, str, list[Any]]]:
    """The parts that are damaged in any run."""
    names = dict.fromkeys(row["part"] for run in runs for row in run.damage.parts if row["part"] != WHOLE)
    rows = []
    for name in names:
        found = [next((row for row in run.damage.parts if row["part"] == name), None) for run in runs]
        if any(row is not None and row["grade"] not in ("D0", NOT_GRADED) for row in found):
            rows.append((f"part {name}", "", [f"{row['grade']} {row['mechanism']}" if row else None for row in found]))
    return rows


def _solver_rows(runs: Sequence[Run]) -> list[tuple[str, str, list[Any]]]:
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
