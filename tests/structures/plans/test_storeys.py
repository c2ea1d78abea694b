# SPDX-License-Identifier: GPL-3.0-or-later
"""A drawing for each storey: walls on walls, floors in the rooms between, faults by the drawing that they lie in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from drawings import Drawing

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.geometry import mass_properties
from structures.kinds.building import plan_of

AWAY = (450_000.0, 90_000.0)  # of a drawing in the coordinates of a country [m]
KEYS = {"kind": "building", "block_length": 1.2, "course_height": 0.5}
SLAB = {"thickness": 0.25, "mass": 400.0}


def house(path: Path, dividing: bool = True, door: float = 2.0, at: tuple[float, float] = (0.0, 0.0)) -> None:
    """9 m by 6 m outside, walls of 0.5 m, one of them between two rooms."""
    drawing, (x, y) = Drawing(), at
    drawing.box((x, y), (x + 9.0, y + 6.0))
    for low, high in ((0.5, 4.75), (5.25, 8.5)) if dividing else ((0.5, 8.5),):
        drawing.box((x + low, y + 0.5), (x + high, y + 5.5))
    drawing.box((x + door, y), (x + door + 1.0, y + 0.5), "DOORS")
    drawing.document.saveas(path)


def two(folder: Path, **second: Any) -> dict[str, Any]:
    house(folder / "ground.dxf", at=AWAY)
    house(folder / "first.dxf", **({"dividing": False, "at": AWAY} | second))
    storeys = [{"plan": "ground.dxf", "height": 3.5, "floor": SLAB}, {"plan": "first.dxf", "height": 3.0, "floor": SLAB | {"strips": 2}}]
    return KEYS | {"storeys": storeys}


def test_walls_stand_on_walls_and_floors_fill_the_rooms(tmp_path: Path) -> None:
    made = structures.make(two(tmp_path), 2000.0, tmp_path)
    for storey, count, low, high in ((1, 5, 0.0, 3.5), (2, 4, 3.5, 6.5)):
        for k in range(1, count + 1):
            z = [z for block in made.blocks if block.group == f"w{k}_{storey}" for z in block.vertices[:, 2]]
            assert (min(z), max(z)) == pytest.approx((low, high))
    floors = [block for block in made.blocks if block.group.startswith("floor")]
    assert [(block.group, float(block.vertices[:, 2].max())) for block in floors] == [
        ("floor_1_1", 3.5), ("floor_1_2", 3.5), ("floor_2_1", 6.5), ("floor_2_1", 6.5),
    ]  # fmt: skip
    volume = sum(mass_properties(block.vertices, block.faces).volume for block in made.blocks if not block.fixed)
    ring, door = 9.0 * 6.0 - 8.0 * 5.0, 0.5 * 1.0 * 2.1
    walls = ring * 6.5 + 0.5 * 5.0 * 3.5 - 2.0 * door
    assert volume == pytest.approx(walls + 0.25 * (4.25 + 3.25 + 8.0) * 5.0)  # floors end at the faces of walls but for their seats
    masses = sum(block.density * mass_properties(block.vertices, block.faces).volume for block in floors)
    assert masses == pytest.approx(400.0 * (4.65 + 3.65 + 8.4) * 5.4, rel=1e-9)


def test_a_fault_is_in_the_drawing_of_its_storey(tmp_path: Path) -> None:
    keys = two(tmp_path, door=0.2)
    with pytest.raises(InputError) as failure:
        structures.make(keys, 2000.0, tmp_path)
    assert [fault.place for fault in failure.value.faults] == ["first.dxf, storey 2: walls[1].openings[0]"]
    plan = plan_of({key: value for key, value in keys.items() if key != "kind"}, tmp_path, failure.value.faults)
    assert plan.wrong == {"w2_2"} and {wall.storey for wall in plan.walls} == {0, 1}


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"plan": "ground.dxf"}, "structure.storeys"),
        ({"storeys": [{"plan": "plan.json", "height": 3.0}]}, "structure.storeys[0].plan"),
        ({"storeys": [{"plan": "ground.dxf", "height": 3.0}, {"plan": "none.dxf", "height": 3.0}]}, "structure.storeys[1].plan"),
        ({"storeys": [{"plan": "ground.dxf", "height": 3.0, "floor": {"mass": 400.0}}]}, "structure.storeys[0].floor.thickness"),
        ({"storeys": [{"plan": "ground.dxf", "height": 3.0, "floor": SLAB | {"bearing": 0.6}}]}, "structure.storeys[0].floor.bearing"),
    ],
)
def test_what_is_wrong_with_storeys_names_their_key(tmp_path: Path, change: dict[str, Any], place: str) -> None:
    with pytest.raises(InputError) as failure:
        structures.make(two(tmp_path) | change, 2000.0, tmp_path)
    assert failure.value.place == place


def test_one_drawing_may_serve_several_storeys(tmp_path: Path) -> None:
    house(tmp_path / "ground.dxf")
    table = {"storeys": 3 * [{"plan": "ground.dxf", "height": 3.0}]}
    walls = plan_of(table, tmp_path).walls
    assert [wall.storey for wall in walls] == 5 * [0] + 5 * [1] + 5 * [2]
    assert [wall.base for wall in walls] == 5 * [0.0] + 5 * [3.0] + 5 * [6.0]


def test_a_room_that_is_not_convex_is_named_and_gets_no_floor(tmp_path: Path) -> None:
    drawing = Drawing()
    drawing.outline([(0, 0), (9, 0), (9, 4), (4, 4), (4, 8), (0, 8)])
    drawing.outline([(0.5, 0.5), (8.5, 0.5), (8.5, 3.5), (3.5, 3.5), (3.5, 7.5), (0.5, 7.5)])
    drawing.document.saveas(tmp_path / "l.dxf")
    made = structures.make(KEYS | {"storeys": [{"plan": "l.dxf", "height": 3.0, "floor": SLAB}]}, 2000.0, tmp_path)
    assert not any(block.group.startswith("floor") for block in made.blocks)
    assert any("storey 1" in note and "[[structure.floors]]" in note for note in made.notes)
