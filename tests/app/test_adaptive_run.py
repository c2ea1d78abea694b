# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole runs whose time step adapts: fixed times, resumption, what is reported."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from datasets import contents
from models import stepper, still, wall

from masonry_cd.app.case import prepare
from masonry_cd.app.closing_lines import closing_lines
from masonry_cd.app.run_case import run_case
from masonry_cd.app.run_loop import Checkpoints, RunPlan, run
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.io import checkpoint
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.find_joints import find_joints

TICKS, TICK, FRAME = 992, 1e-2 / 32, 32
SCENE = """
title = "A low wall"
[structure]
kind = "wall"
length = 1.2
height = 0.9
thickness = 0.3
[material]
density = 2000.0
friction = 0.6
[[loads]]
{load}
[run]
dt = "auto"
duration = {duration}
frames_per_second = 100.0
"""
SINE = 'kind = "sinusoidal"\ndirection = "x"\namplitude = 0.4\nfrequency = 2.0\ncycles = 1\nstart = 0.2'
SHOCK = """
[[loads.shocks]]
name = "{name}"
[[loads.shocks.components]]
direction = "x"
spectrum = "EC8"
ag = {ag}
ground = "B"
rise = 0.3
level = 0.4
duration = {length}
periods = [0.1, 0.5]
tolerance = 0.5
seed = 1
"""
SHOCKS = """kind = "sequence"
rest = "still"
longest_rest = 0.8
still = 5e-3
hold = 0.1
""" + "".join(SHOCK.format(name=name, ag=ag, length=length) for name, ag, length in (("first", 1.5, 2.013), ("second", 1.0, 2.0)))


def scene(folder: Path, load: str = SINE, duration: float = 1.0, *changes: str):
    path = folder / "scene.toml"
    path.write_text(SCENE.format(load=load, duration=duration))
    return read_scene(path, changes)


def machine(**settings):
    velocity = still(TICKS)
    velocity[:, 0, 0] = 0.5 * np.sin(2 * np.pi * 4.0 * np.arange(TICKS + 1) * TICK)
    return stepper(wall(2, 4), TICKS, support_velocity=velocity, **({"dt": "auto", "solver": "auto", "tolerance": 1e-8} | settings))


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory):
    path, m = tmp_path_factory.mktemp("run") / "unbroken.h5", machine()
    joints = find_joints(m.assembly)
    with ResultWriter(path, m.assembly, joints, "scene") as writer:
        return path, run(m, joints, writer, RunPlan(TICKS, FRAME))


