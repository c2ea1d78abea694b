# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction problems of a run written to files: what is written is what was solved, and the run does not notice."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest
from command_line import masonry_cd
from hostile import refused_at
from made_run import box

from masonry_cd.app.commands.solve import solve
from masonry_cd.app.dump import parse_steps
from masonry_cd.io.problem_files import read_problem
from masonry_cd.io.results import Results
from structures.files import blockfile

SCENE = """\
structure = { kind = "file", path = "blocks.json" }
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
    blockfile.write(tmp_path / "blocks.json", blocks)
    (tmp_path / "scene.toml").write_text(SCENE)
    return tmp_path / "scene.toml"


def test_problems_are_those_that_were_solved_and_the_run_keeps_its_bits(falling, tmp_path):
    masonry_cd("run", falling, "-o", tmp_path / "plain", "-q")
    with h5py.File(tmp_path / "plain" / "result.h5") as file:
        landing = 1 + int(np.argmax(np.diff(file["energy/impact"][...], prepend=0.0) > 1.0))
    result = masonry_cd("run", falling, "-o", tmp_path / "out", "--dump-problem", f"20,{landing}", "--dump-problem", 1)
    assert result.exit_code == 0, result.output
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
