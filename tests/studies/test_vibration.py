"""The run itself in vibration against the modes of rigid blocks on the same elastic joints."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from models import tower, wall

from masonry_cd.dynamics.settings import Run
from masonry_cd.errors import InputError
from masonry_cd.model.blocks import Assembly
from masonry_cd.model.materials import JointLaw
from masonry_cd.studies.vibration import free_vibration, linear_modes, sweep, vibration_case

RUN = Run(dt=1e-3, duration=1.0, tolerance=1e-9)


def test_a_dry_tower_swings_at_the_frequencies_of_its_joints():
    """In all directions and about its axis; without cohesion, its weight presses the joints together."""
    assembly = Assembly.from_blocks(tower(4), 0.6, {"default": JointLaw(normal_stiffness=1e9)})
    rows = free_vibration(assembly, RUN, linear_modes(assembly, 6), 6)
    assert [row["nscd_hz"] for row in rows] == pytest.approx([row["linear_hz"] for row in rows], rel=5e-3)
    assert rows[0]["linear_hz"] < 0.5 * rows[2]["linear_hz"]


def test_a_mortar_wall_swings_like_a_bonded_one_and_a_dry_one_softer():
    """Head joints carry no weight: only mortar lets them act as the linear model has it."""
    frequencies = []
    for cohesion in (1e6, 0.0):
        assembly = Assembly.from_blocks(wall(2, 3), 0.6, {"default": JointLaw(normal_stiffness=1e9, cohesion=cohesion)})
        rows = free_vibration(assembly, RUN, linear_modes(assembly, 3), 3)
        frequencies.append([row["nscd_hz"] for row in rows])
    linear = [row["linear_hz"] for row in rows]
    assert frequencies[0] == pytest.approx(linear, rel=5e-3)
    assert frequencies[1][2] < 0.99 * linear[2]


def test_a_small_sweep_follows_the_linear_model_and_a_strong_one_does_not():
    assembly = Assembly.from_blocks(tower(2), 0.6, {"default": JointLaw(normal_stiffness=1e9)})
    companion = linear_modes(assembly, 12)
    first = companion.frequencies[0]
    small = 1e-3 * 9.81 / (2 * np.pi * first)
    rows = sweep(assembly, RUN, companion, 0, small, first * np.array([0.5, 1.0, 1.5]))
    own, linear = (np.array([row[key] for row in rows]) for key in ("nscd_ratio", "linear_ratio"))
    assert own == pytest.approx(linear, rel=0.05)
    assert own.argmax() == 1 and own[1] > 5 * own[0]
    strong = sweep(assembly, RUN, companion, 0, 300 * small, first * np.array([1.0]))[0]
    assert strong["nscd_ratio"] < 0.8 * strong["linear_ratio"]


def test_rigid_joints_are_refused():
    with pytest.raises(InputError, match=r"joints base-block are rigid, a vibration needs elastic ones"):
        linear_modes(Assembly.from_blocks(tower(2), 0.6, {"block-block": JointLaw(normal_stiffness=1e9)}), 3)


def test_from_scene_to_files(tmp_path: Path):
    scene = tmp_path / "scene.toml"
    scene.write_text(
        """\
title = "Column"
[structure]
kind = "column"
height = 2.0
diameter = 0.5
drums = 2
sides = 8
[material]
density = 2200.0
friction = 0.6
[material.joints]
normal_stiffness = 5e9
[run]
dt = 2e-3
duration = 1.0
"""
    )
    out = tmp_path / "out"
    found = vibration_case(scene, {"modes": 2}, out)
    assert [Path(name).name for name in found["written"]] == ["vibration.json", "vibration.csv"]
    with (out / "vibration.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [abs(float(row["difference_percent"])) < 1.0 for row in rows] == [True, True]
    assert "free vibration of the run" in found["lines"][0]
    with pytest.raises(InputError, match=r"modal\.sweep"):
        vibration_case(scene, {"sweep": "w"}, out)
