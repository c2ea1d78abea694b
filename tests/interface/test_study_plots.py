# SPDX-License-Identifier: GPL-3.0-or-later
"""Pushes of a study's runs laid over each other, and a measured curve beside them."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from hostile import refused_at

import masonry_cd as mc
from masonry_cd.foundation.errors import InputError
from masonry_cd.interface.plots import StudyPlots

SCENE = {
    "title": "A block pushed",
    "structure": {"blocks": [mc.box((-1, -1, -0.5), (2, 2, 0)), mc.box((0, 0, 0), (0.5, 1, 1))], "fixed": "b0"},
    "material": {"density": 2000.0, "friction": 0.3},
    "loads": [{"kind": "push", "control": "displacement", "direction": "x", "blocks": "b1", "targets": [0.004], "speed": 0.008}],
    "run": {"dt": 5e-3},
    "report": {"crack_map": False},
}
WEIGHT = 0.5 * 2000.0 * 9.81  # [N]


def plots_of(folder: Path, *runs: str) -> StudyPlots:
    """The plots of a study in a folder, as if these had been its runs."""
    study = SimpleNamespace(folder=folder, text=lambda column: list(runs))
    return StudyPlots(cast(Any, SimpleNamespace(study=study)), lambda: None)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of a study that kept two runs and lost one."""
    folder = tmp_path_factory.mktemp("study")
    mc.run(mc.scene(SCENE), folder / "runs" / "low", progress=False)
    shutil.copytree(folder / "runs" / "low", folder / "runs" / "high")
    return folder


def test_the_curves_of_all_runs_are_laid_over_each_other_beside_the_measured_one(folder: Path) -> None:
    (folder / "test.csv").write_text("displacement [m],force [N]\n0,0\n0.001,2000\n0.004,2900\n")
    figure = plots_of(folder, "low", "lost", "high").force_displacement(measured=folder / "test.csv")
    lines = {str(line.get_label()): line for line in figure.axes[0].get_lines() if not str(line.get_label()).startswith("_")}
    assert list(lines) == ["test", "low", "high"]
    assert list(lines["test"].get_ydata()) == pytest.approx([0.0, 2.0, 2.9])  # in kN
    assert max(lines["low"].get_ydata()) == pytest.approx(1e-3 * 0.3 * WEIGHT, rel=0.02)
    assert max(lines["high"].get_xdata()) == pytest.approx(4.0, rel=0.02)  # in mm


def test_what_cannot_be_drawn_is_said(folder: Path) -> None:
    with pytest.raises(InputError, match=r'no run was kept; a study with run = \{keep = "all"\}'):
        plots_of(folder, "lost").force_displacement()
    (folder / "bad.csv").write_text("displacement,force\n0,0\n1e-3,much\n")
    with refused_at("bad.csv:3"):
        plots_of(folder, "low").force_displacement(measured=folder / "bad.csv")
    with refused_at("none.csv"):
        plots_of(folder, "low").force_displacement(measured=folder / "none.csv")
