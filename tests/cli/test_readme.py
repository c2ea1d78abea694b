# SPDX-License-Identifier: GPL-3.0-or-later
"""README and the page on own blocks speak of the program as it is: the scene runs, the block file reads."""

from __future__ import annotations

from pathlib import Path

from doc_pages import fences
from places import ROOT

from masonry_cd.app.case import prepare
from masonry_cd.app.scene import read_scene
from structures.files.blockfile import read

README = ROOT / "README.md"
BLOCKS = ROOT / "docs" / "howto" / "blocks.md"


def fenced(page: Path, language: str) -> str:
    """The first code block of a language."""
    return next(fence.text for fence in fences(page) if fence.language == language)


def test_the_scene_of_the_readme_is_sound(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(fenced(README, "toml"))
    case = prepare(read_scene(scene, ["run.duration=0.01"]))
    assert case.assembly.count >= 150


def test_the_block_file_of_the_page_is_sound(tmp_path):
    (tmp_path / "blocks.json").write_text(fenced(BLOCKS, "json"))
    plinth, stone = read(tmp_path / "blocks.json", 2000.0)
    assert (plinth.name, plinth.density, plinth.fixed) == ("plinth", 2000.0, True)
    assert (stone.name, stone.density, stone.group) == ("stone", 2400, "stones")


def test_the_readme_stays_an_introduction():
    assert len(README.read_text().splitlines()) <= 120
