# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene asks for after the run is refused before its first step: one line, exit code 2, nothing written."""

from __future__ import annotations

from pathlib import Path

import pytest
from made_run import at_rest, box, write_run
from typer.testing import CliRunner

import structures
from masonry_cd.cli.app import app
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary, read_summary
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from reports import outputs
from reports.settings import Report


@pytest.fixture
def no_step(monkeypatch: pytest.MonkeyPatch) -> None:
    def step(_: Stepper) -> None:
        raise AssertionError("a step was made")

    monkeypatch.setattr(Stepper, "step", step)


@pytest.mark.parametrize(
    ("asked", "line", "message"),
    [
        ("times = [0.1, 7.0]", 19, "report.times: 7 s lies beyond the run, which ends at 0.5 s"),
        ("times = [0.53]", 19, "report.times: 0.53 s lies beyond the run, which ends at 0.5 s"),
        ('crack_map = true\ncut = "y=3"', 20, "report.cut: y = 3 m does not pass through the structure, which spans -0.25 to 0.25 m"),
        ('cut = "y=3"', 19, "report.cut: y = 3 m does not pass through the structure, which spans -0.25 to 0.25 m"),
        (
            'cut = "q"',
            19,
            'report.cut: "q" is no plane; write x, y or z for the middle, or y=1.5 for a place, in m or with its unit, "y=150 cm"',
        ),
        (
            'cut = "y=nan"',
            19,
            'report.cut: "y=nan" is no plane; write x, y or z for the middle, or y=1.5 for a place, in m or with its unit, "y=150 cm"',
        ),
        ('cut = "y"\nview = "side"', 19, "report.cut: the side view sees the plane y = 0 m edge-on; front and isometric show it"),
    ],
)
@pytest.mark.usefixtures("no_step")
def test_reports_that_cannot_be_drawn(block_on_plate, tmp_path: Path, asked: str, line: int, message: str) -> None:
    scene = block_on_plate(report=f"[report]\n{asked}")
    result = CliRunner().invoke(app, ["run", str(scene), "-o", str(tmp_path / "out")])
    assert (result.exit_code, result.stderr) == (2, f"masonry-cd: error: {scene}:{line}: {message}\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("asked", ["times = [0.0, 0.5, 0.509]", 'cut = "y"', 'cut = "x=0.1"\nview = "isometric"'])
@pytest.mark.usefixtures("no_step")
def test_reports_that_can(block_on_plate, tmp_path: Path, asked: str) -> None:
    result = CliRunner().invoke(app, ["run", str(block_on_plate(report=f"[report]\n{asked}")), "-o", str(tmp_path / "out")])
    assert str(result.exception) == "a step was made"


def test_times_that_rests_cut_short_take_away_are_reported(tmp_path: Path) -> None:
    blocks = [box("base", (-2, -1, -0.5), (2, 1, 0), "base", fixed=True), box("s", (-0.5, -0.5, 0), (0.5, 0.5, 1))]
    asked = Report(times=[0.1, 0.3, 9.0])
    with Results.open(write_run(tmp_path / "run.h5", blocks, [at_rest(blocks)] * 4)) as results:
        more = outputs.write_asked(results, tmp_path, asked, Summary(warnings=("another",)))
    assert more.warnings == ("another", "report.times: no map at 9 s: the run, whose rests were cut short, ends at 0.3 s")
    assert {path.name for path in tmp_path.glob("*.png")} == {"crack_map_0.1s.png", "crack_map_0.3s.png"}


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        (
            {"amplitude": "amplitude = 1e150"},
            "loads: the supports would move at up to 1e+150 m/s, at most 10000 are taken: check units and factors",
        ),
        (
            {"duration": "duration = 0.5\ngravity = [0.0, 1e300, 0.0]"},
            "loads: the blocks would be pulled at up to 1e+300 m/s2, at most 1e+06 are taken",
        ),
    ],
)
@pytest.mark.usefixtures("no_step")
def test_motions_that_nothing_built_meets(block_on_plate, tmp_path: Path, keys: dict[str, str], message: str) -> None:
    result = CliRunner().invoke(app, ["run", str(block_on_plate(**keys)), "-o", str(tmp_path / "out")])
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert message in result.stderr


@pytest.mark.parametrize("number", ["nan", "1e160"])
def test_corners_of_a_mesh_that_are_no_numbers_or_nowhere(tmp_path: Path, number: str) -> None:
    (tmp_path / "b.obj").write_text(f"o a\nv 0 0 0\nv 1 0 {number}\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    table = {"kind": "file", "path": "b.obj", "units": "m", "up": "z", "repair": True}
    with pytest.raises(InputError, match=r'^b\.obj: block "a": a corner has coordinates that are no finite numbers, or far too large$'):
        structures.build(table, 2000.0, tmp_path)


@pytest.mark.parametrize("text", ["[1, 2]", "3", '{"a": ' * 100_000, "nonsense", ""])
def test_summaries_that_are_none(tmp_path: Path, text: str) -> None:
    (tmp_path / "summary.json").write_text(text)
    with pytest.raises(InputError, match=r"summary\.json: not a summary, or one that was cut off$"):
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
    result = CliRunner().invoke(app, ["run", str(scene), "-o", str(tmp_path / "out")])
    if result.exit_code != 2:  # 1e30 is a force, if a large one
        assert (len(number), str(result.exception)) == (31, "a step was made")
    else:
        assert all("loads[" in line for line in result.stderr.splitlines())
