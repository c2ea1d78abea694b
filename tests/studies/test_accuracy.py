# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against run time: errors fall with the tolerance and the time step, rows come in order, and what was missed is marked."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
import scenes
from command_line import masonry_cd
from pictures import main_colours

from benchmarks import scenes as bench_scenes
from benchmarks.ours import stepper
from masonry_cd.io.problem_files import write_problem
from masonry_cd.studies.accuracy.picture import table as markdown
from masonry_cd.studies.accuracy.scene_runs import Motion, SceneRow, motion_errors, run_rows
from masonry_cd.studies.accuracy.solver_rows import SolverRow, solver_rows, solvers_for
from reports.drawing.figure import COLOURS

SLIDING = {"friction": "friction = 0.3", "amplitude": "amplitude = 0.6", "duration": "duration = 0.4", "dt": "dt = 4e-3"}


def table(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def quiet(line: str) -> None:
    """Say nothing."""


def test_solvers_come_in_order_with_errors_below_their_tolerances():
    rows = solver_rows(scenes.wall(4, 4), ("admm", "newton"), (1e-2, 1e-5, 1e-9), 2, quiet)
    assert [(row.solver, row.tolerance) for row in rows] == [(s, t) for s in ("admm", "newton") for t in (1e-2, 1e-5, 1e-9)]
    assert all(row.reached and row.error <= row.tolerance and row.repeats == 2 for row in rows)
    for solver in ("admm", "newton"):
        errors, iterations = zip(*((row.error, row.iterations) for row in rows if row.solver == solver), strict=True)
        assert list(errors) == sorted(errors, reverse=True)
        assert list(iterations) == sorted(iterations)


def test_a_miss_is_marked_and_ends_the_line_of_a_solver():
    problem = scenes.tower(60)  # a sweep of Gauss-Seidel carries the error on by one joint
    rows = solver_rows(problem, ("nlgs", "admm"), (1e-1, 1e-12, 1e-13), 1, quiet)
    nlgs = [row for row in rows if row.solver == "nlgs"]
    assert [row.reached for row in nlgs] == [True, False]
    assert nlgs[-1].error > 1e-12
    assert "**missed**" in markdown([vars(row) for row in nlgs]).splitlines()[-1]
    assert len([row for row in rows if row.solver == "admm"]) >= 2


def test_solvers_are_not_measured_where_another_would_stand_in_for_them():
    problem = scenes.wall(2, 2)
    assert "interior" in solvers_for(problem, None)
    assert "interior" not in solvers_for(problem.to_local(), None)
    assert "pivoting" not in solvers_for(problem, None)
    assert "pivoting" in solvers_for(stepper(bench_scenes.wall(2, 2), 1).friction_problem().problem, None)


def test_a_problem_file_gets_table_picture_and_lines(tmp_path):
    write_problem(tmp_path / "p.npz", scenes.wall(3, 3))
    result = masonry_cd("accuracy", tmp_path / "p.npz", "-o", tmp_path / "out", "--solvers", "admm", "--tolerances", "1e-8,1e-3")
    assert result.exit_code == 0, result.output
    rows = table(tmp_path / "out" / "accuracy.csv")
    assert tuple(rows[0]) == tuple(SolverRow.__dataclass_fields__)
    assert [float(row["tolerance"]) for row in rows] == [1e-3, 1e-8]
    assert (tmp_path / "out" / "accuracy.png").read_bytes().startswith(b"\x89PNG")
    assert "| admm" in (tmp_path / "out" / "accuracy.md").read_text()
    assert "admm: reached all, the tightest, 1e-08" in result.stdout


def test_the_error_of_a_run_falls_with_the_time_step(block_on_plate):
    """A block that slides: the time at which it starts and stops is met to about a step."""
    rows = run_rows(block_on_plate(**SLIDING), (), ("nlgs",), (8e-3, 4e-3, 2e-3, 1e-3), (1e-8,), 1, quiet)
    assert rows[0].reference
    assert rows[0].dt == 5e-4
    assert rows[0].displacement_error == rows[0].opening_error == 0.0
    assert [row.dt for row in rows[1:]] == [8e-3, 4e-3, 2e-3, 1e-3]
    errors = [row.displacement_error for row in rows[1:]]
    assert errors == sorted(errors, reverse=True)
    order = np.polyfit(np.log([row.dt for row in rows[1:]]), np.log(errors), 1)[0]
    assert order > 0.7  # first order at least; close to the reference errors fall faster
    assert all(row.reached and row.joints_slid == 1 for row in rows)


def test_the_error_of_a_run_falls_with_the_tolerance(block_on_plate):
    rows = run_rows(block_on_plate(**SLIDING), (), ("nlgs",), (4e-3,), (0.5, 1e-2, 1e-6), 1, quiet)
    errors = [row.displacement_error for row in rows[1:]]
    assert [row.tolerance for row in rows[1:]] == [0.5, 1e-2, 1e-6]
    assert errors[0] > 2.0 * errors[2]
    assert errors[1] == pytest.approx(errors[2], rel=0.1)  # what is left is that of the time step


def test_errors_are_those_of_the_head_of_the_module():
    """Two blocks, of which one is off by 3 mm at one of two times, where the reference has moved by 4 mm and 3 mm at most."""
    best = np.zeros((2, 2, 3))
    best[1, 0, 0], best[1, 1, 2] = 4e-3, 3e-3
    got = best.copy()
    got[1, 0, 1] = 3e-3
    opening = np.array([[0.0], [2e-3]])
    time = np.array([0.0, 1.0])
    found = motion_errors(Motion(time, got, 0.5 * opening, 1.0), Motion(time, best, opening, 1.0))
    assert found == pytest.approx((3.0 / 5.0, 0.5))
    longer = Motion(np.array([0.0, 1.5]), got, opening, 1.0)  # its last frame is at another time, and does not count
    assert motion_errors(longer, Motion(time, best, opening, 1.0)) == (0.0, 0.0)


def test_what_stands_still_has_no_relative_error():
    still, noise = np.zeros((2, 1, 3)), np.full((2, 1, 3), 1e-12)
    time, opening = np.array([0.0, 1.0]), np.zeros((2, 1))
    assert max(motion_errors(Motion(time, noise, opening, 5.0), Motion(time, still, opening, 5.0))) < 1e-6


def test_a_scene_gets_table_and_picture(block_on_plate, tmp_path):
    words = ("--dts", "4e-3,2e-3", "--tolerances", "1e-6", "--duration", "0.2")
    result = masonry_cd("accuracy", block_on_plate(**SLIDING), "-o", tmp_path / "out", *words)
    assert result.exit_code == 0, result.output
    rows = table(tmp_path / "out" / "accuracy.csv")
    assert tuple(rows[0]) == tuple(SceneRow.__dataclass_fields__)
    assert [(row["dt"], row["steps"], row["reference"]) for row in rows] == [
        ("0.001", "200", "True"), ("0.004", "50", "False"), ("0.002", "100", "False"),
    ]  # fmt: skip
    assert COLOURS[0] in main_colours(tmp_path / "out" / "accuracy.png"), "the curve of the tolerance"


@pytest.mark.parametrize("option", ["--duration", "--ensemble"])
def test_options_of_a_scene_are_refused_for_a_problem(tmp_path, option):
    write_problem(tmp_path / "p.npz", scenes.wall(2, 2))
    result = masonry_cd("accuracy", tmp_path / "p.npz", "-o", tmp_path / "out", option, 4)
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)
    assert option in result.stderr
    assert masonry_cd("accuracy", tmp_path / "none.npz", "-o", tmp_path / "out").exit_code == 2
