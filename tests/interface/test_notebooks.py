# SPDX-License-Identifier: GPL-3.0-or-later
"""The notebooks of the documentation run from top to bottom, and are stored without what they show."""

from __future__ import annotations

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient
from places import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
PICTURES = {"arch": 5, "own_blocks": 3, "stepping": 3, "study": 3, "sweep": 3}  # that each shows, at least


def shown(notebook: nbformat.NotebookNode) -> list[nbformat.NotebookNode]:
    """What the cells of a notebook show."""
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
