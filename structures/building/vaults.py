# SPDX-License-Identifier: GPL-3.0-or-later
"""Vaults over a rectangular bay: barrel, cross, domical, and a dome over four walls.

    barrel     springs from two sides of the bay
    cross      two barrels that meet on the groins; each web ends in a chase of its wall, and the corners carry it
    domical    a cloister vault: four sides that rise from four walls
    dome       a sail dome: a sphere through the corners of the bay, whose rows are cut by the walls

A vault is made over a square, upright to its size, and stretched to the bay: planes stay planes. It reaches into its walls by its
thickness, where their stones are cut to it (:mod:`structures.building.cuts`); what would be a splinter of it there stays wall.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from masonry_cd.foundation.errors import Faults, InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Polyhedron
from structures.building.axes import Facet, Leg
from structures.building.footprints import BuildingPlan
from structures.building.table import BuildingTable, BuildingVaultTable
from structures.courser import rings
from structures.courser.arch_profiles import RingTable, joints_of
from structures.courser.vault_courses import barrel, crossing
from structures.geometry import polygons
from structures.geometry.compound_block import moved
from structures.geometry.convex import halves
from structures.plans.places import place

PARALLEL = 1e-3  # of walls that carry a barrel, the sine of the angle between them
CROSSING = 0.5  # sine of the angle between walls that make a corner of a bay, at least
SQUARE = 1e-4  # what a bay may lack of a rectangle
OBLONG = 2.0  # longest bay of a vault of four sides, in widths
CHASE = 1.05  # depth to which the webs of a cross vault reach into walls, in thicknesses
CARRIED = 0.95  # of what a vault bears on, this has to be wall
SIDES = 16  # of a sail dome
SPLINTER = 0.2  # of a stone of a dome that walls cut: less of it is none


@dataclass(frozen=True, eq=False)
class Bay:
    """A clear rectangle of the plan, between walls."""

    middle: np.ndarray  # (2,) [m]
    across: np.ndarray  # unit vector (2,) of x
    half: tuple[float, float]  # of its width along x and along y [m]

    def world(self, points: np.ndarray) -> np.ndarray:
        """World x, y (..., 2) of points of the bay."""
        x, y = self.across
        return np.asarray(self.middle + points[..., :1] * [x, y] + points[..., 1:2] * [-y, x])

    def turned(self) -> Bay:
        """The rectangle with its other side along x."""
        x, y = self.across
        return Bay(self.middle, np.array([-y, x]), self.half[::-1])


@dataclass(frozen=True, eq=False)
class Vault:
    """A vault in its bay."""

    keys: BuildingVaultTable
    name: str
    bay: Bay


def vaults_of(plan: BuildingPlan, table: BuildingTable, faults: Faults) -> list[Vault]:
    """The vaults of a table in their bays; what is wrong is added to the faults."""
    found = []
    for k, keys in enumerate(table.vaults):
        name = keys.name or f"vault{k + 1}"
        with faults.of(f"structure.vaults[{k}]", f"vault {name}"):
            vault = Vault(keys, name, bay_of(plan, keys))
            _check_springings(plan, vault)
            found.append(vault)
    return found


def blocks_of(vault: Vault, unit: float, density: float) -> list[Block]:
    """The blocks of a vault, ``NAME.ROW.NUMBER`` and the like."""
    keys = vault.keys
    made = MAKERS[keys.shape](vault, keys.block_length or unit, density)
    return [replace(_placed(block, vault), name=f"{vault.name}.{block.name}", group=vault.name) for block in made]


def _placed(block: Block, vault: Vault) -> Block:
    """A block of the bay, springing at z = 0, put into the world."""

    def put(points: np.ndarray) -> np.ndarray:
        return np.column_stack([vault.bay.world(points[:, :2]), points[:, 2] + vault.keys.springing])

    return moved(block, put)


# --- bays -----------------------------------------------------------------------------------------------------------------------------


def bay_of(plan: BuildingPlan, keys: BuildingVaultTable) -> Bay:
    """The bay of a vault.

    Raises:
        InputError: no walls or corners, or none that bound a rectangle.
    """
    if (keys.walls is None) == (keys.corners is None):
        raise InputError("", "give walls that carry it, or corners of its bay")
    if keys.corners is not None:
        corners = np.array(keys.corners)
        bay = _rectangle(Polygon(corners), corners[1] - corners[0])
        return bay if bay.half[0] <= bay.half[1] else bay.turned()
    assert keys.walls is not None
    facets = [facets_of(plan, name) for name in keys.walls]
    if keys.shape == "barrel":
        if len(facets) != 2:
            raise InputError("", f"a barrel springs from two walls, got {len(facets)}")
        room, along = _between(facets[0], facets[1], keys.walls)
    else:
        if len(facets) != 4:
            raise InputError("", f"a vault of this shape springs from four walls, got {len(facets)}")
        room, along = _within(facets), facets[0][0][1].along
    bay = _rectangle(clear_of(plan, room, keys.springing), along)
    return bay.turned() if keys.shape == "barrel" else bay


def clear_of(plan: BuildingPlan, room: BaseGeometry, z: float) -> Polygon:
    """The largest part of a room in which no wall stands at a height.

    Raises:
        InputError: there is none.
    """
    standing = [_world(plan, leg, facet) for leg in plan.legs for facet in leg.facets if stands(leg, z)]
    clear = polygons.polygons(room.difference(shapely.union_all(standing)), 1e-4)
    if not clear:
        raise InputError("", "there is no room between its walls")
    return max(clear, key=lambda part: part.area)


def facets_of(plan: BuildingPlan, name: str) -> list[tuple[Leg, Facet]]:
    """The facets of a wall.

    Raises:
        InputError: there is no such wall.
    """
    found = [(leg, facet) for leg in plan.legs for facet in leg.facets if leg.keys.name == name]
    if not found:
        raise InputError("", f'there is no wall "{name}"')
    return found


def _between(ones: Sequence[tuple[Leg, Facet]], others: Sequence[tuple[Leg, Facet]], names: Sequence[str]) -> tuple[Polygon, np.ndarray]:
    """The rectangle between two walls, as far as both go, and the direction of the first."""
    best: tuple[float, Polygon, np.ndarray] | None = None
    for leg, facet in ones:
        for other, across in others:
            if abs(facet.along @ across.left) > PARALLEL:
                continue
            ends = facet.local(np.array([across.start, across.end]))
            low, high = max(0.0, ends[:, 0].min()), min(facet.length, ends[:, 0].max())
            near, far = math.copysign(0.5 * leg.thickness, ends[0, 1]), float(ends[0, 1]) - math.copysign(0.5 * other.thickness, ends[0, 1])
            if high > low and abs(far) > abs(near) and (best is None or high - low > best[0]):
                ring = facet.place(np.array([(low, near), (high, near), (high, far), (low, far)]))
                best = high - low, Polygon(ring), facet.along
    if best is None:
        at = place(ones[0][1].place(np.array([0.5 * ones[0][1].length, 0.0])))
        raise InputError("", f"walls {names[0]} and {names[1]} are not parallel, or not next to each other, at {at}")
    return best[1], best[2]


def _within(walls: Sequence[Sequence[tuple[Leg, Facet]]]) -> BaseGeometry:
    """Return the area on the inner sides of four walls; of a bent one its longest piece counts."""
    longest = [max(facets, key=lambda item: item[1].length) for facets in walls]
    middle = _middle([facet for _, facet in longest])
    room: BaseGeometry = Polygon(middle + 1e3 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]))
    for leg, facet in longest:
        inner = math.copysign(0.5 * leg.thickness, float(facet.local(middle)[1]))
        far = math.copysign(1e4, inner)
        room = room.intersection(Polygon(facet.place(np.array([(-1e4, inner), (1e4, inner), (1e4, far), (-1e4, far)]))))
    return room


def _middle(facets: Sequence[Facet]) -> np.ndarray:
    """The middle of the corners (2,) that walls make, however far they go on beyond them [m]."""
    corners = []
    for one, other in combinations(facets, 2):
        if abs(one.sine(other)) > CROSSING:
            corners.append(one.start + one.crossing(other)[0] * one.along)
    return np.asarray(np.mean(corners or [facet.start for facet in facets], axis=0))


def _rectangle(shape: Polygon, along: np.ndarray) -> Bay:
    """A bay from its polygon, x along a direction.

    Raises:
        InputError: it is not a rectangle.
    """
    unit = along / np.hypot(*along)
    ring = polygons.loop(shape)
    local = np.column_stack([ring @ unit, ring @ np.array([-unit[1], unit[0]])])
    low, high = local.min(axis=0), local.max(axis=0)
    if abs(shape.area - float(np.prod(high - low))) > SQUARE * shape.area:
        raise InputError("", f"its bay at {place(ring.mean(axis=0))} is not a rectangle: {len(ring)} corners, {shape.area:.4g} m2")
    middle = 0.5 * (low + high)
    return Bay(
        middle[0] * unit + middle[1] * np.array([-unit[1], unit[0]]), unit, (float(0.5 * (high - low)[0]), float(0.5 * (high - low)[1]))
    )


def stands(leg: Leg, z: float) -> bool:
    """Return True if a leg stands at a height, or up to it."""
    return leg.base < z - 1e-6 and max(top for _, top in leg.tops) >= z - 1e-6


def footprint(plan: BuildingPlan, leg: Leg) -> BaseGeometry:
    """A leg with its corners filled, in the world."""
    return shapely.union_all([_world(plan, leg, facet) for facet in leg.facets])


def _world(plan: BuildingPlan, leg: Leg, facet: Facet) -> Polygon:
    """A facet with its corners filled, in the world."""
    shape = plan.shape(plan.legs.index(leg), leg.facets.index(facet))
    return Polygon(facet.place(np.array(shape.exterior.coords)[:-1]))


def _check_springings(plan: BuildingPlan, vault: Vault) -> None:
    """Refuse a vault without walls where it springs.

    Raises:
        InputError: says where nothing carries it.
    """
    keys, (a, b) = vault.keys, vault.bay.half
    t = keys.thickness
    if keys.shape != "barrel" and max(a, b) > OBLONG * min(a, b):
        raise InputError("", f"its bay of {2 * a:.4g} m by {2 * b:.4g} m is longer than {OBLONG:g} times its width")
    sides = [(-a - t, -a, -b, b), (a, a + t, -b, b)]
    if keys.shape == "domical":
        sides += [(-a, a, -b - t, -b), (-a, a, b, b + t)]
    if keys.shape in ("cross", "dome"):
        sides = [
            (x - t if x < 0 else x, x if x < 0 else x + t, y - t if y < 0 else y, y if y < 0 else y + t) for x in (-a, a) for y in (-b, b)
        ]
    standing = shapely.union_all([_world(plan, leg, facet) for leg in plan.legs for facet in leg.facets if stands(leg, keys.springing)])
    for x0, x1, y0, y1 in sides:
        seat = Polygon(vault.bay.world(np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])))
        share = seat.intersection(standing).area / seat.area
        if share < CARRIED:
            at = place(np.array([seat.centroid.x, seat.centroid.y]))
            raise InputError(
                "",
                f"no wall to stand on at {at}, z = {keys.springing:g} m: of the {t:g} m that it bears on, walls carry {100 * share:.0f} %",
            )


# --- shapes, over a square or a bay about the origin ---------------------------------------------------------------------------------


def _profile(span: float, rise: float, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the joints of an arch on intrados and extrados (N + 1, 2) [m]."""
    count = max(5, 2 * round(0.5 * (math.hypot(span, 2.0 * rise) * 1.1 / (1.2 * thickness) - 1.0)) + 1)
    pointed = rise > 0.5 * span * (1.0 + 1e-9)
    keys = {"shape": "pointed" if pointed else "circular", "span": span, "rise": rise, "thickness": thickness}
    return joints_of(RingTable.model_validate(keys | {"voussoirs": count + (count % 2 if pointed else 0)}))


