# SPDX-License-Identifier: GPL-3.0-or-later
"""Events of a scene: when they come, what the results say of them, and runs that resume across them."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from models import box, ground
from small_runs import ctrl_c_before_step, ran, write_scene

from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results

WEIGHT = 2000.0 * 9.81  # of a cube [N]
SCENE = """
[material]
density = 2000.0
friction = 0.6
[run]
dt = 2e-3
duration = 0.4
frames_per_second = 20
until_still = false
tolerance = 1e-10
[[output.point]]
block = "high"
name = "top"
relative = false
"""
REMOVED = '[[events]]\nat = 0.1\nremove = "low"\nname = "shore goes"\n'
ADDED = '[[events]]\nwhen = { gauge = "top", quantity = "z", below = -0.1 }\nadd = "late"\n'


def scene(folder: Path, *events: str) -> Path:
    """Two cubes on each other, and one next to them."""
    cubes = [box(name, (x, 0, z), (x + 1, 1, z + 1)) for name, x, z in (("low", 0, 0), ("high", 0, 1), ("late", 3, 0))]
    return write_scene(folder, [ground(), *cubes], SCENE + "".join(events))


def test_an_event_comes_at_its_time_or_once_its_gauge_has_passed_its_value(tmp_path: Path) -> None:
    summary = ran(scene(tmp_path, REMOVED, ADDED))
    first, second = summary.events
    assert (first.name, first.time) == ("shore goes", pytest.approx(0.1))
    assert second.time == pytest.approx(0.1 + np.sqrt(0.2 / 9.81), abs=0.004)  # a free fall of 0.1 m
    with Results.open(tmp_path / "out" / "result.h5") as results:
        there = np.array([results.present(frame) for frame in range(results.frames)])
        time, reaction = results.time, results.reaction
    assert reaction is not None
    assert there[:, 1].tolist() == (time <= 0.1).tolist()
    assert there[:, 3].tolist() == (time > second.time).tolist()
    assert reaction[1, 0, 2] == pytest.approx(2.0 * WEIGHT, rel=1e-6)
    assert reaction[-1, 0, 2] == pytest.approx(WEIGHT, rel=1e-6)
    assert summary.energy.balance_error < 1e-9
    assert not summary.collapsed_block_names or "low" not in summary.collapsed_block_names


def test_an_event_that_does_not_come_is_a_warning(tmp_path: Path) -> None:
    summary = ran(scene(tmp_path, ADDED), "run.duration=0.02")
    assert summary.events[0].time is None
    assert any("events[0] has not come" in line for line in summary.warnings)


def test_a_run_ends_where_there_is_no_room_for_a_block(tmp_path: Path) -> None:
    """A cube slides without friction to where another is put in."""
    path = scene(tmp_path, '[[events]]\nat = 0.8\nadd = "late"\n')
    summary = ran(path, "material.friction=0", "run.gravity=[9.81,0,-9.81]", "run.duration=1.0")
    assert "events[0].add" in summary.stopped
    assert summary.steps == 400


def test_a_run_resumes_across_its_events_to_the_bit(tmp_path: Path) -> None:
    whole, broken = (tmp_path / name for name in ("whole", "broken"))
    for folder in (whole, broken):
        folder.mkdir()
        scene(folder, REMOVED, ADDED)
    ran(whole / "scene.toml")
    case = prepare(read_scene(broken / "scene.toml", ()))
    with ctrl_c_before_step(80):
        assert run_case(case, broken / "out").stopped
    again = run_case(prepare(read_scene(broken / "scene.toml", ())), broken / "out", resume=True)
    assert [event.time is None for event in again.events] == [False, False]
    with h5py.File(whole / "out" / "result.h5") as one, h5py.File(broken / "out" / "result.h5") as other:
        for name in ("position", "velocity", "present", "joints/opening", "energy/change_work"):
            assert np.array_equal(one[name][...], other[name][...])


def test_joints_of_blocks_that_are_not_there_count_as_they_were_built(tmp_path: Path) -> None:
    ran(scene(tmp_path, REMOVED))
    with Results.open(tmp_path / "out" / "result.h5") as results:
        assert results.joint_history("opening").max() < 1e-9
        assert (results.joint_history("contact_area") >= (1.0 - 1e-9) * results.joints.area).all()


def test_forces_are_those_of_their_joints_whichever_blocks_are_there(tmp_path: Path) -> None:
    """Also where a run resumes in the middle: numbers of joints are those of all blocks as built."""
    folders = [tmp_path / name for name in ("whole", "broken")]
    for folder in folders:
        folder.mkdir()
        scene(folder, '[[events]]\nat = 0.06\nadd = "late"\n', '[[events]]\nat = 0.2\nrelease = "ground"\n')
    whole, broken = folders
    ran(whole / "scene.toml")
    with ctrl_c_before_step(150):
        run_case(prepare(read_scene(broken / "scene.toml", ())), broken / "out")
    run_case(prepare(read_scene(broken / "scene.toml", ())), broken / "out", resume=True)
    with Results.open(whole / "out" / "result.h5") as one, Results.open(broken / "out" / "result.h5") as other:
        for name in ("normal_force", "opening", "contact_area"):
            assert np.array_equal(one.joint_history(name), other.joint_history(name))
        pairs = {frozenset((int(a), int(b))): j for j, (a, b) in enumerate(zip(one.joints.block_a, one.joints.block_b, strict=True))}
        force = one.joint_history("normal_force")
    assert force[1, pairs[frozenset((0, 3))]] == 0.0  # before the block is put in
    weights = [force[3, pairs[frozenset(pair)]] / WEIGHT for pair in ((0, 1), (1, 2), (0, 3))]
    assert weights == pytest.approx([2.0, 1.0, 1.0], rel=1e-6)
    assert np.abs(force[-1]).max() < 1e-9  # all of them fall with the ground


def test_a_condition_waits_for_its_block(tmp_path: Path) -> None:
    joint = '[[output.joint]]\nblocks = ["low", "high"]\nname = "bed"\n'
    added = '[[events]]\nat = 0.2\nadd = "high"\n'
    slips = '[[events]]\nwhen = { gauge = "bed", quantity = "normal_force", below = 1.0 }\nremove = "late"\n'
    summary = ran(scene(tmp_path, joint, added, slips))
    assert summary.events[1].time is None  # without the block there is no force, and with it more


def test_steps_that_adapt_end_where_an_event_comes(tmp_path: Path) -> None:
    summary = ran(scene(tmp_path, REMOVED.replace("0.1", "0.13")), 'run.dt="auto"', "run.dt_min=1e-3", "run.dt_max=1.6e-2")
    assert summary.events[0].time == pytest.approx(0.13)
    assert summary.displacement_max == pytest.approx(0.5 * 9.81 * 0.27**2, rel=0.01)


def test_limit_analysis_refuses_a_scene_whose_blocks_come_and_go(tmp_path: Path) -> None:
    from masonry_cd.app.limit_structure import limit_structure

    asked = read_scene(scene(tmp_path, REMOVED), ('limit.push="x"',))
    with pytest.raises(InputError, match="events"):
        limit_structure(asked)
