# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the walls of a plan meet and where they end, with the widths found there: what a drawing has come to, to be compared with it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon

from masonry_cd.foundation.errors import Faults
from structures.building import junctions
from structures.building.axes import Leg, legs_of
from structures.building.junctions import Junction
from structures.building.table import BuildingTable


class Meeting(NamedTuple):
    """A junction, or the free end of a wall."""

    what: str  # corner, tee, crossing or free end
    x: float  # [m]
    y: float
    walls: str  # their names
    thickness: str  # of each [m]
    angle: str = ""  # between the first two [degrees]
    nearest: str = ""  # wall to a free end
    gap: str = ""  # and how far away it is [m]


class Meetings(NamedTuple):
    """All of a plan."""

    found: list[Meeting]
    reach: dict[str, tuple[float, float]]  # of each wall, by how much it goes on beyond the start and the end of its axis [m]


def meetings_of(table: BuildingTable, origin: Sequence[float] = (0.0, 0.0)) -> Meetings:
    """The junctions and free ends of the walls that are sound by themselves.

    Args:
        table: the building; the heights of its walls may be missing.
        origin: of the structure, in the coordinates of the drawing, in which places are given [m].
    """
    legs, faults = list[Leg](), Faults()
    for k, keys in enumerate(table.walls):
        with faults.of():
            own = legs_of(k, keys if keys.height or keys.top else keys.model_copy(update={"height": 1.0}))
            legs += own if all(Polygon(junctions.strip(leg, facet)).is_valid for leg in own for facet in leg.facets) else []
    met = junctions.find(legs, table, faults)
    found = [_junction(legs, junction, origin) for junction in met]
    reach = {leg.keys.name: (0.0, 0.0) for leg in legs}
    beyond = {(arm.leg, arm.end): arm for junction in met for pair in junction.pairs for arm in pair.arms if arm.end}
    last = {leg.wall: k for k, leg in enumerate(legs)}
    for k, leg in enumerate(legs):
        start, end = beyond.get((k, -1)), beyond.get((k, 1))
        name, facet = leg.keys.name, leg.facets[-1]
        if start and leg.number == 0:
            reach[name] = -start.low, reach[name][1]
        if end and last[leg.wall] == k:
            reach[name] = reach[name][0], end.high - facet.length
        found += [_free_end(legs, k, side, origin) for side, arm in ((0, start), (-1, end)) if not arm and not leg.closed]
    return Meetings(found, reach)


def _junction(legs: Sequence[Leg], junction: Junction, origin: Sequence[float]) -> Meeting:
    arms = [arm for pair in junction.pairs for arm in pair.arms]
    ends = len({arm.leg for arm in arms if arm.end})
    what = "crossing" if not ends else "corner" if ends == len(junction.legs) else "tee"
    sine = legs[arms[0].leg].facets[arms[0].facet].sine(legs[arms[1].leg].facets[arms[1].facet])
    own = [legs[k].keys for k in junction.legs]
    names, widths = "; ".join(keys.name for keys in own), "; ".join(f"{keys.thickness:.4g}" for keys in own)
    return Meeting(what, *_place(junction.point, origin), names, widths, f"{math.degrees(math.asin(min(1.0, abs(sine)))):.1f}")


def _free_end(legs: Sequence[Leg], number: int, side: int, origin: Sequence[float]) -> Meeting:
    """The end of a leg that meets nothing, with the wall that is nearest to it."""
    leg, facet = legs[number], legs[number].facets[side]
    point = facet.end if side else facet.start
    face = LineString([point - 0.5 * leg.thickness * facet.left, point + 0.5 * leg.thickness * facet.left])
    others = [(face.distance(strips), other.keys.name) for other, strips in _others(legs, leg.wall)]
    gap, nearest = min(others, default=(math.inf, ""))
    rest = (nearest, f"{gap:.4g}") if nearest else ("", "")
    return Meeting("free end", *_place(point, origin), leg.keys.name, f"{leg.thickness:.4g}", "", *rest)


def _others(legs: Sequence[Leg], wall: int) -> Iterator[tuple[Leg, shapely.Geometry]]:
    for leg in legs:
        if leg.wall != wall:
            yield leg, shapely.union_all([Polygon(junctions.strip(leg, facet)) for facet in leg.facets])


def _place(point: np.ndarray, origin: Sequence[float]) -> tuple[float, float]:
    x, y = (round(float(near) + far, 4) + 0.0 for near, far in zip(point, origin, strict=True))
    return x, y
