"""What a scene asks for after the run is refused before its first step: one line, exit code 2, nothing written."""

from __future__ import annotations

from pathlib import Path

import pytest
from made_run import at_rest, box, write_run
from typer.testing import CliRunner

from masonry_cd.cli.app import app
from masonry_cd.dynamics.moreau_jean import Stepper
from masonry_cd.io.results import Results
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
        ('cut = "q"', 19, 'report.cut: "q" is no plane; write x, y or z for the middle, or y=1.5 for a place [m]'),
        ('cut = "y=nan"', 19, 'report.cut: "y=nan" is no plane; write x, y or z for the middle, or y=1.5 for a place [m]'),
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


def test_times_that_rests_cut_short_take_away_are_told(tmp_path: Path) -> None:
    blocks = [box("base", (-2, -1, -0.5), (2, 1, 0), "base", fixed=True), box("s", (-0.5, -0.5, 0), (0.5, 0.5, 1))]
    asked = Report(times=[0.1, 0.3, 9.0])
    with Results.open(write_run(tmp_path / "run.h5", blocks, [at_rest(blocks)] * 4)) as results:
        more = outputs.write_asked(results, tmp_path, asked, {"warnings": ["another"]})
    assert more["warnings"] == ["another", "report.times: no map at 9 s: the run, whose rests were cut short, ends at 0.3 s"]
    assert {path.name for path in tmp_path.glob("*.png")} == {"crack_map_0.1s.png", "crack_map_0.3s.png"}
