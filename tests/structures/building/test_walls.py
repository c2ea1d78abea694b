# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls of a plan: every corner filled, joints exact, interlocked, standing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from plans import free_volume, prepare, volume_of_plan, wall
from solids import build
from statics3d import assembled, can_stand, in_one_piece

CLOSED = [[0, 0], [4, 0], [4.6, 3.2], [0, 3.5], [0, 0]]
CASES: dict[str, dict[str, Any]] = {
    "square of four walls": {
        "walls": [
            wall("s", [[0, 0], [4, 0]]),
            wall("e", [[4, 0], [4, 3]], 0.5),
            wall("n", [[4, 3], [0, 3]], height=2.1),
            wall("w", [[0, 3], [0, 0]]),
        ]
    },
    "one wall out of square": {"walls": [wall("ring", CLOSED)]},
    "T at an angle": {"walls": [wall("a", [[0, 0], [5, 0]]), wall("b", [[2.5, 0], [4, 2.5]], 0.4, 1.8)]},
    "X at an angle": {"walls": [wall("a", [[0, 0], [5, 0]]), wall("b", [[1.5, -2], [3.5, 2]], 0.4, 3.0)]},
    "three walls in one place": {
        "walls": [wall("a", [[0, 0], [2.5, 0]]), wall("c", [[2.5, 0], [5, 0]], 0.5), wall("b", [[2.5, 0], [3, 2.5]], 0.5, 1.8)]
    },
    "butt and a share": {
        "walls": [wall("a", [[0, 0], [5, 0]]), wall("b", [[0, 0], [0.8, 2.5]]), wall("c", [[5, 0], [5, 2.5]])],
        "junctions": [{"walls": ["b", "a"], "bond": "butt"}, {"walls": ["a", "c"], "bond": 0.5}],
    },
    "gable between side walls": {
        "walls": [
            wall("facade", [[0, 0], [5, 0]], top=[[0, 2], [2.5, 3.2], [5, 2]], openings=[{"at": 2.5, "width": 0.9, "height": 1.6}]),
            wall("south", [[0, 0], [0, 2]], height=2.0),
            wall("north", [[5, 0], [5, 2]], height=2.0),
        ]
    },
    "stepped and sloping top": {
        "walls": [
            wall("a", [[0, 0], [2, 0], [4, 0.4]], top=[[0, 1.5], [1.4, 1.5], [1.4, 2.1], [3.2, 2.6], [4, 2.6]]),
            wall("b", [[0, 0], [0, 2]]),
        ]
    },
    "arc on a wall": {
        "walls": [
            wall("east", [[-3.2, 0], [3.2, 0]], 0.6),
            wall("apse", [[-2, 0], {"to": [2, 0], "through": [0, 2]}], 0.5, 2.1,
                 openings=[{"at": 3.14159, "width": 0.5, "sill": 0.6, "height": 0.9, "shape": "round"}]),
        ]
    },
    "round tower": {"walls": [wall("tower", [[2, 0], {"to": [2, 0], "through": [-2, 0]}], 0.6, 2.4)]},
    "tower on a corner": {
        "walls": [wall("s", [[0, 0], [4, 0]], height=4.2), wall("w", [[0, 0], [0, 2.5]], height=4.2), wall("e", [[4, 0], [4, 2.5]]),
                  wall("in", [[0, 2.5], [2.2, 2.5]], height=4.2), wall("mid", [[2.2, 2.5], [2.2, 0]], height=4.2)]
    },
    "heights between beds, irregular": {
        "bond": "irregular",
        "walls": [wall("a", [[0, 0], [4, 0]], height=2.45), wall("b", [[4, 0], [4, 2]], height=2.37)],
    },
    "rubble": {"bond": "rubble", "seed": 3, "walls": [wall("a", [[0, 0], [4, 0]]), wall("b", [[4, 0], [5, 2]])]},
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_the_blocks_fill_the_walls_of_the_plan_and_hang_together(case: str) -> None:
    keys = CASES[case]
    blocks = build("building", **keys)  # checked: closed, convex or of convex parts, apart
    assert free_volume(blocks) == pytest.approx(volume_of_plan(prepare(keys)), rel=1e-9)
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)


