# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run says of elastic joints that are shortened by more than stones bear."""

from pathlib import Path

import pytest
from made_run import box

from masonry_cd.app.case import prepare
from masonry_cd.app.closing_lines import closing_lines
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from structures.files.blockfile import write

SCENE = """
[structure]
kind = "file"
path = "blocks.json"

[material]
density = 2000.0
friction = 0.6

[material.joints.default]
normal_stiffness = 1e6

[run]
dt = 1e-3
duration = 0.01
"""


@pytest.mark.parametrize(("stiffness", "named"), [(1e6, True), (1e7, False)])
def test_a_joint_shortened_by_more_than_a_hundredth_of_the_width_is_named(tmp_path: Path, stiffness: float, named: bool) -> None:
    """A cube of 1 m sinks by 19.6 mm into a joint of 1 MN/m3, and by a tenth of that into one of 10 MN/m3."""
    (tmp_path / "scene.toml").write_text(SCENE)
    write(tmp_path / "blocks.json", [box("base", (-1, -1, -1), (2, 2, 0), fixed=True), box("cube", (0, 0, 0), (1, 1, 1))])
    changes = [f"material.joints.default.normal_stiffness={stiffness}"]
    summary = run_case(prepare(read_scene(tmp_path / "scene.toml", changes)), tmp_path / "out")
    assert summary.shortening_max == pytest.approx(2000.0 * 9.81 / stiffness, rel=1e-4)
    assert summary.penetration_max == 0.0
    lines = [line for line in closing_lines(summary) if line.startswith("joints shortened by up to ")]
    assert len(lines) == named
    assert all('2 % of the smallest width, between "cube" and "base" at ' in line for line in lines)
