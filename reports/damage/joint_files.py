# SPDX-License-Identifier: GPL-3.0-or-later
"""The damage joint by joint in a file: joints.csv."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.damage.grades import read_grades
from masonry_cd.analysis.damage.joint_damage import JointDamage
from masonry_cd.analysis.damage.part_damage import Settings
from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.analysis.outputs.summary import damage_numbers
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.io.layout import BONDED, CRUSHED
from masonry_cd.io.results import Results
from reports.settings import Report
from reports.ties import write_ties


def thresholds_of(settings: Report) -> Thresholds:
    """What counts as damage."""
    return Thresholds(opened=settings.opened, slid=settings.slid)


def damage_settings(settings: Report) -> Settings:
    """What counts as damage, and from where on it is which grade."""
    return Settings(thresholds=thresholds_of(settings), grades=read_grades(settings.grades))


def write_joint_damage(results: Results, folder: Path, settings: Report) -> dict[str, Any]:
    """Write joints.csv, and ties.csv where there are ties; return the numbers of damage for the summary, see :func:`damage_numbers`."""
    run, end = Measured(results, damage_settings(settings)), end_state(results, thresholds_of(settings))
    write_joints_csv(run.table, folder / "joints.csv", end.provisional)
    write_ties(results, folder)
    return damage_numbers(run, end)


def write_joints_csv(table: JointDamage, path: Path, provisional: str = "") -> None:
    """Write one row per joint; the columns are the fields of :class:`JointDamage`, an unknown time is left empty.

    The share that is bonded is a column of runs with bonds only, by how much joints were crushed of those whose joints can be, and
    ``provisional``, why residual values are not the last, of runs that did not end at rest.
    """
    left_out = {"both", *(name for name in (BONDED, CRUSHED) if np.isnan(getattr(table, name)).all())}
    columns = [item.name for item in fields(table) if item.name not in left_out]
    cells = [getattr(table, name).tolist() for name in columns]
    if provisional:
        columns, cells = [*columns, "provisional"], [*cells, [provisional] * len(table.joint)]
    write_csv(path, columns, zip(*cells, strict=True), digits=9)
