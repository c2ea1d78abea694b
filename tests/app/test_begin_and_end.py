# SPDX-License-Identifier: GPL-3.0-or-later
"""How a run begins and ends: velocities that its blocks begin with, and run.until_still, which follows them until they are still."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_run import box
from models import advance
from small_runs import write_scene

from masonry_cd.app.case import Case, prepare
from masonry_cd.app.closing_lines import closing_lines
from masonry_cd.app.progress import Interrupted
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import Origin, read_scene, scene_of
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.start import drawn_velocities

SCENE = """
[material]
density = 2000.0
friction = 0.7

[[loads]]
kind = "sinusoidal"
direction = "x"
amplitude = 0.9
frequency = 1.0
cycles = 1

[run]
dt = 4e-3
duration = 1.0
tolerance = 1e-6
"""


def case(folder: Path, *changes: str) -> Case:
    base = box("base", (-1, -1, -0.2), (1, 1, 0), "base", fixed=True)
    scene = write_scene(folder, [base, box("block", (-0.2, -0.2, 0), (0.2, 0.2, 0.9))], SCENE)
    return prepare(read_scene(scene, changes))


def run(folder: Path, *changes: str) -> Summary:
    return run_case(case(folder, *changes), folder / "out")


def test_a_block_that_rocks_at_the_end_of_its_duration_is_followed_until_it_is_still(tmp_path: Path) -> None:
    short = run(tmp_path)
    assert short.steps == short.steps_asked == 250
    assert short.provisional.startswith("provisional: still moving at ")
    assert not any(line.startswith("rest: ") for line in closing_lines(short))
    long = run(tmp_path, "run.until_still=true")
    assert any(line.startswith(f"rest: {4e-3 * (long.steps - 250):.4g} s more") for line in closing_lines(long))
    assert 250 < long.steps < 1750
    assert long.provisional == ""
    assert (short.ended_still, long.ended_still) == (False, True)
    with Results.open(tmp_path / "out" / "result.h5") as results:
        assert results.time[-1] == pytest.approx(long.steps * 4e-3)
        speed = np.abs(results.velocity[: results.frames])
        assert speed[-1].max() < 1e-3
        fixed = np.array([block.fixed for block in results.blocks])
        assert not speed[results.time > 1.001][:, fixed].any()  # the base rests


def test_steps_that_adapt_go_on_until_the_block_is_still(tmp_path: Path) -> None:
    adaptive = ("run.until_still=true", 'run.dt="auto"', "run.dt_max=8e-3", "run.dt_min=1e-3")
    assert case(tmp_path, *adaptive).steps == 7000  # of the shortest
    summary = run(tmp_path, *adaptive)
    assert summary.provisional == ""
    assert any(line.startswith("rest: ") and line.endswith("until all blocks were still") for line in closing_lines(summary))
    assert summary.steps < summary.longest / 1e-3
    with Results.open(tmp_path / "out" / "result.h5") as results:
        assert 1.0 < results.time[-1] < 7.0
        assert np.isclose(results.per_step("step_time"), 1.0, atol=1e-12).any()  # a step ends where the rest begins
        assert np.abs(results.velocity[results.frames - 1]).max() < 1e-3


def test_it_ends_at_the_bound_and_says_so(tmp_path: Path) -> None:
    summary = run(tmp_path, "run.until_still=true", "run.longest=1.1")
    assert summary.steps == 275
    assert not summary.ended_still
    assert summary.provisional.startswith("provisional: still moving at ")
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["provisional"] == summary.provisional


def test_one_that_is_still_when_its_duration_ends_gets_no_step_more(tmp_path: Path) -> None:
    assert run(tmp_path, "run.until_still=true", "loads[0].amplitude=1e-3", "run.duration=2.0").steps == 500


def test_damage_asks_for_it_by_default_and_may_be_asked_not_to(tmp_path: Path) -> None:
    assert case(tmp_path, "report.damage=true").steps == 1750
    assert case(tmp_path, "report.damage=true", "run.until_still=false").steps == 250
    assert case(tmp_path).steps == 250


def test_a_resumed_rest_ends_with_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = run(tmp_path, "run.until_still=true")
    with Results.open(tmp_path / "out" / "result.h5") as results:
        there = results.position[: results.frames]
    made = case(tmp_path, "run.until_still=true")
    from masonry_cd.app import run_case as module

    class Stopped(module.Progress):
        def __call__(self, done: int) -> None:
            if done == 400:
                raise Interrupted(2)

    with monkeypatch.context() as patched:
        patched.setattr(module, "Progress", Stopped)
        broken = run_case(made, tmp_path / "broken")
    assert broken.steps == 400
    assert broken.provisional.startswith("provisional: interrupted after step 400")
    resumed = run_case(case(tmp_path, "run.until_still=true"), tmp_path / "broken", resume=True)
    assert resumed.steps == whole.steps
    with Results.open(tmp_path / "broken" / "result.h5") as results:
        assert np.array_equal(results.position[: results.frames], there)


def test_a_solver_for_the_plane_alone_is_not_replaced_in_silence(tmp_path: Path) -> None:
    asked = "run.solver=pivoting"
    assert not any("pivoting" in line for line in case(tmp_path, asked).warnings)
    assert [line for line in case(tmp_path, asked, "run.planar=false").warnings if '"interior" stands in' in line]


def test_a_base_that_still_moves_at_the_end_ends_the_run_there(tmp_path: Path) -> None:
    assert case(tmp_path, "report.damage=true", "run.duration=0.24").steps == 60  # by default it is left, and reported as provisional


def test_what_the_tolerance_does_not_resolve_counts_as_still(tmp_path: Path) -> None:
    """tolerance g dt sqrt(contacts): 1e-8 resolves far less than 1 mm/s, 0.1 no less than 8 mm/s."""
    assert case(tmp_path, "run.tolerance=1e-8").still == pytest.approx(1e-3)
    assert case(tmp_path, "run.tolerance=0.1").still == pytest.approx(0.1 * 9.81 * 4e-3 * 2.0)


def test_the_summary_and_the_result_say_below_which_speed_is_still(tmp_path: Path) -> None:
    summary = run(tmp_path, "run.tolerance=0.1", "run.duration=0.1", "loads[0].amplitude=0.0")
    with Results.open(tmp_path / "out" / "result.h5") as results:
        assert results.closing.still == summary.still == pytest.approx(0.1 * 9.81 * 4e-3 * 2.0)


def test_a_sequence_that_rests_at_its_end_needs_no_rest_more(tmp_path: Path) -> None:
    shape = 'spectrum="EC8", ag=0.5, ground="B", duration=3.0, rise=0.5, level=1.5, seed=1, tolerance=0.3, periods=[0.1, 0.5]'
    shock = f'{{components=[{{direction="x", {shape}}}]}}'
    loads = f'loads=[{{kind="sequence", longest_rest=1.0, shocks=[{shock}]}}]'
    made = case(tmp_path, loads, "run.duration=20.0", "report.damage=true")
    end = made.loading.pauses[0].last
    assert made.loading.pauses[1].last == made.steps == 11250, "time is left after the rest"
    assert case(tmp_path, loads, f"run.duration={4e-3 * end}", "report.damage=true").steps == end


WALL = {"kind": "wall", "length": 1.0, "thickness": 0.5, "height": 1.0, "course_height": 0.5, "unit_length": 0.5}
SHAKEN = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.3, "frequency": 2.0, "cycles": 1}


def case_velocities(velocities: dict[str, Any] | None, path: Path = Path("scene.toml"), **run: Any) -> Case:
    """A wall that is shaken."""
    own = {"dt": 1e-2, "duration": 0.2, "tolerance": 1e-8, **run, **({"first_velocities": velocities} if velocities else {})}
    tables = {"structure": WALL, "material": {"density": 2000.0, "friction": 0.6}, "loads": [SHAKEN], "run": own}
    return prepare(scene_of(tables, dump_toml(tables), path, Origin("", path)))


def last_position(folder: Path) -> np.ndarray:
    """Return the position of the blocks at the end of a run (B, 3) [m]."""
    with Results.open(folder / "result.h5") as results:
        return np.array(results.position[-1])


@pytest.mark.parametrize("planar", [True, False])
def test_the_account_begins_with_the_energy_of_the_drawn_velocities(planar: bool) -> None:
    made = case_velocities({"size": 1e-3, "seed": 4}, planar=planar)
    loading, settings = made.loading, made.scene.run
    machine = Stepper(made.assembly, loading.support_velocity, loading.acceleration, settings)
    assert settings.first_velocities is not None
    velocity = drawn_velocities(machine.system, settings.first_velocities)
    machine.kick(velocity)
    free = ~made.assembly.fixed
    begun = 0.5 * np.sum(made.assembly.mass[free, None] * velocity[free, :3] ** 2)
    assert machine.motion.energy.begun == pytest.approx(begun, rel=1e-12)
    assert np.array_equal(machine.state.velocity[free], velocity[free])
    assert not machine.state.velocity[~free].any()
    assert 0.0 < np.abs(velocity[free, :3]).max() <= 1e-3
    assert (machine.plane is not None) == planar
    assert velocity[:, 1].any() != planar
    advance(machine, 10)
    assert abs(machine.energy["balance"]) < 1e-6 * begun  # it closes to rounding of the work of the base, which is far larger


def test_a_seed_gives_the_same_bits_and_another_one_others(tmp_path: Path) -> None:
    ends = {}
    for name, seed in {"rest": None, "a": 1, "again": 1, "b": 2}.items():
        run_case(case_velocities(None if seed is None else {"size": 1e-4, "seed": seed}), tmp_path / name)
        ends[name] = last_position(tmp_path / name)
    assert np.array_equal(ends["a"], ends["again"])
    assert not np.array_equal(ends["a"], ends["b"])
    assert not np.array_equal(ends["a"], ends["rest"])
    assert np.abs(ends["a"] - ends["rest"]).max() < 1e-3


def test_a_resumed_run_is_not_set_in_motion_again(tmp_path: Path) -> None:
    path, velocities = tmp_path / "scene.toml", {"size": 1e-2, "seed": 3}
    made = case_velocities(velocities, path, checkpoint_every=0.0)
    run_case(made, tmp_path / "unbroken")
    stopped = run_case(made, tmp_path / "broken", limit=1e-9)
    assert stopped.stopped
    summary = run_case(made, tmp_path / "broken", resume=True)
    assert not summary.stopped
    assert np.array_equal(last_position(tmp_path / "broken"), last_position(tmp_path / "unbroken"))
