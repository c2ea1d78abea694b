# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene whose building is drawn: what ``build`` writes of its plan, and that one can go on from it."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest
from command_line import masonry_cd
from drawings import Drawing
from json_schema import faults
from places import EXAMPLES

from masonry_cd.app.scene_schema import PLAN_FILE, plan_schema_text
from masonry_cd.foundation.errors import InputError
from reports.drawing.palette import FAULTY
from structures.kinds.building import WALLS, build, plan_of
from structures.plans import open_plan

SCENE = """title = "Hut"
[structure]
kind = "building"
plan = "{plan}"
block_length = 1.0
course_height = 0.5
{more}
[material]
density = 2000.0
friction = 0.6
[run]
dt = 1e-3
duration = 1.0
"""


@pytest.fixture
def hut(tmp_path: Path) -> Path:
    """A folder with the drawing of a hut and its scene."""
    drawing = Drawing()
    drawing.box((0.0, 0.0), (5.0, 4.0))
    drawing.box((0.5, 0.5), (4.5, 3.5))
    drawing.box((2.0, 0.0), (3.0, 0.5), "DOORS")
    drawing.text("h=2.0", (2.1, 0.6), "DOORS")
    drawing.lines((1, 1), (2, 2), layer="TABLE")
    drawing.document.saveas(tmp_path / "hut.dxf")
    (tmp_path / "scene.toml").write_text(SCENE.format(plan="hut.dxf", more="wall_height = 3.0"))
    return tmp_path


def built(folder: Path, scene: str, out: str) -> str:
    result = masonry_cd("build", folder / scene, "-o", folder / out, "--no-picture")
    assert result.exit_code == 0, result.output
    return result.output


def test_build_writes_a_plan_from_which_one_goes_on_to_equal_blocks(hut: Path):
    said = built(hut, "scene.toml", "first")
    assert "hut.dxf: 1 entities are not understood" in said
    assert "layer TABLE: LINE" in said
    assert (hut / "first" / "plan_left.csv").read_text().splitlines()[1].split(",")[1:3] == ["TABLE", "LINE"]
    (hut / "again.toml").write_text(SCENE.format(plan="first/plan.json", more=""))
    built(hut, "again.toml", "second")
    assert not (hut / "second" / "plan_left.csv").exists()
    first, second = (json.loads((hut / out / "plan.json").read_text()) for out in ("first", "second"))
    assert first == second
    blocks = [(hut / out / "blocks.json").read_bytes() for out in ("first", "second")]
    assert blocks[0] == blocks[1]


def test_keys_of_the_scene_win_over_the_plan_and_lists_add_to_it(hut: Path):
    built(hut, "scene.toml", "first")
    own = {
        "plan": "first/plan.json",
        "course_height": 0.25,
        "walls": [{"name": "x", "axis": [[9, 0], [9, 3]], "thickness": 0.5, "height": 1.0}],
    }
    keys = plan_of(own, hut).tables
    assert keys["course_height"] == 0.25
    assert keys["block_length"] == 1.0
    assert [wall["name"] for wall in keys["walls"]] == ["w1", "w2", "w3", "w4", "x"]


def test_a_wrong_key_in_a_plan_is_named(hut: Path):
    (hut / "first").mkdir()
    (hut / "first" / "plan.json").write_text('{"walls": [{"name": "a", "axis": [[0, 0], [3, 0]], "thicknes": 0.5, "height": 3.0}]}')
    (hut / "again.toml").write_text(SCENE.format(plan="first/plan.json", more=""))
    result = masonry_cd("build", hut / "again.toml", "-o", hut / "out", "--no-picture")
    assert result.exit_code == 2
    assert 'walls[0].thicknes: unknown key (did you mean "thickness"?)' in result.stderr
    assert not (hut / "out").exists()


def test_faults_of_a_drawing_far_from_the_origin_are_at_its_own_places(tmp_path: Path):
    drawing = Drawing()
    drawing.box((450_000.0, 90_000.0), (450_006.0, 90_000.5))
    drawing.box((450_000.1, 90_000.0), (450_001.1, 90_000.5), "DOORS")
    drawing.document.saveas(tmp_path / "hut.dxf")
    with pytest.raises(InputError, match=r"^hut\.dxf: .*height of wall w1 at x = 450003\.00 m, y = 90000\.25 m"):
        build({"plan": "hut.dxf"}, 2000.0, tmp_path)
    with pytest.raises(InputError, match=r"^hut\.dxf: walls\[0\]\.openings\[0\]: .* at x = 450000\.00 m, y = 90000\.25 m"):
        build({"plan": "hut.dxf", "wall_height": 3.0}, 2000.0, tmp_path)


@pytest.mark.parametrize(("code", "fits"), [(6, '"cm" (9 m)'), (4, '"cm" (9 m)')])
def test_the_unit_is_asked_for_where_walls_are_too_large_or_too_small_for_a_building(tmp_path: Path, code: int, fits: str):
    drawing = Drawing()
    drawing.box((0.0, 0.0), (900.0, 600.0))
    drawing.box((50.0, 50.0), (850.0, 550.0))
    drawing.document.header["$INSUNITS"] = code
    drawing.document.saveas(tmp_path / "hut.dxf")
    with pytest.raises(InputError, match=r"^structure\.units: ") as failure:
        build({"plan": "hut.dxf", "wall_height": 3.0}, 2000.0, tmp_path)
    assert fits in str(failure.value)
    assert len(open_plan(tmp_path / "hut.dxf", {"units": "cm"}).tables["walls"]) == 4