def test_a_room_with_every_shape_of_opening_stands() -> None:
    openings = [
        {"at": 1.4, "width": 0.8, "height": 1.5},
        {"at": 3.2, "width": 0.9, "sill": 0.62, "height": 1.1, "shape": "round"},
        {"at": 4.9, "width": 0.7, "sill": 0.5, "height": 1.2, "shape": "pointed"},
        {"at": 6.6, "width": 0.9, "height": 1.3, "ring": 0.3},
    ]
    more = [
        {"at": 1.2, "width": 0.8, "sill": 0.9, "shape": "rose"},
        {"at": 3.0, "width": 0.6, "sill": 0.4, "height": 1.0, "shape": "niche", "rise": 0.2},
        {"at": 4.4, "width": 0.8, "height": 1.4, "shape": "segmental", "rise": 0.2},
    ]
    walls = [
        wall("front", [[0, 0], [8, 0]], openings=openings),
        wall("side", [[8, 0], [8.5, 5.6]], openings=more),
        wall("back", [[8.5, 5.6], [0, 5]]),
        wall("west", [[0, 5], [0, 0]]),
    ]
    blocks = build("building", walls=walls, block_length=0.7)
    assert free_volume(blocks) == pytest.approx(volume_of_plan(prepare({"walls": walls, "block_length": 0.7})), rel=1e-9)
    assert can_stand(blocks, 0.6)


def test_a_lintel_that_rounding_parts_from_its_bed_leaves_no_hair_over_it() -> None:
    """Its top lies at 0.9 + 1.4 + 0.675 m, a bit below or above a bed at 2.975 m; the stones next to it stay two."""
    openings = [{"at": at, "width": 1.0, "sill": 0.9, "height": 1.4} for at in (3.0, 6.4)]
    keys = {"walls": [wall("a", [[0, 0], [9.4, 0]], 0.5, 6.2, openings=openings)], "block_length": 1.35, "course_height": 0.675}
    blocks = build("building", **keys)
    assert free_volume(blocks) == pytest.approx(volume_of_plan(prepare(keys)), rel=1e-9)


def test_bonded_courses_take_turns_and_butt_joints_do_not() -> None:
    """At a corner each wall owns half of the stones on the outer edge; with butt the first one owns all."""
    walls = [wall("a", [[0, 0], [4, 0]]), wall("b", [[0, 0], [0, 3]])]
    for bond, expected in (("bonded", [4, 4]), ("butt", [8, 0]), (0.5, [6, 2])):
        blocks = build("building", walls=walls, junction=bond)
        corner = [block for block in blocks if not block.fixed and np.hypot(*(block.vertices[:, :2] - [-0.3, -0.3]).T).min() < 1e-9]
        assert [sum(block.group == name for block in corner) for name in ("a", "b")] == expected


def test_equal_seeds_give_equal_blocks_and_corners_agree_to_the_bit() -> None:
    keys = {"walls": [wall("a", [[0, 0], [4, 0.7]]), wall("b", [[4, 0.7], [5, 3]])], "bond": "irregular", "seed": 5}
    one, two = build("building", **keys), build("building", **keys)
    assert all((a.vertices == b.vertices).all() for a, b in zip(one, two, strict=True))
    other = build("building", **keys | {"seed": 6})
    assert {block.vertices.tobytes() for block in other} != {block.vertices.tobytes() for block in one}
    points = np.unique(np.concatenate([block.vertices for block in one if not block.fixed]), axis=0)
    apart = np.sort(np.linalg.norm(points[:, None] - points[None], axis=2), axis=1)[:, 1]
    assert apart.min() > 1e-6


@pytest.mark.parametrize("thickness", [0.4, 0.6, 0.9])
def test_corner_stones_of_bonded_walls_reach_beyond_the_other_wall(thickness: float) -> None:
    """Or else an upright joint would run along its face from bottom to top."""
    axes = {"along": [[0.0, 0.0], [4.0, 0.0]], "across": [[0.0, 0.0], [0.0, 4.0]]}
    blocks = build("building", walls=[wall(name, axis, thickness) for name, axis in axes.items()], block_length=0.6, course_height=0.3)
    reached = dict.fromkeys(axes, 0)
    for block in blocks:
        low, high = block.vertices.min(axis=0), block.vertices.max(axis=0)
        name = block.name.split(".")[0]
        if name in axes and np.abs(low[:2] + 0.5 * thickness).max() < 1e-9:
            assert high[list(axes).index(name)] >= 0.5 * thickness + 0.35 * 0.6 - 1e-9
            reached[name] += 1
    assert reached == {"along": 4, "across": 4}


def test_a_gable_goes_on_falling_to_the_far_faces_of_the_walls_at_its_ends_and_a_shed_ends_level() -> None:
    gable = wall("gable", [[0, 0], [4, 0]], top=[[0, 2.4], [2, 3.4], [4, 2.4]])
    legs = prepare({"walls": [gable, wall("b", [[0, 0], [0, 3]], 0.5, 2.0)]}).plan.legs
    assert legs[0].top(legs[0].facets[0], -0.25) == pytest.approx(2.4 - 0.25 * 0.5)
    shed = prepare({"walls": [wall("shed", [[0, 0], [4, 0]], top=[[0, 2.4], [4, 3.4]])]}).plan.legs[0]
    assert shed.top(shed.facets[0], -0.2) == pytest.approx(2.35)
    assert shed.top(shed.facets[0], 4.2) == 3.4
