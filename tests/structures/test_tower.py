# SPDX-License-Identifier: GPL-3.0-or-later
"""Towers: interlocked corners, belfry, inclination."""

from __future__ import annotations

import math

import numpy as np
import pytest
from solids import bonded_share, build, exposed, free_volume, moved_at_rest, volume_of_walls
from statics3d import assembled, can_stand, in_one_piece

from structures.courser import wall_plan
from structures.kinds import tower

SMALL: dict[str, object] = {"side": 3.0, "height": 8.0, "thickness": 0.6, "belfry_width": 0.7, "belfry_height": 1.5, "door_width": 0.8}


@pytest.mark.parametrize("keys", [{}, SMALL, {"side": 4.0, "side_y": 5.5, "height": 12.0, "leaves": 2, "belfry_width": 1.0}])
def test_blocks_fill_the_walls(keys: dict[str, object]) -> None:
    table = tower.TowerTable.model_validate(keys)
    walls, sizes = tower.elevations(table), wall_plan.Sizes(table.course_height, 2.0 * table.course_height)
    blocks = build("tower", **keys)
    assert free_volume(blocks) == pytest.approx(volume_of_walls(walls, sizes), rel=1e-6)
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)


def test_every_inner_face_of_a_plain_shaft_is_a_joint() -> None:
    blocks = build("tower", side=3.0, height=6.0, thickness=0.7, belfry_width=0.0, door_width=0.0)
    assembly, joints = assembled(blocks)
    plan_area = 3.0**2 - 1.6**2
    assert exposed(blocks, assembly, joints) == pytest.approx(4 * (3.0 + 1.6) * 6.0 + plan_area, rel=1e-9)  # the foot is a joint


def test_corners_are_interlocked_unless_straight_joints_are_asked_for() -> None:
    bonded, straight = build("tower", **SMALL), build("tower", bonded=False, **SMALL)
    at = -1.5 + 0.6
    share = bonded_share(bonded, 0, at, -1.5, -0.9), bonded_share(bonded, 1, at, -1.5, -0.9)
    assert sum(share) == pytest.approx(1.0)  # courses take turns
    assert min(share) > 0.4
    assert bonded_share(straight, 0, at, -1.5, -0.9) + bonded_share(straight, 1, at, -1.5, -0.9) == pytest.approx(1.0)
    assert min(bonded_share(straight, 0, at, -1.5, -0.9), bonded_share(straight, 1, at, -1.5, -0.9)) == 0.0


def test_it_stands_and_a_tower_that_leans_too_far_falls() -> None:
    blocks = build("tower", **SMALL)
    assert can_stand(blocks, mu=0.6)
    assert moved_at_rest(blocks) < 1e-4
    assert can_stand(build("tower", inclination=5.0, **SMALL), mu=0.6)
    slender = {**SMALL, "height": 16.0, "course_height": 1.0, "belfry_width": 0.0, "door_width": 0.0}
    assert not can_stand(build("tower", inclination=15.0, **slender), mu=0.6)  # 8 sin 15 > 1.5 cos 15


def test_inclination_is_a_rotation_with_the_base() -> None:
    upright, leaning = build("tower", **SMALL), build("tower", inclination=10.0, **SMALL)
    a = math.radians(10.0)
    for one, other in zip(upright, leaning, strict=True):
        assert np.allclose(other.vertices[:, 0], one.vertices[:, 0] * math.cos(a) + one.vertices[:, 2] * math.sin(a))
    assert free_volume(leaning) == pytest.approx(free_volume(upright))