def test_frames_are_at_their_times_and_steps_add_up(unbroken):
    path, report = unbroken
    with Results.open(path) as results:
        time, step_time = np.array(results.time), results.per_step("step_time")
        ends = results.per_step("load_step")
    assert np.array_equal(time, TICK * FRAME * np.arange(TICKS // FRAME + 1))
    assert np.array_equal(step_time, TICK * ends) and ends[-1] == TICKS
    lengths = np.diff(ends, prepend=0).astype(int)
    assert {str(n): int((lengths == n).sum()) for n in np.unique(lengths)} == report.spans
    assert sum(report.spans.values()) == report.steps == len(ends)
    assert len(report.spans) > 2 and report.repeated_error > 0
    assert report.balance_error < 1e-9


@pytest.mark.parametrize("after", [200, 500, 800])
def test_a_resumed_run_ends_with_the_same_bits(tmp_path, unbroken, after):
    path, saved, m = tmp_path / "broken.h5", tmp_path / checkpoint.NAME, machine()
    joints = find_joints(m.assembly)

    def stop(tick: int) -> None:
        if tick >= after:
            raise KeyboardInterrupt

    with ResultWriter(path, m.assembly, joints, "scene") as writer:
        assert run(m, joints, writer, RunPlan(TICKS, FRAME), stop, Checkpoints(saved)).stopped
    m = machine()
    with ResultWriter.resumed(path, checkpoint.load(saved)[1]["rows"]) as writer:
        report = run(m, joints, writer, RunPlan(TICKS, FRAME), checkpoints=Checkpoints(saved, resume=True))
    assert contents(path) == contents(unbroken[0])
    assert report.spans == unbroken[1].spans
    assert report.repeated_error == unbroken[1].repeated_error
    assert report.energy == unbroken[1].energy


@pytest.mark.parametrize(
    ("name", "values", "line"),
    [
        ("pace/control", [3, 0, 0], "pace/control: out of range"),
        ("pace/control", [64, 0, 0], "pace/control: out of range"),
        ("pace/last_blocks", [[1.0]], "pace/last_blocks"),
        ("steps", [10, 40, 40, 5], "steps: out of range"),
        ("steps", [50, 40, 40, 1], "steps: out of range"),
    ],
)
def test_a_checkpoint_that_no_such_run_leaves_is_refused(tmp_path, name, values, line):
    path, saved, m = tmp_path / "broken.h5", tmp_path / checkpoint.NAME, machine()
    joints = find_joints(m.assembly)
    with ResultWriter(path, m.assembly, joints, "scene") as writer:
        run(m, joints, writer, RunPlan(40, FRAME), checkpoints=Checkpoints(saved))
    arrays, numbers = checkpoint.load(saved)
    arrays[name] = np.array(values)
    checkpoint.save(saved, arrays, numbers)
    with ResultWriter.resumed(path, numbers["rows"]) as writer, pytest.raises(InputError, match=line):
        run(machine(), joints, writer, RunPlan(TICKS, FRAME), checkpoints=Checkpoints(saved, resume=True))


def test_the_summary_says_how_long_the_steps_were(tmp_path):
    summary = run_case(prepare(scene(tmp_path)), tmp_path / "out")
    found, steps = summary.time_step, summary.steps
    assert json.loads((tmp_path / "out/summary.json").read_text())["time_step"] == found.as_dict()
    assert steps == summary.steps_asked == sum(row["steps"] for row in found.steps_by_length)
    assert found.dt_max == found.longest == 1e-2 and found.dt_min == found.shortest == 1e-2 / 32
    assert sum(row["steps"] * row["dt"] for row in found.steps_by_length) == pytest.approx(1.0, rel=1e-12)
    said = "\n".join(closing_lines(summary))
    assert f"{steps} steps of 312 us to 10 ms (median {1e3 * found.median:.3g} ms)" in said.replace("625 us", "0.625 ms")
    assert "time steps: local error" in said and "aimed at" in said
    with Results.open(tmp_path / "out/result.h5") as results:
        assert np.array_equal(np.array(results.time), 1e-2 * np.arange(101))


def test_a_run_of_fixed_steps_says_nothing_of_it(tmp_path):
    summary = run_case(prepare(scene(tmp_path, SINE, 0.05, "run.dt=1e-3")), tmp_path / "out")
    assert "time_step" not in summary
    assert summary.steps == summary.steps_asked == 50


def test_a_rest_between_shocks_ends_early_and_the_next_one_begins_on_time(tmp_path):
    made = scene(tmp_path, SHOCKS, 5.615)
    case = prepare(made)
    summary = run_case(case, tmp_path / "out")
    first, second = summary.shocks
    with Results.open(tmp_path / "out/result.h5") as results:
        ends, time = results.per_step("load_step").astype(int), results.per_step("step_time")
    for shock in case.loading.shocks:
        assert shock.last in ends  # the record of a shock ends with a step
    made_of = np.diff(time, prepend=0.0) / made.run.dt  # ticks of each step
    begins = ends - np.round(made_of).astype(int)
    cut = np.flatnonzero(begins[1:] > ends[:-1])
    assert len(cut) == 1  # the rest after the first shock was cut short, and the second began on time
    assert begins[cut[0] + 1] == case.loading.shocks[1].first
    assert first.rest_end == pytest.approx(second.start, abs=1e-9)


def test_a_push_that_gives_way_is_dated_by_the_steps_as_they_were(tmp_path):
    load = 'kind = "tilt"\ndirection = "y"\nrate = 6.0'
    adaptive = run_case(prepare(scene(tmp_path, load, 3.5)), tmp_path / "a").load_factor
    fixed = run_case(prepare(scene(tmp_path, load, 3.5, "run.dt=2e-3")), tmp_path / "b").load_factor
    assert adaptive.given_way == pytest.approx(fixed.given_way, rel=0.03)
    assert adaptive.end == pytest.approx(fixed.end, rel=1e-3)
