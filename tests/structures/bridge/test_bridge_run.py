# SPDX-License-Identifier: GPL-3.0-or-later
"""Bridges in runs: at rest, crossed and shaken, with the energy of the fill accounted for."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from masonry_cd.cli.app import app

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
    done = CliRunner().invoke(app, ["run", str(path), "-o", str(tmp_path / "out"), "--quiet"])
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (found["displacement_max"] > 5e-3) == moves
    assert found["solver"]["steps_missed"] == 0
    if moves:  # of a structure that stands still the largest work is next to nothing
        assert abs(found["energy"]["balance_error"]) < 1e-6
