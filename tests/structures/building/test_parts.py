# SPDX-License-Identifier: GPL-3.0-or-later
"""Columns, arcades, buttresses and vaults of a building, and its macro-elements."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from plans import free_volume, prepare, volume_of_plan, wall
from solids import build
from statics3d import assembled, can_stand, in_one_piece

import structures
from masonry_cd.foundation.errors import InputError
from structures.kinds.building import KIND
from structures.macro_elements import macro_elements

SIDES = [wall("w", [[0, -1], [0, 1]], 0.6, 2.7), wall("e", [[4.6, -1], [4.6, 1]], 0.6, 2.7)]
ARCADE: dict[str, Any] = {
    "walls": SIDES,
    "columns": [{"name": "row", "at": [2.3, 0], "size": 0.5, "height": 1.2}],
    "buttresses": [{"wall": "e", "at": 1.0, "width": 0.6, "depth": 0.5, "height": 1.8, "slope": 0.4}],
}
ROOM = [
    wall("s", [[0, 0], [3, 0]], 0.6),
    wall("e", [[3, 0], [3, 2.4]], 0.6),
    wall("n", [[3, 2.4], [0, 2.4]], 0.6),
    wall("w", [[0, 2.4], [0, 0]], 0.6),
]
CLEAR = [[0.3, 0.3], [2.7, 0.3], [2.7, 2.1], [0.3, 2.1]]
ALL = ["s", "e", "n", "w"]
VAULT: dict[str, Any] = {"springing": 1.2, "thickness": 0.25, "block_length": 0.5}


def test_an_arcade_stands_on_its_columns_and_springs_from_responds() -> None:
    row = {"name": "row", "at": [2, 0], "to": [4, 0], "number": 2, "size": 0.5, "height": 1.5}
    walls = [wall("w", [[0, -1], [0, 1]], 0.6, 2.7), wall("e", [[6, -1], [6, 1]], 0.6, 2.7)]
    blocks = build("building", walls=walls, columns=[row], arcades=[{"columns": "row", "ends": [[0, 0], [6, 0]]}])
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)
    assert can_stand(blocks, 0.7)
    arches = {block.name.split(".")[1] for block in blocks if block.name.startswith("arcade1.o")}
    assert arches == {"o1", "o2", "o3"}


def test_buttresses_are_bonded_and_columns_have_their_volume() -> None:
    blocks = build("building", **ARCADE)
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)
    sloped = free_volume([block for block in blocks if block.group == "buttresses"])
    assert 0.6 * 0.5 * 1.6 < sloped < 0.6 * (0.5 * 1.6 + 0.6 * 1.8)  # and what of its courses reaches into the wall


@pytest.mark.parametrize("shape", ["barrel", "cross", "domical"])
def test_a_vault_over_a_bay_fills_its_pockets_and_stands(shape: str) -> None:
    names = ["s", "n"] if shape == "barrel" else ALL
    blocks = build("building", walls=ROOM, vaults=[VAULT | {"shape": shape, "walls": names}], junction="bonded")
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)
    assert can_stand(blocks, 0.7)
    vault = [block for block in blocks if block.group == "vault1"]
    rest = free_volume(blocks) - free_volume(vault)
    walls = shapely.union_all([shapely.box(-0.3, -0.3, 3.3, 2.7)]).difference(shapely.box(0.3, 0.3, 2.7, 2.1))
    within = sum(_beyond(block.convex_parts) for block in vault)
    assert rest + within == pytest.approx(2.4 * walls.area, rel=1e-9)
    assert volume_of_plan(prepare({"walls": ROOM})) == pytest.approx(2.4 * walls.area, rel=1e-9)


@pytest.mark.slow(reason="the stones of a sail dome cut those of its walls by many planes")
def test_a_sail_dome_over_four_walls_stands() -> None:
    blocks = build("building", walls=ROOM, vaults=[VAULT | {"shape": "dome", "walls": ALL}])
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)
    assert can_stand(blocks, 0.7)


def _beyond(parts: Any) -> float:
    """Volume of convex parts outside the clear bay, by slicing them along z [m3]: of the second degree between their corners."""
    total = 0.0
    bay = shapely.box(0.3, 0.3, 2.7, 2.1)
    for part in parts:
        levels = _levels(part, bay)
        for low, high in pairwise(levels):
            areas = [_slice(part, low + share * (high - low)).difference(bay).area for share in (1e-12, 0.5, 1.0 - 1e-12)]
            total += (high - low) * (areas[0] + 4.0 * areas[1] + areas[2]) / 6.0
    return total


def _levels(part: Any, bay: Any) -> list[float]:
    """Heights at which a slice changes its kind: of corners, and where edges pass a side of the bay [m]."""
    heights = set(np.round(part.vertices[:, 2], 12).tolist())
    for face in part.faces:
        for i, j in zip(face, (*face[1:], face[0]), strict=True):
            a, b = part.vertices[i], part.vertices[j]
            for axis, place in ((0, 0.3), (0, 2.7), (1, 0.3), (1, 2.1)):
                if (a[axis] - place) * (b[axis] - place) < 0.0:
                    heights.add(round(float(a[2] + (place - a[axis]) / (b[axis] - a[axis]) * (b[2] - a[2])), 12))
    return sorted(heights)


def _slice(part: Any, z: float) -> Any:
    """A convex part at a height."""
    points = []
    for face in part.faces:
        for i, j in zip(face, (*face[1:], face[0]), strict=True):
            a, b = part.vertices[i], part.vertices[j]
            if (a[2] - z) * (b[2] - z) < 0.0:
                points.append(a[:2] + (z - a[2]) / (b[2] - a[2]) * (b[:2] - a[:2]))
    return shapely.MultiPoint(np.array(points)).convex_hull


def test_a_floor_has_its_seats_in_walls_by_name_and_is_tied_to_those_asked_for() -> None:
    floor: dict[str, Any] = {"height": 1.8, "thickness": 0.2, "mass": 300.0, "walls": ["s", "n"]}
    floor["anchors"] = {"spacing": 1.2, "walls": ["n"]}
    made = structures.make({"kind": "building", "walls": ROOM, "floors": [floor]}, 2000.0, Path())
    slab = next(block for block in made.blocks if block.name == "floor1")
    assert np.ptp(slab.vertices[:, 1]) == pytest.approx(1.8 + 2 * 0.2)
    assert {bar.blocks[1].split(".")[0] for bar in made.ties} | {bar.blocks[0].split(".")[0] for bar in made.ties} == {"floor1", "n"}
    floor["anchors"] = {"walls": ["w"]}
    with pytest.raises(InputError, match=r'anchors\.walls: the floor has no seat in "w"'):
        structures.make({"kind": "building", "walls": ROOM, "floors": [floor]}, 2000.0, Path())


def test_tie_beams_of_a_roof_stay_where_there_are_floors() -> None:
    floor: dict[str, Any] = {"height": 1.8, "thickness": 0.2, "mass": 300.0, "walls": ["s", "n"], "anchors": {"spacing": 1.2}}
    roof = {"walls": ["s", "n"], "rise": 0.8, "mass": 150.0, "tied": True}
    made = structures.make({"kind": "building", "walls": ROOM, "roofs": [roof], "floors": [floor]}, 2000.0, Path())
    assert {bar.keys["name"].split(".")[0] for bar in made.ties} == {"roof1", "floor1"}


FAULTS: dict[str, tuple[dict[str, Any], str]] = {
    "no wall to stand on": (
        {"walls": ROOM[:2] + ROOM[3:], "vaults": [VAULT | {"corners": CLEAR, "shape": "domical"}]},
        r"vault vault1: no wall to stand on at x = 1.5 m, y = 2.225 m, z = 1.2 m: of the 0.25 m that it bears on, walls carry 0 %",
    ),
    "no such wall": ({"walls": ROOM, "vaults": [VAULT | {"walls": ["s", "x"]}]}, 'vault vault1: there is no wall "x"'),
    "not parallel": ({"walls": ROOM, "vaults": [VAULT | {"walls": ["s", "e"]}]}, "vault vault1: walls s and e are not parallel"),
    "above its walls": ({"walls": ROOM, "vaults": [VAULT | {"walls": ["s", "n"], "springing": 3.0}]}, "vault vault1: no wall to stand on"),
    "arcade without columns": ({"walls": SIDES, "arcades": [{"columns": "row"}]}, 'arcade arcade1: columns "row": there are no columns'),
    "arcade of one column": (ARCADE | {"arcades": [{"columns": "row"}]}, "they are one column"),
    "buttress beyond": (
        {"walls": SIDES, "buttresses": [{"wall": "e", "at": 5.0, "width": 0.6, "depth": 0.5, "height": 1.8}]},
        "buttress buttress1: at 5 m it is beyond wall e",
    ),
    "columns in each other": (
        {"walls": SIDES, "columns": [{"at": [[2, 0], [2.2, 0]], "height": 1.0}]},
        "columns column1: two of them are 0.2 m apart",
    ),
}


@pytest.mark.parametrize("case", FAULTS)
def test_what_has_nothing_to_stand_on_is_a_fault_with_its_place(case: str) -> None:
    keys, said = FAULTS[case]
    with pytest.raises(InputError, match=said):
        build("building", **keys)


def test_each_wall_and_vault_is_a_macro_element_and_a_wall_falls_across_its_axis() -> None:
    slanted = wall("slanted", [[0, 0], [3, 3]], 0.5)
    blocks = build("building", walls=[slanted, wall("b", [[0, 0], [4, 0]], top=[[0, 2.4], [2, 3.2], [4, 2.4]])])
    found = {one.name: one for one in macro_elements(blocks, KIND.parts)}
    assert np.abs(found["slanted"].directions[0][0]) == pytest.approx(0.5**0.5, abs=0.02)
    assert found["slanted"].directions[0][0] * found["slanted"].directions[0][1] < 0.0
    assert {"b, gable", "b, upper part", "b, in its plane"} <= found.keys()
    along = found["slanted, in its plane"].directions
    assert np.abs(along) == pytest.approx(np.array([[0.5**0.5, 0.5**0.5, 0.0]] * 2), abs=1e-9)
    assert np.sum(np.multiply(*along)) == pytest.approx(-1.0)
