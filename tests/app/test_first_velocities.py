# SPDX-License-Identifier: GPL-3.0-or-later
"""Velocities that the blocks of a scene begin with: their energy, their bits, their plane, and resumed runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from masonry_cd.app.case import Case, prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import Origin, scene_of
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.start import drawn_velocities

WALL = {"kind": "wall", "length": 1.0, "thickness": 0.5, "height": 1.0, "course_height": 0.5, "unit_length": 0.5}
SHAKEN = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.3, "frequency": 2.0, "cycles": 1}


def case(velocities: dict[str, Any] | None, path: Path = Path("scene.toml"), **run: Any) -> Case:
    """A wall that is shaken."""
    own = {"dt": 1e-2, "duration": 0.2, "tolerance": 1e-8, **run, **({"first_velocities": velocities} if velocities else {})}
    tables = {"structure": WALL, "material": {"density": 2000.0, "friction": 0.6}, "loads": [SHAKEN], "run": own}
    return prepare(scene_of(tables, dump_toml(tables), path, Origin("", path)))


def last_position(folder: Path) -> np.ndarray:
    """Of the blocks at the end of a run (B, 3) [m]."""
    with Results.open(folder / "result.h5") as results:
        return np.array(results.position[-1])


@pytest.mark.parametrize("planar", [True, False])
def test_the_account_begins_with_the_energy_of_the_drawn_velocities(planar: bool) -> None:
    made = case({"size": 1e-3, "seed": 4}, planar=planar)
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
    for _ in range(10):
        machine.step()
    assert abs(machine.energy["balance"]) < 1e-6 * begun  # it closes to rounding of the work of the base, which is far larger


def test_a_seed_gives_the_same_bits_and_another_one_others(tmp_path: Path) -> None:
    ends = {}
    for name, seed in {"rest": None, "a": 1, "again": 1, "b": 2}.items():
        run_case(case(None if seed is None else {"size": 1e-4, "seed": seed}), tmp_path / name)
        ends[name] = last_position(tmp_path / name)
    assert np.array_equal(ends["a"], ends["again"])
    assert not np.array_equal(ends["a"], ends["b"])
    assert not np.array_equal(ends["a"], ends["rest"])
    assert np.abs(ends["a"] - ends["rest"]).max() < 1e-3


def test_a_resumed_run_is_not_set_in_motion_again(tmp_path: Path) -> None:
    path, velocities = tmp_path / "scene.toml", {"size": 1e-2, "seed": 3}
    made = case(velocities, path, checkpoint_every=0.0)
    run_case(made, tmp_path / "unbroken")
    stopped = run_case(made, tmp_path / "broken", limit=1e-9)
    assert stopped.stopped
    summary = run_case(made, tmp_path / "broken", resume=True)
    assert not summary.stopped
    assert np.array_equal(last_position(tmp_path / "broken"), last_position(tmp_path / "unbroken"))
