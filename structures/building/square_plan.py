# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans of walls along x and y, as the kinds wall, tower, church and aqueduct draw them: tables of a building, with turns of their own at
junctions, leaves, and places left out for what is bonded in from elsewhere.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from shapely.geometry import Polygon

from masonry_cd.foundation.errors import Fault, Faults, InputError
from masonry_cd.mechanics.model.blocks import Block
from structures.building import beds, junctions, openings
from structures.building.axes import SAME, legs_of
from structures.building.engine import Walls, blocks_of_walls
from structures.building.footprints import BuildingPlan
from structures.building.frames import LEAST_MEASURE, Frame, Named
from structures.building.junctions import FacetPair, Junction
from structures.building.panels import Laying, Leaves
from structures.building.table import BuildingTable, WallOpeningTable
from structures.courser.wall_plan import Opening, PlanWall, Sizes
from structures.geometry.polygons import box

SHAPES = {"lintel": "rectangular", "flat": "rectangular", "segmental": "segmental", "round": "round"}


def beds_of(walls: Sequence[PlanWall], sizes: Sizes, more: Mapping[str, float] = MappingProxyType({})) -> list[float]:
    """The beds that all walls share [m].

    Args:
        more: further heights that need a bed, by the key that sets each [m].

    Raises:
        InputError: a bed that another one is too close to, or an opening that is none.
    """
    faults = Faults()
    frames = frames_of(walls, sizes, faults)
    faults.refuse()
    levels = [z for wall in walls for z in (wall.foot, wall.top, wall.top + wall.gable, *(wall.shoulder or ())[:1])]
    around = [frame for some in frames.values() for frame in some]
    found = beds.beds([*levels, *more.values()], around, sizes.course).tolist()
    for key, z in more.items():
        near = min(found, key=lambda bed: abs(bed - z))
        if abs(near - z) > SAME:
            raise InputError(
                key,
                f"asks for a bed {1e3 * abs(near - z):.3g} mm from another one, at {near:g} m; "
                f"bring them to one level, or {beds.LEAST_COURSE * sizes.course:g} m apart or more, or take lower courses",
            )
    return found


def build(walls: Sequence[PlanWall], levels: Sequence[float], sizes: Sizes, density: float, bonded: bool = True) -> list[Block]:
    """The blocks of all walls, ``NAME.COURSE.NUMBER``, voussoirs and lintels ``NAME.oOPENING.NUMBER``.

    Args:
        levels: from :func:`beds_of` [m].
        density: [kg/m3].
        bonded: False makes straight joints where walls meet.

    Raises:
        InputError: an opening that does not lie inside its wall, or walls that cannot meet as they do.
    """
    layings = [_laying(wall, levels, sizes) for wall in walls]
    table = _table(walls, sizes)
    faults = Faults()
    legs = [leg for k, keys in enumerate(table.walls) for leg in legs_of(k, keys)]
    plan = BuildingPlan(legs, [_in_turns(junction, walls, bonded) for junction in junctions.find(legs, table, faults)])
    frames = frames_of(walls, sizes, faults)
    for k, wall in enumerate(walls):
        frames.setdefault((k, 0), []).extend(_left_out(box(a - wall.start, b - wall.start, low, high)) for a, b, low, high in wall.voids)
    openings.check(plan, layings, frames, faults)
    first: dict[str, Fault] = {}
    for fault in faults.found:  # one for each key: it may draw many openings
        first.setdefault(fault.place, fault)
    Faults([*first.values()]).refuse()
    return blocks_of_walls(Walls(table, plan, frames, layings), density)


def frames_of(walls: Sequence[PlanWall], sizes: Sizes, faults: Faults) -> openings.Frames:
    """The frames of all openings by wall and facet, which is 0; faults name the keys that draw them."""
    table = _table(walls, sizes)
    legs = [leg for k, keys in enumerate(table.walls) for leg in legs_of(k, keys)]
    return openings.frames(
        BuildingPlan(legs, []), table, faults, {(k, i): o.key for k, wall in enumerate(walls) for i, o in enumerate(wall.openings)}
    )


def _table(walls: Sequence[PlanWall], sizes: Sizes) -> BuildingTable:
    """The table of a building of some walls."""
    keys = {"walls": [_wall_table(wall) for wall in walls], "course_height": sizes.course, "block_length": sizes.unit}
    return BuildingTable.model_validate(keys)


def _wall_table(wall: PlanWall) -> dict[str, Any]:
    """A wall by the middle line of its plan."""
    middle = 0.5 * (wall.near + wall.far)
    axis = [(s, middle) if wall.axis == 0 else (middle, s) for s in (wall.start, wall.end)]
    profile = [(s - wall.start, z - wall.foot) for s, z in wall.profile]
    keys = {"name": wall.name, "group": wall.group, "axis": axis, "thickness": wall.far - wall.near, "base": wall.foot, "top": profile}
    return keys | {"openings": [_opening_table(opening, wall) for opening in wall.openings]}


def _opening_table(opening: Opening, wall: PlanWall) -> dict[str, Any]:
    """An opening as a wall of a building has it.

    Raises:
        InputError: a measure that is a slip, and would make voussoirs by the million.
    """
    for measure in ("width", "height", "depth", "rise", "bearing"):
        value = getattr(opening, measure)
        if value is not None and value < LEAST_MEASURE:
            raise InputError(opening.key, f"its {measure} must be at least {LEAST_MEASURE:g} m, got {value:g}")
    keys = {"shape": SHAPES[opening.head], "at": opening.centre - wall.start, "width": opening.width, "height": opening.height}
    keys |= {"sill": opening.sill - wall.foot, "lintel" if opening.head == "lintel" else "ring": opening.depth}
    return keys | {key: value for key in ("rise", "bearing") if (value := getattr(opening, key)) is not None}


def _left_out(hull: Polygon) -> Frame:
    """A rectangle s, z of a wall that is left out."""
    left, low, right, high = hull.bounds
    keys = WallOpeningTable.model_validate({"at": 0.5 * (left + right), "width": right - left, "height": high - low})
    return Frame(keys, Named("a place left out"), hull, (), hull, ())


def _in_turns(junction: Junction, walls: Sequence[PlanWall], bonded: bool) -> Junction:
    """A junction at which walls along x run through in even courses; of unbonded walls the one that goes on, or else that along x."""

    def turned(pair: FacetPair) -> FacetPair:
        along_x = int(walls[pair.arms[0].leg].axis == 1)
        goes_on = [arm.end == 0 for arm in pair.arms]
        return replace(
            pair,
            bond="bonded" if bonded else "butt",
            through=along_x if bonded or goes_on[0] == goes_on[1] else goes_on.index(True),
        )

    return replace(junction, pairs=tuple(turned(pair) for pair in junction.pairs))


def _laying(wall: PlanWall, levels: Sequence[float], sizes: Sizes) -> Laying:
    """How a wall is laid: in leaves where it has several, counted from its near face."""
    half = 0.5 * (wall.far - wall.near)
    middle = 0.5 * (wall.near + wall.far)
    bounds = np.linspace(-half, half, wall.leaves + 1) if wall.core is None else np.array([-half, *(n - middle for n in wall.core), half])
    leaves = Leaves(bounds if wall.axis == 0 else -bounds, wall.through, wall.core is not None, wall.hollow) if wall.leaves > 1 else None
    anchor = 0.0 if wall.anchor is None else wall.anchor - wall.start
    return Laying(np.array(levels), sizes.course, sizes.unit, anchor=anchor, leaves=leaves)
