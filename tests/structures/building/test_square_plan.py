# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls along x and y through the engine: steps at junctions, corner stones, leaves."""

from __future__ import annotations

import numpy as np
import pytest
from solids import build, free_volume

from masonry_cd.mechanics.model.blocks import Block
from structures.building import square_plan
from structures.courser import wall_plan

THICK, UNIT, COURSE = 0.5, 0.8, 0.25


def corner(leaves: int = 1, bonded: bool = True) -> list[Block]:
    """Two walls of 2 m height that meet at the origin."""
    along = wall_plan.PlanWall("along", "along", 0, 0.0, 4.0, 0.0, THICK, 0.0, 2.0, leaves=leaves)
    across = wall_plan.PlanWall("across", "across", 1, 0.0, 3.0, 0.0, THICK, 0.0, 2.0, leaves=leaves)
    walls = [along, across]
    sizes = wall_plan.Sizes(COURSE, UNIT)
    return square_plan.build(walls, square_plan.beds_of(walls, sizes), sizes, 2000.0, bonded)


def test_stones_on_a_corner_reach_beyond_the_other_wall_and_take_turns() -> None:
    for block in corner():
        low, high = block.vertices.min(axis=0), block.vertices.max(axis=0)
        if np.abs(low[:2]).max() > 1e-9:
            continue
        axis = ("along", "across").index(block.name.split(".")[0])
        assert high[axis] >= THICK + 0.35 * UNIT - 1e-9
        assert round(low[2] / COURSE) % 2 == axis  # even courses run through along x


def test_leaves_fill_the_corner_and_their_through_stones_have_its_whole_thickness() -> None:
    one, two = corner(), corner(leaves=2)
    assert free_volume(two) == pytest.approx(free_volume(one), rel=1e-12)
    names = [block.name for block in two]
    assert len(set(names)) == len(names)
    depth = {block.name: np.ptp(block.vertices[:, 1]) for block in two if block.name.startswith("along")}
    assert all(size == pytest.approx(0.5 * THICK if name.endswith((".a", ".b")) else THICK) for name, size in depth.items())
    assert {name.split(".")[1] for name in depth if not name.endswith((".a", ".b"))} == {"3", "6"}


def test_a_straight_joint_leaves_the_corner_to_one_wall() -> None:
    on = [block for block in corner(bonded=False) if np.abs(block.vertices[:, :2].min(axis=0)).max() < 1e-9]
    assert {block.name.split(".")[0] for block in on} == {"along"}


@pytest.mark.parametrize("upper", [(1.0, 3.5), (1.5, 3.0)])
def test_a_wall_may_step_where_another_one_meets_it(upper: tuple[float, float]) -> None:
    """Its top steps in the very faces of walls that stand higher than its lower part."""
    a, b = upper
    profile = [[0.0, 1.5], [a, 1.5], [a, 3.0], [b, 3.0], [b, 1.5], [4.5, 1.5]]
    front = {"name": "front", "axis": [[0.0, 0.0], [4.5, 0.0]], "thickness": 0.5, "top": profile}
    sides = [{"name": f"side{k}", "axis": [[x, 0.0], [x, 3.0]], "thickness": 0.5, "height": 2.0} for k, x in enumerate((1.25, 3.25))]
    blocks = build("building", walls=[front, *sides], block_length=0.6, course_height=0.25)
    front_volume = 0.5 * (4.5 * 1.5 + (b - a) * 1.5)
    upper_corners = 0.0 if a == 1.0 else 2 * 0.5 * 0.5 * 0.5  # of the sides, over the lower part of the front
    assert free_volume(blocks) == pytest.approx(front_volume + 2 * 0.5 * 2.0 * 2.75 + upper_corners, rel=1e-9)
