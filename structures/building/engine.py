# SPDX-License-Identifier: GPL-3.0-or-later
"""The blocks of a building, from its table: walls, then what stands in and on them.

All that is wrong with a plan is found before anything is built: what is wrong with a wall, columns, an arcade or a buttress alone is said
at once, and then what is wrong where they meet and with what is in and on them, the first fault of each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import Point

from masonry_cd.foundation.errors import Faults, InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Shell
from masonry_cd.mechanics.model.masonry_kinds import KINDS, KN_PER_M3
from structures import size
from structures.building import columns, junctions, leaves, openings, roofs, vaults
from structures.building.added_walls import added
from structures.building.axes import SAME, Facet, Leg, legs_of
from structures.building.beds import beds
from structures.building.footprints import BuildingPlan
from structures.building.frames import Frame
from structures.building.panels import FacetStone, Laying, lay
from structures.building.slivers import Stone, joined
from structures.building.stones import across, parts_of, stone, welded
from structures.building.table import ArcTable, BuildingTable, BuildingWallTable
from structures.building.widths import NARROW
from structures.geometry import polygons
from structures.layout.pockets import with_pockets
from structures.plans.places import place
from structures.ties import PlacedBar

SLIVER = 0.1  # of the thickness of a vault: what it leaves of a stone that is thinner goes to another
MOST_FACETS = 400  # of walls up to which arcs are cut again for their junctions: each time all junctions are looked for
LEAST_SEAT = 0.02  # share of the footprint of a wall that something has to be under


@dataclass(frozen=True, eq=False)
class Walls:
    """The walls of a building, ready to be laid."""

    table: BuildingTable
    plan: BuildingPlan
    frames: dict[tuple[int, int], list[Frame]]  # by leg and facet
    layings: list[Laying]  # of each leg


def blocks_of(table: BuildingTable, density: float) -> tuple[list[Block], list[PlacedBar], list[str]]:
    """The blocks of a building without its base, the tie beams of its roofs, and a line on each wall that is near others and joins none.

    Args:
        table: the building.
        density: of the material [kg/m3].

    Raises:
        InputError: all that is wrong with it, a line each.
    """
    faults = Faults()
    rows = columns.rows_of(table, faults)
    walls = prepared(table, faults, rows)
    over = vaults.vaults_of(walls.plan, table, faults)
    roof, bars = roofs.roofs_of(walls.plan, table, faults)
    _check_feet(walls.plan, rows, faults)
    _check_columns(walls.plan, rows, faults)
    faults.refuse()
    laid = joined([stone for k, leg in enumerate(walls.plan.legs) for stone in _leg_stones(walls, k, leg)])
    blocks = _all_blocks(walls, laid, density)
    vaulted = [block for vault in over for block in vaults.blocks_of(vault, table.block_length, density)]
    if vaulted:
        thin = SLIVER * min(vault.keys.thickness for vault in over)
        blocks = with_pockets(blocks, [part for block in vaulted for part in block.convex_parts], thin)
    blocks += [block for row in rows for block in columns.blocks_of(row, table, density)]
    return welded([*blocks, *vaulted, *roof]), bars, junctions.apart(walls.plan.legs, walls.plan.junctions)


def blocks_of_walls(walls: Walls, density: float) -> list[Block]:
    """The blocks of walls that are square to each other, of which no corner leaves slivers."""
    return _all_blocks(walls, [stone for k, leg in enumerate(walls.plan.legs) for stone in _leg_stones(walls, k, leg)], density)


def prepared(table: BuildingTable, faults: Faults, rows: Sequence[columns.ColumnRow] = ()) -> Walls:
    """The walls of a table, and those of its arcades on rows of columns, with their junctions, beds and openings.

    Args:
        faults: of the rows; to which are added those of walls where they meet, and of openings.

    Raises:
        InputError: what is wrong with walls, arcades and buttresses alone, and all that was wrong before.
    """
    given = {f"structure.walls[{k}]": [keys] for k, keys in enumerate(table.walls)}
    legs = _legs(given, [], faults)
    if not table.walls:
        faults.add("structure.walls", "missing; every wall is a table of its own, headed [[structure.walls]], or comes from a plan")
    faults.refuse()
    more = added(table, legs, rows, faults)
    legs += _legs(more, table.walls, faults)
    table = table.model_copy(update={"walls": (*table.walls, *(keys for some in more.values() for keys in some))})
    with faults.of():
        size.check_size(_estimate(legs, table), "block_length")
    faults.refuse()
    plan = _joined(legs, table, faults)
    frames = openings.frames(plan, table, faults)
    walls = Walls(table, plan, frames, _layings(plan, table, frames))
    _check_courses(plan, walls.layings, faults)
    openings.check(plan, walls.layings, frames, faults)
    return walls


def _legs(walls: Mapping[str, Sequence[BuildingWallTable]], before: Sequence[BuildingWallTable], faults: Faults) -> list[Leg]:
    """The legs of walls by the keys that make them, which come after others, from which their names differ."""
    legs, names = list[Leg](), {keys.name for keys in before}
    number = len(before)
    for where, keys in ((where, keys) for where, some in walls.items() for keys in some):
        known = len(faults.found)
        with faults.of():
            size.check_count(len(keys.top or ()), size.MOST_TOP, f"{where}.top: points")
            size.check_count(len(keys.openings), size.MOST_OPENINGS, f"{where}.openings: openings of one wall")
        if len(faults.found) > known:
            continue
        with faults.of(where, f"wall {keys.name}"):
            if keys.masonry is not None and keys.masonry not in KINDS:
                raise InputError("", f'masonry "{keys.masonry}" is none of {", ".join(KINDS)}')
            if keys.name in names:
                raise InputError("", "another wall has this name, too")
            names.add(keys.name)
            legs += legs_of(number, keys, where=where)
        number += 1
    return legs


def _joined(legs: list[Leg], table: BuildingTable, faults: Faults) -> BuildingPlan:
    """The legs with their junctions; where facets of an arc are too short for one, or meet in it, each of its junctions gets a facet."""
    wrong = Faults()
    found = junctions.find(legs, table, wrong)
    few = sum(len(leg.facets) for leg in legs) <= MOST_FACETS
    for k, keys in [*enumerate(table.walls)] * 2 if few else ():  # the first facets move the places of the second
        if wrong.found and any(isinstance(piece, ArcTable) for piece in keys.axis):
            left = Faults()
            own = legs_of(k, keys, junctions.along(legs, k), next(leg.where for leg in legs if leg.wall == k))
            bent = [*(leg for leg in legs if leg.wall < k), *own, *(leg for leg in legs if leg.wall > k)]
            again = junctions.find(bent, table, left)
            if len(left.found) < len(wrong.found):
                legs, found, wrong = bent, again, left
    faults.found += wrong.found
    return BuildingPlan(legs, found)


def _estimate(legs: Sequence[Leg], table: BuildingTable) -> float:
    """About how many stones: the faces of all walls over that of a block."""
    total = 0.0
    for leg in legs:
        face = sum(facet.length for facet in leg.facets) * (max(z for _, z in leg.tops) - leg.base)
        total += face / (leg.keys.block_length or table.block_length) / (leg.keys.course_height or table.course_height)
    return total


def _layings(plan: BuildingPlan, table: BuildingTable, frames: dict[tuple[int, int], list[Frame]]) -> list[Laying]:
    """How each leg is laid; those of one height of course share their beds."""
    legs = plan.legs
    height = [leg.keys.course_height or table.course_height for leg in legs]
    shared = _shared(plan, height)
    found: dict[float, np.ndarray] = {}
    for course in dict.fromkeys(height):
        own = [k for k, h in enumerate(height) if h == course]
        levels = [z for k in own for z in (legs[k].base, *(z for _, z in legs[k].tops))]
        around = [frame for (k, _), some in frames.items() if k in own for frame in some]
        found[course] = beds(levels, around, course, table.seed if table.bond == "rubble" else None, shared.get(course, ()))
    return [
        Laying(found[h], h, leg.keys.block_length or table.block_length, leg.keys.bond or table.bond, table.seed)
        for leg, h in zip(legs, height, strict=True)
    ]


def _shared(plan: BuildingPlan, height: Sequence[float]) -> dict[float, set[float]]:
    """Return, by height of course, the levels where walls of other courses begin or end at junctions: who fills these changes there [m]."""
    found: dict[float, set[float]] = {}
    for junction in plan.junctions:
        courses = {height[leg] for leg in junction.legs}
        if len(courses) > 1:
            for arm in (arm for pair in junction.pairs for arm in pair.arms):
                leg = plan.legs[arm.leg]
                tops = [z for _, z in leg.tops_between(leg.facets[arm.facet], arm.low, arm.high)]
                for course in courses:
                    found.setdefault(course, set()).update((leg.base, min(tops), max(tops)))
    return found


def _check_courses(plan: BuildingPlan, layings: Sequence[Laying], faults: Faults) -> None:
    """Walls that are bonded share their courses."""
    for junction in plan.junctions:
        for pair in junction.pairs:
            a, b = (arm.leg for arm in pair.arms)
            if layings[a].course != layings[b].course and pair.bond not in ("butt", 0.0):
                faults.add(
                    plan.legs[b].where,
                    f"walls {plan.legs[a].keys.name} and {plan.legs[b].keys.name} at {place(pair.point)}: "
                    f"courses of {layings[a].course:g} and {layings[b].course:g} m do not interlock; give both one course_height, or a "
                    'junction with bond = "butt"',
                )


def _check_feet(plan: BuildingPlan, rows: Sequence[columns.ColumnRow], faults: Faults) -> None:
    """A wall that begins above the lowest one has walls or columns under it."""
    lowest = min((leg.base for leg in plan.legs), default=0.0)
    for leg in plan.legs:
        if leg.base < lowest + SAME:
            continue
        under = [vaults.footprint(plan, other) for other in plan.legs if vaults.stands(other, leg.base)]
        under += [
            Point(*at).buffer(0.5 * row.keys.size) for row in rows for at in row.places if row.keys.base + row.keys.height > leg.base - SAME
        ]
        own = vaults.footprint(plan, leg)
        if own.intersection(shapely.union_all(under)).area < LEAST_SEAT * own.area:
            at = f"{place(leg.facets[0].start)}, where it begins at z = {leg.base:g} m"
            faults.add(leg.where, f"wall {leg.keys.name}: nothing is under it at {at}")


def _check_columns(plan: BuildingPlan, rows: Sequence[columns.ColumnRow], faults: Faults) -> None:
    """No column stands in a wall."""
    for row in rows:
        for at in row.places:
            shape, foot, top = Point(*at).buffer(0.5 * row.keys.size), row.keys.base, row.keys.base + row.keys.height
            for leg in plan.legs:
                overlap = min(top, max(z for _, z in leg.tops)) - max(foot, leg.base)
                if overlap > SAME and vaults.footprint(plan, leg).intersection(shape).area > LEAST_SEAT * shape.area:
                    faults.add(row.where, f"columns {row.name}: the one at {place(at)} stands in wall {leg.keys.name}")


def _all_blocks(walls: Walls, laid: Sequence[Stone], density: float) -> list[Block]:
    """The blocks of all walls, one after the other."""
    by_wall: dict[int, list[Stone]] = {}
    for one in laid:
        by_wall.setdefault(walls.plan.legs[one.leg].wall, []).append(one)
    return [block for k in range(len(walls.table.walls)) for block in _wall_blocks(walls, k, by_wall.get(k, []), density)]


def _wall_blocks(walls: Walls, number: int, laid: Sequence[Stone], density: float) -> list[Block]:
    """The blocks of one wall from its stones: by course, then those of its openings."""
    keys = walls.table.walls[number]
    own = density_of(keys, density)
    group = keys.group or keys.name
    stones: dict[int, list[Stone]] = {}
    for one in laid:
        stones.setdefault(one.course, []).append(one)
    around: list[Block] = []
    opened = 0
    for k, leg in enumerate(walls.plan.legs):
        if leg.wall != number:
            continue
        for f, facet in enumerate(leg.facets):
            for frame in walls.frames.get((k, f), []):
                opened += 1
                around += _frame_blocks(frame, leg, facet, f"{keys.name}.o{opened}", own, group, walls.layings[k])
    found = []
    for course in sorted(stones):
        for i, one in enumerate(stones[course], start=1):
            found.append(stone(f"{keys.name}.{course + 1}.{one.label or i}", one.parts, own, one.group or group))
    return found + around


def density_of(keys: BuildingWallTable, density: float) -> float:
    """Return the density of a wall [kg/m3]: its own, that of its masonry, or that of the material."""
    if keys.density is not None:
        return keys.density
    if keys.masonry is not None:
        return KN_PER_M3 * KINDS[keys.masonry].weight.mean
    return density


def _leg_stones(walls: Walls, number: int, leg: Leg) -> list[Stone]:
    """The stones of a leg; in odd courses they turn round the bends."""
    laying = walls.layings[number]
    if laying.leaves is not None:
        return list(leaves.stones(walls.plan, number, laying, walls.frames.get((number, 0), [])))
    found: list[tuple[int, list[Shell]]] = []
    before: dict[int, tuple[int, FacetStone]] = {}  # by course, the stone that reaches the mitre before the next facet
    first: dict[int, tuple[int, FacetStone]] = {}  # by course, the stone that reaches the mitre before the first facet
    for f, facet in enumerate(leg.facets):
        ends: dict[int, tuple[int, FacetStone]] = {}
        for piece in lay(walls.plan, number, f, laying, walls.frames.get((number, f), [])):
            parts = parts_of(piece, facet, leg.thickness)
            at = len(found)
            if piece.mitre[0] and piece.course in before and _turns(before[piece.course][1], piece):
                at = before[piece.course][0]
                found[at][1].extend(parts)
            else:
                found.append((piece.course, parts))
            if f == 0 and piece.mitre[0]:
                first[piece.course] = at, piece
            if piece.mitre[1]:
                ends[piece.course] = at, piece
        before = ends
    for course, (at, piece) in before.items() if leg.closed else ():
        if course in first and _turns(piece, first[course][1]) and first[course][0] != at:
            found[first[course][0]][1].extend(found[at][1])
            found[at] = course, []
    return [Stone(number, course, tuple(parts), NARROW * leg.thickness) for course, parts in found if parts]


def _turns(one: FacetStone, other: FacetStone) -> bool:
    """Return True if two stones next to a bend are one: in odd courses, where both are level."""
    level = polygons.is_rectangle(one.shape) and polygons.is_rectangle(other.shape)
    return one.course % 2 == 1 and level and one.shape.bounds[1::2] == other.shape.bounds[1::2]


def _frame_blocks(frame: Frame, leg: Leg, facet: Facet, name: str, density: float, group: str, laying: Laying) -> list[Block]:
    """The voussoirs or the lintel of an opening, and the stones at the back of a niche."""
    half = 0.5 * leg.thickness
    found = []
    for i, (kind, polygon) in enumerate(frame.pieces, start=1):
        found.append(Block(f"{name}.{kind[0]}{i}", *across(polygon, facet, (-half, half)), density, group))
    if frame.depth is not None:
        reach = (-half, half - frame.depth) if frame.keys.side == "left" else (-half + frame.depth, half)
        for i, shape in enumerate(openings.back(frame, laying.course, laying.unit), start=1):
            found.append(stone(f"{name}.s{i}", [across(ring, facet, reach) for ring in shape], density, group))
    return found
