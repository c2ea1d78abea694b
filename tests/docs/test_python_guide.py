# SPDX-License-Identifier: GPL-3.0-or-later
"""The page on Python speaks of the interface as it is: its snippets run one after the other, and its tables are those that there are."""

from __future__ import annotations

import re
import shutil
import textwrap
from pathlib import Path

import pytest
from places import EXAMPLES, ROOT

import masonry_cd as mc
from masonry_cd.interface.plots import StudyPlots

PAGE = ROOT / "docs" / "python.md"
SNIPPETS = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.slow(reason="runs all snippets of a page, a study among them")
@pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
def test_the_snippets_run_one_after_the_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for snippet in SNIPPETS:
        exec(compile(textwrap.dedent(snippet), str(PAGE), "exec"), names)
    said = capsys.readouterr().out
    (promised,) = re.findall(r"print\(error\)  # (.*)", PAGE.read_text(encoding="utf-8"))
    assert promised in said
    run = names["run"]
    assert isinstance(run, mc.Run)
    study = names["study"]
    assert isinstance(study, mc.Study)
    assert (study.runs["status"] == "done").sum() == 8
    assert {"early.png", "report.html", "scene.toml", "motion1.csv"} <= {path.name for path in (tmp_path / "out" / "post").iterdir()}


def test_every_name_and_table_is_on_the_page() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert [
        name for name in mc.__all__ if f"mc.{name}" not in text and name not in ("Comparison", "Run", "Scene", "Structure", "Study")
    ] == []
    for name in re.findall(r"^\| `run\.(\w+)", text, re.MULTILINE):
        assert hasattr(mc.Run, name), name
    for name in re.findall(r"`study\.(\w+)", text):
        assert hasattr(mc.Study, name), name
    for name in re.findall(r"`(\w+)\((?:\"\w+\")?\)`", text[text.index("`study.plot`") :].partition("\n\n")[0]):
        assert hasattr(StudyPlots, name), name


@pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
def test_twenty_lines_are_twenty_and_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    (snippet,) = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "python_in_twenty_lines.md").read_text(encoding="utf-8"), re.DOTALL)
    assert sum(bool(line.strip()) for line in snippet.splitlines()) <= 24  # twenty, and what formatting breaks
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(compile(snippet, "python_in_twenty_lines.md", "exec"), names)
    said = capsys.readouterr().out
    assert "joint 0 opens at" in said and "tilted by 5 degrees" in said
    assert isinstance(names["run"], mc.Run)
