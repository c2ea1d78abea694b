# SPDX-License-Identifier: GPL-3.0-or-later
"""Pitched roofs on walls of one height: pairs of rafters between two walls, which lean on each other at the ridge, or four slopes on four.

They thrust: what holds their feet is friction on the walls, or a tie beam from foot to foot. Each pair carries a stretch of the roof. Two
walls may be up to 10 degrees out of parallel: the ridge stays level, and each pair is as wide as the bay in its middle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from shapely.geometry import Polygon

from masonry_cd.foundation.errors import Faults, InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.polygon import polygon_area
from structures import size
from structures.building import vaults
from structures.building.axes import Facet, Leg
from structures.building.footprints import BuildingPlan
from structures.building.table import BuildingRoofTable, BuildingTable, BuildingVaultTable
from structures.building.vaults import Bay
from structures.courser.courses import divided
from structures.geometry import polygons
from structures.geometry.convex import halves
from structures.geometry.polygons import plan_of
from structures.geometry.prism import between
from structures.plans.places import place
from structures.ties import MODULI, PlacedBar

GROUP = "roof"
LEVEL = 1e-3  # by which the tops of two walls that carry a roof may differ [m]
LEAST_FOOT = 0.02  # height of a rafter at its outer end, at least [m]
SKEWEST = math.sin(math.radians(10.0))  # sine of the angle between two walls that carry a roof, at most
HIPPED = 4  # walls of a roof of four slopes
DAMPING = 0.02  # of a tie beam, share of the critical damping


def roofs_of(plan: BuildingPlan, table: BuildingTable, faults: Faults) -> tuple[list[Block], list[PlacedBar]]:
    """The rafters of all roofs and their tie beams; what is wrong is added to the faults."""
    blocks, bars = list[Block](), list[PlacedBar]()
    for k, keys in enumerate(table.roofs):
        name, where = keys.name or f"roof{k + 1}", f"structure.roofs[{k}]"
        with faults.of(where, f"roof {name}"):
            z, thickness = _tops(plan, keys)
            bay, widening = _bay(plan, keys, z)
            bearing = keys.bearing or 0.5 * thickness
            if bearing > thickness:
                raise InputError("", f"its bearing must be at most the thickness of its walls, {thickness:g} m, got {bearing:g}")
            size.check_size(4.0 * bay.half[1] / keys.spacing, f"{where.removeprefix('structure.')}.spacing")
            roof = Roof(keys, name, where, bay, widening, z, bearing)
            for rafters, bar in (_hipped if len(keys.walls) == HIPPED else _pairs)(roof):
                blocks += rafters
                bars += [bar] if keys.tied and bar else []
    return blocks, bars


@dataclass(frozen=True, eq=False)
class Roof:
    """A roof over its bay, whose ridge runs along y over x = 0."""

    keys: BuildingRoofTable
    name: str
    where: str
    bay: Bay
    widening: float  # of half the width along y: walls need not be parallel
    foot: float  # z of the tops of the walls [m]
    bearing: float  # [m]

    def section(self, half: float) -> tuple[np.ndarray, float]:
        """A rafter's corners (5, 2), distance from the ridge and height over the walls, for half a width, and its height over its foot [m].

        Raises:
            InputError: it is too thin for its foot.
        """
        slope, bearing = self.keys.rise / half, self.bearing
        high = self.keys.thickness * math.sqrt(1.0 + slope**2)
        if high < slope * bearing + LEAST_FOOT:
            least = (slope * bearing + LEAST_FOOT) / math.sqrt(1.0 + slope**2)
            raise InputError(
                "", f"its thickness must be at least {least:.3g} m for a bearing of {bearing:g} m, got {self.keys.thickness:g}"
            )
        low, ridge, outer = self.keys.rise, self.keys.rise + high, high - slope * bearing
        return np.array([(-half - bearing, 0.0), (-half, 0.0), (0.0, low), (0.0, ridge), (-half - bearing, outer)]), outer

    def tie(self, number: int, half: float, y: float, outer: float, blocks: tuple[str, str]) -> PlacedBar:
        """The tie beam from foot to foot at a place along the ridge."""
        feet = self.bay.world(np.array([(sign * (half + 0.5 * self.bearing), y) for sign in (-1.0, 1.0)]))
        points = np.column_stack([feet, np.full(2, self.foot + 0.5 * outer)])
        beam = {"name": f"{self.name}.tie{number}", "area": self.keys.tie[0] * self.keys.tie[1], "modulus": MODULI["timber"]}
        return PlacedBar(self.where, blocks, points, beam | {"tension": 0.0, "from_start": True, "damping": DAMPING})


def _pairs(roof: Roof) -> Iterator[tuple[list[Block], PlacedBar]]:
    """Pair after pair of rafters, with the tie beam between their feet; each as wide as the bay is in its middle."""
    keys, bearing, b = roof.keys, roof.bearing, roof.bay.half[1]
    ends = divided(-b, b, keys.spacing)
    for k in range(len(ends) - 1):
        y = 0.5 * (ends[k] + ends[k + 1])
        a = roof.bay.half[0] + roof.widening * y
        section, outer = roof.section(a)
        density = keys.mass * (a + bearing) / abs(polygon_area(section))
        rafters = []
        for side, sign in (("left", 1.0), ("right", -1.0)):
            plans = [roof.bay.world(np.column_stack([sign * section[:, 0], np.full(len(section), end)])) for end in ends[k : k + 2]]
            loops = [np.column_stack([plan, roof.foot + section[:, 1]]) for plan in plans]
            rafters.append(Block(f"{roof.name}.r{k + 1}.{side}", *between(*loops), density, GROUP))
        yield rafters, roof.tie(k + 1, a, y, outer, (rafters[0].name, rafters[1].name))


def _hipped(roof: Roof) -> Iterator[tuple[list[Block], PlacedBar | None]]:
    """Rafters of four slopes, cut along the hips, which are upright planes at 45 degrees in plan; tie beams between the long sides."""
    a, b = roof.bay.half
    section, outer = roof.section(a)
    left = list[tuple[str, float]]()
    for side, turn, far, half in (("left", 0, a, b), ("right", 2, a, b), ("start", 1, b, a), ("end", 3, b, a)):
        cuts = np.array(divided(-half, half, roof.keys.spacing))
        feet = 0.5 * (cuts[:-1] + cuts[1:])
        cuts[[0, -1]] += [-roof.bearing, roof.bearing]
        for k, (low, high) in enumerate(pairwise(cuts.tolist()), start=1):
            rafter = _between_hips(roof, f"{roof.name}.{side}{k}", section - [far - a, 0.0], (low, high), (far, half), turn)
            bar = None
            if side == "left":
                left.append((rafter.name, float(feet[k - 1])))
            elif side == "right":
                other, y = left[len(feet) - k]
                bar = roof.tie(k, a, y, outer, (other, rafter.name))
            yield [rafter], bar


def _between_hips(roof: Roof, name: str, section: np.ndarray, ends: tuple[float, float], sizes: tuple[float, float], turn: int) -> Block:
    """A rafter of one slope between two places along its wall, cut by both hips, which leave the corners of the bay.

    Args:
        roof: hipped.
        name: of the block.
        section: (5, 2) from the middle of the bay, and height [m].
        ends: along the wall, from its middle [m].
        sizes: from the middle of the bay to the wall, and half the length of the wall [m].
        turn: quarter turns from the side of negative x.
    """
    (far, half), (c, s) = sizes, ((1, 0), (0, 1), (-1, 0), (0, -1))[turn]

    def put(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return roof.bay.world(np.column_stack([c * x - s * y, s * x + c * y]))

    loops = [np.column_stack([put(section[:, 0], np.full(len(section), y)), roof.foot + section[:, 1]]) for y in ends]
    block = Block(name, *between(*loops), 1.0, GROUP)
    corner = np.array([far, half])
    for sign in (1.0, -1.0):  # keep sign y - half <= -x - far, where x is negative
        hip, middle = put(np.array([1.0, 0.0]), np.array([sign, 0.0]))
        normal = np.append(hip - middle, 0.0)
        below, _ = halves(block, normal, float(normal[:2] @ middle) + float(corner @ [-1.0, 1.0]))
        assert below is not None
        block = below
    area = abs(polygon_area(plan_of(block.vertices)))
    return replace(block, density=roof.keys.mass * area / block.mass_properties.volume)


def _bay(plan: BuildingPlan, keys: BuildingRoofTable, z: float) -> tuple[Bay, float]:
    """The bay of a roof with its ridge along y, and by how much half its width grows along that.

    Raises:
        InputError: walls that do not bound one.
    """
    if len(keys.walls) not in (2, HIPPED):
        raise InputError("", f"give the two walls that carry it, or all four of a hipped one, got {len(keys.walls)}")
    shape = "domical" if len(keys.walls) == HIPPED else "barrel"
    if shape == "barrel":
        (leg, facet), (other, across) = (max(vaults.facets_of(plan, name), key=lambda own: own[1].length) for name in keys.walls)
        if vaults.PARALLEL < abs(facet.sine(across)) <= SKEWEST:
            return _skewed(plan, [(leg, facet), (other, across)], z)
    bay = vaults.bay_of(plan, BuildingVaultTable.model_validate({"shape": shape, "walls": keys.walls, "springing": z}))
    return (bay.turned() if shape == "domical" and bay.half[0] > bay.half[1] else bay), 0.0


def _skewed(plan: BuildingPlan, walls: Sequence[tuple[Leg, Facet]], z: float) -> tuple[Bay, float]:
    """As :func:`_bay`, between two walls that are nearly parallel: the ridge lies over the line that halves their angle."""
    faces, middle = [], [facet.place(np.array([0.5 * facet.length, 0.0])) for _, facet in walls]
    for (leg, facet), inside in zip(walls, middle[::-1], strict=True):
        n = math.copysign(0.5 * leg.thickness, float(facet.local(inside)[1]))
        faces.append(facet.place(np.array([(0.0, n), (facet.length, n)])))
    one, other = (facet.along for _, facet in walls)
    faces[1] = faces[1] if one @ other > 0.0 else faces[1][::-1]
    along = one + math.copysign(1.0, float(one @ other)) * other
    along /= np.hypot(*along)
    left = np.array([-along[1], along[0]])
    clear = vaults.clear_of(plan, Polygon([*faces[0], *faces[1][::-1]]), z)
    ring = polygons.loop(clear) @ along
    low, high = np.sort(ring)[[1, -2]]
    ends = np.array([[np.interp(y, face @ along, face @ left) for y in (low, high)] for face in faces])  # (face, end)
    half, y = 0.5 * np.abs(ends[0] - ends[1]), 0.5 * float(low + high)
    bay = Bay(y * along + float(ends.mean()) * left, np.array([along[1], -along[0]]), (float(half.mean()), 0.5 * float(high - low)))
    return bay, float((half[1] - half[0]) / (high - low))


def _tops(plan: BuildingPlan, keys: BuildingRoofTable) -> tuple[float, float]:
    """z of the tops of its walls, and the least of their thicknesses [m].

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
    for name, top in zip(keys.walls, tops, strict=True):
        if abs(tops[0] - top) > LEVEL:
            raise InputError("", f"walls {keys.walls[0]} and {name} do not end at one height: {tops[0]:.4g} and {top:.4g} m")
    return tops[0], min(thickness)
