"""studies.laboratory: the closed form of a bed, scenes that a user can run, and a command that lists its cases."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from masonry_cd.cli.app import app
from masonry_cd.studies.laboratory.cases import CASES
from masonry_cd.studies.laboratory.cases.bed import exact


def test_the_closed_form_of_the_bed() -> None:
    published = (4040, 5054, 5950, 6397, 6703, 6942, 7011)  # at 0.1, 0.2, 0.5, 1, 2, 5, 10 mm [N]
    for way, force in zip((1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2), published, strict=True):
        assert exact(way) == pytest.approx(force, rel=1e-3)


def test_the_command_lists_the_cases_and_refuses_others(tmp_path: Path) -> None:
    listed = CliRunner().invoke(app, ["validate"])
    assert listed.exit_code == 0
    assert all(name in listed.output for name in CASES)
    refused = CliRunner().invoke(app, ["validate", "bde", "-o", str(tmp_path / "out")])
    assert refused.exit_code == 2
    assert 'did you mean "bed"' in refused.output
    assert not (tmp_path / "out").exists()


@pytest.mark.validation
@pytest.mark.parametrize(("name", "share"), [("bed", 0.35), ("bending", 0.35), ("arch", 0.5), ("columns", 0.15), ("dry_walls", 0.6)])
def test_a_case_of_the_laboratory(name: str, share: float, tmp_path: Path) -> None:
    """Each number within a share of what was measured: the page says which are nearer, and why others are not."""
    done = CliRunner().invoke(app, ["validate", name, "-o", str(tmp_path)])
    print(done.output)
    assert done.exit_code == 0, done.output
    for row in json.loads((tmp_path / "table.json").read_text()):
        for value in (row["rigid"], row["elastic"]):
            assert value is None or abs(value / row["measured"] - 1.0) <= share, row