def test_the_schema_of_plans_takes_what_build_writes_and_no_more(hut: Path):
    built(hut, "scene.toml", "first")
    schema = json.loads(plan_schema_text())
    assert PLAN_FILE.read_text(encoding="utf-8") == plan_schema_text(), "masonry-cd schema --plan -o masonry_cd/app/plan.schema.json"
    plan = json.loads((hut / "first" / "plan.json").read_text())
    assert faults(plan, schema) == []
    assert faults(plan | {"layers": {}}, schema)
    assert faults(plan | {"walls": [{"name": "a", "thickness": -1.0}]}, schema)


@pytest.mark.parametrize(
    ("name", "walls", "left"),
    [
        ("church", {"facciata", "lato_sud", "lato_nord", "abside", "torre_o", "torre_s", "torre_e"}, 0),
        ("house", {"party", "front", "cross", "back", "spine", "court", "yard", "end"}, 9),
        pytest.param(
            "oratory",
            {"facciata", "sud", "nord", "arco_trionfale", "abside"},
            0,
            marks=pytest.mark.slow(reason="cuts the stones of a barrel and of an apse; house and church are drawn as it is"),
        ),
    ],
)
def test_the_plans_of_the_examples_stand_as_they_are_drawn(name: str, walls: set[str], left: int):
    plan = open_plan(EXAMPLES / "plans" / f"{name}.dxf", {})
    assert {wall["name"] for wall in plan.tables["walls"]} == walls
    assert len(plan.left) == left
    keys = tomllib.loads((EXAMPLES / "plans" / f"{name}.toml").read_text())["structure"]
    blocks = build({"plan": f"{name}.dxf", **{k: keys[k] for k in ("block_length", "course_height")}}, 2000.0, EXAMPLES / "plans").blocks
    assert {block.group for block in blocks} >= walls


def test_a_plan_that_is_refused_is_written_with_its_faults_in_red(tmp_path: Path):
    walls = [
        {"name": "south", "axis": [[0, 0], [6, 0]], "thickness": 0.6, "height": 3.0, "openings": [{"at": 5.7, "width": 1.0}]},
        {"name": "east", "axis": [[6, 0], [6, 4]], "thickness": 0.5, "height": 3.0},
        {"name": "west", "axis": [[0, 3.4], [0, 0.9]], "thickness": 0.5, "height": 3.0},
    ]
    (tmp_path / "own.json").write_text(json.dumps({"walls": walls}))
    (tmp_path / "scene.toml").write_text(SCENE.format(plan="own.json", more=""))
    result = masonry_cd("build", tmp_path / "scene.toml", "-o", tmp_path / "out")
    assert (result.exit_code, "walls[0].openings[0]" in result.stderr) == (2, True)
    assert {path.name for path in (tmp_path / "out").glob("[!.]*")} == {"plan.json", "plan.svg", "plan_junctions.csv"}
    assert [wall["name"] for wall in json.loads((tmp_path / "out" / "plan.json").read_text())["walls"]] == ["south", "east", "west"]
    assert (tmp_path / "out" / "plan.svg").read_text().count(FAULTY) >= 3  # the wall in plan and elevation, and the line
    rows = (tmp_path / "out" / "plan_junctions.csv").read_text().splitlines()
    assert rows[1] == "corner,6.0,0.0,south; east,0.6; 0.5,90.0,,"
    assert rows[2:] == [
        "free end,0.0,0.0,south,0.6,,west,0.6",
        "free end,6.0,4.0,east,0.5,,south,3.7",
        "free end,0.0,3.4,west,0.5,,south,3.1",
        "free end,0.0,0.9,west,0.5,,south,0.6",
    ]


def test_measures_of_a_plan_are_those_of_faces(tmp_path: Path):
    reach = {outline.name: outline.reach for outline in plan_of({"walls": WALLS}, tmp_path).walls}
    assert reach == {"south": (0.25, 0.25), "east": (0.25, 0.25), "north": (0.25, 0.25), "west": (0.25, 0.25)}


def test_single_lines_are_drawn_all_in_red(tmp_path: Path):
    drawing = Drawing()
    for k in range(4):
        drawing.lines((2.0 * k, 0), (2.0 * k, 4.0))
    drawing.text("CAMERA", (2.6, 2.0), "TEXT")
    drawing.document.saveas(tmp_path / "hut.dxf")
    plan = plan_of({"plan": "hut.dxf"}, tmp_path)
    assert plan.wrong == {wall.name for wall in plan.walls} and plan.walls


def test_walls_that_are_none_do_not_keep_a_refused_plan_from_being_drawn(tmp_path: Path):
    walls = [
        {"name": "spot", "axis": [[1, 1], [1, 1]], "thickness": 0.5, "height": 3.0},
        {"name": "broad", "axis": [[6, 2], [1, 0], [0, 0]], "thickness": 900.0, "height": 3.0},
        {"name": "high", "axis": [[0, 0], [5, 0]], "thickness": 0.5},
    ]
    with pytest.raises(InputError) as refused:
        build({"walls": walls}, 2000.0, tmp_path)
    plan = plan_of({"walls": walls}, tmp_path, refused.value.faults)
    assert plan.wrong >= {"spot", "high"}
    assert [wall.name for wall in plan.walls] == ["broad", "high"]
    assert [meeting[0] for meeting in plan.meetings] == 2 * ["free end"]
