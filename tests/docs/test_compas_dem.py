# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples of a neighbour in docs/howto/compas_dem.md: as short as theirs, and what they find is in balance."""

from __future__ import annotations

import re
from pathlib import Path
from typing import cast

import pytest
from places import ROOT

import masonry_cd as mc
import structures
from structures.files import meshfile

PAGE = ROOT / "docs" / "howto" / "compas_dem.md"
THEIRS = (11, 24)  # lines that are no comments and not empty: the arch, the cross vault


@pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
@pytest.mark.parametrize("number", [0, 1], ids=["arch", "vault"])
def test_an_example_is_no_longer_than_theirs_and_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    snippet = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[number]
    assert sum(bool(line.strip()) for line in snippet.splitlines()) <= THEIRS[number]
    vault = structures.build({"kind": "vault", "form": "cross", "voussoirs": 7, "span": 2.0, "thickness": 0.4}, 2400.0, tmp_path)
    meshfile.write(tmp_path / "crossvault.obj", vault)
    text = (tmp_path / "crossvault.obj").read_text(encoding="utf-8")
    (tmp_path / "crossvault.obj").write_text(re.sub(r"^v (.*)$", _drawn_larger, text, flags=re.MULTILINE), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(compile(snippet, PAGE.name, "exec"), names)
    run = cast(mc.Run, names["run"])
    weight = 9.81 * sum(block.density * block.mass_properties.volume for block in run.scene.structure if not block.fixed)
    assert run.reactions()["fz"].sum() == pytest.approx(weight, rel=0.05)


def _drawn_larger(line: re.Match[str]) -> str:
    """A corner in the units of the drawing, of which 40 are a metre."""
    return "v " + " ".join(repr(40.0 * float(word)) for word in line[1].split())
