# SPDX-License-Identifier: GPL-3.0-or-later
"""structures.floors: floors fill their room, sit in seats that are cut for them, and carry what statics says of a rigid diaphragm."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from limit_loads import joined, push_loads
from models import GRAVITY, box, ground

import structures
from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
from masonry_cd.analysis.limit.problem import Bars
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import mass_properties
from structures import site
from structures.floors import FloorTable, with_floors
from structures.ties import PlacedBar

HOUSE = {
    "kind": "tower", "side": 6.0, "side_y": 5.0, "height": 4.0, "thickness": 0.5, "course_height": 0.5, "unit_length": 1.5,
    "belfry_width": 0.0, "door_width": 0.0, "bonded": False,
}  # fmt: skip
FLOOR = {"height": 3.0, "thickness": 0.25, "mass": 400.0, "walls": ["south", "north"]}


def made(*floors: dict[str, Any], **keys: Any) -> structures.MadeStructure:
    return structures.make({**HOUSE, **keys, "floors": list(floors)}, 2000.0, Path())


def volume(blocks: list[Block]) -> float:
    return sum(mass_properties(block.vertices, block.faces).volume for block in blocks)


def named(blocks: list[Block], name: str) -> Block:
    return next(block for block in blocks if block.name == name)


def test_a_floor_fills_its_room_reaches_into_named_walls_and_ends_short_of_others():
    plain, house = structures.make(HOUSE, 2000.0, Path()), made(FLOOR)
    slab = named(house.blocks, "floor1")
    assert slab.group == "floor1"
    assert slab.vertices.min(axis=0) == pytest.approx([-2.5 + 0.01, -2.0 - 0.2, 2.75])
    assert slab.vertices.max(axis=0) == pytest.approx([2.5 - 0.01, 2.0 + 0.2, 3.0])
    assert slab.density * mass_properties(slab.vertices, slab.faces).volume == pytest.approx(400.0 * 4.98 * 4.4)
    seats = 2 * 5.0 * 0.2 * 0.25  # which reach from wall to wall
    assert volume(plain.blocks) - (volume(house.blocks) - volume([slab])) == pytest.approx(seats, rel=1e-9)
    (note,) = house.notes
    assert note == ('floor "floor1": rigid, 4.98 m by 4.4 m, 8.765 t, its top at z = 3 m, on seats of 0.2 m in the south, north')


def test_stones_with_a_seat_are_one_stone_of_two_parts_and_those_cut_through_are_two():
    house = made(FLOOR)
    stone = named(house.blocks, "south.6.2")
    assert len(stone.parts) == 2
    through = made({**FLOOR, "height": 2.9, "bearing": 0.5})  # over the whole thickness, within a course
    pieces = [block for block in through.blocks if block.name.startswith("south.6.2.s")]
    assert [len(piece.parts) for piece in pieces] == [0, 0]
    assert sorted(np.ptp(piece.vertices[:, 2]) for piece in pieces) == pytest.approx([0.1, 0.15])


def test_a_floor_above_the_walls_lies_on_them():
    house = made({**FLOOR, "height": 4.25, "walls": ["*"]})
    slab = named(house.blocks, "floor1")
    assert slab.vertices.min(axis=0) == pytest.approx([-2.7, -2.2, 4.0])
    assert not any(block.parts for block in house.blocks)


def test_two_walls_alone_carry_a_floor_as_long_as_they_are():
    walls = [ground(5.0), box("a", (-1.0, -2.4, 0.0), (1.0, -2.0, 3.0)), box("b", (-1.0, 2.0, 0.0), (1.0, 2.4, 3.0))]
    blocks, _, _ = with_floors(walls, [FloorTable.model_validate({**FLOOR, "walls": ["a", "b"]})])
    slab = named(blocks, "floor1")
    assert np.ptp(slab.vertices, axis=0) == pytest.approx([2.0, 4.4, 0.25])


def test_anchors_hold_the_floor_to_the_outer_faces_of_its_walls():
    bars = made({**FLOOR, "anchors": {"spacing": 2.5, "diameter": 0.02, "yield_force": 4e4}}).ties
    assert [bar.keys["name"] for bar in bars] == ["floor1.south1", "floor1.south2", "floor1.north1", "floor1.north2"]
    assert {bar.blocks[0] for bar in bars} == {"floor1"}
    assert [bar.blocks[1].split(".")[0] for bar in bars] == ["south", "south", "north", "north"]
    assert bars[0].points == pytest.approx(np.array([[-1.245, -1.0, 2.875], [-1.245, -2.5, 2.875]]))
    assert all(bar.keys["yield_force"] == 4e4 for bar in bars)


def test_a_structure_in_its_place_takes_its_floors_along():
    tables = [{"name": "a", **HOUSE}, {"name": "b", **HOUSE, "floors": [FLOOR], "at": [20.0, 0.0, 0.0], "rotate": 90}]
    house = site.build(tables, 2000.0, Path())
    slab = named(list(house.blocks), "b.floor1")
    assert np.ptp(slab.vertices, axis=0) == pytest.approx([4.4, 4.98, 0.25])


@pytest.mark.parametrize(
    ("floor", "message"),
    [
        ({"walls": ["sooth"]}, 'structure.floors[0].walls: "sooth" is not a group or block (did you mean "south"?); groups: '),
        ({"height": 9.0}, "structure.floors[0].height: no block of south, north stands at or below z = 8.75 to 9 m"),
        ({"bearing": 0.6}, "structure.floors[0].bearing: must be at most the depth of its wall in the south, 0.5 m, got 0.6"),
        ({"bearing": 0.495}, 'structure.floors[0]: of block "south.6.2" a sliver of 5 mm would remain next to it; another height, '),
        ({"inside": [0.0, 2.2]}, 'structure.floors[0].inside: no room about x = 0 m, y = 2.2 m at this height: block "north.6.'),
        ({"inside": [0.0, 9.0]}, "structure.floors[0].inside: no room about x = 0 m, y = 9 m at this height: it lies outside the walls"),
        ({"walls": ["south"]}, 'structure.floors[0].inside: no room about x = 0 m, y = -2.25 m at this height: block "south.6.'),
        ({"name": "south"}, 'structure.floors[0].name: "south" is the name of other blocks'),
        ({"anchors": {"spacing": 1e-3}}, "structure.floors[0].anchors.spacing: makes 4980 anchors on a wall, at most 500 are allowed"),
        ({"anchors": {"length": 4.5}}, "structure.floors[0].anchors.length: must be at most that of the floor there, got 4.5"),
        ({"anchors": {"space": 1.0}}, "structure.floors[0].anchors.space: unknown key"),
        ({"mass": 0.0}, "structure.floors[0].mass: input should be greater than 0, got 0.0"),
    ],
)
def test_what_is_wrong_with_a_floor_is_said_in_one_line(floor, message):
    with pytest.raises(InputError) as caught:
        made({**FLOOR, **floor})
    assert str(caught.value).startswith(message)


def test_faults_of_anchors_come_with_those_of_other_floors():
    floors = [
        {**FLOOR, "anchors": {"length": 4.5}},
        {**FLOOR, "height": 1.5, "anchors": {"spacing": 1e-3}},
        {**FLOOR, "height": 9.0},
    ]
    with pytest.raises(InputError) as caught:
        made(*floors)
    places = ("floors[2].height", "floors[0].anchors.length", "floors[1].anchors.spacing")
    assert [line.split(":")[0].removeprefix("structure.") for line in caught.value.lines] == list(places)


@pytest.mark.parametrize(("thick", "bearing", "web"), [(0.45, 0.2, "50 mm"), (0.5, 0.2, ""), (0.45, 0.17, "")])
def test_a_thin_web_between_two_seats_is_named(thick: float, bearing: float, web: str):
    walls = [box("a", (-1.0, -2.4, 0.0), (1.0, -2.0, 3.0)), box("b", (-1.0, 2.0, 0.0), (1.0, 2.0 + thick, 3.0))]
    walls += [ground(9.0), box("c", (-1.0, 6.0, 0.0), (1.0, 6.4, 3.0))]
    tables = [{**FLOOR, "walls": pair, "inside": [0.0, y], "bearing": bearing} for pair, y in ((["a", "b"], 0.0), (["b", "c"], 4.0))]
    _, _, notes = with_floors(walls, [FloorTable.model_validate(table) for table in tables])
    assert [note for note in notes[2:] if web in note and '"floor1" and "floor2"' in note] == notes[2:]
    assert bool(web) == bool(notes[2:])


# Two walls along x, 3 m high and 2 m long: one of courses and 0.4 m thick, and a block of 4 m that nothing moves, 3 m apart.
# A floor of 0.2 m lies in seats of 0.15 m, its top flush with theirs.
HIGH, LONG, THICK, APART, DEEP, SLAB, COURSES = 3.0, 2.0, 0.4, 3.0, 0.15, 0.2, 10
MASS, DENSITY = 500.0, 2000.0


def propped(courses: int, floor: bool) -> list[Block]:
    beds = np.linspace(0.0, HIGH, courses + 1)
    half = 0.5 * LONG
    wall = [box(f"w{k}", (-half, 0.0, float(beds[k])), (half, THICK, float(beds[k + 1])), density=DENSITY) for k in range(courses)]
    blocks = [ground(20.0), *wall, box("far", (-half, THICK + APART, 0.0), (half, THICK + APART + 4.0, HIGH), density=DENSITY)]
    if not floor:
        return blocks
    table = {"height": HIGH, "thickness": SLAB, "mass": MASS, "walls": [f"w{courses - 1}", "far"], "bearing": DEEP, "inside": [0.0, 1.9]}
    return with_floors(blocks, [FloorTable.model_validate(table)])[0]


def factor_of(blocks: list[Block], towards: float, between: float, bars: Sequence[PlacedBar] = ()) -> float:
    """The largest push along y; ``between`` is the friction of the floor's own joints."""
    names = [block.name for block in blocks]
    friction = {"default": 2.0} if names[-1] != "floor1" else {"default": 2.0, "block-floor1": between}
    assembly, joints = joined(blocks, friction)
    ends = np.array([[names.index(end) for end in bar.blocks] for bar in bars], dtype=np.int64).reshape(-1, 2)
    points = np.array([bar.points for bar in bars]).reshape(-1, 2, 3)
    held = Bars(ends, points, np.array([bar.keys["yield_force"] for bar in bars]))
    loads = push_loads(assembly, (0.0, towards, 0.0), held)
    return analyse(assembly, joints, loads, LimitOptions(starts=0)).associated.factor


