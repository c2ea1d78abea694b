# SPDX-License-Identifier: GPL-3.0-or-later
"""What the page says of loads and of motions of the supports."""

from __future__ import annotations

import json
import re
from html import unescape
from pathlib import Path
from typing import Any

import pytest
from made_run import at_rest, box, shifted, write_run

from masonry_cd.analysis.deformed import solids_of
from masonry_cd.analysis.support_motion import support_motions
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from reports.page import write_page

SCENE = """[structure]
kind = "file"
[material]
density = 2000.0
friction = 0.6
[[loads]]
kind = "settlement"
supports = ["right"]
direction = "-z"
displacement = 0.03
duration = 0.5
[[loads]]
kind = "point"
block = "beam"
point = [1.0, 0.5, 0.5]
force = [0.0, 0.0, -400e3]
[[loads]]
kind = "push"
direction = [1.0, 0.0, 0.0]
rate = 0.05
[[loads]]
kind = "tie"
blocks = ["beam", "left"]
diameter = 0.02
tension = 5e3
"""


def blocks() -> list[Any]:
    """A beam on three supports."""
    return [
        box("left", (0, 0, -0.2), (0.5, 1, 0), "base", fixed=True),
        box("middle", (1, 0, -0.2), (1.5, 1, 0), "base", fixed=True),
        box("right", (2, 0, -0.2), (2.5, 1, 0), "base", fixed=True),
        box("beam", (0, 0, 0), (2.5, 1, 0.5), "beam"),
    ]


def result(folder: Path, settling: float = -0.03) -> Path:
    rest = at_rest(blocks())
    return write_run(folder / "result.h5", blocks(), [rest, shifted(rest, 2, (0, 0, settling))], scene=SCENE, ended=True)


def page(folder: Path, path: Path) -> tuple[str, dict[str, Any]]:
    """Words and facts of a page."""
    with Results.open(path) as results:
        write_page(results, folder / "report.html")
    text = (folder / "report.html").read_text(encoding="utf-8")
    facts = re.search(r'<script type="application/json" id="facts-data">(.*?)</script>', text, re.DOTALL)
    assert facts is not None
    body = text[text.index("<body>") : text.index('<script type="application/json"')]
    return unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", body))), json.loads(facts.group(1))


def test_a_support_that_settles_is_not_averaged_with_those_that_do_not(tmp_path):
    with Results.open(result(tmp_path)) as results:
        first, second = support_motions(results, solids_of(results.blocks))
    assert (first.names, second.names) == (("right",), ("left", "middle"))
    assert first.displacement[-1] == pytest.approx([0.0, 0.0, -0.03])
    assert first.moves and not second.moves
    said, facts = page(tmp_path, tmp_path / "result.h5")
    assert facts["motions"] == ["right"] and facts["motions_at_rest"]
    assert "base/0/displacement/z" in json.dumps(facts["contents"])
    assert "right 30 mm 0, 0, −30" in said
    assert "left, middle at rest" in said


def test_supports_that_move_alike_are_one_motion(tmp_path):
    rest = at_rest(blocks())
    path = write_run(tmp_path / "result.h5", blocks(), [rest, shifted(rest, slice(None), (0.02, 0, 0))], scene=SCENE, ended=True)
    said, facts = page(tmp_path, path)
    assert facts["motions"] == [""]
    assert "Motions of the supports" not in said


def test_loads_are_listed_and_not_said_to_be_left_out(tmp_path):
    said, _ = page(tmp_path, result(tmp_path))
    assert "Load 1: settlement, supports right, direction -z, displacement 0.03, duration 0.5" in said
    assert "Load 4: tie, blocks beam, left, diameter 0.02, tension 5000" in said
    assert "live loads beyond the 1 point load of Masses, ties and loads in the model , water" in said


def test_what_a_run_said_before_it_began_is_what_is_modelled(tmp_path):
    with Results.open(result(tmp_path)) as results:
        modelled = ["masses: 2.5 t free to move, beam 2.5 t", 'loads[1] point load of 4e+05 N on "beam"']
        write_page(results, tmp_path / "report.html", Summary(modelled=modelled))
    said = unescape((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert '<li>Masses: 2.5 t free to move, beam 2.5 t</li><li>Load 2: point load of 4e+05 N on "beam"</li>' in said
