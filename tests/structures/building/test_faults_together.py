# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults of different parts of a building: each in a line, all in one report, and none that only follows from another."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import ezdxf
import pytest
from plans import wall
from typer.testing import CliRunner

import structures
from masonry_cd.cli.app import app
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


CASES: dict[str, tuple[dict[str, Any], list[str]]] = {
    "an opening over a corner, a vault and a floor without their walls": (
        {
            "walls": box(south=opening(0.4)),
            "vaults": [BARREL | {"walls": ["east", "x"]}],
            "floors": [FLOOR | {"walls": ["south", "nort"], "anchors": {"walls": ["est"]}}],
        },
        [
            "opening o1 of wall south at 0.4 m: with its head it lies over the junction with wall west",
            'vault vault1: there is no wall "x"',
            'structure.floors[0].anchors.walls: "est" is no group or block',
            'structure.floors[0].walls: "nort" is no group or block (did you mean "north"?)',
        ],
    ),
    "an opening beyond its wall, floors that find no seat and no room": (
        {"walls": box(south=opening(9.0)), "floors": [FLOOR | {"bearing": 0.9}, FLOOR | {"height": 1.2, "inside": [3.0, 0.1]}]},
        [
            "opening o1 of wall south at 9 m: it is beyond the wall, which is 6 m long",
            "structure.floors[0].bearing: must be at most the depth of its wall in the north, 0.6 m, got 0.9",
            "structure.floors[1].inside: no room about x = 3 m, y = 0.1 m at this height",
        ],
    ),
    "a wall without height: nothing is said of what names it, all of what does not": (
        {
            "walls": box(north={"height": None} | opening(9.0)),
            "floors": [FLOOR],
            "ties": [TIE],
            "junctions": [{"walls": ["north", "east"]}, {"walls": ["south", "x"]}],
            "vaults": [BARREL, BARREL | {"walls": ["east", "west"], "springing": 3.0}],
            "buttresses": [{"wall": "north", "at": 9.0, "width": 0.5, "depth": 0.5, "height": 2.0}],
            "roofs": [{"walls": ["east", "y"], "rise": 1.0, "mass": 100.0}],
        },
        [
            "wall north: give height, or top",
            'structure.junctions[1].walls: there is no wall "x"',
            "vault vault2: no wall to stand on",
            'roof roof1: there is no wall "y"',
        ],
    ),
    "keys that are wrong, and what is wrong elsewhere": (
        {
            "walls": box(
                north={"thicknes": 0.3},
                south={"openings": [{"at": 2.0, "width": -1.0}, {"at": 5.9, "width": 0.8}]},
            ),
            "vaults": [BARREL, BARREL | {"rise": "3 kg"}, BARREL | {"walls": ["east", "x"]}],
            "junctions": [{"walls": ["south", "east"], "bond": "but"}, {"walls": ["east", "west"]}],
            "floors": [FLOOR, FLOOR | {"thickness": -1.0, "mas": 3.0}],
        },
        [
            'structure.vaults[1].rise: "kg" is no unit of a length',
            'structure.walls[2].thicknes: unknown key (did you mean "thickness"?)',
            "structure.walls[0].openings[0].width: input should be greater than 0, got -1.0 m",
            "structure.junctions[0].bond: input should be 'bonded' or 'butt', got 'but'",
            "structure.junctions[1].walls: walls east and west do not meet",
            "opening o2 of wall south at 5.9 m: with its head it lies over the junction with wall east",
            'vault vault3: there is no wall "x"',
            'structure.floors[1].mas: unknown key (did you mean "mass"?)',
            "structure.floors[1].thickness: input should be greater than 0, got -1.0 m",
        ],
    ),
    "columns, arcades, buttresses and a masonry": (
        {
            "walls": box(east={"masonry": "cheese"}),
            "columns": [
                {"name": "row", "at": [2.0, 0.1], "height": 2.0, "size": 0.4},
                {"name": "half", "at": [2.0, 2.0], "to": [4.0, 2.0], "height": 2.0},
            ],
            "arcades": [{"columns": "rows"}, {"columns": "row"}, {"columns": "half"}],
            "buttresses": [
                {"wall": "south", "at": 9.0, "width": 0.5, "depth": 0.5, "height": 2.0},
                {"wall": "eest", "at": 1.0, "width": 0.5, "depth": 0.5, "height": 2.0},
            ],
        },
        [
            "columns half: a row from at to to has a number of columns",
            'wall east: masonry "cheese" is none of',
            'arcade arcade1: columns "rows": there are no columns of this name',
            'arcade arcade2: columns "row": they are one column',
            "buttress buttress1: at 9 m it is beyond wall south",
            'buttress buttress2: there is no wall "eest"',
            "columns row: the one at x = 2 m, y = 0.1 m stands in wall south",
        ],
    ),
    "walls at a sharp angle, a floor above all walls, ties on nothing": (
        {
            "walls": [*box(), SHARP],
            "floors": [FLOOR | {"height": 9.0}],
            "ties": [TIE | {"parts": ["soth"]}, TIE | {"at": [30.0]}, TIE | {"along": "q"}],
        },
        [
            "walls south and sharp: their strips overlap",
            "structure.floors[0].height: no block of south, north stands",
            'structure.ties[0].parts: "soth" is no group or block (did you mean "south"?)',
            "structure.ties[1]: the line along y at x = 30 m, z = 2 m meets no block",
            "structure.ties[2].along: input should be 'x' or 'y', got 'q'",
        ],
    ),
    "one name twice, an axis on the spot; what may stand on that wall is left alone": (
        {
            "walls": [*box(west={"axis": [[0, 4], [0, 4]]}), wall("south", [[0, 2], [5, 2]]), wall("up", [[1, 8], [2, 8]], base=2.6)],
            "vaults": [{"shape": "cross", "corners": [[9, 9], [12, 9], [12, 12], [9, 12]], "springing": 1.5}],
            "floors": [FLOOR | {"walls": ["w*"]}],
        },
        ["wall south: another wall has this name, too", "wall west: its axis stays on the spot at x = 0 m, y = 4 m"],
    ),
    "nothing under a wall or a vault": (
        {
            "walls": [*box(south=opening(3.0, rise=0.2)), wall("up", [[1, 8], [2, 8]], base=2.6)],
            "vaults": [{"shape": "cross", "corners": [[9, 9], [12, 9], [12, 12], [9, 12]], "springing": 1.5}],
        },
        [
            "opening o1 of wall south at 3 m: rise belongs to another shape",
            "vault vault1: no wall to stand on",
            "wall up: nothing is under it at x = 1 m, y = 8 m",
        ],
    ),
    "a misspelt list of walls: what stands on walls is left alone": (
        {"wals": box(), "floors": [FLOOR], "vaults": [BARREL, BARREL | {"springing": -1.0}]},
        ['structure.wals: unknown key (did you mean "walls"?)', "structure.vaults[1].springing: input should be greater than"],
    ),
    "too many blocks": (
        {
            "walls": [*box(), SHARP],
            "block_length": 1e-7,
            "vaults": [BARREL | {"walls": ["south", "x"]}],
            "floors": [FLOOR | {"mass": -1.0}],
        },
        [
            "walls south and sharp: their strips overlap",
            "structure.block_length: makes about",
            'vault vault1: there is no wall "x"',
            "structure.floors[0].mass: input should be greater than 0",
        ],
    ),
    "courses that do not interlock, tops of two heights, a floor outside": (
        {
            "walls": box(east={"course_height": 0.25} | opening(2.0, rise=0.2), north={"height": 3.0}),
            "roofs": [{"walls": ["south", "north"], "rise": 1.0, "mass": 100.0}],
            "floors": [FLOOR | {"inside": [20.0, 2.0]}, FLOOR],
        },
        [
            "opening o1 of wall east at 2 m: rise belongs to another shape",
            "walls south and east at x = 6 m, y = 0 m: courses of 0.6 and 0.25 m do not interlock",
            "walls east and north at x = 6 m, y = 4 m: courses of 0.25 and 0.6 m do not interlock",
            "roof roof1: walls south and north do not end at one height",
            "structure.floors[0].inside: no room about x = 20 m, y = 2 m",
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


def test_faults_of_a_plan_in_json_and_of_its_scene_are_said_together(tmp_path: Path) -> None:
    plan = {"walls": box(north={"thicknes": 0.3}, south=opening(0.4)), "vaults": [BARREL, BARREL | {"walls": ["east", "x"]}]}
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    found = lines({"plan": "plan.json", "walls": [SHARP], "floors": [FLOOR, FLOOR | {"walls": ["nort"]}]}, tmp_path)
    begins = [
        "structure.walls[2].thicknes: unknown key",
        "walls south and sharp: their strips overlap",
        "opening o1 of wall south at 0.4 m: with its head it lies over",
        'vault vault2: there is no wall "x"',
        'structure.floors[1].walls: "nort" is no group or block',
    ]
    assert said(found, begins), "\n".join(found)


def test_faults_of_a_drawing_and_of_its_scene_are_said_together_and_end_with_2(tmp_path: Path) -> None:
    drawing = ezdxf.new("R2010")
    drawing.header["$INSUNITS"] = 6
    for (x, y), (x1, y1) in (((0, 0), (6, 0.6)), ((0, 3.4), (6, 4)), ((0, 0.6), (0.6, 3.4)), ((5.4, 0.6), (6, 3.4))):
        corners = [(x, y), (x1, y), (x1, y1), (x, y1)]
        drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": "WALLS"})
    for words, at in (("SOUTH h=2.4", (2, -0.3)), ("NORTH h=2.4", (2, 4.2)), ("EAST", (6.2, 2)), ("WEST h=2.4", (-0.6, 2))):
        drawing.modelspace().add_text(words, height=0.1, dxfattribs={"layer": "HEIGHTS"}).set_placement(at)
    drawing.modelspace().add_lwpolyline([(0.7, 0), (1.5, 0), (1.5, 0.6), (0.7, 0.6)], close=True, dxfattribs={"layer": "DOORS"})
    drawing.saveas(tmp_path / "plan.dxf")
    (tmp_path / "scene.toml").write_text("""
material = { density = 2000.0, friction = 0.6 }
run = { dt = 2e-3, duration = 1.0 }

[structure]
kind = "building"
plan = "plan.dxf"
block_length = 1.6
course_height = 0.6
vaults = [{ walls = ["south", "x"], springing = 1.5 }]
floors = [
    { height = 2.1, thickness = 0.2, mass = 300.0, walls = ["south", "norht"] },
    { height = 2.1, thickness = 0.2, mass = 300.0, walls = ["east"] },
]
""")
    result = CliRunner().invoke(app, ["build", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out")])
    assert result.exit_code == 2
    found = [
        line.partition(": ")[2] if "scene.toml" in line else line for line in result.stderr.replace("masonry-cd: error: ", "").splitlines()
    ]
    begins = [
        "plan.dxf: nothing says the height of wall east",
        "opening o1 of wall south at ",
        'vault vault1: there is no wall "x"',
        'structure.floors[0].walls: "norht" is no group or block (did you mean "north"?)',
    ]
    assert said(found, begins), result.stderr


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
    assert lines(KEYS | keys) == ["wall buttress1: another wall has this name, too"]
