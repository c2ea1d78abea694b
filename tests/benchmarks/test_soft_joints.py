# SPDX-License-Identifier: GPL-3.0-or-later
"""Benchmarks of joints' points: the cost of rings in a scene, and the pulses that an arch stands and falls under."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import soft_arch
from benchmarks.joint_points import costs

WALL = """
structure = { kind = "wall", length = 0.8, height = 0.6, thickness = 0.2, unit_length = 0.4, course_height = 0.2 }
material = { density = 2000.0, friction = 0.6, joints = { normal_stiffness = 1e9 } }
run = { dt = 2e-3, duration = 0.2, tolerance = 1e-5 }
loads = [{ kind = "sinusoidal", direction = "y", amplitude = 0.3, frequency = 3.0, cycles = 2 }]
"""


def test_what_rings_cost_is_tabled_beside_three_points_and_rings_in_all_joints(tmp_path: Path) -> None:
    scene = tmp_path / "wall.toml"
    scene.write_text(WALL)
    _, _, *rows = costs(scene, [], 60).splitlines()
    names, contacts = zip(*((cells[1].strip(), int(cells[2])) for cells in (row.split("|") for row in rows)), strict=True)
    assert names == ("3", "7", "9", "11", "9 in all joints")
    assert contacts[0] < contacts[1] < contacts[2] < contacts[3] and contacts[2] <= contacts[4]


def test_the_pulse_that_throws_an_arch_down_is_found_between_one_that_it_stands_and_one_it_does_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(soft_arch, "falls", lambda share, joints, thick: share > 0.1234)
    low, high = soft_arch.least(None, soft_arch.THICK)
    assert low <= 0.1234 < high <= low + soft_arch.APART
