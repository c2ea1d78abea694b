# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages on Python, the notebooks and the docstrings of the interface run, and speak of it as it is."""

from __future__ import annotations

import doctest
import re
import shutil
import textwrap
from importlib import import_module
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient
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


NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
PICTURES = {"arch": 5, "own_blocks": 3, "stepping": 3, "study": 3, "sweep": 3}  # that each shows, at least


def shown(notebook: nbformat.NotebookNode) -> list[nbformat.NotebookNode]:
    """The outputs of the cells of a notebook."""
    return [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]


def test_all_are_tried() -> None:
    assert {path.stem for path in NOTEBOOKS} == set(PICTURES)


@pytest.mark.slow(reason="a kernel of Jupyter runs a whole notebook")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert shown(notebook) == []
    assert all(cell.execution_count is None for cell in notebook.cells if cell.cell_type == "code")
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    done = NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert sum("image/png" in output.get("data", {}) for output in shown(done)) >= PICTURES[path.stem]
    said = "".join(output.text for output in shown(done) if output.output_type == "stream" and output.name == "stderr")
    assert "Warning" not in said, said


MODULES = sorted(path.stem for path in (ROOT / "masonry_cd" / "interface").glob("*.py"))
WITH_EXAMPLES = {
    "assessing", "comparison", "limit", "modal", "results",
    "run_stress", "running", "scenes", "simulation", "studies",
}  # fmt: skip


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)  # where the scenes of the examples lie
    found = doctest.testmod(import_module(f"masonry_cd.interface.{name}"))
    assert found.failed == 0
    assert (found.attempted > 0) == (name in WITH_EXAMPLES)
