# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of a run: its friction problems in files, an explanation of what it left out, and results for which the disc has no room."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from command_line import done, masonry_cd
from hostile import refused_at
from made_run import box
from small_runs import write_scene

from masonry_cd.app.case import prepare
from masonry_cd.app.commands.solve import solve
from masonry_cd.app.dump import parse_steps
from masonry_cd.app.run_case import result_bytes
from masonry_cd.app.scene import read_scene
from masonry_cd.io.problem_files import read_problem
from masonry_cd.io.results import Results

SCENE = """\
material = { density = 2000.0, friction = 0.5 }
[run]
dt = 1e-3
duration = 0.04
tolerance = 1e-9
"""


@pytest.fixture
def falling(tmp_path):
    """One cube at rest, a second one that falls on it from 5 mm in step 33: impacts are then solved apart from forces."""
    blocks = [
        box("plate", (-2, -0.25, -1), (2, 0.75, 0), fixed=True),
        box("low", (0, 0, 0), (1, 0.5, 1)),
        box("high", (0.2, 0, 1.005), (1, 0.5, 2)),
    ]
    return write_scene(tmp_path, blocks, SCENE)


def test_problems_are_those_that_were_solved_and_the_run_keeps_its_bits(falling, tmp_path):
    masonry_cd("run", falling, "-o", tmp_path / "plain", "-q")
    with h5py.File(tmp_path / "plain" / "result.h5") as file:
        landing = 1 + int(np.argmax(np.diff(file["energy/impact"][...], prepend=0.0) > 1.0))
    result = done("run", falling, "-o", tmp_path / "out", "--dump-problem", f"20,{landing}", "--dump-problem", 1)
    names = ["problem_1.npz", "problem_20.npz", f"problem_{landing}_forces.npz", f"problem_{landing}_impacts.npz"]
    assert sorted(path.name for path in (tmp_path / "out").glob("problem_*")) == sorted(names)
    assert all(name in result.stdout for name in names)
    with Results.open(tmp_path / "plain" / "result.h5") as one, Results.open(tmp_path / "out" / "result.h5") as two:
        assert np.array_equal(one.position[...], two.position[...])
        assert np.array_equal(one.per_step("energy/friction"), two.per_step("energy/friction"))
        contacts = two.per_step("solver/contacts")
    for name in names:
        problem = read_problem(tmp_path / "out" / name)
        assert problem.contacts == contacts[int(name.split("_")[1].removesuffix(".npz")) - 1] or "forces" in name
        assert solve(tmp_path / "out" / name, tolerance=1e-9).value["converged"]


def test_at_rest_the_impulses_of_the_file_carry_the_weight(falling, tmp_path):
    masonry_cd("run", falling, "-o", tmp_path / "out", "--dump-problem", 20, "-q")
    problem = read_problem(tmp_path / "out" / "problem_20.npz")
    solve(tmp_path / "out" / "problem_20.npz", tolerance=1e-12, output=tmp_path / "s.npz")
    weight = 2000.0 * 0.5 * 9.81 * 1e-3  # of the lower cube over a step; the upper one is in the air
    total = np.load(tmp_path / "s.npz")["r"][:, 0].sum()
    assert total == pytest.approx(weight, rel=1e-6)
    assert problem.dimension == 2  # the scene moves in its plane


def test_an_old_problem_does_not_survive_a_new_run(falling, tmp_path):
    masonry_cd("run", falling, "-o", tmp_path / "out", "--dump-problem", 3, "-q")
    masonry_cd("run", falling, "-o", tmp_path / "out", "--dump-problem", 5, "-q", "--force")
    assert [path.name for path in (tmp_path / "out").glob("problem_*")] == ["problem_5.npz"]
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["dumped"] == ["problem_5.npz"]


def test_steps_are_counted_once_and_in_order():
    assert parse_steps(["9,2", "2"]) == (2, 9)
    with refused_at("--dump-problem"):
        parse_steps([""])


SCENE_EXPLAIN = """\
material = { density = 2000.0, friction = 0.5 }
run = { dt = 1e-3, duration = 0.06 }
"""


@pytest.fixture
def explained(tmp_path):
    """Runs two cubes, the upper of which falls by 5 mm, and a third far away; returns what was said and kept."""
    cubes = [box("low", (0, 0, 0), (1, 0.5, 1)), box("high", (0.2, 0, 1.005), (1, 0.5, 2)), box("far", (10, 0, 0), (11, 0.5, 1))]
    scene = write_scene(tmp_path, [box("plate", (-2, -0.25, -1), (12, 0.75, 0), fixed=True), *cubes], SCENE_EXPLAIN)

    def run(*changes: str) -> tuple[str, dict]:
        words = [word for change in changes for word in ("--set", change)]
        result = done("run", scene, "-o", tmp_path / "out", "--force", "--explain", *words)
        return result.stdout, json.loads((tmp_path / "out" / "summary.json").read_text())

    return run


