# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls of coursed blocks: running bond, one leaf or several with through-stones, openings, gable.

The wall stands on a fixed base at z = 0, centred on x = 0 and y = 0. Its courses adapt to the sills, springings and lintels of its
openings (:mod:`structures.building.beds`). A wall of several leaves is tied by through-stones: every
third course (``through``) all leaves have the same joints and every third stone fills the whole thickness.

A wall with a core has two outer leaves and between them stones, ``core = "solid"``, or rubble, ``core = "rubble"``: spheres that lie on one
another (:mod:`structures.layout.rubble`). All leaves have the same joints, and stones at both ends reach through the wall.

The default is a wall of 4 m by 3 m in squared blocks of 0.5 m by 0.25 m. Groups: ``wall``, ``core`` and ``base``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.table_schema import rows
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.courser import wall_plan
from structures.courser.wall_plan import opening_of
from structures.kind import Keys, StructureKind, fewer_through_stones, other_seed, scaled
from structures.layout import rubble
from structures.layout.ground import ground
from structures.layout.loose_grains import ContainerPlan, count_for
from structures.macro_elements import NORTH, SOUTH, BlockLayout, MacroElement, walls
from structures.schema import Density, Height, Length, OpeningTable, Share, Table, Thickness, WallHeight


class WallTable(Table):
    """The [structure] table of a wall."""

    length: Length = Field(4.0)
    height: WallHeight = 3.0
    """without the gable"""
    thickness: Thickness = Field(0.4)
    course_height: WallHeight = 0.25
    """aimed at; courses adapt to the openings"""
    unit_length: Length | None = None
    """of a block; by default two courses"""
    leaves: int = Field(1, ge=1, le=4)
    """layers of stones through the thickness"""
    through: int = Field(3, ge=0, le=100)
    """through-stones: with n, every n-th stone of every n-th course; 0 for none"""
    core: Literal["none", "solid", "rubble"] = "none"
    """core between two outer leaves: stones, or rubble of spheres"""
    core_thickness: Thickness | None = None
    """of the core; by default a third of the thickness"""
    core_diameters: tuple[Length, ...] | None = Field(None, strict=False, min_length=1, max_length=20)
    """of the rubble; by default 0.6 and 0.4 of the core's thickness"""
    core_shares: tuple[Share, ...] | None = Field(None, strict=False)
    """of the number of spheres thrown in, for each diameter, in any unit; by default equal ones"""
    core_density: Density | None = None
    """of the core; by default that of the material"""
    core_seed: int = Field(0, ge=0)
    """seed of the places of the rubble; equal seeds give equal places"""
    openings: tuple[dict[str, Any], ...] = Field((), strict=False, json_schema_extra=rows(OpeningTable))
    """doors and windows, [[structure.openings]] each"""
    gable: Height = 0.0
    """height of a gable on top"""
    base_depth: Length | None = None
    """of the base; by default two courses"""


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build a wall on its base.

    Raises:
        InputError: a key that is unknown or out of range, or measures that do not fit together.
    """
    from structures.building import square_plan

    keys = parse_table(WallTable, table, "structure")
    wall = elevation(keys)
    unit = keys.unit_length or 2.0 * keys.course_height
    size.check_size(keys.length / unit * ((keys.height + 0.5 * keys.gable) / keys.course_height) * wall.leaves, "course_height")
    sizes = wall_plan.Sizes(keys.course_height, unit)
    beds = square_plan.beds_of([wall], sizes)
    blocks = square_plan.build([wall], beds, sizes, density)
    if wall.core is not None:
        own = keys.core_density or density
        blocks = [replace(block, density=own) if block.group == wall_plan.CORE else block for block in blocks]
        if wall.hollow:
            blocks += _rubble(keys, wall, blocks, beds, own)
    blocks.append(ground(blocks, keys.base_depth or 2.0 * keys.course_height, density))
    return blocks


def elevation(keys: WallTable) -> wall_plan.PlanWall:
    """The wall of a table, checked.

    Raises:
        InputError: measures that do not fit together.
    """
    unit = keys.unit_length or 2.0 * keys.course_height
    if keys.course_height > keys.height:
        raise InputError("structure.course_height", f"must be at most the height, {keys.height:g} m, got {keys.course_height:g}")
    if unit > keys.length:
        raise InputError("structure.unit_length", f"must be at most the length of the wall, {keys.length:g} m, got {unit:g}")
    if 0 < keys.gable < keys.course_height:
        raise InputError("structure.gable", f"must be 0, or at least a course, {keys.course_height:g} m, got {keys.gable:g}")
    core = _core(keys)
    openings = []
    for i, entry in enumerate(keys.openings):
        made = parse_table(OpeningTable, entry, f"structure.openings[{i}]")
        openings.append(opening_of(made, f"structure.openings[{i}]", keys.course_height))
        check_inside(f"structure.openings[{i}].", made.centre, made.width, 0.5 * keys.length)
    half, thick = 0.5 * keys.length, 0.5 * keys.thickness
    leaves = keys.leaves if core is None else 3
    return wall_plan.PlanWall(
        "wall", "wall", 0, -half, half, -thick, thick, 0.0, keys.height, tuple(openings), keys.gable, leaves, keys.through,
        core=core, hollow=keys.core == "rubble",
    )  # fmt: skip


def _core(keys: WallTable) -> tuple[float, float] | None:
    """Where the core begins and ends across the wall [m]; None without one.

    Raises:
        InputError: keys of a core that is not there, or that do not fit it.
    """
    given = keys.model_fields_set
    rubble_keys = ("core_diameters", "core_shares", "core_seed")
    for key in ("core_thickness", "core_density") if keys.core == "none" else ():
        if key in given:
            raise InputError(f"structure.{key}", 'belongs to core = "solid" or "rubble", and the wall has none')
    for key in rubble_keys if keys.core != "rubble" else ():
        if key in given:
            raise InputError(f"structure.{key}", f'belongs to core = "rubble", and the core is "{keys.core}"')
    if keys.core == "none":
        return None
    if "leaves" in given:
        raise InputError("structure.leaves", "a wall with a core has three, of which the core is one; leave the key out")
    if keys.core == "rubble" and (keys.openings or keys.gable):
        key = "openings" if keys.openings else "gable"
        raise InputError(f"structure.{key}", 'a wall with core = "rubble" has none, the rubble would run out; core = "solid" may have')
    width = keys.core_thickness or keys.thickness / 3.0
    if width >= keys.thickness:
        raise InputError("structure.core_thickness", f"must be below the thickness of the wall, {keys.thickness:g} m, got {width:g}")
    for k, diameter in enumerate(_diameters(keys, width) if keys.core == "rubble" else ()):
        if diameter >= width:
            raise InputError(f"structure.core_diameters[{k}]", f"must be below the thickness of the core, {width:.4g} m, got {diameter:g}")
    return -0.5 * width, 0.5 * width


def _diameters(keys: WallTable, width: float) -> tuple[float, ...]:
    """Return the diameters of the rubble in a core of a given thickness [m]."""
    return keys.core_diameters or (0.6 * width, 0.4 * width)


def _rubble(keys: WallTable, wall: wall_plan.PlanWall, stones: Sequence[Block], beds: Sequence[float], density: float) -> list[Block]:
    """The spheres between the leaves of a wall whose stones are made.

    Raises:
        InputError: shares that do not go with the diameters, or too many spheres.
    """
    near, far = wall.core or (0.0, 0.0)
    diameters = _diameters(keys, far - near)
    shares = keys.core_shares or (1.0,) * len(diameters)
    if len(shares) != len(diameters):
        raise InputError("structure.core_shares", f"must have one for each of the {len(diameters)} diameters, got {len(shares)}")
    plan = ContainerPlan(wall.end - wall.start, far - near)
    size.check_size(count_for(keys.height, plan, diameters, shares, False), "core_diameters")
    through = [b.vertices for b in stones if np.ptp(b.vertices[:, 1]) > wall.far - wall.near - wall_plan.SAME]
    reach = np.array([[v[:, 0].min(), v[:, 0].max(), v[:, 2].min(), v[:, 2].max()] for v in through]).reshape(-1, 4)
    slot = rubble.Slot(wall.start, wall.end, near, far, beds[0], beds[-1])
    grains = rubble.fill(slot, reach, beds, diameters, shares, keys.core_seed)
    return [
        Block.sphere(f"core.{i + 1}", centre, 0.5 * diameters[k], density, wall_plan.CORE)
        for i, (centre, k) in enumerate(zip(grains.centre, grains.size.tolist(), strict=True))
    ]


def check_inside(key: str, centre: float, width: float, half: float) -> None:
    """Refuse an opening outside its wall of a given half length [m]."""
    if width >= 2.0 * half:
        raise InputError(f"{key}width", f"must be below the length of the wall, {2.0 * half:g} m, got {width:g}")
    room = half - 0.5 * width
    if abs(centre) > room:
        raise InputError(f"{key}centre", f"must be between {-room:.4g} and {room:.4g} m for an opening inside the wall, got {centre:g}")


def bonds(table: Keys) -> dict[str, Keys]:
    """Fewer stones through its leaves, other rubble in its core."""
    return fewer_through_stones(table) | (other_seed(table, "core_seed", " of the core") if table.get("core") == "rubble" else {})


def parts(layout: BlockLayout) -> list[MacroElement]:
    """A wall on its own: out of its plane to both sides, and in it."""
    own = np.flatnonzero(~layout.fixed)
    found = walls.out_of_plane(layout, "wall", own, (NORTH, SOUTH), _eaves(layout, own), "wall")
    return found + walls.in_plane(layout, "wall", "wall")


def _eaves(layout: BlockLayout, own: np.ndarray) -> float:
    """Up to where a wall has its full length: above it is a gable [m]."""
    axis = layout.axis(own)
    return layout.top(own[layout.low[own, axis] <= layout.low[own, axis].min() + 1e-6])


KIND = StructureKind(
    build, WallTable, first={"length": 4.0, "height": 3.0, "thickness": 0.4, "course_height": 0.25}, masonry="squared stone",
    resized=partial(scaled, WallTable, lengths=("course_height", "unit_length")), bonds=bonds, parts=parts,
)  # fmt: skip
