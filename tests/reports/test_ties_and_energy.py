# SPDX-License-Identifier: GPL-3.0-or-later
"""The tension that ties had to bear, and the picture of the energies, which closes: drawn from the result file alone."""

from __future__ import annotations

import csv
from pathlib import Path

import browser as browsers
import h5py
import numpy as np
import pytest
from command_line import done
from models import stepper, still, wall
from pictures import crack_map, main_colours
from PIL import Image
from places import EXAMPLES

from masonry_cd.analysis.ties import histories
from masonry_cd.app import run_loop
from masonry_cd.app.case import make_structures, prepare
from masonry_cd.app.closing_lines import closing_lines
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results
from masonry_cd.io.summary import read_summary
from masonry_cd.mechanics.contact.find_joints import find_joints
from reports.drawing.figure import COLOURS, Sheet
from reports.drawing.palette import PULLING
from reports.drawing.solids import structure_scene
from reports.outputs import energy as picture
from reports.outputs.energy import GOES, WORKS, energies, energy_figure
from reports.page import write_page
from reports.ties import tie_lines, tie_tensions
from structures.ties import lines_of

COLOUR = tuple(int(PULLING[i : i + 2], 16) for i in (1, 3, 5))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tied arch up to where its tie has yielded, and its summary as written."""
    folder = tmp_path_factory.mktemp("ties")
    changes = ["run.duration=0.08", "run.until_still=false", "report.html=false", "report.crack_map=false", "structure.ties[0].plate=0.5"]
    run_case(prepare(read_scene(EXAMPLES / "arch_tied.toml", changes)), folder)
    return folder


def purple(path: Path) -> np.ndarray:
    """Where a picture has the colour of ties, (N, 2) row and column."""
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    return np.argwhere(np.abs(pixels - COLOUR).max(axis=2) <= 2)


def test_bars_of_one_name_are_one_tie_whose_tension_is_their_sum(run):
    with Results.open(run / "result.h5") as results:
        (tie,) = histories(results)
        tension = results.per_step("ties/tension")
        assert len(tie.bars) == tension.shape[1] == 4  # two blocks under either plate
        assert tie.total == pytest.approx(tension.sum(axis=1))
        assert tie.area == pytest.approx(np.pi * 1e-4)
        assert tie.at(0.01) == tie.total[np.searchsorted(tie.time, 0.01 * (1 + 1e-9)) - 1]
        row = tie.row()
    assert row.tension_max == pytest.approx(9e3)
    assert row.yielded
    assert tie.total[np.searchsorted(tie.time, row.yield_time)] > 8e3
    summary = read_summary(run)
    assert summary is not None and summary.ties == (row,)
    (line,) = (line for line in closing_lines(summary) if line.startswith("tie "))
    assert line.startswith('tie "springings" ("buttress1.')
    assert f", yielded from {row.yield_time:.3g} s on" in line


def test_the_table_has_a_row_for_each_tie(run):
    with open(run / "ties.csv", encoding="utf-8") as file:
        (row,) = csv.DictReader(file)
    assert (row["tie"], row["bars"], row["yielded"]) == ("springings", "4", "true")
    assert float(row["yield_force"]) == pytest.approx(9e3)
    assert float(row["stress_max"]) == pytest.approx(float(row["tension_max"]) / (np.pi * 1e-4))


def test_the_crack_map_shows_the_tie_where_it_is(run, tmp_path):
    with Results.open(run / "result.h5") as results:
        crack_map(results, tmp_path / "map.png")
    rows = purple(tmp_path / "map.png")
    widest = np.bincount(rows[:, 0]).argmax()
    columns = rows[rows[:, 0] == widest, 1]
    assert np.ptp(columns) > 800  # from face to face of the picture's structure
    assert np.ptp(rows[:, 0][rows[:, 1] == int(columns.mean())]) < 60  # a level line, and letters above it


def test_the_picture_of_a_structure_shows_its_ties(tmp_path):
    made = make_structures(read_scene(EXAMPLES / "arch_tied.toml"))
    Sheet.drawn(structure_scene(made.blocks, "tied", ties=lines_of(made.ties))).save(tmp_path / "with.png")
    Sheet.drawn(structure_scene(made.blocks, "loose")).save(tmp_path / "without.png")
    assert len(purple(tmp_path / "with.png")) > 2000
    assert not len(purple(tmp_path / "without.png"))


def test_the_page_has_a_line_for_each_tie(run):
    with Results.open(run / "result.h5") as results:
        arrays = tie_lines(results, np.array([1.0, 0.0, 0.0]))
        held = [results.blocks[b].name for b in arrays["tie_block"]]
    assert arrays["tie_point"].shape == (2, 3)
    assert arrays["tie_point"][:, 0] == pytest.approx([-3.6, 1.6], abs=0.05)  # as built, from the origin
    assert [name.split(".")[0] for name in held] == ["buttress1", "buttress2"]


def test_the_page_has_the_tension_of_each_tie_at_its_frames(run):
    with Results.open(run / "result.h5") as results:
        times = np.asarray(results.time)
        (tie,) = histories(results)
        arrays = tie_tensions(results, times)
    assert arrays["tie_tension"].shape == (1, len(times))
    assert arrays["tie_tension"][0] == pytest.approx([tie.at(time) for time in times], rel=1e-6)
    assert arrays["tie_tension"][0].max() > 5e3


@pytest.mark.skipif(bool(browsers.missing()), reason=browsers.missing())
def test_the_model_names_the_tension_next_to_its_tie(run, tmp_path):
    with Results.open(run / "result.h5") as results:
        write_page(results, tmp_path / "report.html", read_summary(run))
        (tie,) = histories(results)
        last = float(results.time[-1])
    with browsers.browser(tmp_path) as page:
        page.open(tmp_path / "report.html")
        labels = "done([...document.querySelectorAll('#tensions span')].map((s) => s.textContent))"
        drawn = f"requestAnimationFrame(() => requestAnimationFrame(() => {labels}))"
        (label,) = page.run_async(f"masonry.seek(1e9); {drawn}")
        assert float(label.removesuffix(" kN")) == pytest.approx(tie.at(last) / 1e3, rel=5e-3)
        page.click("#tension")
        assert page.run_async(drawn) == []
        assert page.complaints() == []


def test_the_page_does_not_call_the_ties_of_a_structure_left_out(run, tmp_path):
    with Results.open(run / "result.h5") as results:
        write_page(results, tmp_path / "report.html", read_summary(run))
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "What is not modelled" in text and "Ties and anchors" not in text


def test_ties_that_are_damaged_in_the_file_are_named(run, tmp_path):
    for text in ("no json", "[{}]", '[{"name": "a", "blocks": [0, 999], "points": [[0,0,0],[1,0,0]], "section": 1, "limit": null}]'):
        path = tmp_path / "r.h5"
        path.write_bytes((run / "result.h5").read_bytes())
        with h5py.File(path, "a") as file:
            file.attrs["ties"] = text
        with pytest.raises(InputError, match="damaged: its blocks, joints or scene have changed since they were written"):
            Results.open(path)  # the checksum


@pytest.fixture(scope="module")
def shaken(tmp_path_factory) -> Path:
    """A wall on a base that shakes so that it slides."""
    path, steps = tmp_path_factory.mktemp("energy") / "result.h5", 120
    velocity = still(steps)
    velocity[:, 0, 0] = 0.8 * np.sin(2 * np.pi * 4.0 * np.arange(steps + 1) * 2e-3)
    machine = stepper(wall(2, 2), steps, support_velocity=velocity, dt=2e-3, friction=0.4, tolerance=1e-8)
    joints = find_joints(machine.assembly)
    with ResultWriter(path, machine.assembly, joints, title="a wall") as writer:
        run_loop.run(machine, joints, writer, run_loop.RunPlan(steps, 20))
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
    result = done("report", shaken.parent, "--energy", "--no-crack-map")
    assert "energy.png" in result.stdout
    assert set(COLOURS[1:3]) <= main_colours(shaken.parent / "energy.png"), "the work of the base, and that of gravity"


def test_a_run_without_a_step_is_one_line(shaken, tmp_path):
    (tmp_path / "result.h5").write_bytes(shaken.read_bytes())
    with h5py.File(tmp_path / "result.h5", "r+") as file:
        del file.attrs["format"]  # as by a version that wrote no checksums, and killed
        file["step_time"].resize(0, axis=0)
    with Results.open(tmp_path / "result.h5") as results, pytest.raises(InputError, match="the run made no step"):
        energy_figure(results)
