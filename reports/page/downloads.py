# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of a run, carried within the page: the reader saves them as CSV files, without a network and without the run's folder."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.damage.joint_damage import JointDamage
from masonry_cd.analysis.damage.part_damage import PartDamage
from masonry_cd.io.results import Results
from reports.damage.joint_files import write_joints_csv
from reports.damage.part_files import write_part_damage
from reports.files import carried_files, known_files
from reports.page.section import Section
from reports.page.words import PageContext

JOINTS = "joints.csv"
PREFIX = "file/"  # of their names among the packed arrays


def tables(results: Results, table: JointDamage, parts: PartDamage | None) -> dict[str, np.ndarray]:
    """The bytes of each table by its name among the packed arrays; they are those of the files in the run's folder."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        write_joints_csv(table, here / JOINTS, end_state(results, parts.settings.thresholds if parts else None).provisional)
        if parts is not None:
            write_part_damage(parts, here)
        return {PREFIX + name: np.frombuffer((here / name).read_bytes(), np.uint8) for name in carried_files() if (here / name).exists()}


def downloads(context: PageContext) -> Mapping[str, Any]:
    """The tables that the page carries, and what each holds."""
    meanings = known_files()
    return {"files": [(name, meanings[name]) for name in (name.removeprefix(PREFIX) for name in context.carried)]}


SECTIONS = {"tables": Section("Tables", downloads, 40)}
