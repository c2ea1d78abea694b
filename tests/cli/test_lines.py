# SPDX-License-Identifier: GPL-3.0-or-later
"""Outputs that cannot be are refused before the run; a warning of numpy is a line; -q is quiet; README speaks of the program as it is."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
import typer
from command_line import masonry_cd
from doc_pages import fences
from hostile import refused_at
from made_run import at_rest, box, write_run
from places import ROOT

import structures
from masonry_cd.app.case import prepare
from masonry_cd.app.scene import read_scene
from masonry_cd.cli.printing import errors_reported
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary, read_summary
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from reports import outputs
from reports.settings import Report
from structures.files.blockfile import read


@pytest.fixture
def no_step(monkeypatch: pytest.MonkeyPatch) -> None:
    def step(_: Stepper) -> None:
        raise AssertionError("a step was made")

    monkeypatch.setattr(Stepper, "step", step)


@pytest.mark.parametrize("asked", ["times = [0.0, 0.5, 0.509]", 'cut = "y"', 'cut = "x=0.1"\nview = "isometric"'])
@pytest.mark.usefixtures("no_step")
def test_reports_that_can(block_on_plate, tmp_path: Path, asked: str) -> None:
    result = masonry_cd("run", block_on_plate(report=f"[report]\n{asked}"), "-o", tmp_path / "out")
    assert str(result.exception) == "a step was made"


def test_times_that_rests_cut_short_take_away_are_reported(tmp_path: Path) -> None:
    blocks = [box("base", (-2, -1, -0.5), (2, 1, 0), "base", fixed=True), box("s", (-0.5, -0.5, 0), (0.5, 0.5, 1))]
    asked = Report(times=[0.1, 0.3, 9.0])
    with Results.open(write_run(tmp_path / "run.h5", blocks, [at_rest(blocks)] * 4)) as results:
        more = outputs.write_asked(results, tmp_path, asked, Summary(warnings=("another",)))
    assert more.warnings == ("another", "report.times: no map at 9 s: the run, whose quiet times were skipped, ends at 0.3 s")
    assert {path.name for path in tmp_path.glob("*.png")} == {"crack_map_0.1s.png", "crack_map_0.3s.png"}


@pytest.mark.parametrize("number", ["nan", "1e160"])
def test_corners_of_a_mesh_that_are_no_numbers_or_nowhere(tmp_path: Path, number: str) -> None:
    (tmp_path / "b.obj").write_text(f"o a\nv 0 0 0\nv 1 0 {number}\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    table = {"kind": "file", "path": "b.obj", "units": "m", "up": "z", "repair": True}
    with refused_at("b.obj"):
        structures.build(table, 2000.0, tmp_path)


@pytest.mark.parametrize("text", ["[1, 2]", "3", '{"a": ' * 100_000, "nonsense", ""])
def test_summaries_that_are_none(tmp_path: Path, text: str) -> None:
    (tmp_path / "summary.json").write_text(text)
    with refused_at("summary.json"):
        read_summary(tmp_path)


@pytest.mark.parametrize(
    "load",
    [
        'kind = "point"\nblock = "block"\nforce = [0.0, 1.0, NUMBER]',
        'kind = "sinusoidal"\ndirection = [1, 0, NUMBER]\namplitude = 1.0\nfrequency = 1.0\ncycles = 1',
        'kind = "sequence"\nrest = NUMBER\nshocks = []',
        'kind = "artificial"\ndirection = "x"\nspectrum = "EC8"\nag = 1.0\nperiods = [0.1, NUMBER]',
        'kind = "record"\ndirection = "x"\npath = "b.csv"\nwindow = [0.1, NUMBER]',
        'kind = "record"\ndirection = "x"\npath = "b.csv"\nresample = NUMBER',
    ],
)
@pytest.mark.parametrize("number", ["1" + "0" * 30, "1" + "0" * 400])
@pytest.mark.usefixtures("no_step")
def test_whole_numbers_beyond_the_range_of_others(block_on_plate, tmp_path: Path, load: str, number: str) -> None:
    scene = block_on_plate(report=f"[[loads]]\n{load.replace('NUMBER', number)}")
    result = masonry_cd("run", scene, "-o", tmp_path / "out")
    if result.exit_code != 2:  # 1e30 is a force, if a large one
        assert (len(number), str(result.exception)) == (31, "a step was made")
    else:
        assert all("loads[" in line for line in result.stderr.splitlines())


def test_a_warning_that_was_not_expected_is_one_line(capsys):
    with errors_reported():
        for _ in range(3):
            np.array([1e308]) * 10.0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("masonry-cd: warning: overflow encountered in multiply (test_lines.py, line ")


def test_one_that_is_named_at_its_place_is_none(capsys):
    with errors_reported(), np.errstate(over="ignore"):
        np.array([1e308]) * 10.0
    assert capsys.readouterr().err == ""


def test_next_to_a_refusal_it_says_nothing(capsys):
    with pytest.raises(typer.Exit) as ended, errors_reported():
        np.array([1e308]) * 10.0
        raise InputError("material.density", "not finite")
    assert ended.value.exit_code == 2
    assert capsys.readouterr().err == "masonry-cd: error: material.density: not finite\n"


def test_other_warnings_pass():
    with pytest.warns(UserWarning, match="of another kind"), errors_reported():
        warnings.warn("of another kind", UserWarning, stacklevel=1)


def test_limit_is_quiet_where_it_is_asked_to_be(tmp_path: Path) -> None:
    asked = ("limit", ROOT / "examples" / "arch.toml", "--set", 'limit.push="x"', "--no-picture")
    loud, quiet = masonry_cd(*asked, "-o", tmp_path / "loud"), masonry_cd(*asked, "-o", tmp_path / "quiet", "-q")
    assert (loud.exit_code, quiet.exit_code) == (0, 0)
    assert "written: " in loud.output
    assert quiet.stdout == "" and quiet.stderr == loud.stderr != ""
    assert (tmp_path / "quiet" / "limit.json").exists()


README = ROOT / "README.md"
BLOCKS = ROOT / "docs" / "howto" / "blocks.md"


def fenced(page: Path, language: str) -> str:
    """The first code block of a language."""
    return next(fence.text for fence in fences(page) if fence.language == language)


def test_the_scene_of_the_readme_is_sound(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(fenced(README, "toml"))
    case = prepare(read_scene(scene, ["run.duration=0.01"]))
    assert case.assembly.count >= 150


def test_the_block_file_of_the_page_is_sound(tmp_path):
    (tmp_path / "blocks.json").write_text(fenced(BLOCKS, "json"))
    plinth, stone = read(tmp_path / "blocks.json", 2000.0)
    assert (plinth.name, plinth.density, plinth.fixed) == ("plinth", 2000.0, True)
    assert (stone.name, stone.density, stone.group) == ("stone", 2400, "stones")


def test_the_readme_stays_an_introduction():
    assert len(README.read_text().splitlines()) <= 120