def _barrel(vault: Vault, unit: float, density: float) -> list[Block]:
    a, b = vault.bay.half
    intrados, extrados = _profile(2.0 * a, vault.keys.rise or a, vault.keys.thickness)
    return barrel(intrados, extrados, (-b, b), unit, density, name="v")


def _cross(vault: Vault, unit: float, density: float) -> list[Block]:
    a, b = vault.bay.half
    least, t = min(a, b), vault.keys.thickness
    made = crossing(*_profile(2.0 * least, least, t), least + CHASE * t, unit, density)
    return [_stretched(block, (a / least, b / least, (vault.keys.rise or least) / least)) for block in made]


def _domical(vault: Vault, unit: float, density: float) -> list[Block]:
    a, b = vault.bay.half
    least = min(a, b)
    ring = rings.Ring(4, 4, start=-0.25 * math.pi)
    made = _rows(ring, least, vault.keys.thickness, unit, density)
    return [_stretched(block, (a / least, b / least, (vault.keys.rise or least) / least)) for block in made]


def _rows(ring: rings.Ring, inner: float, thickness: float, unit: float, density: float) -> list[Block]:
    """A dome of flat sides with its key."""
    top = math.acos(min(0.25, 0.8 * thickness / inner))
    count = max(2, round(top * (inner + 0.5 * thickness) / thickness))
    rows = rings.dome_rows("row", inner, thickness, 0.0, count, top)
    return [*rings.build(ring, rows, unit, density), rings.key(ring, rows[-1], density, "key", "key")]


