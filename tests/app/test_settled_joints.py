# SPDX-License-Identifier: GPL-3.0-or-later
"""What opens and slides while elastic joints take up the weight is no damage."""

import json
import shutil

import numpy as np
import pytest
from command_line import masonry_cd

from masonry_cd.io.results import Results

SCENE = """\
[structure]
kind = "wall"
length = 3.0
height = 2.0
thickness = 0.4
course_height = 0.5
unit_length = 1.0
[[structure.openings]]
centre = 0.0
width = 1.0
sill = 0.5
height = 0.5
[material]
masonry = {kind = "irregular stone", E = 2e7}
friction = 0.4
[[loads]]
kind = "sinusoidal"
direction = "x"
amplitude = 0.05
frequency = 2.0
cycles = 1
[run]
dt = 2e-3
duration = 0.1
"""


def run(folder, *words, code=0):
    (folder / "scene.toml").write_text(SCENE)
    result = masonry_cd("run", folder / "scene.toml", "-o", folder / "out", "-q", *words)
    assert result.exit_code == code, result.output
    return json.loads((folder / "out" / "summary.json").read_text())


def openings(folder):
    with Results.open(folder / "out" / "result.h5") as results:
        return np.array(results.file["joints/opening"]), np.array(results.file["joints/contact_area"]), results.joints.area


def test_a_wall_at_rest_after_settling_is_whole(tmp_path):
    still = ["--set", "loads[0].amplitude=1e-12"]
    settled = run(tmp_path, *still)
    opening, area, whole = openings(tmp_path)
    assert opening[0].max() == 0.0
    assert area[0] == pytest.approx(whole)
    assert opening.max() < 1e-6
    assert settled["joints_opened"] == settled["joints_slid"] == 0
    shutil.rmtree(tmp_path / "out")
    at_once = run(tmp_path, *still, "--set", "run.settle=false", "--set", "run.duration=0.3")
    assert at_once["joints_opened"] + at_once["joints_slid"] > 0, "the weight does open joints of this wall, were it to come in the run"