def by_hinges(bed: float) -> float:
    """The factor at which the wall folds towards the floor that props it: hinges at its toe, at a bed, and where the floor pushes back.

    Unit turn of the lower piece about its inner toe. The upper one turns back about the bed's outer edge by phi, its seat leaning on the
    lower edge of the floor; the inner edge of the seat lifts the floor, which turns by psi about its upper edge at the far wall.
    """
    foot, span = HIGH - SLAB, 2.0 * DEEP + APART  # of the seat [m]; of the floor [m]
    lever = span - DEEP  # of the edge on which the floor is lifted
    # phi (foot - bed) = bed + psi SLAB,   psi lever = THICK (1 + phi)
    psi = THICK * (1.0 + bed / (foot - bed)) / (lever - THICK * SLAB / (foot - bed))
    phi = (bed + psi * SLAB) / (foot - bed)
    pieces = [  # volume, middle (y, z), of what has its density
        (bed * THICK, 0.5 * THICK, 0.5 * bed),
        ((HIGH - bed) * THICK, 0.5 * THICK, 0.5 * (HIGH + bed)),
        (-SLAB * DEEP, THICK - 0.5 * DEEP, HIGH - 0.5 * SLAB),
    ]
    along = lift = 0.0
    for k, (area, y, z) in enumerate(pieces):
        weight = DENSITY * area
        along += weight * (z if k == 0 else bed - phi * (z - bed))
        lift += weight * (THICK - y if k == 0 else THICK + phi * y)
    slab = MASS * span
    return (lift + slab * 0.5 * psi * span) / (along - slab * 0.5 * psi * SLAB)


