# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls: coursed blocks that fill the wall around its openings, bonded, standing."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from solids import build, exposed, free_volume, holes_of, moved_at_rest, volume_of_walls
from statics3d import assembled, can_stand, in_one_piece

from masonry_cd.mechanics.model.polygon import polygon_area
from structures.courser import wall_plan
from structures.kinds import wall

OPENINGS = [
    {"centre": 0.0, "width": 1.4, "height": 2.6, "head": "round"},
    {"centre": -2.7, "width": 0.9, "sill": 1.0, "height": 1.4, "head": "segmental"},
    {"centre": 2.7, "width": 0.9, "sill": 1.0, "height": 1.4, "head": "flat"},
    {"centre": 0.0, "width": 0.8, "sill": 3.5, "height": 1.0},
    {"centre": 2.7, "width": 0.7, "sill": 3.3, "height": 0.9, "head": "round"},
]
CASES: dict[str, dict[str, object]] = {
    "default": {},
    "all heads and a gable": {"length": 9.0, "height": 5.0, "thickness": 0.5, "gable": 2.0, "openings": OPENINGS, "course_height": 0.3},
    "two leaves": {"thickness": 0.6, "leaves": 2, "openings": [{"centre": 0.3, "width": 0.9, "height": 1.8}]},
    "long low blocks": {
        "unit_length": 1.1,
        "course_height": 0.2,
        "openings": [{"centre": 0.0, "width": 1.2, "height": 1.9, "head": "segmental"}],
    },
}


def drawn(keys: dict[str, object]) -> tuple[wall_plan.PlanWall, wall_plan.Sizes]:
    table = wall.WallTable.model_validate(keys)
    return wall.elevation(table), wall_plan.Sizes(table.course_height, table.unit_length or 2.0 * table.course_height)


@pytest.mark.parametrize("case", CASES)
def test_blocks_fill_the_wall_and_every_inner_face_is_a_joint(case: str) -> None:
    keys = CASES[case]
    made, sizes = drawn(keys)
    blocks = build("wall", **keys)
    assert free_volume(blocks) == pytest.approx(volume_of_walls([made], sizes), rel=1e-6)
    assembly, joints = assembled(blocks)
    assert in_one_piece(assembly, joints)
    thickness, length = made.far - made.near, made.end - made.start
    rim = 2.0 * made.top + (2.0 * np.hypot(0.5 * length, made.gable) if made.gable else length) + length  # with the foot
    sides = 2.0 * length * (made.top + 0.5 * made.gable)
    for polygon in holes_of(made, sizes):
        edges = np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1)
        at_foot = np.ptp(polygon[:, 0]) if polygon[:, 1].min() == 0 else 0.0
        rim += edges.sum() - 2.0 * at_foot
        sides -= 2.0 * abs(polygon_area(polygon))
    foot = joints.area[assembly.fixed[joints.block_a] | assembly.fixed[joints.block_b]].sum()
    assert exposed(blocks, assembly, joints) == pytest.approx(sides + thickness * rim - foot, rel=1e-6)


@pytest.mark.parametrize("case", ["default", "two leaves"])
def test_it_stands(case: str) -> None:
    blocks = build("wall", **CASES[case])
    assert can_stand(blocks, mu=0.6)
    assert moved_at_rest(blocks) < 1e-4


def test_openings_of_all_heads_stand_and_a_wall_without_friction_in_its_flat_arch_does_not() -> None:
    flat = {"length": 3.0, "height": 2.2, "openings": [{"centre": 0.0, "width": 1.2, "sill": 0.5, "height": 1.0, "head": "flat"}]}
    assert can_stand(build("wall", **flat), mu=0.6)
    assert not can_stand(build("wall", **flat), mu=0.05)
    assert can_stand(build("wall", **CASES["all heads and a gable"]), mu=0.6)


def test_head_joints_of_successive_courses_keep_apart() -> None:
    blocks = [b for b in build("wall", **CASES["all heads and a gable"]) if not b.fixed]
    uprights: dict[float, list[tuple[float, float]]] = {}
    for block in blocks:
        low, high = block.vertices.min(axis=0), block.vertices.max(axis=0)
        uprights.setdefault(round(float(low[2]), 6), []).append((low[0], high[2]))
    beds = sorted(uprights)
    near = 0
    for below, above in pairwise(beds):
        xs = [x for x, top in uprights[below] if abs(top - above) < 1e-6]
        near += sum(0 < abs(x - other) < 0.05 for x in xs for other, _ in uprights[above])
    assert near <= 0.02 * len(blocks)


def test_through_stones_tie_the_leaves() -> None:
    tied = build("wall", leaves=2, thickness=0.6)
    widths = [np.ptp(b.vertices[:, 1]) for b in tied if not b.fixed]
    assert any(w == pytest.approx(0.6) for w in widths)
    assert any(w == pytest.approx(0.3) for w in widths)


def test_same_table_gives_the_same_bits() -> None:
    for one, other in zip(build("wall", **CASES["two leaves"]), build("wall", **CASES["two leaves"]), strict=True):
        assert one.name == other.name
        assert one.vertices.tobytes() == other.vertices.tobytes()
