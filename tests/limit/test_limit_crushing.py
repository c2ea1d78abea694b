# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analysis of scenes whose joints crush: what is said and written, and what is refused."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from command_line import masonry_cd
from limit_scenes import said
from models import box, ground
from typer.testing import Result

from masonry_cd.limit.case import limit_case
from masonry_cd.limit.files import write
from structures.files import blockfile

WEIGHT = 2000.0 * 9.81 * 1.5  # pressure under the pillar [Pa]


def scene(folder: Path, strength: str, tables: str = "[limit]\npush = 'x'\n") -> Path:
    """A pillar of 0.5 x 0.4 x 1.5 m."""
    blockfile.write(folder / "blocks.json", [ground(2.0), box("a", (0.0, -0.2, 0.0), (0.5, 0.2, 1.5))])
    path = folder / "scene.toml"
    path.write_text(
        'structure = {kind = "file", path = "blocks.json"}\nrun = {dt = 1e-3, duration = 1.0}\n'
        f"material = {{density = 2000.0, friction = 2.0, joints = {{compressive_strength = {strength}}}}}\n{tables}"
    )
    return path


def test_joints_that_crush_are_said_and_written(tmp_path):
    case = limit_case(scene(tmp_path, '"117.72 kPa"'))
    assert case.whole.analysis.associated.factor == pytest.approx(0.5 / 1.5 * (1.0 - WEIGHT / 117.72e3), rel=1e-6)
    assert any(line.startswith("mechanism: 1 of 1 blocks") and line.endswith("; 1 of them crush") for line in said(case))
    assert any("the factor is an upper bound" in line for line in said(case))
    write(case, tmp_path / "out", pictures=False)
    assert json.loads((tmp_path / "out" / "limit.json").read_text())["mechanism"]["joints_crushing"] == 1
    with (tmp_path / "out" / "joints.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert float(row["stress_block_share"]) == pytest.approx(WEIGHT / 117.72e3, rel=1e-4) and float(row["closing"]) > 0.0


def test_joints_without_a_strength_do_not(tmp_path):
    path = scene(tmp_path, "1e7")
    path.write_text(path.read_text().replace("compressive_strength = 1e7", "cohesion = 0.0"))
    case = limit_case(path)
    assert not any("crush" in line for line in said(case)) and not case.whole.collapse.mechanism.crushing.any()


@pytest.mark.parametrize(
    ("strength", "tables", "fault"),
    [
        ("2e4", "[limit]\npush = 'x'\n", 'material.joints: the joint "ground" - "a"'),
        ("2e6", "[limit]\npush = 'x'\n[limit.curve]\n", "limit.curve: joints that crush are not followed"),
    ],
)
def test_what_has_no_answer_is_one_line(strength, tables, fault, tmp_path):
    done = masonry_cd("limit", scene(tmp_path, strength, tables), "-o", tmp_path / "out")
    assert done.exit_code == 2 and fault in done.output and done.output.count("\n") == 1
    assert not (tmp_path / "out" / "limit.json").exists()


def macro_elements(folder: Path, strength: str) -> Result:
    return masonry_cd("limit", scene(folder, strength), "-o", folder / "out", "--macro-elements", "--no-picture")


def test_macro_elements_crush_as_the_whole_does(tmp_path):
    """b/h (1 - N/(f b t)) of the pillar, as a part and as the whole, whose search has begun at the part."""
    assert macro_elements(tmp_path, "2e5").exit_code == 0
    parts = json.loads((tmp_path / "out" / "limit.json").read_text())["mechanisms"]
    whole = json.loads((tmp_path / "out" / "limit.json").read_text())["least"]["factor"]
    exact = 0.5 / 1.5 * (1.0 - WEIGHT / 2e5)
    along_x = min(row["alpha0"] for row in parts if row["push"] == "x")
    assert along_x == pytest.approx(exact, rel=1e-3) and whole == pytest.approx(exact, rel=1e-3)
    assert all(row["mechanism"].endswith("; ground - a crushes") for row in parts if row["push"] == "x")


def test_a_strength_below_the_stress_in_a_part_is_one_line(tmp_path):
    done = macro_elements(tmp_path, str(0.9 * WEIGHT))
    assert done.exit_code == 2 and 'material.joints: the joint "ground" - "a"' in done.output
    assert not (tmp_path / "out").exists()


def test_the_joints_that_crush_under_a_load_later_than_the_dead_one_are_named(tmp_path):
    """A lintel on two stones, of which a point load that grows crushes the one whole; the lintel turns the other over its stress block."""
    stones = [box("west", (-1.0, -0.2, 0.0), (-0.5, 0.2, 0.5)), box("east", (0.5, -0.2, 0.0), (1.0, 0.2, 0.5))]
    blockfile.write(tmp_path / "blocks.json", [ground(), *stones, box("lintel", (-1.0, -0.2, 0.5), (1.0, 0.2, 1.0))])
    path = tmp_path / "scene.toml"
    path.write_text(
        'structure = {kind = "file", path = "blocks.json"}\n'
        'material = {density = 2000.0, friction = 0.6, joints = {compressive_strength = "60 kPa"}}\n'
        '[[loads]]\nkind = "point"\nblock = "east"\nforce = [0.0, 0.0, -1e3]\npoint = [0.75, 0.0, 0.25]\n[limit]\nlive = [0]\n'
    )
    case = limit_case(path)
    east, west = case.whole.crushed
    assert (east.block_a, east.block_b, east.share) == ("ground", "east", pytest.approx(1.0, rel=1e-3))
    assert (west.block_a, west.block_b) == ("ground", "west")
    off = abs(case.whole.collapse.force_point[west.joint, 0] + 0.75)
    assert off == pytest.approx(0.25 * (1.0 - west.share), rel=1e-3)  # b/2 (1 - N/(f b t)): it is on the surface of its domain
    (line,) = (one for one in said(case) if one.startswith("crushing: "))
    assert line.startswith(
        'crushing: 2 joints at the strength at this factor: "ground" - "east" (base-block, 60 kPa) over 100 % of its area, '
    )
    write(case, tmp_path / "out", pictures=False)
    assert [one["block_b"] for one in json.loads((tmp_path / "out" / "limit.json").read_text())["crushed"]] == ["east", "west"]
    assert "2 joints at the strength at this factor" in (tmp_path / "out" / "limit.html").read_text()


@pytest.mark.parametrize(("times", "little"), [(1.1, True), (1.5, False)])
def test_a_strength_of_which_the_dead_loads_leave_little_is_said_with_its_joint(times, little, tmp_path):
    case = limit_case(scene(tmp_path, str(times * WEIGHT)))
    found = [line for line in said(case) if line.startswith("the dead loads leave little of the strength")]
    assert bool(found) is little and (case.whole.spare is not None) is little
    if case.whole.spare is not None:
        assert case.whole.spare.factor == pytest.approx(times, rel=1e-6)
        assert 'at 1.1 times of them joints crush: "ground" - "a" ' in found[0] and found[0].endswith("over 100 % of its area")