def test_a_wall_that_a_floor_props_folds_at_the_factor_of_statics():
    """Without a floor it overturns at thickness over height; propped by the diaphragm it must fold at the weakest of its beds."""
    assert factor_of(propped(COURSES, floor=False), 1.0, 2.0) == pytest.approx(THICK / HIGH, rel=1e-6)
    beds = np.linspace(0.0, HIGH, COURSES + 1)[1:-1]
    least = min(by_hinges(float(bed)) for bed in beds)
    assert least > 4.0 * THICK / HIGH
    assert factor_of(propped(COURSES, floor=True), 1.0, 0.0) == pytest.approx(least, rel=1e-5)


@pytest.mark.parametrize("strength", [0.0, 8e3])
def test_anchors_hold_a_wall_back_by_their_yield_force(strength):
    """A wall in one piece overturns away from the far one, about its outer toe by a unit, and takes the floor along.

    Its seat lifts the floor by its inner edge and pushes it by the lower edge; the anchors of both walls stretch, by the height of the
    floor's middle between them.
    """
    table = {"height": HIGH, "thickness": SLAB, "mass": MASS, "walls": ["w0", "far"], "bearing": DEEP, "inside": [0.0, 1.9]}
    anchors = {"anchors": {"spacing": 1.0, "yield_force": strength}} if strength else {}
    blocks, bars, _ = with_floors(propped(1, floor=False), [FloorTable.model_validate(table | anchors)])
    assert len(bars) == (4 if strength else 0)
    foot, span = HIGH - SLAB, 2.0 * DEEP + APART
    psi = THICK / (span - DEEP)
    wall = [(HIGH * THICK, 0.5 * THICK, 0.5 * HIGH), (-SLAB * DEEP, THICK - 0.5 * DEEP, HIGH - 0.5 * SLAB)]
    held = sum(DENSITY * area * y for area, y, _ in wall) + MASS * span * 0.5 * psi * span
    pushed = sum(DENSITY * area * z for area, _, z in wall) + MASS * span * (foot - 0.5 * psi * SLAB)
    tied = 2.0 * strength / (GRAVITY * LONG) * (HIGH - 0.5 * SLAB)
    assert factor_of(blocks, -1.0, 0.0, bars) == pytest.approx((held + tied) / pushed, rel=1e-5)


