# SPDX-License-Identifier: GPL-3.0-or-later
"""Heads of openings: one shape for walls with keys of their own and for those of plans, all joints found, no stone that bridges an arch."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from plans import wall
from solids import build, touching_area
from statics3d import assembled, can_stand

OPENINGS: dict[str, dict[str, Any]] = {
    "rectangular": {"sill": 0.5, "height": 1.3},
    "round": {"sill": 0.0, "height": 1.75, "shape": "round"},
    "segmental": {"sill": 0.55, "height": 1.3, "shape": "segmental"},
    "pointed": {"sill": 0.0, "height": 1.9, "shape": "pointed"},
    "rose": {"sill": 0.7, "shape": "rose"},
    "niche": {"sill": 0.6, "height": 1.0, "shape": "niche", "rise": 0.3},
}
LENGTH, UNIT, COURSE = 4.0, 0.6, 0.3


@pytest.mark.parametrize("shape", OPENINGS)
def test_joints_around_a_head_are_all_found(shape: str) -> None:
    opening = {"at": 1.93, "width": 1.0} | OPENINGS[shape]
    blocks = build("building", walls=[wall("a", [[0, 0], [LENGTH, 0]], 0.5, 2.7, openings=[opening])], block_length=UNIT)
    _, joints = assembled(blocks)
    assert joints.area.sum() == pytest.approx(touching_area(blocks), rel=1e-9)
    assert can_stand(blocks, 0.7)


@pytest.mark.parametrize(
    ("head", "shape"), [("lintel", "rectangular"), ("flat", "rectangular"), ("segmental", "segmental"), ("round", "round")]
)
def test_a_wall_with_keys_of_its_own_has_the_stones_of_a_plan(head: str, shape: str) -> None:
    opening = {"width": 1.0, "sill": 0.5, "height": 1.4}
    kind = build("wall", length=LENGTH, height=2.7, thickness=0.5, course_height=COURSE, openings=[opening | {"centre": 0.1, "head": head}])
    own = opening | {"at": 0.5 * LENGTH + 0.1, "shape": shape} | ({"ring": COURSE} if head == "flat" else {})
    axis = [[-0.5 * LENGTH, 0.0], [0.5 * LENGTH, 0.0]]
    plan = build("building", walls=[wall("wall", axis, 0.5, 2.7, openings=[own])], block_length=2.0 * COURSE, course_height=COURSE)
    corners = [sorted(map(tuple, np.concatenate([b.vertices for b in blocks if not b.fixed]).round(9))) for blocks in (kind, plan)]
    assert np.allclose(*corners, atol=1e-8)
    assert [b.name for b in kind if not b.fixed] == [b.name for b in plan if not b.fixed]


@pytest.mark.parametrize("height", [1.6, 1.7, 1.8, 1.9])
def test_no_stone_bridges_an_arch(height: float) -> None:
    """Wherever its crown lies between two beds: one long stone over it would carry what the arch should."""
    opening = {"at": 2.0, "width": 1.6, "height": height, "shape": "round"}
    blocks = build("building", walls=[wall("a", [[0, 0], [LENGTH, 0]], 0.5, 2.7, openings=[opening])], block_length=UNIT)
    assert max(np.ptp(block.vertices[:, 0]) for block in blocks if not block.fixed) < 1.7 * UNIT
