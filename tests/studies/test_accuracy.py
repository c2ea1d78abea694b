# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against run time, alone and over ensembles: errors fall with tolerance and time step, biases show, misses are marked."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
import scenes
from block_files import cuboid
from command_line import done, masonry_cd
from pictures import main_colours
from places import EXAMPLES
from studied import SCENE, row_names, write_scene
from typer.testing import Result

from benchmarks import scenes as bench_scenes
from benchmarks.ours import stepper
from masonry_cd.analysis.run_row import DONE, RunRow
from masonry_cd.app.scene import read_scene
from masonry_cd.io.problem_files import write_problem
from masonry_cd.studies.accuracy.ensemble import (
    COLUMNS,
    MEASURES,
    EnsemblePlan,
    EnsembleRow,
    Setting,
    chance,
    good_enough,
    lines_of,
    member_cells,
    settings_of,
    spreads_of,
)
from masonry_cd.studies.accuracy.picture import table as markdown
from masonry_cd.studies.accuracy.scene_runs import ComparedMotion, SceneRow, motion_errors, run_rows
from masonry_cd.studies.accuracy.solver_rows import SolverRow, solver_rows, solvers_for
from masonry_cd.studies.study.task import Task, run_task
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
    result = done("accuracy", tmp_path / "p.npz", "-o", tmp_path / "out", "--solvers", "admm", "--tolerances", "1e-8,1e-3")
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
    found = motion_errors(ComparedMotion(time, got, 0.5 * opening, 1.0), ComparedMotion(time, best, opening, 1.0))
    assert found == pytest.approx((3.0 / 5.0, 0.5))
    longer = ComparedMotion(np.array([0.0, 1.5]), got, opening, 1.0)  # its last frame is at another time, and does not count
    assert motion_errors(longer, ComparedMotion(time, best, opening, 1.0)) == (0.0, 0.0)


def test_what_stands_still_has_no_relative_error():
    still, noise = np.zeros((2, 1, 3)), np.full((2, 1, 3), 1e-12)
    time, opening = np.array([0.0, 1.0]), np.zeros((2, 1))
    assert max(motion_errors(ComparedMotion(time, noise, opening, 5.0), ComparedMotion(time, still, opening, 5.0))) < 1e-6


def test_a_scene_gets_table_and_picture(block_on_plate, tmp_path):
    words = ("--dts", "4e-3,2e-3", "--tolerances", "1e-6", "--duration", "0.2")
    done("accuracy", block_on_plate(**SLIDING), "-o", tmp_path / "out", *words)
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


def members(values: np.ndarray, seconds: float) -> tuple[RunRow, ...]:
    """Runs whose measures are all the same number."""
    rest = {"grade": "D1", "collapsed_blocks": 0, "steps": 100, "steps_missed": 0, "error_max": 1e-6}
    columns = [COLUMNS[key] for key in MEASURES]
    return tuple(RunRow(DONE, numbers=rest | dict.fromkeys(columns, float(v)), timing={"processor": seconds}) for v in values)


def row(values: np.ndarray, finest: np.ndarray, seconds: float, tolerance: float) -> EnsembleRow:
    own = members(values, seconds)
    return EnsembleRow(Setting("auto", 4e-3, tolerance), own, spreads_of(own, members(finest, 8.0)), finest=values is finest)


def test_a_bias_is_unlikely_and_equal_samples_are_certain():
    random = np.random.default_rng(3)
    first, second = random.normal(size=12), random.normal(size=12)
    assert chance(first, first[::-1]) == 1.0
    assert chance(first, second) > 0.05
    assert chance(first, second + 3.0) < 1e-3


def test_members_differ_by_their_amplitude_and_keep_their_setting(tmp_path: Path):
    """Runs of one length: what would end them at rest is taken out."""
    write_scene(tmp_path, SCENE.replace("tolerance = 1e-6", "longest = 5.0\nuntil_still = true"))
    settings = settings_of(("nlgs",), (1e-2, 5e-3), (1e-6,))
    plan = EnsemblePlan(read_scene(tmp_path / "scene.toml"), settings, 3)
    scenes = [plan.maker.tables(run.asked) for run in plan.runs]
    assert [tables["run"]["dt"] for tables in scenes] == [1e-2, 5e-3] * 3
    assert [tables["loads"][0]["amplitude"] for tables in scenes[::2]] == pytest.approx(
        [0.4, 0.4 * (1 + 1e-9), 0.4 * (1 + 2e-9)], rel=1e-14
    )
    assert len({tables["loads"][0]["amplitude"] for tables in scenes}) == 3
    found = member_cells(run_task(Task("a", scenes[0], 60.0)).row)
    assert (found["steps"], found["steps_missed"], found["collapsed_blocks"]) == (50, 0, 0)
    assert found["displacement_max"] == pytest.approx(found["sliding_max"], rel=1e-3)
    assert found["sliding_max"] > 1e-3 > found["opening_max"]
    assert found["seconds"] > 0.0 and found["drift"] >= 0.0


