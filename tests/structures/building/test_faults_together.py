# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults of different parts of a building: all wrong keys at once, then all elements that are wrong by themselves, then where they meet and
what stands on them, then floors and ties; the first fault of each, in a line, and none that only follows from another."""

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
FLOOR = {"height": 2.1, "thickness": 0.2, "mass": 300.0, "walls": ["south", "north"]}
BARREL = {"shape": "barrel", "walls": ["south", "north"], "springing": 1.5}
TIE = {"along": "y", "height": 2.0, "diameter": 0.02}
KEYS = {"kind": "building", "block_length": 1.6, "course_height": 0.6}
SHARP = wall("sharp", [[1, 0], [5, 0.9]])


def box(**others: dict[str, Any]) -> list[dict[str, Any]]:
    """Four walls around a room, of which some have other keys; a key of None is left out."""
    walls = [wall(name, [*axis]) for name, axis in zip(("south", "east", "north", "west"), pairwise(CORNERS), strict=True)]
    return [{key: value for key, value in (own | others.get(own["name"], {})).items() if value is not None} for own in walls]


def opening(at: float, **keys: float) -> dict[str, Any]:
    return {"openings": [{"at": at, "width": 0.8, "height": 1.5} | keys]}


KEYS_OF_ALL = {
    "walls": box(
        north={"thicknes": 0.3},
        south={"openings": [{"at": 2.0, "width": -1.0}, {"at": 5.9, "width": 0.8}]},
    ),
    "vaults": [BARREL, BARREL | {"rise": "3 kg"}, BARREL | {"walls": ["east", "x"]}],
    "junctions": [{"walls": ["south", "east"], "bond": "but"}, {"walls": ["east", "west"]}],
    "floors": [FLOOR, FLOOR | {"thickness": -1.0, "mas": 3.0}],
}
CASES: dict[str, tuple[dict[str, Any], list[str]]] = {
    "units that are none": (
        KEYS_OF_ALL,
        [
            'structure.vaults[1].rise: "kg" is no unit of a length',
            'structure.floors[1].mas: unknown key (did you mean "mass"?)',
            "structure.floors[1].thickness: input should be greater than 0, got -1.0 m",
        ],
    ),
    "keys that are wrong": (
        KEYS_OF_ALL | {"vaults": [BARREL, BARREL | {"walls": ["east", "x"]}]},
        [
            'structure.walls[2].thicknes: unknown key (did you mean "thickness"?)',
            "structure.walls[0].openings[0].width: input should be greater than 0, got -1.0 m",
            "structure.junctions[0].bond: input should be 'bonded' or 'butt', got 'but'",
            'structure.floors[1].mas: unknown key (did you mean "mass"?)',
            "structure.floors[1].thickness: input should be greater than 0, got -1.0 m",
        ],
    ),
    "junctions, openings and vaults": (
        {
            "walls": box(south={"openings": [{"at": 2.0, "width": 1.0}, {"at": 5.9, "width": 0.8}]}),
            "vaults": [BARREL, BARREL | {"walls": ["east", "x"]}],
            "junctions": [{"walls": ["south", "east"]}, {"walls": ["east", "west"]}],
        },
        [
            "structure.junctions[1].walls: walls east and west do not meet",
            "structure.walls[0].openings[1]: opening o2 of wall south at 5.9 m: with its head it lies over the junction with wall east",
            'structure.vaults[1]: vault vault2: there is no wall "x"',
        ],
    ),
    "an opening over a corner, a vault without its wall": (
        {"walls": box(south=opening(0.4)), "vaults": [BARREL | {"walls": ["east", "x"]}]},
        [
            "structure.walls[0].openings[0]: opening o1 of wall south at 0.4 m: with its head it lies over the junction with wall west",
            'structure.vaults[0]: vault vault1: there is no wall "x"',
        ],
    ),
    "floors without their walls": (
        {
            "walls": box(),
            "floors": [FLOOR | {"anchors": {"walls": ["est"]}}, FLOOR | {"walls": ["south", "nort"]}, FLOOR | {"height": 9.0}],
            "ties": [TIE | {"parts": ["soth"]}],
        },
        [
            'structure.floors[0].anchors.walls: "est" is no group or block',
            'structure.floors[1].walls: "nort" is no group or block (did you mean "north"?)',
            "structure.floors[2].height: no block of south, north stands",
        ],
    ),
    "floors that find no seat and no room": (
        {
            "walls": box(),
            "floors": [FLOOR | {"bearing": 0.9}, FLOOR | {"height": 1.2, "inside": [3.0, 0.1]}, FLOOR | {"inside": [20.0, 2.0]}],
        },
        [
            "structure.floors[0].bearing: must be at most the depth of its wall in the north, 0.6 m, got 0.9",
            "structure.floors[1].inside: no room about x = 3 m, y = 0.1 m at this height",
            "structure.floors[2].inside: no room about x = 20 m, y = 2 m",
        ],
    ),
    "a wall without height: nothing is said of what names it": (
        {
            "walls": box(north={"height": None} | opening(9.0)),
            "floors": [FLOOR],
            "ties": [TIE],
            "junctions": [{"walls": ["north", "east"]}, {"walls": ["south", "x"]}],
            "vaults": [BARREL, BARREL | {"walls": ["east", "west"], "springing": 3.0}],
            "buttresses": [{"wall": "north", "at": 9.0, "width": 0.5, "depth": 0.5, "height": 2.0}],
            "roofs": [{"walls": ["east", "y"], "rise": 1.0, "mass": 100.0}],
        },
        ["structure.walls[2]: wall north: give height, or top"],
    ),
    "what names walls that are not there, and stands on none": (
        {
            "walls": box(),
            "junctions": [{"walls": ["north", "east"]}, {"walls": ["south", "x"]}],
            "vaults": [BARREL, BARREL | {"walls": ["east", "west"], "springing": 3.0}],
            "roofs": [{"walls": ["east", "y"], "rise": 1.0, "mass": 100.0}],
        },
        [
            'structure.junctions[1].walls: there is no wall "x"',
            "structure.vaults[1]: vault vault2: no wall to stand on",
            'structure.roofs[0]: roof roof1: there is no wall "y"',
        ],
    ),
    "columns and a masonry": (
        {
            "walls": box(east={"masonry": "cheese"}),
            "columns": [{"name": "half", "at": [2.0, 2.0], "to": [4.0, 2.0], "height": 2.0}],
            "arcades": [{"columns": "rows"}],
        },
        [
            "structure.columns[0]: columns half: a row from at to to has a number of columns",
            'structure.walls[1]: wall east: masonry "cheese" is none of',
        ],
    ),
    "arcades and buttresses": (
        {
            "walls": box(),
            "columns": [{"name": "row", "at": [2.0, 0.1], "height": 2.0, "size": 0.4}],
            "arcades": [{"columns": "rows"}, {"columns": "row"}],
            "buttresses": [
                {"wall": "south", "at": 9.0, "width": 0.5, "depth": 0.5, "height": 2.0},
                {"wall": "eest", "at": 1.0, "width": 0.5, "depth": 0.5, "height": 2.0},
            ],
        },
        [
            'structure.arcades[0]: arcade arcade1: columns "rows": there are no columns of this name',
            'structure.arcades[1]: arcade arcade2: columns "row": they are one column',
            "structure.buttresses[0]: buttress buttress1: at 9 m it is beyond wall south",
            'structure.buttresses[1]: buttress buttress2: there is no wall "eest"',
        ],
    ),
    "walls at a sharp angle; a tie along nothing": (
        {"walls": [*box(), SHARP], "ties": [TIE | {"along": "q"}]},
        ["structure.walls[4]: walls south and sharp: their strips overlap", "structure.ties[0].along: input should be 'x' or 'y', got 'q'"],
    ),
    "ties on nothing": (
        {"walls": box(), "ties": [TIE | {"parts": ["soth"]}, TIE | {"at": [30.0]}]},
        [
            'structure.ties[0].parts: "soth" is no group or block (did you mean "south"?)',
            "structure.ties[1]: the line along y at x = 30 m, z = 2 m meets no block",
        ],
    ),
    "one name twice, an axis on the spot; what may stand on that wall is left alone": (
        {
            "walls": [*box(west={"axis": [[0, 4], [0, 4]]}), wall("south", [[0, 2], [5, 2]]), wall("up", [[1, 8], [2, 8]], base=2.6)],
            "vaults": [{"shape": "cross", "corners": [[9, 9], [12, 9], [12, 12], [9, 12]], "springing": 1.5}],
            "floors": [FLOOR | {"walls": ["w*"]}],
        },
        [
            "structure.walls[3]: wall west: its axis stays on the spot at x = 0 m, y = 4 m",
            "structure.walls[4]: wall south: another wall has this name, too",
        ],
    ),
    "nothing under a wall or a vault": (
        {
            "walls": [*box(south=opening(3.0, rise=0.2)), wall("up", [[1, 8], [2, 8]], base=2.6)],
            "vaults": [{"shape": "cross", "corners": [[9, 9], [12, 9], [12, 12], [9, 12]], "springing": 1.5}],
        },
        [
            "structure.walls[0].openings[0]: opening o1 of wall south at 3 m: rise belongs to another shape",
            "structure.vaults[0]: vault vault1: no wall to stand on",
            "structure.walls[4]: wall up: nothing is under it at x = 1 m, y = 8 m",
        ],
    ),
    "a misspelt list of walls": (
        {"wals": box(), "floors": [FLOOR], "vaults": [BARREL, BARREL | {"springing": -1.0}]},
        ['structure.wals: unknown key (did you mean "walls"?)', "structure.vaults[1].springing: input should be greater than"],
    ),
    "too many blocks": ({"walls": [*box(), SHARP], "block_length": 1e-7}, ["structure.block_length: makes about"]),
    "courses that do not interlock, tops of two heights": (
        {
            "walls": box(east={"course_height": 0.25} | opening(2.0, rise=0.2), north={"height": 3.0}),
            "roofs": [{"walls": ["south", "north"], "rise": 1.0, "mass": 100.0}],
            "floors": [FLOOR | {"inside": [20.0, 2.0]}, FLOOR],
        },
        [
            "structure.walls[1].openings[0]: opening o1 of wall east at 2 m: rise belongs to another shape",
            "structure.walls[1]: walls south and east at x = 6 m, y = 0 m: courses of 0.6 and 0.25 m do not interlock",
            "structure.walls[2]: walls east and north at x = 6 m, y = 4 m: courses of 0.25 and 0.6 m do not interlock",
            "structure.roofs[0]: roof roof1: walls south and north do not end at one height",
        ],
    ),
}  # fmt: skip


def lines(keys: dict[str, Any], folder: Path = Path()) -> list[str]:
    """What is said of a building."""
    with pytest.raises(InputError) as failure:
        structures.make(KEYS | keys, 2000.0, folder)
    return str(failure.value).splitlines()


def said(found: list[str], begins: list[str]) -> bool:
    """Whether lines begin as they should, in any order, and there is no other."""
    return len(found) == len(begins) and all(sum(line.startswith(begin) for line in found) == 1 for begin in begins)


@pytest.mark.parametrize("case", CASES)
def test_all_faults_are_in_one_report_and_none_that_follows_from_another(case: str) -> None:
    keys, begins = CASES[case]
    found = lines(keys)
    assert said(found, begins), "\n".join(found)


def test_faults_in_a_plan_name_its_file_and_those_in_the_scene_their_key(tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text(json.dumps({"walls": box(south=opening(0.4)), "vaults": [BARREL]}))
    found = lines({"plan": "plan.json", "walls": [SHARP], "vaults": [BARREL | {"walls": ["east", "x"]}]}, tmp_path)
    begins = [
        "structure.walls[0]: walls south and sharp: their strips overlap",
        "plan.json: walls[0].openings[0]: opening o1 of wall south at 0.4 m: with its head it lies over",
        "plan.json: vaults[0]: vault vault1: its bay at x = 3.333 m, y = 1.3 m is no rectangle",
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
