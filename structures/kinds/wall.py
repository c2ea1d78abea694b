"""Walls of coursed blocks: running bond, one leaf or several with through-stones, openings, gable.

The wall stands on a fixed base at z = 0, centred on x = 0 and y = 0. Its courses adapt to the sills, springings and lintels of its
openings (:mod:`structures.layout.coursing`, :mod:`structures.layout.openings`). A wall of several leaves is tied by through-stones: every
third course (``through``) all leaves have the same joints and every third stone fills the whole thickness.

The default is a wall of 4 m by 3 m in squared blocks of 0.5 m by 0.25 m. Groups: ``wall`` and ``base``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import Field

from masonry_cd.errors import InputError, parse_table
from masonry_cd.model.blocks import Block
from masonry_cd.table_schema import rows
from structures import size
from structures.geometry.checks import check
from structures.layout import wall_plan
from structures.layout.openings import opening_of
from structures.schema import Height, Length, OpeningTable, Table


class WallTable(Table):
    """The [structure] table of a wall."""

    length: Length = Field(4.0, description="[m]")
    height: Length = Field(3.0, description="without the gable [m]")
    thickness: Length = Field(0.4, description="[m]")
    course_height: Length = Field(0.25, description="aimed at; courses adapt to the openings [m]")
    unit_length: Length | None = Field(None, description="of a block; by default two courses [m]")
    leaves: int = Field(1, ge=1, le=4, description="layers of stones through the thickness")
    through: int = Field(3, ge=1, le=100, description="through-stones: with n, every n-th stone of every n-th course")
    openings: tuple[dict[str, Any], ...] = Field(
        (), strict=False, json_schema_extra=rows(OpeningTable), description="doors and windows, [[structure.openings]] each"
    )
    gable: Height = Field(0.0, description="height of a gable on top [m]")
    base_depth: Length | None = Field(None, description="of the base; by default two courses [m]")


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build a wall on its base.

    Raises:
        InputError: a key that is unknown or out of range, or measures that do not fit together.
    """
    keys = parse_table(WallTable, table, "structure")
    wall = elevation(keys)
    unit = keys.unit_length or 2.0 * keys.course_height
    size.within(keys.length / unit * ((keys.height + 0.5 * keys.gable) / keys.course_height) * keys.leaves, "course_height")
    blocks = wall_plan.build([wall], wall_plan.levels([wall], keys.course_height), unit, density)
    blocks.append(wall_plan.ground(blocks, keys.base_depth or 2.0 * keys.course_height, density))
    check(blocks)
    return blocks


def elevation(keys: WallTable) -> wall_plan.Wall:
    """The wall of a table, checked.

    Raises:
        InputError: measures that do not fit together.
    """
    unit = keys.unit_length or 2.0 * keys.course_height
    if keys.course_height > keys.height:
        raise InputError(f"structure.course_height: must be at most the height, {keys.height:g} m, got {keys.course_height:g}")
    if unit > keys.length:
        raise InputError(f"structure.unit_length: must be at most the length of the wall, {keys.length:g} m, got {unit:g}")
    if 0 < keys.gable < keys.course_height:
        raise InputError(f"structure.gable: must be 0, or at least a course, {keys.course_height:g} m, got {keys.gable:g}")
    openings = []
    for i, entry in enumerate(keys.openings):
        made = parse_table(OpeningTable, entry, f"structure.openings[{i}]")
        openings.append(opening_of(made, f"structure.openings[{i}].", keys.course_height, unit))
    for opening in openings:
        inside(opening.key, opening.centre, opening.width, 0.5 * keys.length)
    half, thick = 0.5 * keys.length, 0.5 * keys.thickness
    return wall_plan.Wall(
        "wall", "wall", 0, -half, half, -thick, thick, 0.0, keys.height, tuple(openings), keys.gable, keys.leaves, keys.through
    )


def inside(key: str, centre: float, width: float, half: float) -> None:
    """Refuse an opening outside its wall of a given half length [m]."""
    if width >= 2.0 * half:
        raise InputError(f"{key}width: must be below the length of the wall, {2.0 * half:g} m, got {width:g}")
    room = half - 0.5 * width
    if abs(centre) > room:
        raise InputError(f"{key}centre: must be between {-room:.4g} and {room:.4g} m for an opening inside the wall, got {centre:g}")