def test_the_finest_setting_comes_last_once():
    settings = settings_of(("admm", "auto"), (2e-3, 4e-3), (1e-3, 1e-6))
    assert len(settings) == len(set(settings)) == 8
    assert settings[-1] == Setting("admm", 2e-3, 1e-6)


def test_the_cheapest_setting_without_a_bias_is_good_enough():
    random = np.random.default_rng(6)
    finest = 0.05 + 2e-3 * random.standard_normal(10)
    rows = [
        row(1.5 * (0.05 + 2e-3 * random.standard_normal(10)), finest, 1.0, 1e-3),
        row(finest + 1e-4 * random.standard_normal(10), finest, 4.0, 1e-5),
        row(finest, finest, 8.0, 1e-6),
    ]
    assert [one.is_biased for one in rows] == [True, False, False]
    assert not rows[0].spreads["opening_max"].within
    assert good_enough(rows) is rows[1]
    assert str(rows[1].setting) in lines_of("A scene", rows)[-1]
    assert "only the finest" in lines_of("A scene", [rows[0], rows[2]])[-1]


def test_a_difference_that_matters_to_nobody_is_no_bias():
    """All members agree to 1e-9, and the settings differ by 1 %: beyond all chance, and still of no account."""
    finest = 0.05 * (1.0 + 1e-9 * np.arange(8))
    close, off = row(1.01 * finest, finest, 1.0, 1e-3), row(1.03 * finest, finest, 1.0, 1e-3)
    assert close.spreads["opening_max"].chance < 0.01
    assert [close.is_biased, off.is_biased] == [False, True]


@pytest.mark.slow(reason="starts workers several times")
def test_a_row_per_setting_and_one_per_run_which_are_kept(tmp_path: Path):
    """With more members the new ones are made; another scene is refused."""
    out = tmp_path / "out"

    def measured(count: int, *more: object) -> Result:
        words = ("--ensemble", count, "--workers", 2, "--duration", 0.05, "--tolerances", "1e-8,1e-4", *more)
        return masonry_cd("accuracy", EXAMPLES / "arch.toml", "-o", out, *words)

    def table(name: str) -> list[dict[str, str]]:
        with (out / name).open(encoding="utf-8") as file:
            return [{key: value for key, value in row.items() if key != "seconds"} for row in csv.DictReader(file)]

    done = measured(4)
    assert done.exit_code == 0, done.output
    rows, whole, kept = table("accuracy.csv"), table("members.csv"), row_names(out)
    assert [(float(row["tolerance"]), row["finest"]) for row in rows] == [(1e-4, "False"), (1e-8, "True")]
    assert all(row["grades"] == "4 D0" for row in rows)
    assert all(rows[1][f"{key}_chance"] == "1" for key in MEASURES)
    assert len(whole) == len(kept) == 8
    found = json.loads((out / "accuracy.json").read_text(encoding="utf-8"))
    assert found["lines"][-1].startswith("good enough: ") and found["lines"][-1] in done.output
    assert (out / "accuracy.png").read_bytes().startswith(b"\x89PNG")
    assert "10 runs, 2 still to run" in measured(5).stderr
    assert {name: row_names(out)[name] for name in kept} == kept
    assert [row for row in table("members.csv") if row["member"] != "4"] == whole
    other = measured(5, "--set", "material.friction=0.7")
    assert other.exit_code == 2 and "of another scene" in other.stderr


def test_blocks_that_are_wrong_are_reported_before_anything_is_written(tmp_path: Path):
    (tmp_path / "scene.toml").write_text(SCENE)
    block = cuboid((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)) | {"name": "b", "fixed": True}
    block["faces"] = block["faces"][:-1]
    (tmp_path / "blocks.json").write_text(json.dumps({"units": "m", "blocks": [block]}))
    done = masonry_cd("accuracy", tmp_path / "scene.toml", "-o", tmp_path / "out", "--ensemble", 4)
    assert (done.exit_code, len(done.stderr.splitlines())) == (2, 1)
    assert 'block "b"' in done.stderr and "open" in done.stderr
    assert not (tmp_path / "out").exists()
