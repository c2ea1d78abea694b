# SPDX-License-Identifier: GPL-3.0-or-later
"""The [structure] table of a building: a plan of walls, and what stands on and in them.

Lengths in [m], z up. A wall is given by the middle line of its plan; what is said for the whole building (courses, blocks, bond, junctions)
may be said again for a wall or a junction.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from masonry_cd.foundation.units import Unit
from structures.plans.keys import PlanKeys, StoreyTable
from structures.schema import ArealMass, Density, Height, Length, Place, Table, Thickness, WallHeight


def _printable(name: str) -> str:
    if not name.isprintable():
        raise ValueError("should have no control characters")
    return name


FARTHEST = 1e5  # of a point of a plan from its origin [m]
Coordinate = Annotated[Place, Field(ge=-FARTHEST, le=FARTHEST)]
Point = Annotated[tuple[Coordinate, Coordinate], Field(strict=False)]
Points = Annotated[tuple[Point, ...], Field(strict=False, min_length=1)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Bond = Literal["regular", "irregular", "rubble"]
JunctionBond = Literal["bonded", "butt"] | Fraction
OpeningShape = Literal["rectangular", "round", "segmental", "pointed", "rose", "niche"]
Name = Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[^.\s*]+$"), AfterValidator(_printable)]
Angle = Annotated[float, Unit("degrees"), Field(allow_inf_nan=False)]


class ArcTable(Table):
    """A curved piece of an axis: an arc of a circle from the point before it."""

    to: Point
    """where it ends"""
    through: Point
    """a point that it passes"""


class WallOpeningTable(Table):
    """One entry ``[[structure.walls.openings]]``."""

    name: Name | None = None
    """for reports; by default o1, o2 ..."""
    shape: OpeningShape = "rectangular"
    """shape of its head; a rose is a whole circle, a niche does not go through"""
    at: Place
    """distance of its middle from the start of the axis, along it"""
    width: Length
    """clear; of a rose its diameter"""
    sill: Height = 0.0
    """above the base of the wall"""
    height: WallHeight | None = None
    """clear, from the sill to the highest point; by default that of a rose, 2 widths of others"""
    rise: Length | None = None
    """of a segmental head, by default a sixth of the width; of a pointed one, by default that of equal sides; of a niche"""
    ring: Length | None = None
    """thickness of its voussoirs; a rectangular one with a ring has a flat arch"""
    lintel: Length | None = None
    """height of the lintel of a rectangular one; by default a course"""
    bearing: Length | None = None
    """of the lintel on each jamb; by default a third of a block"""
    depth: Length | None = None
    """of a niche; by default a third of the wall"""
    side: Literal["left", "right"] = "right"
    """face that a niche is in, seen along the axis"""


class BuildingWallTable(Table):
    """One entry ``[[structure.walls]]``."""

    name: Name
    """name of its blocks"""
    axis: tuple[Point | ArcTable, ...] = Field(strict=False, min_length=2)
    """points of the middle line; a piece may be an arc { to = [x, y], through = [x, y] }"""
    thickness: Thickness
    """of the wall"""
    base: Coordinate = 0.0
    """z of its foot"""
    height: WallHeight | None = None
    """from the base to a level top"""
    top: tuple[Point, ...] | None = Field(None, strict=False, min_length=2)
    """or profile of the top, [s, z] each: distance along the axis and height over the base"""
    course_height: WallHeight | None = None
    """by default that of the building; walls bonded with each other share it"""
    block_length: Length | None = None
    """by default that of the building"""
    masonry: str | None = None
    """kind of masonry that sets its density"""
    density: Density | None = None
    """by default that of the material"""
    group: Name | None = None
    """group of its blocks; by default its name"""
    bond: Bond | None = None
    """by default that of the building"""
    openings: tuple[WallOpeningTable, ...] = Field((), strict=False)
    """doors, windows and niches"""


class JunctionTable(Table):
    """One entry ``[[structure.junctions]]``."""

    walls: tuple[str, str] = Field(strict=False)
    """the two that meet; with butt the first one runs through"""
    bond: JunctionBond = "bonded"
    """bonded, butt, or the share of courses that interlock"""


class BuildingVaultTable(Table):
    """One entry ``[[structure.vaults]]``."""

    name: Name | None = None
    """name of its blocks and group; by default vault1, vault2 ..."""
    shape: Literal["barrel", "cross", "domical", "dome"] = "barrel"
    """domical: of four sides, a cloister vault"""
    walls: tuple[str, ...] | None = Field(None, strict=False, min_length=2)
    """that carry it: two of a barrel, which are parallel; four of the others"""
    corners: tuple[Point, ...] | None = Field(None, strict=False, min_length=4, max_length=4)
    """or corners of the clear bay; a barrel spans between its longer sides"""
    springing: Height
    """z of the springing of the intrados"""
    rise: Length | None = None
    """of the intrados; by default half the span"""
    thickness: Thickness = 0.3
    """of the shell"""
    block_length: Length | None = None
    """by default that of the building"""


class BuildingRoofTable(Table):
    """One entry ``[[structure.roofs]]``: a pitched roof on walls of one height, in pairs of rafters that thrust or are tied."""

    name: Name | None = None
    """name of its blocks; by default roof1, roof2 ...; their group is roof"""
    walls: tuple[str, ...] = Field(strict=False, min_length=2, max_length=4)
    """two that carry it, up to 10 degrees out of parallel, or the four of a hipped roof; all of one height"""
    rise: Length
    """of the underside at the ridge, over the tops of the walls"""
    thickness: Thickness = 0.25
    """thickness of the rafters with their cover"""
    mass: ArealMass
    """over its plan"""
    spacing: Length = 1.5
    """spacing of the pairs of rafters, each of which carries this width of the roof"""
    bearing: Length | None = None
    """of the feet on the walls, from their inner faces; by default half the wall"""
    tied: bool = False
    """whether tie beams join the feet of each pair; without them the roof thrusts on its walls"""
    tie: tuple[Length, Length] = Field((0.15, 0.15), strict=False)
    """width and depth of a tie beam, of timber"""


class BuildingColumnTable(Table):
    """One entry ``[[structure.columns]]``."""

    name: Name | None = None
    """name of its blocks and group; by default column1, column2 ..."""
    at: Point | Points
    """its axis [x, y], or a list of them, which is a row"""
    to: Point | None = None
    """the last one of a row that begins with at"""
    number: int | None = Field(None, ge=2, le=200)
    """of columns in the row from at to to"""
    section: Literal["round", "square"] = "round"
    """in plan; a round one has twelve sides"""
    size: Length = 0.6
    """diameter, or side"""
    base: Coordinate = 0.0
    """z of its foot"""
    height: WallHeight
    """with plinth and capital"""
    drum: Length | None = None
    """height of a stone; by default two courses"""
    turned: Angle = 0.0
    """of a square section from the x axis"""


class ArcadeTable(Table):
    """One entry ``[[structure.arcades]]``: arches from column to column, and the wall above them."""

    name: Name | None = None
    """name of its wall; by default arcade1, arcade2 ..."""
    columns: str
    """name of the row of columns that carries it"""
    thickness: Thickness | None = None
    """of the wall; by default the size of the columns"""
    top: Place | None = None
    """z of the top of the wall; by default a course over the rings"""
    shape: Literal["round", "segmental", "pointed"] = "round"
    """of its arches"""
    rise: Length | None = None
    """of the arches"""
    ring: Length | None = None
    """thickness of the voussoirs"""
    ends: tuple[Point, ...] | None = Field(None, strict=False, max_length=2)
    """points on walls to which it extends from its first and last columns"""
    group: Name | None = None
    """by default its name"""


class ButtressTable(Table):
    """One entry ``[[structure.buttresses]]``."""

    name: Name | None = None
    """name of its blocks; by default buttress1, buttress2 ..."""
    wall: str
    """that it leans on"""
    at: Place
    """distance of its middle from the start of the axis of the wall"""
    side: Literal["left", "right"] = "right"
    """of the wall, seen along its axis"""
    width: Length
    """along the wall"""
    depth: Length
    """beyond the face of the wall"""
    height: WallHeight
    """from the base of the wall"""
    slope: Height = 0.0
    """by how much its top falls outwards"""


class BuildingTable(PlanKeys):
    """The [structure] table of a building."""

    plan: str | None = None
    """file with the plan, .json, .dxf or .ifc, relative to the scene; the other keys add to it"""
    storeys: tuple[StoreyTable, ...] = Field((), strict=False)
    """or a drawing for each storey, [[structure.storeys]] each; names of walls end with its number, wall_1"""
    block_length: Length = 0.6
    """of a block"""
    course_height: WallHeight = 0.3
    """aimed at; courses adapt to sills, springings and tops where they are near"""
    bond: Bond = "regular"
    """lengths of blocks: regular, irregular, or rubble, whose courses vary, too"""
    seed: int = Field(0, ge=0)
    """of an irregular bond; equal seeds give equal blocks"""
    junction: JunctionBond = "bonded"
    """of walls that meet: bonded, butt, or the share of courses that interlock"""
    base_depth: Length | None = None
    """of the base; by default two courses"""
    walls: tuple[BuildingWallTable, ...] = Field((), strict=False)
    """[[structure.walls]] each"""
    junctions: tuple[JunctionTable, ...] = Field((), strict=False)
    """that differ from the others"""
    vaults: tuple[BuildingVaultTable, ...] = Field((), strict=False)
    """[[structure.vaults]] each"""
    roofs: tuple[BuildingRoofTable, ...] = Field((), strict=False)
    """pitched roofs, [[structure.roofs]] each"""
    columns: tuple[BuildingColumnTable, ...] = Field((), strict=False)
    """columns and piers, [[structure.columns]] each"""
    arcades: tuple[ArcadeTable, ...] = Field((), strict=False)
    """[[structure.arcades]] each"""
    buttresses: tuple[ButtressTable, ...] = Field((), strict=False)
    """[[structure.buttresses]] each"""
