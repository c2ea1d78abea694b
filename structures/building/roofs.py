# SPDX-License-Identifier: GPL-3.0-or-later
"""Pitched roofs between two walls of one height: pairs of rafters that lean on each other at the ridge and rest on the walls.

They thrust: what holds their feet is friction on the walls, or a tie beam from foot to foot. Each pair carries a stretch of the roof.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from masonry_cd.foundation.errors import Faults, InputError
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.building import vaults
from structures.building.footprints import Plan
from structures.building.table import BuildingRoofTable, BuildingTable, BuildingVaultTable
from structures.geometry.prism import between
from structures.plans.places import place
from structures.ties import MODULI, Bar

GROUP = "roof"
LEVEL = 1e-3  # by which the tops of two walls that carry a roof may differ [m]
LEAST_FOOT = 0.02  # height of a rafter at its outer end, at least [m]
DAMPING = 0.02  # of a tie beam, share of the critical damping


def roofs_of(plan: Plan, table: BuildingTable, faults: Faults) -> tuple[list[Block], list[Bar]]:
    """The rafters of all roofs and their tie beams; what is wrong is added to the faults."""
    blocks, bars = list[Block](), list[Bar]()
    for k, keys in enumerate(table.roofs):
        name = keys.name or f"roof{k + 1}"
        with faults.of(f"structure.roofs[{k}]", f"roof {name}"):
            for pair, bar in _pairs(plan, keys, name, f"structure.roofs[{k}]"):
                blocks += pair
                bars += [bar] if keys.tied else []
    return blocks, bars


def _pairs(plan: Plan, keys: BuildingRoofTable, name: str, where: str) -> Iterator[tuple[list[Block], Bar]]:
    """Pair after pair of rafters, with the tie beam between their feet.

    Raises:
        InputError: no such wall, walls that are not parallel or not of one height, nothing between them, rafters too thin for their feet.
    """
    z, thickness = _tops(plan, keys)
    bay = vaults.bay_of(plan, BuildingVaultTable.model_validate({"walls": keys.walls, "springing": z}))
    a, b = bay.half
    bearing = keys.bearing or 0.5 * thickness
    if bearing > thickness:
        raise InputError("", f"its bearing must be at most the thickness of its walls, {thickness:g} m, got {bearing:g}")
    slope = keys.rise / a
    high = keys.thickness * math.sqrt(1.0 + slope**2)
    if high < slope * bearing + LEAST_FOOT:
        least = (slope * bearing + LEAST_FOOT) / math.sqrt(1.0 + slope**2)
        raise InputError("", f"its thickness must be at least {least:.3g} m for a bearing of {bearing:g} m, got {keys.thickness:g}")
    section = np.array([(-a - bearing, 0.0), (-a, 0.0), (0.0, keys.rise), (0.0, keys.rise + high), (-a - bearing, high - slope * bearing)])
    area = 0.5 * bearing * (2.0 * high - slope * bearing) + a * high
    density = keys.mass * (a + bearing) / area
    size.within(4.0 * b / keys.spacing, f"{where.removeprefix('structure.')}.spacing")
    ends = np.linspace(-b, b, max(1, round(2.0 * b / keys.spacing)) + 1)
    for k in range(len(ends) - 1):
        rafters = []
        for side, sign in (("left", 1.0), ("right", -1.0)):
            plans = [bay.world(np.column_stack([sign * section[:, 0], np.full(len(section), y)])) for y in ends[k : k + 2]]
            loops = [np.column_stack([plan, z + section[:, 1]]) for plan in plans]
            rafters.append(Block(f"{name}.r{k + 1}.{side}", *between(*loops), density, GROUP))
        feet = bay.world(np.array([(sign * (a + 0.5 * bearing), 0.5 * (ends[k] + ends[k + 1])) for sign in (-1.0, 1.0)]))
        points = np.column_stack([feet, np.full(2, z + 0.5 * (high - slope * bearing))])
        beam = {"name": f"{name}.tie{k + 1}", "area": keys.tie[0] * keys.tie[1], "modulus": MODULI["timber"]}
        rest = {"tension": 0.0, "from_start": True, "damping": DAMPING}
        yield rafters, Bar(where, (rafters[0].name, rafters[1].name), points, beam | rest)


def _tops(plan: Plan, keys: BuildingRoofTable) -> tuple[float, float]:
    """z of the tops of both walls, and the lesser of their thicknesses [m].

    Raises:
        InputError: a wall that is not there, or not level; tops of two heights.
    """
    tops, thickness = [], []
    for name in keys.walls:
        legs = [leg for leg in plan.legs if leg.keys.name == name]
        if not legs:
            raise InputError("", f'there is no wall "{name}"')
        heights = [z for leg in legs for _, z in leg.tops]
        if max(heights) - min(heights) > LEVEL:
            raise InputError("", f"the top of wall {name} at {place(legs[0].facets[0].start)} is not level")
        tops.append(max(heights))
        thickness.append(legs[0].thickness)
    if abs(tops[0] - tops[1]) > LEVEL:
        raise InputError("", f"walls {keys.walls[0]} and {keys.walls[1]} do not end at one height: {tops[0]:.4g} and {tops[1]:.4g} m")
    return tops[0], min(thickness)
