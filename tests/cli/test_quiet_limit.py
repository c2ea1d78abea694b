# SPDX-License-Identifier: GPL-3.0-or-later
"""cli.limit: -q says nothing but warnings of what is found, and writes it."""

from __future__ import annotations

from pathlib import Path

from places import ROOT
from typer.testing import CliRunner

from masonry_cd.cli.app import app


def test_limit_is_quiet_where_it_is_asked_to_be(tmp_path: Path) -> None:
    asked = ["limit", str(ROOT / "examples" / "arch.toml"), "--set", 'limit.push="x"', "--no-picture"]
    loud = CliRunner().invoke(app, [*asked, "-o", str(tmp_path / "loud")])
    quiet = CliRunner().invoke(app, [*asked, "-o", str(tmp_path / "quiet"), "-q"])
    assert (loud.exit_code, quiet.exit_code) == (0, 0)
    assert "written: " in loud.output
    assert quiet.stdout == "" and quiet.stderr == loud.stderr != ""
    assert (tmp_path / "quiet" / "limit.json").exists()
