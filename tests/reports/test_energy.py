# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of the energies: what it draws closes, and it is drawn for short, long and killed runs."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import masonry_cd
from models import stepper, still, wall
from pictures import main_colours

from masonry_cd.app.run_loop import Plan, run
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.find_joints import find_joints
from reports.drawing.figure import COLOURS
from reports.outputs import energy as picture
from reports.outputs.energy import GOES, WORKS, energies, energy_figure


@pytest.fixture(scope="module")
def shaken(tmp_path_factory) -> Path:
    """A wall on a base that shakes so that it slides."""
    path, steps = tmp_path_factory.mktemp("energy") / "result.h5", 120
    velocity = still(steps)
    velocity[:, 0, 0] = 0.8 * np.sin(2 * np.pi * 4.0 * np.arange(steps + 1) * 2e-3)
    machine = stepper(wall(2, 2), steps, support_velocity=velocity, dt=2e-3, friction=0.4, tolerance=1e-8)
    joints = find_joints(machine.assembly)
    with ResultWriter(path, machine.assembly, joints, title="a wall") as writer:
        run(machine, joints, writer, Plan(steps, 20))
    return path


def test_what_is_drawn_closes(shaken):
    """The areas reach up to the line of what was put in, but for the balance."""
    with Results.open(shaken) as results:
        time, energy = energies(results)
    assert len(time) == 120
    put_in = sum(energy[key] for key in WORKS if key in energy)
    went = sum(energy[key] for key in GOES if key in energy)
    assert put_in.max() > 1.0
    assert energy["friction"][-1] > 0.1 * put_in.max()
    assert np.abs(put_in - went - energy["balance"]).max() < 1e-9 * put_in.max()
    assert np.abs(put_in - went).max() < 1e-6 * put_in.max()


def test_a_long_run_is_thinned_from_end_to_end(shaken, monkeypatch):
    monkeypatch.setattr(picture, "POINTS", 10)
    with Results.open(shaken) as results:
        time, energy = energies(results)
    assert len(time) == len(energy["kinetic"]) == 10
    assert (time[0], time[-1]) == pytest.approx((2e-3, 0.24))


def test_the_command_draws_it(shaken):
    result = masonry_cd("report", shaken.parent, "--energy", "--no-crack-map")
    assert result.exit_code == 0, result.output
    assert "energy.png" in result.stdout
    assert set(COLOURS[1:3]) <= main_colours(shaken.parent / "energy.png"), "the work of the base, and that of gravity"


def test_a_run_without_a_step_is_one_line(shaken, tmp_path):
    (tmp_path / "result.h5").write_bytes(shaken.read_bytes())
    with h5py.File(tmp_path / "result.h5", "r+") as file:
        del file.attrs["format"]  # as by a version that wrote no checksums, and killed
        file["step_time"].resize(0, axis=0)
    with Results.open(tmp_path / "result.h5") as results, pytest.raises(InputError, match="the run made no step"):
        energy_figure(results)
