# SPDX-License-Identifier: GPL-3.0-or-later
"""Towers: a hollow square or rectangle of coursed walls, interlocked at the corners, with a belfry and an inclination.

Four walls in plan (:mod:`structures.courser.wall_plan`) share their beds. The belfry is an arched opening in every wall below the top, the
door one in the wall towards -y. An inclined tower is turned about y, towards +x, with its base: it has settled as it stands.
Stairs and floors are left out.

The default is a tower of 5 m by 5 m by 20 m with walls of 0.8 m, a small Italian campanile. Groups: ``south`` (towards -y),
``east`` (+x), ``north``, ``west``, and ``base``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.courser import wall_plan
from structures.courser.wall_plan import Opening, opening_of
from structures.geometry.compound_block import moved
from structures.kind import Keys, StructureKind, fewer_through_stones, scaled, straight_joints
from structures.layout.ground import ground
from structures.macro_elements import EAST, NORTH, SOUTH, WEST, BlockLayout, MacroElement, rests, walls
from structures.schema import Height, Length, OpeningTable, Table, Thickness, WallHeight


class TowerTable(Table):
    """The [structure] table of a tower."""

    side: Length = 5.0
    """outer, along x"""
    side_y: Length | None = None
    """outer side along y; by default the same"""
    height: WallHeight = Field(20.0)
    thickness: Thickness = 0.8
    """of the walls"""
    course_height: WallHeight = 0.5
    """aimed at"""
    unit_length: Length | None = None
    """of a block; by default two courses"""
    leaves: int = Field(1, ge=1, le=4)
    """layers of stones through the thickness"""
    through: int = Field(3, ge=1, le=100)
    """through-stones: with n, every n-th stone of every n-th course"""
    belfry_width: Height = 1.4
    """width of the openings of the belfry; 0 for none"""
    belfry_height: WallHeight = 2.6
    """of the openings"""
    belfry_sill: Length | None = None
    """by default two courses of masonry remain above the arches"""
    door_width: Height = 1.0
    """0 for none"""
    door_height: WallHeight = Field(2.0)
    inclination: Annotated[float, Unit("degrees")] = Field(0.0, ge=-15.0, le=15.0)
    """towards +x"""
    bonded: bool = True
    """false: straight joints at the corners from bottom to top"""
    base_depth: Length | None = None
    """of the base; by default a course"""


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build a tower on its base.

    Raises:
        InputError: a key that is unknown or out of range, or measures that do not fit together.
    """
    from structures.building import square_plan

    keys = parse_table(TowerTable, table, "structure")
    unit = keys.unit_length or 2.0 * keys.course_height
    around = 2.0 * (keys.side + (keys.side_y or keys.side))
    size.check_size(around / unit * (keys.height / keys.course_height) * keys.leaves, "course_height")
    walls, sizes = elevations(keys), wall_plan.Sizes(keys.course_height, unit)
    blocks = square_plan.build(walls, square_plan.beds_of(walls, sizes), sizes, density, keys.bonded)
    blocks.append(ground(blocks, keys.base_depth or keys.course_height, density))
    if keys.inclination:
        blocks = inclined(blocks, math.radians(keys.inclination))
    return blocks


def elevations(keys: TowerTable) -> list[wall_plan.PlanWall]:
    """The four walls of a table, checked.

    Raises:
        InputError: measures that do not fit together.
    """
    across = keys.side_y or keys.side
    room = min(keys.side, across)
    if 2.0 * keys.thickness >= room:
        raise InputError("structure.thickness", f"must be below half the side, {0.5 * room:g} m, got {keys.thickness:g}")
    if keys.course_height > keys.height:
        raise InputError("structure.course_height", f"must be at most the height, {keys.height:g} m, got {keys.course_height:g}")
    belfry = belfry_opening(keys)
    door: tuple[Opening, ...] = ()
    if keys.door_width:
        made = OpeningTable.model_validate({"centre": 0.0, "width": keys.door_width, "height": keys.door_height, "head": "round"})
        door = (opening_of(made, "structure.door_width and door_height", keys.course_height),)
    return hollow(keys, across, belfry, door)


def belfry_opening(keys: TowerTable) -> tuple[Opening, ...]:
    """The opening of the belfry, centred on 0."""
    if not keys.belfry_width:
        return ()
    made = OpeningTable.model_validate({"centre": 0.0, "width": keys.belfry_width, "height": keys.belfry_height, "head": "round"})
    opening = opening_of(made, "structure.belfry_width and belfry_height", keys.course_height)
    course = keys.course_height
    sill = keys.belfry_sill or course * math.floor((keys.height - opening.height - opening.depth) / course - 2.0 + 1e-9)
    most = keys.height - opening.height - opening.depth - course
    if most <= 0:
        least = keys.height - most
        raise InputError(
            "structure.height",
            f"must exceed {least:.4g} m for the belfry, whose arches need a course above them, got {keys.height:g}; "
            "belfry_width = 0 leaves it out",
        )
    if not 0 < sill <= most:
        raise InputError("structure.belfry_sill", f"must be above 0 and at most {most:.4g} m, got {sill:g}")
    return (replace(opening, sill=sill),)


def hollow(keys: TowerTable, across: float, belfry: Sequence[Opening], door: Sequence[Opening]) -> list[wall_plan.PlanWall]:
    """Four walls around the origin."""
    a, b, t = 0.5 * keys.side, 0.5 * across, keys.thickness
    top = keys.height
    opening = tuple(belfry)

    def wall(name: str, axis: int, half: float, near: float, openings: tuple[Opening, ...]) -> wall_plan.PlanWall:
        return wall_plan.PlanWall(
            name, name, axis, -half, half, near, near + t, 0.0, top, openings, leaves=keys.leaves, through=keys.through
        )

    return [
        wall("south", 0, a, -b, (*door, *opening)),
        wall("north", 0, a, b - t, opening),
        wall("west", 1, b, -a, opening),
        wall("east", 1, b, a - t, opening),
    ]


def inclined(blocks: Sequence[Block], angle: float) -> list[Block]:
    """The blocks turned about the y axis, towards +x [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return [moved(block, lambda points: np.einsum("vj,ij->vi", points, turn)) for block in blocks]


def bonds(table: Keys) -> dict[str, Keys]:
    """Straight joints at the corners, fewer stones through the leaves."""
    return straight_joints(table) | fewer_through_stones(table)


def parts(layout: BlockLayout) -> list[MacroElement]:
    """A tower: as a whole, its walls, belfry and corners."""
    own = np.flatnonzero(~layout.fixed & ~np.array([rests(str(group)) for group in layout.group]))
    found = [walls.ring(layout, own, "tower", "tower")]
    sides = {"south": SOUTH, "north": NORTH, "west": WEST, "east": EAST}
    for name, way in sides.items():
        wall = layout.of_walls(name)
        if len(wall):
            found += walls.out_of_plane(layout, f"{name} wall", wall, (way,), layout.top(wall), "wall")
            found += walls.in_plane(layout, name, f"{name} wall")
    middle = layout.foot(own) + 0.5 * (layout.top(own) - layout.foot(own))
    high = [hole.sill for name in sides for hole in layout.holes(name) if hole.sill > middle]
    if high:
        found.append(walls.ring(layout, own, "belfry", "belfry", max(high)))
    return found + walls.corners(layout, own)


KIND = StructureKind(
    build, TowerTable, first={"side": 5.0, "height": 20.0, "thickness": 0.8, "course_height": 1.0}, masonry="squared stone",
    resized=partial(scaled, TowerTable, lengths=("course_height", "unit_length")), bonds=bonds, parts=parts,
)  # fmt: skip
