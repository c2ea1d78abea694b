# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies from Python: the rows of the command line, tables and pictures, folders, interrupts, and going on."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from command_line import done
from hostile import refused_at
from made_run import box
from made_study import Made, write_study_folder
from places import ROOT
from studied import GRID, rows_without_seconds, write_scene, write_study

import masonry_cd as mc
from masonry_cd.foundation.errors import InputError
from masonry_cd.interface.plots import StudyPlots
from masonry_cd.studies.study.progress import StudyProgress

GRID_TABLES: dict[str, Any] = {
    "scene": "scene.toml",
    "design": "grid",
    "vary": {"loads[0].amplitude": [0.3, 0.4, 0.6], "material.friction": [0.2, 0.4]},
    "limit_states": {"slid": {"quantity": "max_sliding", "above": 1e-3}},
}


@pytest.fixture(scope="module")
def folder(scheduler: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study file next to its scene, and what it came to in Python."""
    folder = tmp_path_factory.mktemp("study")
    write_study(folder)
    mc.study(folder / "study.toml", folder / "out", scheduler=scheduler, progress=False)
    return folder


@pytest.fixture
def made(tmp_path: Path) -> mc.Study:
    """A folder made by hand, of 12 records at 5 levels."""
    return mc.open_study(write_study_folder(tmp_path / "made", Made(by_friction=0.2), joints=True))


# --- making ---------------------------------------------------------------------------------------------------------------------------


def test_the_rows_are_those_of_the_command_line_which_continues_the_folder(folder: Path) -> None:
    before = rows_without_seconds(folder / "out")
    assert len(before) == 7
    assert "6 runs, 0 still to run" in done("study", folder / "study.toml", "-o", folder / "out", "--resume", "--workers", "1").output
    assert rows_without_seconds(folder / "out") == before
    assert {"study.html", "summary.json", "study.toml"} <= {path.name for path in (folder / "out").iterdir()}


def test_tables_name_the_runs_of_the_file(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    study = mc.study(GRID_TABLES, "out", workers=1, progress=False)  # no run is made again: all are known by their names
    assert repr(study) == '<Study "Block on a plate": grid, 6 runs>'
    assert study.stopped == ""
    assert study.runs.index.tolist() == mc.open_study(folder / "out").runs.index.tolist()


@pytest.mark.slow(reason="starts a worker")
def test_arrays_become_files_with_which_the_command_line_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plate, block = box("plate", (-1, -1, -1), (1, 1, 0), fixed=True), box("block", (-0.3, -0.3, 0), (0.3, 0.3, 0.6))
    scene = mc.scene(
        structure={"blocks": [plate, block]},
        material={"density": 2000.0, "friction": 0.4},
        loads=[{"kind": "sinusoidal", "direction": "x", "amplitude": 0.4, "frequency": 2.0, "cycles": 1}],
        run={"dt": 1e-2, "duration": 0.1},
    )
    tables = {"scene": scene, "design": "grid", "vary": {"material.friction": [0.3, 0.5]}, "run": {"keep": "all"}}
    study = mc.study(tables, tmp_path / "out", workers=1, progress=False)
    assert (study.runs["status"] == "done").all()
    assert (tmp_path / "out" / "blocks.json").is_file()
    kept = study.run(study.runs.index[0])
    assert kept.scene.tables["structure"]["path"] == str(tmp_path / "out" / "blocks.json")
    assert kept.joints.shape[0] == 1
    monkeypatch.chdir(tmp_path)
    assert "2 runs, 0 still to run" in done("study", "out/study.toml", "-o", "out", "--workers", "1").output


@pytest.mark.slow(reason="starts workers twice")
def test_ctrl_c_keeps_what_has_ended_and_the_same_call_goes_on(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_scene(tmp_path)
    (tmp_path / "study.toml").write_text(GRID)
    ended = StudyProgress.ended

    def interrupting(self: StudyProgress, *arguments: Any) -> None:
        ended(self, *arguments)
        if self.finished == 2:
            os.kill(os.getpid(), signal.SIGINT)

    with monkeypatch.context() as patched:
        patched.setattr(StudyProgress, "ended", interrupting)
        study = mc.study(tmp_path / "study.toml", tmp_path / "out", workers=1, progress=False)
    assert 2 <= len(study.runs) < 6
    assert study.stopped == f"{len(study.runs)} of 6 runs are made"
    assert study.stopped in repr(study)
    assert not (tmp_path / "out" / "study.html").exists()
    whole = mc.study(tmp_path / "study.toml", tmp_path / "out", workers=1, progress=False)
    assert whole.stopped == ""
    assert rows_without_seconds(tmp_path / "out") == rows_without_seconds(folder / "out")


@pytest.mark.slow(reason="a process of its own and a worker")
def test_a_script_needs_no_guard(tmp_path: Path) -> None:
    write_study(tmp_path, GRID.replace("[0.3, 0.4, 0.6]", "[0.3]"))
    making = 'study = mc.study("study.toml", "out", workers=1, progress=False)'
    script = f'print("begins")\nimport masonry_cd as mc\n{making}\nprint(study.runs["status"].tolist())\n'
    (tmp_path / "script.py").write_text(script)
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=600)
    assert done.stdout.splitlines() == ["begins", "['done', 'done']"], done.stderr


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"design": "grid"}, "study: scene: missing"),
        (GRID_TABLES | {"vary": {"material.fraction": [0.3]}}, 'study: vary."material.fraction": 0.3 is refused by the scene'),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_line(tables: dict[str, Any], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_scene(tmp_path)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(mc.InputError) as caught:
        mc.study(tables, "out")
    assert str(caught.value).startswith(words)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_ways_to_run_exclude_each_other(folder: Path) -> None:
    with refused_at("workers, scheduler and slurm"):
        mc.study(folder / "study.toml", workers=1, scheduler="tcp://nowhere:1")
    with refused_at("workers"):
        mc.study(folder / "study.toml", workers=0)


# --- what it says ---------------------------------------------------------------------------------------------------------------------


def test_tables_have_types_and_units(made: mc.Study) -> None:
    assert repr(made) == '<Study "Column": stripes, 60 runs>' and str(made) == "\n".join(made.lines)
    assert made._repr_html_().startswith(f"<b>{made.lines[0]}")
    assert made.runs.shape[0] == 60
    assert made.runs["collapsed_blocks"].dtype == np.int64
    assert made.runs.attrs["units"]["PGA"] == "m/s²"
    assert made.runs.attrs["units"]["level"] == "m/s²"
    collapse = made.fragility.loc["collapse"]
    assert 2.4 < collapse["theta"] < 3.6
    assert collapse["theta_low"] < collapse["theta"] < collapse["theta_high"]
    assert made.fragility.attrs["units"]["theta"] == "m/s²"
    assert collapse["exceeded"] == (made.runs["collapsed_blocks"] > 0).sum()
    joints = made.joint_probabilities
    assert joints["opened"].tolist() == sorted(joints["opened"], reverse=True)
    assert joints.loc[2, "lost"] == (made.runs["collapsed_blocks"] > 0).mean()
    assert joints.attrs["units"] == {"median_opening": "m"}
    assert set(made.sensitivity.index) == {"material.friction", "PGA", "PGV"}


def test_pictures_are_drawn_and_the_folder_stays_as_it_is(made: mc.Study) -> None:
    before = sorted(path.name for path in made.folder.iterdir())
    for picture in (made.plot.fragility(), made.plot.stripes(), made.plot.tornado(), made.plot.probability("lost")):
        assert picture.width > 600
        assert len(picture.getcolors(1 << 24)) > 50
    assert made.plot.probability(level=4.0).size == made.plot.median_opening().size
    assert sorted(path.name for path in made.folder.iterdir()) == before
    assert made.plot.page().path == made.folder / "study.html"


def test_pictures_that_there_are_not_are_refused(made: mc.Study) -> None:
    with refused_at("ida"):
        made.plot.ida()
    with refused_at("probability"):
        made.plot.probability("openend")
    with refused_at("probability_opened_at_2.5"):
        made.plot.probability(level=2.5)


def test_runs_are_opened_where_they_were_kept(folder: Path, made: mc.Study) -> None:
    study = mc.open_study(folder / "out")
    with pytest.raises(mc.InputError, match=r'was not kept; a study with run = \{keep = "all"\} keeps'):
        study.run(study.runs.index[0])
    with pytest.raises(mc.InputError, match='the study has no run "none"'):
        study.run("none")
    with pytest.raises(mc.InputError, match=r"no study: it has no study\.json"):
        mc.open_study(made.folder.parent)


def test_a_study_without_joints_says_so(tmp_path: Path) -> None:
    study = mc.open_study(write_study_folder(tmp_path, Made()))
    with pytest.raises(mc.InputError, match="no run of the study is done whose joints are known"):
        study.joint_probabilities  # noqa: B018


SCENE = {
    "title": "A block pushed",
    "structure": {"blocks": [mc.box((-1, -1, -0.5), (2, 2, 0)), mc.box((0, 0, 0), (0.5, 1, 1))], "fixed": "b0"},
    "material": {"density": 2000.0, "friction": 0.3},
    "loads": [{"kind": "push", "control": "displacement", "direction": "x", "blocks": "b1", "targets": [0.004], "speed": 0.008}],
    "run": {"dt": 5e-3},
    "report": {"crack_map": False},
}
WEIGHT = 0.5 * 2000.0 * 9.81  # [N]


def plots_of(folder_plots: Path, *runs: str) -> StudyPlots:
    """The plots of a study in a folder, as if these had been its runs."""
    study = SimpleNamespace(folder=folder_plots, text=lambda column: list(runs))
    return StudyPlots(cast(Any, SimpleNamespace(study=study)), lambda: None)


@pytest.fixture(scope="module")
def folder_plots(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Plots of a study that kept two runs and lost one."""
    folder_plots = tmp_path_factory.mktemp("study")
    mc.run(mc.scene(SCENE), folder_plots / "runs" / "low", progress=False)
    shutil.copytree(folder_plots / "runs" / "low", folder_plots / "runs" / "high")
    return folder_plots


def test_the_curves_of_all_runs_are_laid_over_each_other_next_to_the_measured_one(folder_plots: Path) -> None:
    (folder_plots / "test.csv").write_text("displacement [m],force [N]\n0,0\n0.001,2000\n0.004,2900\n")
    figure = plots_of(folder_plots, "low", "lost", "high").force_displacement(measured=folder_plots / "test.csv")
    lines = {str(line.get_label()): line for line in figure.axes[0].get_lines() if not str(line.get_label()).startswith("_")}
    assert list(lines) == ["test", "low", "high"]
    assert list(lines["test"].get_ydata()) == pytest.approx([0.0, 2.0, 2.9])  # in kN
    assert max(lines["low"].get_ydata()) == pytest.approx(1e-3 * 0.3 * WEIGHT, rel=0.02)
    assert max(lines["high"].get_xdata()) == pytest.approx(4.0, rel=0.02)  # in mm


def test_what_cannot_be_drawn_is_said(folder_plots: Path) -> None:
    with pytest.raises(InputError, match=r'no run was kept; a study with run = \{keep = "all"\}'):
        plots_of(folder_plots, "lost").force_displacement()
    (folder_plots / "bad.csv").write_text("displacement,force\n0,0\n1e-3,much\n")
    with refused_at("bad.csv:3"):
        plots_of(folder_plots, "low").force_displacement(measured=folder_plots / "bad.csv")
    with refused_at("none.csv"):
        plots_of(folder_plots, "low").force_displacement(measured=folder_plots / "none.csv")
