# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages on Python, the notebooks and the docstrings of the interface run, and speak of it as it is."""

from __future__ import annotations

import doctest
import re
import shutil
import subprocess
import sys
import textwrap
from importlib import import_module
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
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


SCRIPTS = {path.stem: path.read_text(encoding="utf-8") for path in sorted((EXAMPLES / "python").glob("*.py"))}
SAID = {"twenty_lines": ("joint 0 opens at", "tilted by 5 degrees"), "neighbours": ("blocks,",)}  # by some of the scripts


def test_the_page_names_every_script() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert [name for name in SCRIPTS if f"examples/python/{name}.py" not in text] == []


@pytest.mark.parametrize("title", SCRIPTS)
@pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
def test_twenty_lines_are_twenty_and_run(
    title: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = [line for line in SCRIPTS[title].splitlines() if line.strip() and not line.startswith(("import ", "from ", "# ", '"""'))]
    assert len(lines) <= 30  # twenty, and what formatting breaks
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(compile(SCRIPTS[title], f"{title}.py", "exec"), names)
    said = capsys.readouterr().out
    assert [words for words in SAID.get(title, ()) if words not in said] == []
    if title == "neighbours":
        weights = [float(line.split()[2]) for line in said.splitlines()]
        assert len(weights) == 3 and weights == pytest.approx([weights[0]] * 3, rel=1e-3)
    elif title == "branches":
        ends = [names[name].state.position for name in ("sim", "same", "pushed")]
        assert np.array_equal(ends[0], ends[1]) and not np.array_equal(ends[0], ends[2]) and names["frames"].sizes["time"] > 10


@pytest.mark.slow(reason="the type checker reads the whole package")
def test_type_checkers_take_the_short_scripts(tmp_path: Path) -> None:
    for k, script in enumerate(SCRIPTS.values()):
        (tmp_path / f"script{k}.py").write_text(script, encoding="utf-8")
    found = subprocess.run(
        [sys.executable, "-m", "mypy", "--check-untyped-defs", *map(str, sorted(tmp_path.glob("script*.py")))],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stdout


@pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
def test_our_lines_next_to_other_programs_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (ROOT / "docs" / "other_programs.md").read_text(encoding="utf-8")
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    (first,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(first, "other_programs.md", "exec"), names)
    rows = [line.split(" | ")[1] for line in page.splitlines() if line.startswith("| ") and not line.startswith("| job")]
    lines = [code for row in rows for code in re.findall(r"`([^`]+)`", row) if "=" in code.split("(")[0] or code.startswith("sim.")]
    assert len(rows) == 11 and len(lines) == 12
    for line in lines:
        exec(compile(line, "other_programs.md", "exec"), names)
    for name in ("pushed", "ruled", "solved"):
        names[name].step()
    assert names["less"].absent.sum() == 1
    assert names["sim"].steps == 20 and names["frames"].sizes["time"] > 2 and len(names["files"]) > 5 and len(names["arch"].structure) > 15


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
    monkeypatch.setenv("PYTHONWARNINGS", "ignore:IProgress not found")  # of tqdm, which pyvista's pooch finds installed, about ipywidgets
    done = NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert sum("image/png" in output.get("data", {}) for output in shown(done)) >= PICTURES[path.stem]
    said = "".join(output.text for output in shown(done) if output.output_type == "stream" and output.name == "stderr")
    assert "Warning" not in said, said


MODULES = sorted(path.stem for path in (ROOT / "masonry_cd" / "interface").glob("*.py"))
WITH_EXAMPLES = {
    "assessing", "calibrating", "comparison", "hazard", "limit", "modal", "results",
    "run_stress", "running", "scenes", "simulation", "strengthening", "studies",
}  # fmt: skip


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)  # where the scenes of the examples lie
    found = doctest.testmod(import_module(f"masonry_cd.interface.{name}"))
    assert found.failed == 0
    assert (found.attempted > 0) == (name in WITH_EXAMPLES)
