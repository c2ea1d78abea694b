# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies of limit analyses: a row of factors and a verdict over what varies."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from models import GRAVITY

from masonry_cd.studies.study.limit_runs import LIMITS, limit_lines, write_limits
from masonry_cd.studies.study.study_case import plan_of
from masonry_cd.studies.study.task import Task, run_task
from structures.files import blockfile

SCENE = """\
title = "Pillar"
structure = {kind = "file", path = "blocks.json"}
material = {density = 2000.0, friction = 0.5}
run = {dt = 1e-3, duration = 1.0}
limit = {push = "x", starts = 2, check = {spectrum = "EC8", ag = 2.0, displacements = false}}
"""
STUDY = """\
scene = "scene.toml"
design = "grid"
asks = "limit"
[vary]
"material.friction" = [0.2, 0.5]
"limit.check.ag" = [1.0, 8.0]
"""


def study_in(folder: Path, text: str = STUDY) -> Path:
    """A study of a pillar of 0.5 by 1.5 m."""
    from models import box, ground

    blockfile.write(folder / "blocks.json", [ground(3.0), box("a", (0.0, -0.2, 0.0), (0.5, 0.2, 1.5))])
    (folder / "scene.toml").write_text(SCENE)
    (folder / "study.toml").write_text(text)
    return folder / "study.toml"


def test_factors_and_verdicts_stand_over_what_varies(tmp_path: Path) -> None:
    """With a friction of 0.2 it slides, with 0.5 it leans at 1/3; a0* = alpha g / 1.35 against ag / 2."""
    plan = plan_of(study_in(tmp_path))
    rows = {run.name: run_task(Task(run.name, plan.maker.tables(run.asked), 60.0, asks="limit")).row for run in plan.runs}
    assert all(row.done for row in rows.values()), rows
    write_limits(tmp_path, plan, rows)
    with (tmp_path / LIMITS).open() as file:
        table = list(csv.DictReader(file))
    assert len(table) == 4
    for row in table:
        friction, ag = float(row["material.friction"]), float(row["limit.check.ag"])
        factor = min(friction, 1.0 / 3.0)
        ratio = factor * GRAVITY / 1.35 / (0.5 * ag)
        assert float(row["associated"]) == pytest.approx(factor, rel=1e-4) and float(row["least"]) == pytest.approx(factor, rel=1e-4)
        assert float(row["ratio"]) == pytest.approx(ratio, rel=1e-3)
        assert row["verdict"] == ("satisfied" if ratio > 1.06 else "NOT satisfied") and int(row["agreeing"]) == 2
    lines = limit_lines(plan, rows)
    assert len(lines) == 4 and all("verdict" in line and "material.friction = " in line for line in lines)


def test_a_failed_analysis_is_a_row_with_its_reason(tmp_path: Path) -> None:
    plan = plan_of(study_in(tmp_path, STUDY.replace('"limit.check.ag" = [1.0, 8.0]', '"limit.push" = ["w"]')))
    row = run_task(Task("a", plan.maker.tables(plan.runs[0].asked), 60.0, asks="limit")).row
    assert row.status == "failed" and "limit.push" in row.reason
