# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables and pictures of a run: what the files hold, with units, and images that show themselves."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from two_blocks import shaking, two_blocks

import masonry_cd as mc
from masonry_cd.interface.tables import UNIT_OF
from reports.damage import write_part_damage
from reports.page.motion import rotation_vectors

WITHOUT_UNIT = {"error", "contact_area_loss", "lost_share", "residual_drift", "max_drift", "drift", "largest_drift"}  # shares

pytestmark = pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")  # short, coarse and strong, as wanted here


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> mc.Run:
    """A run in which the upper block rocks."""
    scene = mc.scene(two_blocks() | {"loads": [shaking(2, peak=9.0)]}, "run.duration=0.2")
    return mc.run(scene, tmp_path_factory.mktemp("run"), progress=False)


def test_joints_are_those_of_the_file(run: mc.Run) -> None:
    with (run.folder / "joints.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(run.joints) == run.summary["joints"]
    for name in ("area", "max_opening", "residual_sliding", "max_rotation"):
        assert [f"{value:.9g}" for value in run.joints[name]] == [row[name] for row in rows]
    assert run.joints["state"].tolist() == [row["state"] for row in rows]
    assert run.joints["max_opening"].max() > 1e-4
    assert run.joints[["x", "y", "z"]].round(9).to_numpy().tolist()[1] == [0.0, 0.0, 0.4]
    assert run.joints.attrs["provisional"] == run.provisional != ""


def test_parts_hinges_levels_and_history_are_those_of_the_files(run: mc.Run, tmp_path: Path) -> None:
    write_part_damage(run.damage, tmp_path)
    for frame, name in ((run.parts, "damage"), (run.hinges, "hinges"), (run.levels, "drift"), (run.history, "damage_history")):
        with (tmp_path / f"{name}.csv").open() as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == len(frame)
        assert not rows or set(rows[0]) == {*frame.columns, *([frame.index.name] if frame.index.name else [])}
    assert run.parts.index[-1] == "structure"
    assert run.parts.loc["structure", "grade"] == run.damage.parts[-1]["grade"]


def test_every_measure_has_a_unit(run: mc.Run) -> None:
    for frame in (run.joints, run.parts, run.hinges, run.levels, run.history, run.steps, run.energy, run.blocks(), run.motion("b2")):
        numbers = [name for name in frame.columns if frame[name].dtype.kind == "f"]
        assert [name for name in numbers if name not in frame.attrs["units"] and name not in WITHOUT_UNIT] == []
    assert run.steps.attrs["units"]["time"] == "s"
    assert UNIT_OF["wx"] == "rad/s"


def test_steps_and_energy_have_a_row_per_step(run: mc.Run) -> None:
    steps, energy = run.steps, run.energy
    assert len(steps) == len(energy) == run.summary["steps"] == 100
    assert steps.index[-1] == pytest.approx(0.2)
    assert steps["iterations"].max() == run.summary["solver"]["iterations_max"]
    assert energy["kinetic"].iloc[-1] == pytest.approx(run.summary["energy"]["kinetic_end"])
    assert set(energy.attrs["units"].values()) == {"J", "s"}


def test_blocks_are_where_the_frame_has_them(run: mc.Run) -> None:
    now = run.blocks(0.1)
    with run.results() as found:
        frame = int(np.argmin(np.abs(found.time - 0.1)))
        assert now.attrs["time"] == found.time[frame]
        assert np.array_equal(now[["x", "y", "z"]], found.position[frame])
        assert np.array_equal(now[["vx", "vy", "vz", "wx", "wy", "wz"]], found.velocity[frame])
        assert np.array_equal(now[["rx", "ry", "rz"]], rotation_vectors(found.orientation[frame]))
        moved = found.position[frame] - found.position[0] - (found.position[frame][0] - found.position[0][0])
        assert np.abs(moved).max() > 1e-4
        assert np.allclose(now[["ux", "uy", "uz"]], moved, rtol=0.0, atol=1e-12)
    assert run.blocks().attrs["time"] == run.time[-1]
    with refused_at("time"):
        run.blocks(9.0)


def test_the_motion_of_a_block_is_its_row_frame_by_frame(run: mc.Run) -> None:
    moved = run.motion("b2")
    assert len(moved) == len(run.time)
    for time in (run.time[3], run.time[-1]):
        row = run.blocks(float(time)).loc["b2"]
        for name in ("x", "uz", "ry", "vx", "wy"):
            assert moved.loc[time, name] == pytest.approx(row[name], abs=1e-15)
    assert moved["base_x"].to_numpy() == pytest.approx(run.motion("b0")["x"].to_numpy(), abs=1e-15)
    with pytest.raises(mc.InputError, match=r'no block is named "b3"'):
        run.motion("b3")


def test_histories_of_joints(run: mc.Run) -> None:
    opening = run.joint_history("opening")
    assert opening.shape == (len(run.time), len(run.joints))
    assert (opening.max() <= run.joints["max_opening"] * (1 + 1e-12)).all()
    assert set(run.joint_history("normal_force").attrs["units"].values()) == {"N", "s"}
    with refused_at("joint_history"):
        run.joint_history("openings")
    with pytest.raises(mc.InputError, match="the run has written no bonded"):
        run.joint_history("bonded")


def test_it_says_what_the_command_line_says(run: mc.Run) -> None:
    from masonry_cd.app.closing_lines import closing_lines
    from masonry_cd.io.summary import read_summary

    assert str(run).splitlines() == closing_lines(read_summary(run.folder))
    assert "<b>Two blocks: 100 steps" in run._repr_html_()


def test_crack_maps_are_images_in_the_style_that_is_asked_for(run: mc.Run) -> None:
    last, before = run.plot.crack_map(), run.plot.crack_map(0.1, view="isometric", scale=5.0)
    assert last._repr_png_().startswith(b"\x89PNG")
    assert np.asarray(last).shape[2] == 3
    assert last.size != before.size or (np.asarray(last) != np.asarray(before)).any()
    with refused_at("report.view"):
        run.plot.crack_map(view="below")
    with refused_at("report.scales"):
        run.plot.crack_map(scales=2)


def test_plots_are_figures_that_show_themselves(run: mc.Run) -> None:
    for figure in (run.plot.energy(), run.plot.history(), run.plot.history("b1", "b2", axis="y")):
        assert figure._repr_png_().startswith(b"\x89PNG")
    upper, lower = run.plot.history("b1", "b2", axis="y").axes
    assert [line.get_label() for line in upper.lines[:2]] == ["b1", "b2"]
    assert upper.lines[1].get_ydata() == pytest.approx(1000.0 * run.motion("b2")["uy"].to_numpy(), abs=1e-9)
    assert lower.lines[0].get_ydata() == pytest.approx(run.motion("b0")["vy"].to_numpy())
    with refused_at("axis"):
        run.plot.history(axis="q")
    with pytest.raises(mc.InputError, match='no block is named "b7"'):
        run.plot.history("b7")


def test_the_page_lies_in_the_folder_and_shows_itself(run: mc.Run, tmp_path: Path) -> None:
    page = run.plot.page()
    assert page.path == run.folder / "report.html"
    assert "Two blocks" in page.path.read_text()
    assert page._repr_html_().startswith('<iframe srcdoc="&lt;!')
    assert run.plot.page(tmp_path / "own.html").path.read_text() == page.path.read_text()


def test_runs_are_compared_by_name(run: mc.Run, tmp_path: Path) -> None:
    weak = mc.run(run.scene.changed("loads[0].scale=0.1", "loads[1].scale=0.1"), progress=False)
    found = mc.compare({"weak": weak, "strong": run.folder})
    assert list(found.table.columns) == ["unit", "weak", "strong"]
    assert found.table.loc["loads[0].scale", "weak"] == 0.1
    assert found.table.loc["largest displacement", "weak"] < found.table.loc["largest displacement", "strong"]
    assert "| weak" in str(found)
    assert "<table" in found._repr_html_()
    assert found.plot()._repr_png_().startswith(b"\x89PNG")
    assert {path.name for path in found.write(tmp_path)} == {"comparison.csv", "comparison.md", "comparison.png"}
    with refused_at("compare"):
        mc.compare([run])


def test_modal_frequencies_come_from_the_scene() -> None:
    made = mc.modal(two_blocks(), young=1e9, method="joints", modes=3)
    assert made["title"] == "Two blocks"
    assert len(made["models"]["joints"]["frequency_hz"]) == 3
    with refused_at("modal.yung"):
        mc.modal(two_blocks(), yung=1e9)
