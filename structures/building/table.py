# SPDX-License-Identifier: GPL-3.0-or-later
"""The [structure] table of a building: a plan of walls, and what stands on and in them.

Lengths in [m], z up. A wall is given by the middle line of its plan; what is said for the whole building (courses, blocks, bond, junctions)
may be said again for a wall or a junction.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from masonry_cd.foundation.units import Unit
from structures.plans.keys import PlanKeys
from structures.schema import ArealMass, Density, Height, Length, Place, Table

FARTHEST = 1e5  # of a point of a plan from its origin [m]
Coordinate = Annotated[Place, Field(ge=-FARTHEST, le=FARTHEST)]
Point = Annotated[tuple[Coordinate, Coordinate], Field(strict=False)]
Points = Annotated[tuple[Point, ...], Field(strict=False, min_length=1)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Bond = Literal["regular", "irregular", "rubble"]
JunctionBond = Literal["bonded", "butt"] | Fraction
OpeningShape = Literal["rectangular", "round", "segmental", "pointed", "rose", "niche"]
Name = Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[^.\s*]+$")]
Angle = Annotated[float, Unit("degrees"), Field(allow_inf_nan=False)]


class ArcTable(Table):
    """A curved piece of an axis: an arc of a circle from the point before it."""

    to: Point = Field(description="where it ends")
    through: Point = Field(description="a point that it passes")


class WallOpeningTable(Table):
    """One entry ``[[structure.walls.openings]]``."""

    name: Name | None = Field(None, description="for reports; by default o1, o2 ...")
    shape: OpeningShape = Field("rectangular", description="of its head; a rose is a whole circle, a niche does not go through")
    at: Place = Field(description="distance of its middle from the start of the axis, along it")
    width: Length = Field(description="clear; of a rose its diameter")
    sill: Height = Field(0.0, description="above the base of the wall")
    height: Length | None = Field(
        None, description="clear, from the sill to the highest point; by default that of a rose, 2 widths of others"
    )
    rise: Length | None = Field(
        None,
        description="of a segmental head, by default a sixth of the width; of a pointed one, by default that of equal sides; of a niche",
    )
    ring: Length | None = Field(None, description="thickness of its voussoirs; a rectangular one with a ring has a flat arch")
    lintel: Length | None = Field(None, description="height of the lintel of a rectangular one; by default a course")
    bearing: Length | None = Field(None, description="of the lintel on each jamb; by default a third of a block")
    depth: Length | None = Field(None, description="of a niche; by default a third of the wall")
    side: Literal["left", "right"] = Field("right", description="face that a niche is in, seen along the axis")


class BuildingWallTable(Table):
    """One entry ``[[structure.walls]]``."""

    name: Name = Field(description="of its blocks")
    axis: tuple[Point | ArcTable, ...] = Field(
        strict=False, min_length=2, description="points of the middle line; a piece may be an arc { to = [x, y], through = [x, y] }"
    )
    thickness: Length = Field(description="of the wall")
    base: Coordinate = Field(0.0, description="z of its foot")
    height: Length | None = Field(None, description="from the base to a level top")
    top: tuple[Point, ...] | None = Field(
        None, strict=False, min_length=2, description="or profile of the top, [s, z] each: distance along the axis and height over the base"
    )
    course_height: Length | None = Field(None, description="by default that of the building; walls bonded with each other share it")
    block_length: Length | None = Field(None, description="by default that of the building")
    masonry: str | None = Field(None, description="kind of masonry that sets its density")
    density: Density | None = Field(None, description="by default that of the material")
    group: Name | None = Field(None, description="of its blocks; by default its name")
    bond: Bond | None = Field(None, description="by default that of the building")
    openings: tuple[WallOpeningTable, ...] = Field((), strict=False, description="doors, windows and niches")


class JunctionTable(Table):
    """One entry ``[[structure.junctions]]``."""

    walls: tuple[str, str] = Field(strict=False, description="the two that meet; with butt the first one runs through")
    bond: JunctionBond = Field("bonded", description="bonded, butt, or the share of courses that interlock")


class BuildingVaultTable(Table):
    """One entry ``[[structure.vaults]]``."""

    name: Name | None = Field(None, description="of its blocks and group; by default vault1, vault2 ...")
    shape: Literal["barrel", "cross", "domical", "dome"] = Field("barrel", description="domical: of four sides, a cloister vault")
    walls: tuple[str, ...] | None = Field(
        None, strict=False, min_length=2, description="that carry it: two of a barrel, which are parallel; four of the others"
    )
    corners: tuple[Point, ...] | None = Field(
        None, strict=False, min_length=4, max_length=4, description="or corners of the clear bay; a barrel spans between its longer sides"
    )
    springing: Height = Field(description="z of the springing of the intrados")
    rise: Length | None = Field(None, description="of the intrados; by default half the span")
    thickness: Length = Field(0.3, description="of the shell")
    block_length: Length | None = Field(None, description="by default that of the building")


class BuildingRoofTable(Table):
    """One entry ``[[structure.roofs]]``: a pitched roof between two walls of one height, in pairs of rafters that thrust or are tied."""

    name: Name | None = Field(None, description="of its blocks; by default roof1, roof2 ...; their group is roof")
    walls: tuple[str, str] = Field(strict=False, description="that carry it, which are parallel and of one height")
    rise: Length = Field(description="of the underside at the ridge, over the tops of the walls")
    thickness: Length = Field(0.25, description="of the rafters with what lies on them")
    mass: ArealMass = Field(description="over its plan")
    spacing: Length = Field(1.5, description="of the pairs of rafters, each of which carries so much of the roof")
    bearing: Length | None = Field(None, description="of the feet on the walls, from their inner faces; by default half the wall")
    tied: bool = Field(False, description="whether tie beams join the feet of each pair; without them the roof thrusts on its walls")
    tie: tuple[Length, Length] = Field((0.15, 0.15), strict=False, description="width and depth of a tie beam, of timber")


class BuildingColumnTable(Table):
    """One entry ``[[structure.columns]]``."""

    name: Name | None = Field(None, description="of its blocks and group; by default column1, column2 ...")
    at: Point | Points = Field(description="its axis [x, y], or a list of them, which is a row")
    to: Point | None = Field(None, description="the last one of a row that begins with at")
    number: int | None = Field(None, ge=2, le=200, description="of columns in the row from at to to")
    section: Literal["round", "square"] = Field("round", description="in plan; a round one has twelve sides")
    size: Length = Field(0.6, description="diameter, or side")
    base: Coordinate = Field(0.0, description="z of its foot")
    height: Length = Field(description="with plinth and capital")
    drum: Length | None = Field(None, description="height of a stone; by default two courses")
    turned: Angle = Field(0.0, description="of a square section from the x axis")


class ArcadeTable(Table):
    """One entry ``[[structure.arcades]]``: arches from column to column, and the wall above them."""

    name: Name | None = Field(None, description="of its wall; by default arcade1, arcade2 ...")
    columns: str = Field(description="name of the row of columns that carries it")
    thickness: Length | None = Field(None, description="of the wall; by default the size of the columns")
    top: Place | None = Field(None, description="z of the top of the wall; by default a course over the rings")
    shape: Literal["round", "segmental", "pointed"] = Field("round", description="of its arches")
    rise: Length | None = Field(None, description="of the arches")
    ring: Length | None = Field(None, description="thickness of the voussoirs")
    ends: tuple[Point, ...] | None = Field(
        None, strict=False, max_length=2, description="points on walls to which it goes on from its first and its last column"
    )
    group: Name | None = Field(None, description="by default its name")


class ButtressTable(Table):
    """One entry ``[[structure.buttresses]]``."""

    name: Name | None = Field(None, description="of its blocks; by default buttress1, buttress2 ...")
    wall: str = Field(description="that it leans on")
    at: Place = Field(description="distance of its middle from the start of the axis of the wall")
    side: Literal["left", "right"] = Field("right", description="of the wall, seen along its axis")
    width: Length = Field(description="along the wall")
    depth: Length = Field(description="beyond the face of the wall")
    height: Length = Field(description="from the base of the wall")
    slope: Height = Field(0.0, description="by how much its top falls outwards")


class BuildingTable(PlanKeys):
    """The [structure] table of a building."""

    plan: str | None = Field(None, description="file with the plan, .json or .dxf, relative to the scene; keys beside it add to it")
    block_length: Length = Field(0.6, description="of a block")
    course_height: Length = Field(0.3, description="aimed at; courses adapt to sills, springings and tops where they are near")
    bond: Bond = Field("regular", description="lengths of blocks: regular, irregular, or rubble, whose courses vary, too")
    seed: int = Field(0, ge=0, description="of an irregular bond; equal seeds give equal blocks")
    junction: JunctionBond = Field("bonded", description="of walls that meet: bonded, butt, or the share of courses that interlock")
    base_depth: Length | None = Field(None, description="of the base; by default two courses")
    walls: tuple[BuildingWallTable, ...] = Field((), strict=False, description="[[structure.walls]] each")
    junctions: tuple[JunctionTable, ...] = Field((), strict=False, description="that differ from the others")
    vaults: tuple[BuildingVaultTable, ...] = Field((), strict=False, description="[[structure.vaults]] each")
    roofs: tuple[BuildingRoofTable, ...] = Field((), strict=False, description="pitched roofs, [[structure.roofs]] each")
    columns: tuple[BuildingColumnTable, ...] = Field((), strict=False, description="columns and piers, [[structure.columns]] each")
    arcades: tuple[ArcadeTable, ...] = Field((), strict=False, description="[[structure.arcades]] each")
    buttresses: tuple[ButtressTable, ...] = Field((), strict=False, description="[[structure.buttresses]] each")