def number(lines: list[str], pattern: str) -> tuple[int, ...]:
    """The numbers of the one line that fits."""
    (found,) = [match for line in lines if (match := re.search(pattern, line))]
    return tuple(int(group) for group in found.groups())


def test_the_numbers_are_those_of_the_run(explained):
    lines = explained()[1]["explanation"]
    assert "mirror image about y = 0.25 m" in lines[0]
    spared, possible = number(lines, r"pairs of blocks: (\d+) of (\d+) not listed")
    assert possible == 6  # four blocks
    assert spared == 3  # the far cube meets neither of the others, and the upper one does not meet the plate
    apart, steps = number(lines, r"impacts apart from forces: not solved in (\d+) of (\d+) steps")
    assert steps == 60
    assert 57 <= apart <= 59  # the cube lands once, in a step or two
    assert number(lines, r"broad phase: left out in (\d+) of (\d+) steps") == (59, 60)
    kept, far = number(lines, r"contact points kept (\d+) times, .* not looked at (\d+) times")
    assert 100 < kept < kept + far <= 60 * 3  # three listed pairs in every step, of which two stand still
    assert any("joints are rigid" in line for line in lines)
    assert any("crack_map" in line and "[report] does not ask" in line for line in lines)


def test_what_is_asked_for_is_not_left_out(explained):
    lines = explained("run.planar=false", "run.solver=nlgs", "material.joints.normal_stiffness=1e9", "report.damage=true")[1]["explanation"]
    assert lines[0] == "third dimension: kept, since run.planar is false"
    assert any(line.startswith("solvers: all but nlgs") for line in lines)
    assert not any("joints are rigid" in line for line in lines)
    assert not any("damage by part" in line for line in lines)


def test_islands_and_what_slept_are_reported(explained):
    summary = explained()[1]
    islands = summary["islands"]
    assert islands["max"] == 2  # the cubes that come to lie on each other, and the far one
    assert 0.3 < islands["sleeping_mean"] < 1.0
    mean, most, asleep = number(summary["explanation"], r"islands, .*: ([\d.]+) on average, (\d+) at most; .* (\d+)% of the blocks slept")
    assert (mean, most, asleep) == (round(islands["mean"]), 2, round(100 * islands["sleeping_mean"]))
    whole = explained("run.islands=false")[1]
    assert "islands: all blocks solved as one, since run.islands is false" in whole["explanation"]
    assert whole["islands"]["max"] == 1


def invoke(*words: object) -> tuple[int, str]:
    result = masonry_cd(*words)
    return result.exit_code, result.stderr


def test_the_estimate_is_near_the_file(block_on_plate, tmp_path: Path) -> None:
    scene = block_on_plate(duration="duration = 8.188\nframes_per_second = 500.0", dt="dt = 2e-3", amplitude="amplitude = 0.0")
    case = prepare(read_scene(scene))
    estimate = result_bytes(case.assembly, case.joints, 4_095, 4_094)  # a chunk of HDF5 has 4,096
    assert invoke("run", scene, "-o", tmp_path / "out", "-q") == (0, "")
    assert 0.8 * estimate < (tmp_path / "out" / "result.h5").stat().st_size < 1.25 * estimate + 2e5  # blocks, scene and heads of HDF5


def test_a_run_that_the_disc_has_no_room_for(block_on_plate, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, out = block_on_plate(duration="duration = 10.0\nframes_per_second = 1000.0"), tmp_path / "out"
    monkeypatch.setattr(shutil, "disk_usage", lambda place: SimpleNamespace(free=1_000_000, total=10_000_000))
    line = "run.frames_per_second: the results would take about 0.0056 GB, 0.001 GB are free where"
    code, said = invoke("run", scene, "-o", out)
    assert (code, said.count("\n")) == (2, 1)
    assert said.startswith(f"masonry-cd: error: {scene}:17: {line} {out} lies; fewer frames, "), said
    assert not out.exists()
    monkeypatch.setattr(shutil, "disk_usage", lambda place: SimpleNamespace(free=5_000_000, total=10_000_000))
    assert invoke("run", scene, "-o", out, "-q", "--set", "run.duration=0.01")[0] == 0
