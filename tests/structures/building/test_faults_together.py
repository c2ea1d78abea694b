# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults of a building that lies in several files: each has its file and line. Those of one table are in tests/refusals/buildings.toml."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import ezdxf
import pytest
from command_line import masonry_cd
from plans import wall

import structures
from masonry_cd.foundation.errors import InputError

CORNERS = [[0, 0], [6, 0], [6, 4], [0, 4], [0, 0]]
BARREL = {"shape": "barrel", "walls": ["south", "north"], "springing": 1.5}
KEYS = {"kind": "building", "block_length": 1.6, "course_height": 0.6}
SHARP = wall("sharp", [[1, 0], [5, 0.9]])


def box(**others: dict[str, Any]) -> list[dict[str, Any]]:
    """Four walls around a room, of which some have other keys; a key of None is left out."""
    walls = [wall(name, [*axis]) for name, axis in zip(("south", "east", "north", "west"), pairwise(CORNERS), strict=True)]
    return [{key: value for key, value in (own | others.get(own["name"], {})).items() if value is not None} for own in walls]


def opening(at: float, **keys: float) -> dict[str, Any]:
    return {"openings": [{"at": at, "width": 0.8, "height": 1.5} | keys]}


def lines(keys: dict[str, Any], folder: Path = Path()) -> list[str]:
    """Return the lines on a building."""
    with pytest.raises(InputError) as failure:
        structures.make(KEYS | keys, 2000.0, folder)
    return str(failure.value).splitlines()


def said(found: list[str], begins: list[str]) -> bool:
    """Return True if lines begin as they should, in any order, and there is no other."""
    return len(found) == len(begins) and all(sum(line.startswith(begin) for line in found) == 1 for begin in begins)


def test_faults_in_a_plan_name_its_file_and_those_in_the_scene_their_key(tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text(json.dumps({"walls": box(south=opening(0.4)), "vaults": [BARREL]}))
    found = lines({"plan": "plan.json", "walls": [SHARP], "vaults": [BARREL | {"walls": ["east", "x"]}]}, tmp_path)
    begins = [
        "structure.walls[0]: walls south and sharp: their strips overlap",
        "plan.json: walls[0].openings[0]: opening o1 of wall south at 0.4 m: with its head it lies over",
        "plan.json: vaults[0]: vault vault1: its bay at x = 3.333 m, y = 1.3 m is not a rectangle",
        'structure.vaults[0]: vault vault2: there is no wall "x"',
    ]
    assert said(found, begins), "\n".join(found)


def test_keys_of_a_plan_that_are_wrong_name_its_file(tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text(json.dumps({"walls": box(north={"thicknes": 0.3}, south={"height": -1.0})}))
    found = lines({"plan": "plan.json", "walls": [SHARP]}, tmp_path)
    assert said(found, ["plan.json: walls[2].thicknes: unknown key", "plan.json: walls[0].height: input should be greater than 0"])


def test_faults_of_geometry_have_the_file_and_line_of_their_element(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text("""
material = { density = 2000.0, friction = 0.6 }
run = { dt = 2e-3, duration = 1.0 }

[structure]
kind = "building"

[[structure.walls]]
name = "south"
axis = [[0, 0], [6, 0]]
thickness = 0.6
height = 3.0

[[structure.walls.openings]]
at = 9.0
width = 1.0
""")
    result = masonry_cd("build", tmp_path / "scene.toml", "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert "scene.toml:14: structure.walls[0].openings[0]: opening o1 of wall south at 9 m:" in result.stderr
    assert not list((tmp_path / "out").glob("blocks.*"))


def test_faults_of_a_drawing_end_with_2_before_those_of_its_scene(tmp_path: Path) -> None:
    drawing = ezdxf.new("R2010")
    drawing.header["$INSUNITS"] = 6
    for (x, y), (x1, y1) in (((0, 0), (6, 0.6)), ((0, 3.4), (6, 4)), ((0, 0.6), (0.6, 3.4)), ((5.4, 0.6), (6, 3.4))):
        corners = [(x, y), (x1, y), (x1, y1), (x, y1)]
        drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": "WALLS"})
    texts = [("SOUTH h=2.4", (2, -0.3)), ("NORTH h=2.4", (2, 4.2)), ("EAST", (6.2, 2)), ("WEST h=2.4", (-0.6, 2))]
    for words, at in texts:
        drawing.modelspace().add_text(words, height=0.1, dxfattribs={"layer": "HEIGHTS"}).set_placement(at)
    drawing.modelspace().add_lwpolyline([(0.7, 0), (1.5, 0), (1.5, 0.6), (0.7, 0.6)], close=True, dxfattribs={"layer": "DOORS"})
    drawing.saveas(tmp_path / "plan.dxf")
    scene = """
material = {{ density = 2000.0, friction = 0.6 }}
run = {{ dt = 2e-3, duration = 1.0 }}

[structure]
kind = "building"
plan = "plan.dxf"
block_length = 1.6
course_height = 0.6
vaults = [{{ walls = ["south", "x"], springing = 1.5 }}]
{}
"""
    for more, begins in (
        ("", ["plan.dxf: nothing says the height of wall east"]),
        (
            "wall_height = 2.4",
            ["plan.dxf: walls[1].openings[0]: opening o1 of wall south at ", "structure.vaults[0]: vault vault1: there is no"],
        ),
    ):
        (tmp_path / "scene.toml").write_text(scene.format(more))
        result = masonry_cd("build", tmp_path / "scene.toml", "-o", tmp_path / "out")
        assert result.exit_code == 2
        found = [line.replace("masonry-cd: error: ", "") for line in result.stderr.splitlines()]
        assert said([line.partition(": ")[2] if "scene.toml" in line else line for line in found], begins), result.stderr


def test_rows_that_are_no_tables_are_named_and_the_rest_is_checked() -> None:
    keys = {"walls": [3.0, wall("a", [[0, 0], [4, 0]], 0.5, 3.0), {"name": "b", "openings": [1.5]}], "vaults": [True]}
    with pytest.raises(InputError) as failure:
        structures.make(KEYS | keys, 2000.0, Path())
    begins = [f"structure.{at}: " for at in ("walls[0]", "walls[2].axis", "walls[2].openings[0]", "vaults[0]")]
    assert [begin for begin in begins if not any(line.startswith(begin) for line in failure.value.lines)] == []


def test_a_buttress_has_another_name_than_the_walls() -> None:
    keys = {
        "walls": box(east={"name": "buttress1"}),
        "buttresses": [{"wall": "south", "at": 3.0, "width": 0.8, "depth": 0.8, "height": 2.0}],
    }
    assert lines(KEYS | keys) == ["structure.buttresses[0]: wall buttress1: another wall has this name, too"]
