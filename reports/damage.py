# SPDX-License-Identifier: GPL-3.0-or-later
"""The damage of a run in files: CSV tables for spreadsheets, and one JSON file with the same numbers.

joints.csv           one row per joint
damage.csv           one row per part and, last, the structure: the end of the run
damage_history.csv   one row per frame and part
hinges.csv           one row per joint that was a hinge at any time
drift.csv            one row per part and level
damage_shocks.csv    the rows of damage.csv after each shock of a sequence and its rest; for such runs only
damage.json          all but the joints, with the thresholds, rules and grades that made them
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.damage.grades import NAMES, read_grades
from masonry_cd.analysis.damage.joint_damage import JointDamage
from masonry_cd.analysis.damage.part_damage import DamageSettings, PartDamage, Row, part_damage
from masonry_cd.analysis.outputs.measured import Measured, damage_numbers
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from reports.settings import Report
from reports.ties import write_ties


def thresholds_of(settings: Report) -> Thresholds:
    """Return the thresholds of damage."""
    return Thresholds(opened=settings.opened, slid=settings.slid)


def damage_settings(settings: Report) -> DamageSettings:
    """Return the thresholds of damage, and those of the grades."""
    return DamageSettings(thresholds=thresholds_of(settings), grades=read_grades(settings.grades))


def damage_of(results: Results, settings: Report) -> PartDamage:
    """The damage by part."""
    return part_damage(results, damage_settings(settings))


def write_joint_damage(results: Results, folder: Path, settings: Report) -> Summary:
    """Write joints.csv, and ties.csv where there are ties; return the numbers of damage for the summary, see :func:`damage_numbers`."""
    run, end = Measured(results, damage_settings(settings)), end_state(results, thresholds_of(settings))
    write_joints_csv(run.table, folder / "joints.csv", end.provisional)
    write_ties(results, folder)
    return damage_numbers(run, end)


def write_joints_csv(table: JointDamage, path: Path, provisional: str = "") -> None:
    """Write one row per joint; the columns are the fields of :class:`JointDamage`, an unknown time is left empty.

    What the run has recorded of the laws of joints has columns behind these, and ``provisional``, why residual values are not the last, of
    runs that did not end at rest.
    """
    own = {item.name: getattr(table, item.name) for item in fields(table) if item.name not in ("both", "of_laws")}
    columns, cells = [*own, *table.of_laws], [values.tolist() for values in (*own.values(), *table.of_laws.values())]
    if provisional:
        columns, cells = [*columns, "provisional"], [*cells, [provisional] * len(table.joint)]
    write_csv(path, columns, zip(*cells, strict=True), digits=9)


NAMES_OF_FILES = ("damage.csv", "damage_history.csv", "hinges.csv", "drift.csv", "damage.json")
BY_SHOCK = "damage_shocks.csv"
DIGITS = 9
NOTE = (
    "A part is a group of blocks. A joint between two parts belongs to both, so the parts add up to more than the structure, which "
    "counts each joint once. opened, slid and separated: states that a joint reached at any time, as in joints.csv; open, slipped, apart, "
    "hinges and residual values: the state at the end, between blocks that have not fallen. SI units. "
)
OF_STEPS = "Largest values, and the hinges of a run, are over all time steps."
OF_FRAMES = (
    "Largest openings and slidings are over all time steps; largest drifts and displacements, and the hinges of a run, are over the frames "
    "only (see history_frames), because the result file holds no others."
)


def write_part_damage(damage: PartDamage, folder: Path) -> tuple[Path, ...]:
    """Write all tables into a folder; return their paths."""
    paths = tuple(folder / name for name in NAMES_OF_FILES)
    empty: dict[str, Sequence[str]] = {"hinges.csv": HINGE_COLUMNS}
    for path, rows in zip(paths, (damage.parts, damage.history, damage.hinges, damage.levels), strict=False):
        write_csv(path, rows[0] if rows else empty.get(path.name, ()), (row.values() for row in rows), DIGITS)
    with replacing(paths[-1]) as part:
        part.write_text(json.dumps(as_json(damage), indent=1) + "\n", encoding="utf-8")
    if not damage.shocks:
        return paths
    write_csv(folder / BY_SHOCK, damage.shocks[0], (row.values() for row in damage.shocks), DIGITS)
    return *paths, folder / BY_SHOCK


HINGE_COLUMNS = ("joint", "block_a", "block_b", "parts", "x", "y", "z", "touches_towards", "opening", "time", "residual_opening", "at_end")


def as_json(damage: PartDamage) -> dict[str, Any]:
    """The tables as one JSON document, numbers with as many digits as in the CSV files, unknown ones null."""
    settings = damage.settings
    grades = settings.grades
    bounds = {name: dict(zip(NAMES[1:], getattr(grades, name), strict=True)) for name in ("width", "drift", "lost")}
    return _plain(
        {
            "title": damage.title,
            "time": damage.time,
            "provisional": damage.provisional,
            "note": NOTE + (OF_STEPS if damage.of_steps else OF_FRAMES),
            "history_frames": len({row["time"] for row in damage.history}),
            "thresholds": asdict(settings.thresholds),
            "rules": asdict(settings.rules),
            "grades": {"labels": dict(zip(NAMES, grades.labels, strict=True)), "reached_from": bounds},
            "crack_classes": damage.width_classes,
            "parts": damage.parts,
            "shocks": damage.shocks,
            "hinges": damage.hinges,
            "levels": damage.levels,
            "history": _by_part(damage.history),
        }
    )


def _by_part(history: Sequence[Row]) -> dict[str, Any]:
    """The history as columns by part: shorter, and what a plot wants."""
    out: dict[str, Any] = {"time": list(dict.fromkeys(row["time"] for row in history)), "parts": {}}
    for row in history:
        columns = out["parts"].setdefault(row["part"], {key: [] for key in row if key not in ("time", "part")})
        for key, column in columns.items():
            column.append(row[key])
    return out


def _plain(value: Any) -> Any:
    """Return values of JSON: NaN becomes null, infinity the text ``inf``."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        if math.isinf(value):
            return "inf"
        return None if math.isnan(value) else float(f"{value:.{DIGITS}g}")
    return value
