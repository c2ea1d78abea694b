# SPDX-License-Identifier: GPL-3.0-or-later
"""A run whose joints crush: its files and closing lines know them, and the map draws them."""

import csv
import json

import numpy as np
from models import box, ground

from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.app.summary import closing_lines
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
    assert summary["joints_crushed"] == 1
    assert summary["energy"]["crushing"] > 0.0
    assert any(line.startswith("crushing: 1 joint, by ") for line in closing_lines(summary))
    with (tmp_path / "out/joints.csv").open() as file:
        assert float(next(csv.DictReader(file))["crushed"]) == float(f"{summary['crushed_max']:.9g}")
    with Results.open(tmp_path / "out/result.h5") as results:
        assert np.diff(results.joint_history("crushed")[:, 0]).min() >= 0.0
        scene = crack_scene(results, results.frames - 1, framing(results, [results.frames - 1], MapStyle()))
        assert "crushed (1)" in [sign.text for panel in scene.key for sign in panel.signs]
        assert scene.joints is not None
        assert tuple(scene.joints.colours[1][0]) == tuple(painted(CRUSHED, 1)[0])
    assert json.loads((tmp_path / "out/summary.json").read_text())["crushed_max"] > 1e-6
