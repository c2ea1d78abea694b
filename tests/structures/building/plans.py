# SPDX-License-Identifier: GPL-3.0-or-later
"""Volumes that a plan should fill, by areas of shapely in level planes, not by its blocks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, pairwise
from typing import Any

import numpy as np
import shapely
from shapely.geometry import Polygon

from masonry_cd.foundation.errors import Faults, parse_table
from masonry_cd.mechanics.model.blocks import Block
from structures.building.axes import Leg
from structures.building.engine import Walls, prepared
from structures.building.table import BuildingTable

GRID = 1e-12  # to which corners are rounded in unions, which otherwise may lose one of two polygons whose sides differ by rounding [m]


def wall(name: str, axis: Sequence[object], thickness: float = 0.6, height: float = 2.4, **keys: object) -> dict[str, Any]:
    """The table of a wall; a top in its keys takes the place of the height."""
    return {"name": name, "axis": axis, "thickness": thickness} | ({} if "top" in keys else {"height": height}) | keys


def prepare(keys: Mapping[str, Any]) -> Walls:
    """The walls of a table, without faults."""
    faults = Faults()
    made = prepared(parse_table(BuildingTable, keys, "structure"), faults)
    assert not faults.found
    return made


def volume_of_plan(walls: Walls) -> float:
    """Return the volume of the walls of a plan drawn out to the far faces at junctions, each counted once, less their openings [m3]."""
    legs = walls.plan.legs
    levels = sorted(
        {z for leg in legs for z in (leg.base, *(z for _, z in leg.tops))}
        | {z for lay in walls.layings for z in lay.beds.tolist()}
        | set(_heights_of_slopes(walls))
    )
    total = 0.0
    for low, high in pairwise(levels):
        if high - low > 1e-9:
            total += _between(walls, low, high, [_area(walls, low + share * (high - low)) for share in (1e-9, 0.5, 1.0 - 1e-9)])
    for (k, _), frames in walls.frames.items():
        total -= sum(frame.hole.area * (frame.depth or legs[k].thickness) for frame in frames)
    return total


def _between(walls: Walls, low: float, high: float, areas: Sequence[float]) -> float:
    """Volume between two heights [m3] by Simpson's rule, from the areas there and halfway; exact at once where no slopes cross."""
    middle = 0.5 * (low + high)
    quarters = [_area(walls, 0.5 * (low + middle)), _area(walls, 0.5 * (middle + high))]
    halves = [areas[0] + 4.0 * quarters[0] + areas[1], areas[1] + 4.0 * quarters[1] + areas[2]]
    once, twice = (high - low) * (areas[0] + 4.0 * areas[1] + areas[2]) / 6.0, (high - low) * sum(halves) / 12.0
    if abs(once - twice) < 1e-10 or high - low < 1e-4:
        return twice
    return _between(walls, low, middle, [areas[0], quarters[0], areas[1]]) + _between(
        walls, middle, high, [areas[1], quarters[1], areas[2]]
    )


def _heights_of_slopes(walls: Walls) -> Iterator[float]:
    """Where sloping tops pass over corners of plans, and of what two of these share: areas there change their course."""
    legs, plan = walls.plan.legs, walls.plan
    shapes = [
        Polygon(facet.place(np.array(plan.shape(k, f).exterior.coords)[:-1]))
        for k, leg in enumerate(legs)
        for f, facet in enumerate(leg.facets)
    ]
    shared = [one.intersection(other) for one, other in combinations(shapes, 2) if one.intersects(other)]
    points = np.concatenate([shapely.get_coordinates(shape) for shape in [*shapes, *shared]])
    for leg in legs:
        if len({z for _, z in leg.tops}) > 1:
            yield from (leg.top(facet, float(s)) for facet in leg.facets for s in facet.local(points)[:, 0])


def _area(walls: Walls, z: float) -> float:
    """Return the area of all walls at a height [m2]."""
    shapes = []
    for k, leg in enumerate(walls.plan.legs):
        for f in range(len(leg.facets)):
            shapes += _slice(walls, k, f, leg, z)
    return float(shapely.union_all(shapes, grid_size=GRID).area)


def _slice(walls: Walls, k: int, f: int, leg: Leg, z: float) -> list[Polygon]:
    """Return the area of a facet at a height."""
    if z < leg.base:
        return []
    facet, shape = leg.facets[f], walls.plan.shape(k, f)
    left, _, right, _ = shape.bounds
    found = []
    for (a, za), (b, zb) in pairwise(leg.tops_between(facet, left, right)):
        if max(za, zb) <= z:
            continue
        ends = [a, b]
        if min(za, zb) < z:
            ends[int(zb < za)] = a + (b - a) * (z - za) / (zb - za)
        part = shape.intersection(shapely.box(ends[0], -1e3, ends[1], 1e3))
        if part.area > 0.0:
            found.append(Polygon(facet.place(np.array(part.exterior.coords)[:-1])))
    return found


def free_volume(blocks: Sequence[Block]) -> float:
    """Return the volume of the blocks of a building without its base [m3]."""
    return float(sum(block.mass_properties.volume for block in blocks if not block.fixed))