OUT_OF_SQUARE = [(0.0, 0.0), (4.0, 0.6), (3.6, 4.2), (-0.5, 3.4)]


def out_of_square(**floor: Any) -> structures.MadeStructure:
    walls = [
        {"name": name, "axis": [OUT_OF_SQUARE[k], OUT_OF_SQUARE[(k + 1) % 4]], "thickness": 0.5, "height": 2.4}
        for k, name in enumerate(("a", "b", "c", "d"))
    ]
    table = {"height": 1.9, "thickness": 0.2, "mass": 300.0, "walls": ["a", "c"]} | floor
    keys = {"kind": "building", "walls": walls, "block_length": 0.8, "course_height": 0.4, "floors": [table]}
    return structures.make(keys, 2000.0, Path())


def test_a_floor_fills_a_room_whose_walls_are_out_of_square():
    made = out_of_square(anchors={"spacing": 1.5})
    slab = named(made.blocks, "floor1")
    plan = slab.vertices[slab.vertices[:, 2] > 1.8][:, :2]
    assert len(plan) == 4
    for k, beyond in ((0, 0.2), (1, -0.01), (2, 0.2), (3, -0.01)):  # a seat, a gap
        start, end = np.array(OUT_OF_SQUARE[k]), np.array(OUT_OF_SQUARE[(k + 1) % 4])
        along = (end - start) / np.hypot(*(end - start))
        inward = (plan - start) @ [-along[1], along[0]]
        assert np.sort(inward)[:2] == pytest.approx([0.25 - beyond] * 2, abs=1e-9)
    across = np.array([bar.points[1] - bar.points[0] for bar in made.ties])
    assert len(across) >= 4
    assert (np.abs(across[:, 2]) < 1e-9).all()
    names = {name.split(".")[0] for bar in made.ties for name in bar.blocks}
    assert names == {"floor1", "a", "c"}


def test_a_floor_in_strips_is_one_block_for_each_and_bears_on_what_lies_across_its_span():
    made = out_of_square(strips=4, span=90.0, walls=["*"])
    strips = [block for block in made.blocks if block.group == "floor1"]
    assert [block.name for block in strips] == ["floor1.1", "floor1.2", "floor1.3", "floor1.4"]
    assert "of 4 strips" in made.notes[-1]
    assert "in the south, north" in made.notes[-1]
    whole = out_of_square(span=90.0, walls=["*"])
    assert volume(strips) == pytest.approx(volume([named(whole.blocks, "floor1")]), rel=1e-9)
    with pytest.raises(InputError, match=r"span: none of a, c lies across 0 degrees"):
        out_of_square(span=0.0)
