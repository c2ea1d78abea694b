# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run says of elastic joints that open wider than their points resolve: key, verdict and closing line, and of whom it is silent."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from made_run import box

from masonry_cd.app.bed_checks import touching_share
from masonry_cd.app.case import prepare
from masonry_cd.app.closing_lines import closing_lines
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.io.summary import Summary
from structures.files.blockfile import write

WEIGHT, DEPTH, WIDTH, HEIGHT = 2000.0 * 9.81, 0.5, 1.0, 2.0  # of the block, of its bed, [N] and [m]
FEW = "material.joints.joint_points=3"
SCENE = """
structure = { kind = "file", path = "blocks.json" }
material = { density = 2000.0, friction = 0.7, joints = { normal_stiffness = 2e9, damping = 0.1, damping_frequency = 10.0 } }
loads = [{ kind = "pulse", direction = "x", acceleration = 3.0, duration = 0.25 }]
run = { dt = 2e-3, duration = 0.3, tolerance = 1e-7 }
"""


def rocked(folder: Path, changes: Sequence[str]) -> Summary:
    """The summary of a block that a pulse makes rock on its bed."""
    (folder / "scene.toml").write_text(SCENE)
    base = box("base", (-1, -1, -1), (2, 2, 0), fixed=True)
    write(folder / "blocks.json", [base, box("block", (0, 0, 0), (DEPTH, WIDTH, HEIGHT))])
    return run_case(prepare(read_scene(folder / "scene.toml", changes)), folder / "out")


def test_a_bed_touches_over_the_share_that_its_closed_form_gives() -> None:
    share, stiffness = np.array([0.01, 0.2, 0.7]), 2e9 * DEPTH * WIDTH
    turn = 1e-3
    force = 0.5 * 2e9 * WIDTH * turn * (share * DEPTH) ** 2
    assert touching_share(force, stiffness * turn * (1.0 - share) * DEPTH) == pytest.approx(share)
    assert touching_share(np.array([0.0, -1.0, 1.0]), np.array([1.0, 1.0, 0.0])).tolist() == [0.0, 0.0, 1.0]


def test_joints_that_open_wider_than_their_points_resolve_are_named_and_to_be_looked_at(tmp_path: Path) -> None:
    summary = rocked(tmp_path, [FEW])
    found = summary.beds
    assert (found.unresolved, found.points, found.where) == (1, 3, '"base" - "block"')
    assert 0.03 < found.share < found.resolved == pytest.approx(1.0 / np.sqrt(6.0))
    (check,) = [one for one in summary.verdict.checks if one.check == "Points of open joints"]
    assert check.verdict == "look" == summary.verdict.verdict
    assert any(line.startswith("elastic joints: ") and '"block"' in line for line in closing_lines(summary))


@pytest.mark.parametrize(
    "changes",
    [
        [],  # the points of the default resolve it
        [FEW, "material.joints.normal_stiffness=1e13"],  # a joint so stiff has its force at the edge
        [FEW, "loads[0].acceleration=0.4"],  # and this one stays closed
    ],
)
def test_nothing_is_said_of_joints_whose_points_resolve_what_carries(tmp_path: Path, changes: list[str]) -> None:
    summary = rocked(tmp_path, changes)
    assert summary.beds.unresolved == 0
    assert not [line for line in closing_lines(summary) if line.startswith("elastic joints: ")]
    assert [one.verdict for one in summary.verdict.checks if one.check == "Points of open joints"] == ["good"]
