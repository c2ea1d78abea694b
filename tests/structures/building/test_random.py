# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans by chance are built exactly or refused by walls and places; three rooms with floors and vaults, at all sizes of blocks."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import random_plans
import shapely
from plans import free_volume, prepare, volume_of_plan, wall
from solids import build
from statics3d import assembled, can_stand, in_one_piece

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import built_gap
from masonry_cd.mechanics.model.blocks import Assembly, Block
from structures.geometry.cells import ConvexCell

WALLS = [
    wall("s", [[0, 0], [4, 0.3]], 0.5),
    wall("e", [[4, 0.3], [3.8, 3.4]], 0.6),
    wall("n", [[3.8, 3.4], [-0.2, 3.1]], 0.5, openings=[{"at": 2.0, "width": 0.8, "sill": 0.6, "height": 1.0, "shape": "segmental"}]),
    wall("w", [[-0.2, 3.1], [0, 0]], 0.6),
]
ROOM = [wall("s", [[0, 0], [3.4, 0]]), wall("e", [[3.4, 0], [3.4, 3]]), wall("n", [[3.4, 3], [0, 3]]), wall("w", [[0, 3], [0, 0]])]
VAULT = {"shape": "cross", "walls": ["s", "e", "n", "w"], "springing": 1.1, "rise": 0.9, "thickness": 0.2}
FLOOR = {"height": 1.7, "thickness": 0.2, "mass": 300.0, "walls": ["s", "n"]}
BACK = [wall("k", [[0, 3], [0, 5.6]], 0.5), wall("l", [[0, 5.6], [3.4, 5.6]], 0.5), wall("m", [[3.4, 5.6], [3.4, 3]], 0.5)]
SEATS = [FLOOR | {"inside": [1.5, 1.5]}, FLOOR | {"inside": [1.5, 4.2], "height": 1.78, "walls": ["n", "l"]}]  # both cut into stones of n
PLANS: dict[str, dict[str, Any]] = {
    "floor": {"walls": WALLS, "floors": [FLOOR]},
    "two floors": {"walls": ROOM + BACK, "floors": SEATS},
    "vault": {"walls": ROOM, "vaults": [VAULT]},
}
LEAST_PART = 0.008  # width of a part [m]: elastic joints sink by some tenths of a millimetre, a tenth of it may pass


def least_width(blocks: list[Block]) -> float:
    """Return the least width of the convex parts of free blocks [m]."""
    parts = [part for block in blocks if not block.fixed for part in block.convex_parts]
    return min(ConvexCell.of(Block("", part.vertices, part.faces)).width for part in parts)


@pytest.mark.parametrize(("name", "size", "bond", "seed"), [
    ("floor", 0.5, "irregular", 0), ("floor", 1.2, "regular", 0), ("floor", 0.8, "rubble", 3), ("two floors", 0.6, "irregular", 1),
    ("two floors", 1.0, "regular", 0), ("two floors", 0.75, "rubble", 2), ("vault", 0.6, "regular", 0), ("vault", 1.0, "irregular", 2),
])  # fmt: skip
def test_seats_and_pockets_leave_no_slivers_at_any_size_of_blocks(name: str, size: float, bond: str, seed: int) -> None:
    keys = {"block_length": size, "course_height": 0.5 * size, "bond": bond, "seed": seed}
    blocks = build("building", **PLANS[name], **keys)
    assert in_one_piece(*assembled(blocks))
    assert least_width(blocks) > LEAST_PART
    taken = [block for block in blocks if block.group in ("vault1", "floor1", "floor2")]
    plain = build("building", **{key: value for key, value in (PLANS[name] | keys).items() if key not in ("floors", "vaults")})
    assert free_volume(plain) - free_volume(taken) < free_volume(blocks) - free_volume(taken) < free_volume(plain)


@pytest.mark.parametrize("seed", [2, 5, 11, 14, 16, 35, 40, 55])
def test_a_plan_by_chance_is_built_exactly_or_refused_by_its_walls(seed: int) -> None:
    keys = random_plans.plan(seed)
    try:
        blocks = build("building", **keys)
    except InputError as refused:
        assert all("wall" in line and "block " not in line for line in str(refused).splitlines())
        return
    assert free_volume(blocks) == pytest.approx(volume_of_plan(prepare(keys)), rel=1e-9)


@pytest.mark.parametrize("seed", [13, 32, 64, 73, 150, 262])
def test_arcs_and_heads_that_just_fit_are_built(seed: int) -> None:
    keys = random_plans.plan(
        seed
    )  # facets of arcs that would be too short for a junction, or bend in it; heads 50 mm from a bend or a junction
    assert free_volume(build("building", **keys)) == pytest.approx(volume_of_plan(prepare(keys)), rel=1e-9)


