# SPDX-License-Identifier: GPL-3.0-or-later
"""Bridges in runs: at rest, crossed and shaken, with the energy of the fill accounted for."""

from __future__ import annotations

import json
import math
import signal
from pathlib import Path

import numpy as np
import pytest
from command_line import masonry_cd
from datasets import contents

from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

SCENE = """title = "b"
[structure]
kind = "bridge"
width = 2.0
spans = [{{ span = 3.0, rise = 1.2, thickness = 0.25, voussoirs = 9 }}]
abutments = [{{ rigid = false, width = 1.0, height = 1.0 }}]
[structure.fill]
mobilised_at = 0.005
[material]
density = 2000.0
friction = 0.6
{load}
[run]
dt = 2e-3
duration = {duration}
tolerance = 1e-7
"""
CROSSED = '[[loads]]\nkind = "vehicle"\naxles = [20e3]\ncontact = [0.2, 0.2]\nspeed = 8.0\n'
SHAKEN = '[[loads]]\nkind = "sinusoidal"\ndirection = "x"\namplitude = 0.8\nfrequency = 2.0\ncycles = 1\n'


@pytest.mark.parametrize(("load", "duration", "moves"), [("", 0.1, False), (CROSSED, 0.7, False), (SHAKEN, 0.6, True)])
def test_a_bridge_stands_is_crossed_and_is_shaken_and_the_balance_of_energy_closes(
    tmp_path: Path, load: str, duration: float, moves: bool
) -> None:
    path = tmp_path / "b.toml"
    path.write_text(SCENE.format(load=load, duration=duration))
    done = masonry_cd("run", path, "-o", tmp_path / "out", "--quiet")
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (found["displacement_max"] > 5e-3) == moves
    assert found["solver"]["steps_missed"] == 0
    if moves:  # of a structure that stands still the largest work is next to nothing
        assert abs(found["energy"]["balance_error"]) < 1e-6


WALLED = """[structure]
kind = "bridge"
width = 4.0
cover = 0.4
spans = [{{ span = 4.0, rise = 1.4, thickness = 0.4, voussoirs = 9 }}]
walls = {{ thickness = {thickness}, course_height = 0.55, unit_length = 1.2 }}
[material]
density = 2200.0
friction = 0.6
{load}
[run]
dt = 4e-3
duration = {duration}
tolerance = 1e-5
"""


def walled(folder: Path, thickness: float, load: str = "", duration: float = 0.2) -> Path:
    path = folder / "walled.toml"
    path.write_text(WALLED.format(thickness=thickness, load=load, duration=duration))
    return path


def ran(scene: Path, out: Path) -> dict:
    done = masonry_cd("run", scene, "-o", out, "--quiet")
    assert done.exit_code == 0, done.output
    return json.loads((out / "summary.json").read_text())


@pytest.mark.parametrize("load", ["", CROSSED])
def test_walls_that_stand_by_statics_stay_at_rest_and_bear_a_crossing(tmp_path: Path, load: str) -> None:
    found = ran(walled(tmp_path, 0.85, load), tmp_path / "out")
    assert found["displacement_max"] < 1e-6
    assert not any("the wall" in line for line in found["warnings"])


def test_walls_that_stand_under_active_pressure_alone_move_out_as_far_as_that_takes_and_rest(tmp_path: Path) -> None:
    found = ran(walled(tmp_path, 0.7, duration=1.2), tmp_path / "out")
    assert 1e-3 < found["displacement_max"] < 0.02
    assert any("but 1.2 of K_a, to which it falls as the wall moves" in line for line in found["warnings"])
    with Results.open(tmp_path / "out" / "result.h5") as results:
        last = results.frames - 1
        assert float(np.abs(results.position[last] - results.position[3 * last // 4]).max()) < 1e-3


def test_walls_that_do_not_stand_fall_outwards_and_are_pushed_no_more(tmp_path: Path) -> None:
    found = ran(walled(tmp_path, 0.5, duration=1.6), tmp_path / "out")
    assert found["collapsed_blocks"] > 10
    assert abs(found["energy"]["balance_error"]) < 1e-5
    assert any("the wall overturns under its fill" in line for line in found["warnings"])
    with Results.open(tmp_path / "out" / "result.h5") as results:
        first, last = results.position[0], results.position[results.frames - 1]
        speed = float(np.sqrt((results.velocity[results.frames - 1][:, :3] ** 2).sum(axis=1)).max())
        press = results.per_step("ties/tension")
    fallen = np.flatnonzero(first[:, 2] - last[:, 2] > 0.5)
    assert (np.sign(last[fallen, 1] - first[fallen, 1]) == np.sign(first[fallen, 1])).all()
    freely = math.sqrt(2.0 * 9.81 * float((first[:, 2] - last[:, 2]).max()))
    assert speed < freely + 2.0  # the fill adds what its wedge has stored, and no more
    assert press[-1].sum() < 0.1 * press[0].sum()


def test_a_walled_bridge_that_is_shaken_resumes_to_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, advance = walled(tmp_path, 0.7, SHAKEN.replace('"x"', '"y"'), 0.16), Stepper.step
    ran(scene, tmp_path / "whole")

    def step(self: Stepper) -> object:
        if self.steps == 20:
            signal.raise_signal(signal.SIGINT)
        return advance(self)

    monkeypatch.setattr(Stepper, "step", step)
    assert masonry_cd("run", scene, "-o", tmp_path / "parts", "-q").exit_code == 130
    monkeypatch.setattr(Stepper, "step", advance)
    assert masonry_cd("run", scene, "-o", tmp_path / "parts", "-q", "--resume").exit_code == 0
    assert contents(tmp_path / "whole" / "result.h5") == contents(tmp_path / "parts" / "result.h5")
