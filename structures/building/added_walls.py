# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls that other tables make: arcades, whose arches are openings from column to column, and buttresses."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import Faults, InputError
from structures.building.axes import Leg
from structures.building.columns import ColumnRow
from structures.building.frames import NATURAL_RISE
from structures.building.table import ArcadeTable, BuildingTable, BuildingWallTable, ButtressTable
from structures.geometry.polygons import without_straight
from structures.plans.places import place

BUTTRESSES = "buttresses"  # their group
RING = 0.38  # of a column: most that the ring of an arch takes of what two of them spring from


def added(table: BuildingTable, legs: Sequence[Leg], rows: Sequence[ColumnRow], faults: Faults) -> dict[str, list[BuildingWallTable]]:
    """The walls of all arcades and buttresses by their keys, next to the legs of other walls; what is wrong is added to the faults."""
    found = dict[str, list[BuildingWallTable]]()
    for k, arcade in enumerate(table.arcades):
        name = arcade.name or f"arcade{k + 1}"
        where = f"structure.arcades[{k}]"
        with faults.of(where, f"arcade {name}"):
            found[where] = _arcade(arcade, name, _row(arcade.columns, rows), table, legs)
    for k, buttress in enumerate(table.buttresses):
        name = buttress.name or f"buttress{k + 1}"
        where = f"structure.buttresses[{k}]"
        with faults.of(where, f"buttress {name}"):
            found[where] = [_buttress(buttress, name, legs)]
    return found


def _row(name: str, rows: Sequence[ColumnRow]) -> ColumnRow:
    """The row of columns of a name.

    Raises:
        InputError: there is none, or it is a single column.
    """
    row = next((row for row in rows if row.name == name), None)
    if row is None:
        raise InputError("", f'columns "{name}": there are no columns of this name')
    if len(row.places) < 2:
        raise InputError("", f'columns "{name}": they are one column, an arcade needs a row of two or more')
    return row


@dataclass(frozen=True, eq=False)
class ArchSupport:
    """Support from which an arch springs."""

    place: np.ndarray  # (2,) [m]
    half: float  # of its width along the arcade [m]


def _arcade(keys: ArcadeTable, name: str, row: ColumnRow, table: BuildingTable, legs: Sequence[Leg]) -> list[BuildingWallTable]:
    """The wall over a row of columns, and the responds against the walls at its ends, from which its outer arches spring.

    Raises:
        InputError: no wall at one of its ends.
    """
    size, base = row.keys.size, row.keys.base + row.keys.height
    columns = [ArchSupport(place, 0.5 * size) for place in row.places]
    ends = [ArchSupport(np.array(end), _half_wall(legs, np.array(end)) + 0.5 * size) for end in keys.ends or ()]
    supports = [*ends[:1], *columns, *ends[1:]]
    first = supports[0].place if ends else _beyond(row.places[1], row.places[0], 0.5 * size)
    last = supports[-1].place if len(ends) > 1 else _beyond(row.places[-2], row.places[-1], 0.5 * size)
    axis = without_straight(np.array([first, *(s.place for s in supports), last]), closed=False)
    openings = list(_arches(keys, supports, size, table, 0.0 if ends else 0.5 * size))
    highest = max(o["height"] + o["ring"] for o in openings)
    wall = {
        "name": name,
        "axis": axis.tolist(),
        "base": base,
        "height": keys.top - base if keys.top is not None and keys.top > base else highest + table.course_height,
        "openings": openings,
    }
    outermost = [row.places[0], row.places[-1]]
    responds = [
        {"name": f"{name}_respond{k + 1}", "base": row.keys.base, "height": row.keys.height}
        | {"axis": [end.place.tolist(), (end.place + end.half * (to - end.place) / math.dist(to, end.place)).tolist()]}
        for k, (end, to) in enumerate(zip(ends, outermost, strict=False))
    ]
    shared = {"thickness": keys.thickness or size, "group": keys.group or name}
    return [BuildingWallTable.model_validate(one | shared) for one in (wall, *responds)]


def _half_wall(legs: Sequence[Leg], point: np.ndarray) -> float:
    """Half the thickness of the wall that a point lies in [m].

    Raises:
        InputError: there is none.
    """
    for leg in legs:
        half = 0.5 * leg.thickness
        for facet in leg.facets:
            s, n = facet.local(point)
            if abs(n) <= half + 1e-6 and -half <= s <= facet.length + half:
                return half
    raise InputError("", f"there is no wall at its end, {place(point)}")


def _beyond(start: np.ndarray, end: np.ndarray, by: float) -> np.ndarray:
    """The point beyond an end of a line."""
    return np.asarray(end + by * (end - start) / math.dist(start, end))


def _arches(
    keys: ArcadeTable, supports: Sequence[ArchSupport], size: float, table: BuildingTable, before: float
) -> Iterator[dict[str, Any]]:
    """The openings between supports; the axis begins so far before the first of them [m]."""
    at = before
    for k, (a, b) in enumerate(pairwise(supports)):
        bay = math.dist(a.place, b.place)
        width = bay - a.half - b.half
        if width < size:
            raise InputError("", f"its arch {k + 1} would be {width:.3g} m wide, less than a column")
        given = None if keys.shape == "round" else keys.rise
        rise = given or NATURAL_RISE[keys.shape] * width
        ring = keys.ring or min(RING * size, max(0.1 * width, 0.8 * table.course_height))
        yield {
            "name": f"arch{k + 1}",
            "shape": keys.shape,
            "at": at + a.half + 0.5 * width,
            "width": width,
            "height": rise,
            "ring": ring,
            "rise": None if keys.shape == "round" else rise,
        }
        at += bay


def _buttress(keys: ButtressTable, name: str, legs: Sequence[Leg]) -> BuildingWallTable:
    """The wall that a buttress is.

    Raises:
        InputError: no such wall, a place beyond it, or a slope that is more than its height.
    """
    own = [leg for leg in legs if leg.keys.name == keys.wall]
    if not own:
        raise InputError("", f'there is no wall "{keys.wall}"')
    if keys.slope >= keys.height:
        raise InputError("", f"its slope must be less than its height, {keys.height:g} m, got {keys.slope:g}")
    wall = own[0].keys
    facet = next((facet for leg in own for facet in leg.facets if facet.span[0] <= keys.at <= facet.span[1]), None)
    if facet is None:
        raise InputError("", f"at {keys.at:g} m it is beyond wall {keys.wall}")
    out = facet.left if keys.side == "left" else -facet.left
    start = facet.place(np.array([facet.s_of(keys.at), 0.0]))
    face = 0.5 * wall.thickness
    end = start + (face + keys.depth) * out
    profile = [(0.0, keys.height), (face, keys.height), (face + keys.depth, keys.height - keys.slope)]
    return BuildingWallTable.model_validate(
        {
            "name": name,
            "axis": [start.tolist(), end.tolist()],
            "thickness": keys.width,
            "base": wall.base,
            "course_height": wall.course_height,
            "block_length": wall.block_length,
            "masonry": wall.masonry,
            "density": wall.density,
            "group": BUTTRESSES,
            **({"top": profile} if keys.slope else {"height": keys.height}),
        }
    )