@pytest.mark.parametrize("tied", [False, True])
def test_a_roof_thrusts_or_is_tied_and_weighs_what_it_says(tied: bool) -> None:
    roofs = [{"walls": ["s", "n"], "rise": 0.8, "mass": 150.0, "tied": tied}]
    made = structures.make({"kind": "building", "walls": ROOM, "roofs": roofs}, 2000.0, Path())
    roof = [block for block in made.blocks if block.group == "roof"]
    assert sum(block.density * block.mass_properties.volume for block in roof) == pytest.approx(150.0 * 2.8 * 3.0)
    assert len(roof) == 4
    assert len(made.ties) == (2 if tied else 0)
    assert can_stand(made.blocks, 0.7)
    assert np.ptp([block.vertices[:, 2].max() for block in roof]) < 1e-12


@pytest.mark.parametrize("tied", [False, True])
def test_a_hipped_roof_bears_on_four_walls_and_weighs_what_it_says(tied: bool) -> None:
    roof = {"walls": ["s", "n", "e", "w"], "rise": 0.8, "mass": 150.0, "tied": tied, "spacing": 1.0}
    made = structures.make({"kind": "building", "walls": ROOM, "roofs": [roof]}, 2000.0, Path())
    rafters = {block.name: block for block in made.blocks if block.group == "roof"}
    total = sum(block.density * block.mass_properties.volume for block in rafters.values())
    assert total == pytest.approx(150.0 * 3.4 * 3.0)  # feet reach to the middle of the walls
    assert built_gap(Assembly.from_blocks(made.blocks, 0.7)) < 1e-9
    assert can_stand(made.blocks, 0.7)
    ends = [(bar.points[k], rafters[bar.blocks[k]].vertices) for bar in made.ties for k in (0, 1)]
    assert all((own.min(axis=0) < point).all() and (point < own.max(axis=0)).all() for point, own in ends) and bool(ends) == tied


@pytest.mark.parametrize("degrees", [3.0, 9.5, 11.0])
def test_walls_out_of_parallel_carry_a_roof_up_to_10_degrees(degrees: float) -> None:
    more = 4.0 * math.tan(math.radians(degrees))
    corners = [(0.0, 0.0), (4.0, -more), (4.0, 3.4), (0.0, 3.4)]
    walls = [
        {"name": name, "axis": [a, b], "thickness": 0.6, "height": 2.4}
        for name, a, b in zip("senw", corners, [*corners[1:], corners[0]], strict=True)
    ]
    keys = {"kind": "building", "walls": walls, "roofs": [{"walls": ["s", "n"], "rise": 0.8, "mass": 150.0, "tied": True, "spacing": 0.8}]}
    if degrees > 10.0:
        with pytest.raises(InputError, match="walls s and n are not parallel"):
            structures.make(keys, 2000.0, Path())
        return
    made = structures.make(keys, 2000.0, Path())
    roof = [block for block in made.blocks if block.group == "roof"]
    assert all(np.abs(block.vertices[:, 2] - 3.2).min() < 1e-9 for block in roof)  # the underside of a level ridge
    assert sum(bool(block.vertices[:, 2].min() == pytest.approx(2.4)) for block in roof) == len(roof) > 6
    total = sum(block.density * block.mass_properties.volume for block in roof)
    over = sum(float(shapely.MultiPoint(block.vertices[:, :2]).convex_hull.area) for block in roof)
    assert total == pytest.approx(150.0 * over)
    assert built_gap(Assembly.from_blocks(made.blocks, 0.7)) < 1e-9


@pytest.mark.parametrize(("roof", "said"), [
    ({"walls": ["s", "n", "e"]}, "roof roof1: give the two walls that carry it, or all four of a hipped one, got 3"),
    ({"walls": ["s", "x"]}, 'roof roof1: there is no wall "x"'),
    ({"walls": ["s", "e"]}, "roof roof1: walls s and e are not parallel"),
    ({"walls": ["s", "n"], "thickness": 0.1}, "roof roof1: its thickness must be at least 0.183 m for a bearing of 0.3 m, got 0.1"),
    ({"walls": ["s", "n"], "bearing": 0.7}, "roof roof1: its bearing must be at most the thickness of its walls, 0.6 m, got 0.7"),
])  # fmt: skip
def test_what_is_wrong_with_a_roof_is_a_line(roof: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        build("building", walls=ROOM, roofs=[{"rise": 0.8, "mass": 150.0} | roof])
