# SPDX-License-Identifier: GPL-3.0-or-later
"""The run itself in vibration against the modes of rigid blocks on the same elastic joints."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from models import box, gravity, stepper, tower, wall

from masonry_cd.app.scene import read_scene
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.studies.joints_at_rest import JointAtRest, at_rest_lines, at_rest_summary, joints_at_rest
from masonry_cd.studies.vibration import free_vibration, linear_modes, sweep, vibration

RUN = Run(dt=1e-3, duration=1.0, tolerance=1e-9)


def test_a_dry_tower_swings_at_the_frequencies_of_its_joints():
    """In all directions and about its axis; without cohesion, its weight presses the joints together."""
    assembly = Assembly.from_blocks(tower(4), Material(friction=0.6, joints={"default": JointLaw(normal_stiffness=1e9)}))
    rows = free_vibration(assembly, RUN, linear_modes(assembly, 6), 6)
    assert [row.nscd_hz for row in rows] == pytest.approx([row.linear_hz for row in rows], rel=5e-3)
    assert rows[0].linear_hz < 0.5 * rows[2].linear_hz


def test_a_mortar_wall_swings_like_a_bonded_one_and_a_dry_one_softer():
    """Head joints carry no weight: only mortar lets them act as the linear model has it."""
    frequencies = []
    for cohesion in (1e6, 0.0):
        assembly = Assembly.from_blocks(
            wall(2, 3), Material(friction=0.6, joints={"default": JointLaw(normal_stiffness=1e9, cohesion=cohesion)})
        )
        rows = free_vibration(assembly, RUN, linear_modes(assembly, 3), 3)
        frequencies.append([row.nscd_hz for row in rows])
    linear = [row.linear_hz for row in rows]
    assert frequencies[0] == pytest.approx(linear, rel=5e-3)
    assert frequencies[1][2] < 0.99 * linear[2]


def at_rest(blocks: list[Block], cohesion: float = 0.0) -> list[JointAtRest]:
    """Return the joints of blocks that have settled."""
    law = {"default": JointLaw(normal_stiffness=1e9, cohesion=cohesion)}
    machine = stepper(blocks, 2, acceleration=gravity(2), joints=law, tolerance=1e-9, solver="auto")
    settle(machine)
    return joints_at_rest(machine)


def test_head_joints_of_a_dry_wall_are_open_at_rest_and_those_of_mortar_are_not():
    rows = at_rest(wall(2, 3))
    head = [row.block_a[:2] == row.block_b[:2] for row in rows]  # of one course
    assert [row.share_left for row in rows] == pytest.approx([0.0 if upright else 1.0 for upright in head])
    found = at_rest_summary(rows)
    assert (found["open"], found["partly"]) == (sum(head), 0)
    assert found["share_left"] == pytest.approx(
        1.0 - sum(r.area for r, up in zip(rows, head, strict=True) if up) / sum(r.area for r in rows)
    )
    first, *named = at_rest_lines(found)
    assert f"{sum(head)} of {len(rows)} joints are open and 0 are only partly in contact" in first
    assert len(named) == sum(head) and "open, 0 of" in named[0]
    assert at_rest_lines(at_rest_summary(at_rest(wall(2, 3), cohesion=1e6))) == []


def test_a_joint_whose_load_leaves_the_middle_third_gapes_and_keeps_a_part_of_its_stiffness():
    """A beam that rests on 0.7 of its 1 m: its weight passes 0.15 m from the middle of the joint, beyond a sixth of 0.7 m."""
    support = box("support", (-0.2, 0.0, -0.2), (0.5, 0.3, 0.0), fixed=True)
    (row,) = at_rest([support, box("beam", (-0.2, 0.0, 0.0), (0.8, 0.3, 0.2))])
    assert 0.5 < row.share_left < 0.999
    assert 0 < row.points_left < row.points
    shorter = box("beam", (-0.2, 0.0, 0.0), (0.55, 0.3, 0.2))  # its weight passes within the middle third
    assert at_rest([support, shorter])[0].share_left == pytest.approx(1.0)


def test_a_small_sweep_follows_the_linear_model_and_a_strong_one_does_not():
    assembly = Assembly.from_blocks(tower(2), Material(friction=0.6, joints={"default": JointLaw(normal_stiffness=1e9)}))
    companion = linear_modes(assembly, 12)
    first = companion.frequencies[0]
    small = 1e-3 * 9.81 / (2 * np.pi * first)
    rows = sweep(assembly, RUN, companion, 0, small, first * np.array([0.5, 1.0, 1.5]))
    own, linear = (np.array([getattr(row, key) for row in rows]) for key in ("nscd_ratio", "linear_ratio"))
    assert own == pytest.approx(linear, rel=0.05)
    assert own.argmax() == 1 and own[1] > 5 * own[0]
    strong = sweep(assembly, RUN, companion, 0, 300 * small, first * np.array([1.0]))[0]
    assert strong.nscd_ratio < 0.8 * strong.linear_ratio


def test_rigid_joints_are_refused():
    with refused_at("material.joints"):
        linear_modes(Assembly.from_blocks(tower(2), Material(friction=0.6, joints={"block-block": JointLaw(normal_stiffness=1e9)})), 3)


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
    result = vibration(read_scene(scene), {"modes": 2}, out)
    found = result.value
    assert [path.name for path in result.written] == ["vibration.json", "vibration.csv"]
    with (out / "vibration.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [abs(float(row["difference_percent"])) < 1.0 for row in rows] == [True, True]
    assert "free vibration of the run" in result.lines[0]
    rest = found["joints_at_rest"]
    assert (rest["open"], rest["partly"], rest["not_closed"]) == (0, 0, [])
    assert rest["share_left"] == pytest.approx(1.0)
    assert not result.warnings
    with refused_at("modal.sweep"):
        vibration(read_scene(scene), {"sweep": "w"}, out, force=True)
