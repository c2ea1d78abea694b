# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion against the contact laws: a run says how much there is, in its results, closing lines, summary and page, and warns of much."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from models import tower

from masonry_cd.app.case import prepare
from masonry_cd.app.closing_lines import closing_lines
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.dynamics import moreau_jean
from structures.files import blockfile

FORCE = 10.0 * 3 * 2000.0 * 0.0625 * 9.81  # ten times the weight of the tower [N]


def run_pushed(folder: Path, ratio: float) -> Summary:
    """The summary of a tower whose top takes a force that is so many times its weight, aslant by a tenth, which friction holds."""
    *rest, top = tower(3)
    blockfile.write(folder / "blocks.json", [*rest, replace(top, density=FORCE / 9.81 / ratio / 0.0625, name="top")])
    (folder / "scene.toml").write_text(
        f"""
structure = {{kind = "file", path = "blocks.json"}}
material = {{density = 2000.0, friction = 0.6}}
run = {{dt = 1e-3, duration = 0.1, solver = "auto", tolerance = 1e-4, until_still = false}}
report = {{html = true}}
[[loads]]
kind = "point"
block = "top"
force = [{0.1 * FORCE}, 0.0, {-FORCE}]
"""
    )
    return run_case(prepare(read_scene(folder / "scene.toml")), folder / "out")


def warned(summary: Summary) -> list[str]:
    return [line for line in summary.warnings if line.startswith("violations of the contact laws")]


def test_a_run_says_what_its_errors_come_to_in_metres(tmp_path: Path) -> None:
    summary = run_pushed(tmp_path, 1e6)
    solver = summary.solver
    with Results.open(tmp_path / "out" / "result.h5") as results:
        assert solver.violation_max == results.per_step("solver/violation").max() > 0.0
        assert solver.false_slip_max == results.per_step("solver/false_slip").max() > 0.0
        assert solver.false_opening_max == results.per_step("solver/false_opening").max()
    assert solver.false_slip_max < 1e-6 and solver.error_max <= 1e-4
    (said,) = [line for line in closing_lines(summary) if line.startswith("contact laws: violated by ")]
    assert "of slip and" in said and said.endswith("of opening at the worst contacts")
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["solver"]["false_slip_max"] == solver.false_slip_max
    assert "Motion against the contact laws" in (tmp_path / "out" / "report.html").read_text()


def test_a_run_whose_violations_are_its_motion_warns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(moreau_jean, "find_overload", lambda *_: None)  # so that the norm hides the light block
    summary = run_pushed(tmp_path, 1e6)
    solver = summary.solver
    assert solver.steps_missed == 0 and solver.error_max <= 1e-4
    assert solver.false_slip_max > 1e-4 and '"top"' in solver.false_slip_where
    (line,) = warned(summary)
    assert "of slip that friction should have held" in line and "% of the largest displacement" in line
    page = (tmp_path / "out" / "report.html").read_text()
    check = page[page.index("Motion against the contact laws</th>") :][:400]
    assert '<span class="verdict doubtful">' in check