def _dome(vault: Vault, unit: float, density: float) -> list[Block]:
    a, b = vault.bay.half
    least, t = min(a, b), vault.keys.thickness
    radius = math.sqrt(2.0) * least
    made = _rows(rings.Ring(SIDES, SIDES, start=-math.pi / SIDES), radius, t, unit, density)
    cut = [piece for block in made for piece in _within_square(block, least, least + t)]
    return [_stretched(block, (a / least, b / least, (vault.keys.rise or least) / radius)) for block in cut]


def _within_square(block: Block, clear: float, reach: float) -> list[Block]:
    """A stone of a dome cut by the four planes at a reach, without splinters that lie in the walls."""
    parts: list[Block] = [Block(block.name, part.vertices, part.faces, block.density, block.group) for part in block.convex_parts]
    for normal in (np.array([1.0, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), np.array([0.0, -1.0, 0.0])):
        parts = [half for part in parts for half in [halves(part, normal, reach)[0]] if half is not None]
    if not parts:
        return []
    whole, left = block.mass_properties.volume, sum(part.mass_properties.volume for part in parts)
    inside = min(float(np.abs(part.vertices[:, :2]).max(axis=1).min()) for part in parts)
    if left < SPLINTER * whole and inside > clear - 1e-6:
        return []
    if left > whole * (1.0 - 1e-9):
        return [block]
    from structures.building.stones import stone

    return [stone(block.name, [(part.vertices, part.faces) for part in parts], block.density, block.group)]


def _stretched(block: Block, by: tuple[float, float, float]) -> Block:
    """A block stretched along each axis."""
    scale = np.array(by)
    return replace(
        block, vertices=block.vertices * scale, parts=tuple(Polyhedron(part.vertices * scale, part.faces) for part in block.parts)
    )


MAKERS: dict[str, Callable[[Vault, float, float], list[Block]]] = {
    "barrel": _barrel,
    "cross": _cross,
    "domical": _domical,
    "dome": _dome,
}
