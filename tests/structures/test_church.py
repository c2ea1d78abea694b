# SPDX-License-Identifier: GPL-3.0-or-later
"""Churches: parts that fill what they should, are interlocked, and stand."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from solids import bonded_share, build, free_volume, moved_at_rest, outline, touching_area, volume_of_walls
from statics3d import assembled, can_stand, in_one_piece

from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.geometry import mass_properties
from masonry_cd.mechanics.model.polygon import polygon_area, polygon_centroid
from structures.courser import wall_plan
from structures.kinds import church, church_parts

COARSE: dict[str, object] = {"block_length": 2.0}
SMALL: dict[str, object] = {
    "block_length": 1.6,
    "length": 11.0,
    "width": 5.0,
    "height": 6.5,
    "thickness": 0.8,
    "gable": 1.6,
    "windows": 1,
    "window_width": 0.8,
    "window_height": 1.5,
    "door_width": 1.2,
    "door_height": 2.6,
    "apse_radius": 2.0,
    "apse_height": 3.2,
    "apse_sides": 5,
    "tower_side": 3.2,
    "tower_height": 11.0,
}


def parts_of(**keys: object) -> tuple[church_parts.Church, list[wall_plan.PlanWall], list[float]]:
    """The measures, walls and beds of a church."""
    made = church_parts.Church.of(church.with_defaults(church.ChurchTable.model_validate(keys)))
    walls = church_parts.walls(made)
    return made, walls, church.beds_of(made, walls)


def volume(blocks: list[Block], *groups: str) -> float:
    """Volume of the blocks of some groups [m3]."""
    return sum(mass_properties(b.vertices, b.faces).volume for b in blocks if b.group in groups)


def _ring(sides: int, profile: np.ndarray) -> float:
    """Volume of half a ring over a polygon of twice as many sides [m3]."""
    return 2.0 * sides * math.tan(0.5 * math.pi / sides) * abs(polygon_area(profile)) * float(polygon_centroid(profile)[0])


@pytest.mark.parametrize("keys", [{}, {"aisles": True}, {"bonded": False, "apse": False}, {"roof": "vault", "tower_side": 5.0}])
def test_walls_fill_their_union(keys: dict[str, object]) -> None:
    made, walls, _ = parts_of(**COARSE, **keys)
    blocks = build("church", **COARSE, **keys)
    groups = {wall.group for wall in walls}
    arms = 0.0
    if keys.get("apse", True) and keys.get("bonded", True):  # stones of the apse that reach into the wall
        arms = sum(_inside(block, 24.0) for block in blocks if block.group == "apse")
    simple = [_without_shoulder(wall) for wall in walls]
    exact = volume_of_walls([part for parts in simple for part in parts], made.sizes)
    assert volume(blocks, *groups) + arms == pytest.approx(exact, rel=1e-6)


def _without_shoulder(wall: wall_plan.PlanWall) -> list[wall_plan.PlanWall]:
    """A wall with shoulders as two walls."""
    if not wall.shoulder:
        return [wall]
    z, a, b = wall.shoulder
    low = wall_plan.PlanWall("low", "low", wall.axis, wall.start, wall.end, wall.near, wall.far, wall.foot, z)
    high = wall_plan.PlanWall("high", "high", wall.axis, a, b, wall.near, wall.far, z, wall.top, (), wall.gable)
    holes = wall_plan.PlanWall("whole", "whole", wall.axis, a, b, wall.near, wall.far, wall.foot, wall.top, wall.openings, wall.gable)
    return [low, high, holes]


def _inside(block: Block, face: float) -> float:
    """Volume of the parts of a block that lie before a plane x [m3]."""
    return sum(mass_properties(p.vertices, p.faces).volume for p in block.parts if p.vertices[:, 0].max() < face + 1e-6)


def test_apse_and_half_dome_fill_half_rings() -> None:
    made, _, beds = parts_of(**SMALL)
    blocks = build("church", **SMALL)
    sides, r, t = 5, 2.0, 0.6
    slope = math.tan(0.1 * math.pi)
    wall = _ring(sides, np.array([[r, 0.0], [r + t, 0.0], [r + t, made.apse_top], [r, made.apse_top]]))
    rows = [z for z in beds if z < made.apse_top + 1e-9]
    window = [b - a for a, b in itertools.pairwise(rows) if 0.45 * made.apse_top <= a and b <= 0.75 * made.apse_top]
    assert window
    wall -= 2 * 2.0 * 0.35 * r * slope * t * sum(window)
    face = 11.0
    whole = volume(blocks, "apse") - sum(_inside(b, face) for b in blocks if b.group == "apse")
    assert whole == pytest.approx(wall, rel=1e-9)
    assembly, joints = assembled(blocks)
    dome = {i for i, b in enumerate(blocks) if b.group == "half_dome"}
    on_wall = {i for i, b in enumerate(blocks) if b.group in ("apse", "triumphal_arch")}
    pairs = list(zip(joints.block_a, joints.block_b, strict=True))
    assert any((a in dome and b in on_wall) or (b in dome and a in on_wall) for a, b in pairs)
    assert in_one_piece(assembly, joints)


def test_corners_junctions_and_apse_are_interlocked() -> None:
    bonded, straight = build("church", **COARSE), build("church", bonded=False, **COARSE)
    place = {"axis": 0, "at": 1.0, "near": 4.5, "far": 5.5}  # the corner of facade and north wall, seen from the north
    assert bonded_share(bonded, **place) > 0.4  # type: ignore[arg-type]
    reach = [b for b in bonded if b.group == "apse" and b.vertices[:, 0].min() < 23.5]
    assert len(reach) == 6  # both ends of three courses
    assert not [b for b in straight if b.group == "apse" and b.vertices[:, 0].min() < 23.5]
    tower = [b for b in bonded if b.group == "tower" and b.vertices[:, 1].min() < 4.6 and b.vertices[:, 1].max() > 5.6]
    assert len([b for b in tower if b.vertices[:, 2].max() < 10.0]) >= 8  # stones through the nave wall
    assert not [b for b in straight if b.group == "tower" and b.vertices[:, 2].max() < 10.0 and b.vertices[:, 1].min() < 5.4]


@pytest.mark.parametrize("keys", [{}, {"roof": "vault", "thickness": 1.2, "tower": False}])
def test_it_stands(keys: dict[str, object]) -> None:
    blocks = build("church", **(SMALL | {"tower_height": 11.0} | keys))
    assert can_stand(blocks, mu=0.6)
    assert moved_at_rest(blocks, seconds=0.04) < 1e-4


def test_every_joint_is_found() -> None:
    blocks = build("church", **SMALL)
    joints = find_joints(Assembly.from_blocks(blocks, 0.6))
    assert joints.area.sum() == pytest.approx(touching_area(blocks), rel=1e-6)


def test_macro_elements_are_groups() -> None:
    groups = {b.group for b in build("church", aisles=True, buttresses=3, **COARSE)}
    walls = {"facade", "nave_walls", "triumphal_arch", "aisle_walls", "buttresses", "tower"}
    assert groups == walls | {"apse", "half_dome", "arcades", "roof", "base"}
    assert "vault" in {b.group for b in build("church", roof="vault", tower_side=5.0, **COARSE)}


def test_plates_weigh_as_much_as_the_roof() -> None:
    plates = [b for b in build("church", tower=False, **COARSE) if b.group == "roof"]
    mass = sum(mass_properties(b.vertices, b.faces).volume * b.density for b in plates)
    assert mass == pytest.approx(150.0 * (9.0 + 2.0) * (24.0 - 2.0 - 0.1), rel=1e-9)


def test_block_length_steers_the_number_of_blocks() -> None:
    counts = [len(build("church", block_length=length)) for length in (2.5, 1.0, 0.6)]
    assert 400 < counts[0] < 700
    assert 1800 < counts[1] < 2600
    assert 4200 < counts[2] < 6000


@pytest.mark.validation
def test_twenty_thousand_blocks() -> None:
    blocks = build("church", block_length=0.3)
    assert 17_000 < len(blocks) < 24_000
    assert in_one_piece(*assembled(blocks))


@pytest.mark.parametrize("length", [1.1, 1.4, 1.8])
def test_any_block_length_makes_a_sound_church(length: float) -> None:
    for keys in ({"aisles": True}, {"leaves": 2, "tower_side": 5.0}):
        blocks = build("church", block_length=length, **keys)
        assembly, joints = assembled(blocks)
        assert in_one_piece(assembly, joints), keys
        assert assembly.shapes.size.min() > 0.05, keys


def test_outline_of_a_gable_has_five_corners() -> None:
    _, walls, _ = parts_of(**COARSE)
    assert len(outline(next(wall for wall in walls if wall.group == "facade"))) == 5
    assert free_volume(build("church", **COARSE)) > 900.0
