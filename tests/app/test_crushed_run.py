# SPDX-License-Identifier: GPL-3.0-or-later
"""A run whose joints crush: its files and closing lines know them, and the map draws them."""

import csv
import json
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from models import box, ground

from masonry_cd.analysis.damage.joint_damage import crushing
from masonry_cd.analysis.damage.verdict import beyond_their_law
from masonry_cd.app.case import prepare
from masonry_cd.app.closing_lines import closing_lines, crushed_lines
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from reports.drawing.palette import CRUSHED
from reports.drawing.parts import painted
from reports.maps.crack_map import crack_scene
from reports.maps.framing import MapStyle, framing
from structures.files import blockfile

SCENE = """
structure = {kind = "file", path = "blocks.json"}
run = {dt = 2e-3, duration = 0.2, tolerance = 1e-6}
report = {crack_map = false}
[material]
density = 2000.0
friction = 2.0
joints = {normal_stiffness = 1e9, compressive_strength = STRENGTH}
[[loads]]
kind = "pulse"
direction = "x"
acceleration = 4.5
duration = 0.15
"""


def test_crushed_joints_are_counted_tabled_and_marked(tmp_path):
    blockfile.write(tmp_path / "blocks.json", [ground(), box("b", (-0.25, -0.5, 0.0), (0.25, 0.5, 0.5))])
    (tmp_path / "scene.toml").write_text(SCENE.replace("STRENGTH", "2e4"))
    summary = run_case(prepare(read_scene(tmp_path / "scene.toml")), tmp_path / "out")
    assert summary.joints_crushed == 1
    assert summary.energy.crushing > 0.0
    (line,) = (line for line in closing_lines(summary) if line.startswith("crushing: 1 joint, by "))
    assert line.endswith(' at the most, "ground" - "b"')
    with (tmp_path / "out/joints.csv").open() as file:
        assert float(next(csv.DictReader(file))["crushed"]) == float(f"{summary.crushed_max:.9g}")
    with Results.open(tmp_path / "out/result.h5") as results:
        assert np.diff(results.joint_history("crushed")[:, 0]).min() >= 0.0
        scene = crack_scene(results, results.frames - 1, framing(results, [results.frames - 1], MapStyle()))
        assert "crushed (1)" in [sign.text for panel in scene.key for sign in panel.signs]
        assert scene.joints is not None
        assert tuple(scene.joints.colours[1][0]) == tuple(painted(CRUSHED, 1)[0])
    assert json.loads((tmp_path / "out/summary.json").read_text())["crushed_max"] > 1e-6


def test_a_strength_below_the_stress_of_the_dead_loads_names_the_joint(tmp_path):
    """A beam on two stones whose beds bear 29 kPa."""
    stones = [box("west", (-1.0, 0.0, 0.0), (-0.5, 0.5, 0.5)), box("east", (0.5, 0.0, 0.0), (1.0, 0.5, 0.5))]
    blockfile.write(tmp_path / "blocks.json", [ground(), *stones, box("beam", (-1.0, 0.0, 0.5), (1.0, 0.5, 1.0))])
    (tmp_path / "scene.toml").write_text(SCENE.replace("STRENGTH", "2e4"))
    words = r'the joint "ground" - "(west|east)".* crushes at 20 kPa under the dead loads alone: .* with a mean stress of '
    with pytest.raises(InputError, match=words):
        run_case(prepare(read_scene(tmp_path / "scene.toml")), tmp_path / "out")


def test_crushing_that_is_forgotten_is_counted():
    """Three joints over three frames: one keeps what it is shorter by, one loses it, one was never crushed."""
    history = np.array([[0.0, 0.0, 0.0], [1e-4, 2e-4, 0.0], [3e-4, 0.0, 0.0]])
    ends = SimpleNamespace(block_a=[0, 0, 0], block_b=[1, 2, 3])
    blocks = [SimpleNamespace(name=name) for name in ("base", "a", "b", "c")]
    results = SimpleNamespace(has_joint_history=lambda name: True, joint_history=lambda name: history, joints=ends, blocks=blocks)
    found = crushing(cast(Results, results))
    assert found.as_dict() == {"joints_crushed": 1, "crushed_max": 3e-4, "crushing_forgotten": 1, "crushed_where": '"base" - "a"'}
    assert len(crushed_lines(found)) == 1 and "1 joint" in beyond_their_law(found)[0]
