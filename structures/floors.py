# SPDX-License-Identifier: GPL-3.0-or-later
"""Floors of a structure: rigid slabs that bear on seats in the walls of a room, and may be anchored to them.

    [[structure.floors]]
    height = 3.0                             # of its top [m]
    thickness = 0.25                         # [m]
    mass = 400.0                             # with what it carries [kg/m2]
    walls = ["south", "north"]               # groups or blocks in which it has its seats
    bearing = 0.2                            # depth of the seats [m]
    anchors = { spacing = 1.5, diameter = 0.016, yield_force = 40e3 }

A floor is one rigid block, a diaphragm: it neither bends nor shears nor stretches in its plane. It fills the clear room about a point,
reaches into the walls named by the depth of its seats, which are cut out of their blocks, and ends short of the others by a gap. Seats are
joints as all others are: they bear the floor, hold it by friction and by what bears against its edges, and open when a wall leaves it.
Anchors are short ties from within the floor to the outer face of the wall, which pull alone. A floor above the walls lies on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from structures.geometry.checks import check
from structures.geometry.prism import box
from structures.layout.rooms import Boxes, Side, room
from structures.layout.seats import without_box
from structures.schema import ArealMass, Height, Length, Place, Table
from structures.ties import MODULI, MOST, Anchor, Bar, Solids, TieRowTable, anchors_at, bar_between

KEY = "floors"
SLIVER = 0.05  # of the thickness of a floor: less than this of a block beside its seat is refused
AT = 1e-6  # [m]


class AnchorTable(Table):
    """The table ``anchors`` of a floor."""

    spacing: Length = 1.5
    """of the anchors along each wall with a seat"""
    diameter: Length = 0.016
    """of their rods"""
    length: Length = 1.0
    """by which they reach into the floor"""
    plate: Length | None = None
    """side of their square plates on the outer face of the wall"""
    modulus: Annotated[float, Unit("Pa")] = Field(MODULI["steel"], gt=0.0)
    """Young's modulus"""
    yield_force: Annotated[float, Unit("N")] | None = Field(None, gt=0.0)
    """at which one yields or pulls out; by default never"""
    damping: float = Field(0.02, ge=0.0, lt=1.0)
    """share of the critical damping"""
    walls: tuple[str, ...] | None = Field(None, strict=False, min_length=1)
    """that it is tied to; on the others it rests; by default all in which it has seats"""


class FloorTable(Table):
    """One entry ``[[structure.floors]]``."""

    height: Place
    """z of its top"""
    thickness: Length = Field()
    mass: ArealMass
    """with what it carries, over its own plan"""
    walls: tuple[str, ...] = Field(strict=False, min_length=1)
    """groups or blocks in which it has seats; * stands for anything"""
    inside: tuple[Place, Place] | None = Field(None, strict=False)
    """a point [x, y] of its room; by default the middle of the walls"""
    bearing: Length = 0.2
    """depth of its seats in the walls"""
    gap: Height = 0.01
    """to walls that are not named"""
    anchors: AnchorTable | None = None
    """which tie it to the walls, { spacing = 1.5, diameter = 0.016 }"""
    name: str | None = Field(None, max_length=80)
    """of its block and group; by default floor1, floor2 ..."""


@dataclass(frozen=True, eq=False)
class _Floor:
    """A floor in its room."""

    keys: FloorTable
    where: str  # its table
    name: str
    seats: tuple[Side, ...]
    low: np.ndarray  # (3,) [m]
    high: np.ndarray  # (3,) [m]
    seat_low: np.ndarray  # (3,) of what is cut out for it: it reaches over the gaps [m]
    seat_high: np.ndarray  # (3,) [m]
    tied: tuple[Side, ...]  # those of the seats that have anchors

    @property
    def block(self) -> Block:
        """The floor itself."""
        return Block(self.name, *box(tuple(self.low), tuple(self.high)), self.keys.mass / self.keys.thickness, self.name)


def with_floors(blocks: Sequence[Block], tables: object) -> tuple[list[Block], list[Bar], list[str]]:
    """The blocks of a structure with its floors and the seats cut for them, the anchors, and a line on each floor.

    Args:
        blocks: sound ones.
        tables: the value of ``structure.floors``.

    Raises:
        InputError: a key that is wrong, no wall where a floor is to bear, a seat deeper than its wall, slivers beside a seat.
    """
    if not isinstance(tables, (list, tuple)) or not all(isinstance(table, Mapping) for table in tables):
        raise InputError(f"structure.{KEY}: every floor is a table of its own, headed [[structure.{KEY}]]")
    made, floors = list(blocks), list[_Floor]()
    for i, table in enumerate(tables):
        where = f"structure.{KEY}[{i}]"
        keys = parse_table(FloorTable, table, where)
        floor = _placed(made, keys, where, keys.name or f"floor{i + 1}")
        made = [*_with_seats(made, floor), floor.block]
        floors.append(floor)
    check(made)
    solids = Solids.of(made)
    bars = [bar for floor in floors for bar in _anchored(solids, floor)]
    return made, bars, [_note(floor, bars) for floor in floors]


def _placed(blocks: Sequence[Block], keys: FloorTable, where: str, name: str) -> _Floor:
    """A floor in the room about its point."""
    if any(name in (block.name, block.group) for block in blocks):
        raise InputError(f'{where}.name: "{name}" is the name of other blocks')
    bottom, top = keys.height - keys.thickness, keys.height
    solids = Solids.of(blocks)
    named = np.any([solids.members(wall, f"{where}.walls") for wall in keys.walls], axis=0)
    boxes = Boxes.between(blocks, bottom, top)
    if not named[boxes.owner].any():  # it lies on the walls
        boxes = Boxes.between(blocks, bottom - 0.5 * keys.thickness, bottom)
    its = named[boxes.owner]
    if not its.any():
        raise InputError(f"{where}.height: no block of {', '.join(keys.walls)} stands at or below z = {bottom:g} to {top:g} m")
    extent = np.array([boxes.low[its].min(axis=0), boxes.high[its].max(axis=0)])
    point = extent.mean(axis=0) if keys.inside is None else np.array(keys.inside)
    within = np.flatnonzero(boxes.around(point))
    if len(within) or not ((extent[0] < point) & (point < extent[1])).all():
        what = f'block "{blocks[boxes.owner[within[0]]].name}" stands there' if len(within) else "it lies outside the walls"
        raise InputError(f"{where}.inside: no room about x = {point[0]:.4g} m, y = {point[1]:.4g} m at this height: {what}")
    sides = room(boxes, point, extent)
    seats = tuple(side for side in sides if named[list(side.owners)].any())
    if not seats:
        raise InputError(f"{where}.walls: none of {', '.join(keys.walls)} bounds the room about x = {point[0]:.4g} m, y = {point[1]:.4g} m")
    shallow = min(seats, key=lambda side: side.depth)
    if keys.bearing > shallow.depth + AT:
        raise InputError(
            f"{where}.bearing: must be at most the depth of its wall in the {shallow.name}, {shallow.depth:.4g} m, got {keys.bearing:g}"
        )
    low, high, seat_low, seat_high = (np.array([0.0, 0.0, z]) for z in (bottom, top, bottom, top))
    for side in sides:
        into = keys.bearing if side in seats else 0.0
        short = keys.gap if side.owners and side not in seats else 0.0
        (seat_high if side.sign > 0 else seat_low)[side.axis] = side.place + side.sign * into
        (high if side.sign > 0 else low)[side.axis] = side.place + side.sign * (into - short)
    return _Floor(keys, where, name, seats, low, high, seat_low, seat_high, _tied(solids, seats, keys.anchors, where))


def _with_seats(blocks: Sequence[Block], floor: _Floor) -> Iterator[Block]:
    """The blocks with a floor cut out of them."""
    for block in blocks:
        if block.fixed:
            yield block
            continue
        try:
            yield from without_box(block, floor.seat_low, floor.seat_high, SLIVER * floor.keys.thickness)
        except InputError as fault:
            raise InputError(f"{floor.where}: {fault}; another height, thickness or bearing") from None


def _anchored(solids: Solids, floor: _Floor) -> Iterator[Bar]:
    """The anchors of a floor, evenly along its seats, from within it to the outer face of the wall."""
    keys, where = floor.keys.anchors, f"{floor.where}.anchors"
    if keys is None:
        return
    slab = next(i for i, block in enumerate(solids.blocks) if block.name == floor.name)
    for side in floor.tied:
        other = 1 - side.axis
        if keys.length > floor.high[side.axis] - floor.low[side.axis]:
            raise InputError(f"{where}.length: must be at most that of the floor there, got {keys.length:g}")
        length = floor.high[other] - floor.low[other]
        wanted = float(length) / keys.spacing
        if not wanted <= MOST:
            raise InputError(f"{where}.spacing: makes {wanted:.4g} anchors on a wall, at most {MOST} are taken")
        count = max(1, round(wanted))
        line = {"along": "xy"[side.axis], "height": float(0.5 * (floor.low[2] + floor.high[2]))}
        row = parse_table(TieRowTable, line | keys.model_dump(exclude={"spacing", "length", "walls"}), where)
        allowed = _in_wall(solids, side)
        for k in range(count):
            through = np.array([0.0, 0.0, row.height])
            through[other] = floor.low[other] + (k + 0.5) * length / count
            inner = through.copy()
            inner[side.axis] = side.place - side.sign * keys.length
            for anchor in anchors_at(solids, row, side.axis, through, allowed, side.sign, where):
                yield bar_between(solids, row, Anchor(slab, inner, 1.0), anchor, where, f"{floor.name}.{side.name}{k + 1}")


def _tied(solids: Solids, seats: tuple[Side, ...], keys: AnchorTable | None, where: str) -> tuple[Side, ...]:
    """Those of the sides with seats on which a floor is anchored.

    Raises:
        InputError: a wall in which it has no seat.
    """
    if keys is None or keys.walls is None:
        return seats
    tied: list[Side] = []
    for wall in keys.walls:
        own = solids.members(wall, f"{where}.anchors.walls")
        sides = [side for side in seats if own[list(side.owners)].any()]
        if not sides:
            raise InputError(f'{where}.anchors.walls: the floor has no seat in "{wall}"')
        tied += [side for side in sides if side not in tied]
    return tuple(tied)


def _in_wall(solids: Solids, side: Side) -> np.ndarray:
    """(B,) the free blocks within the thickness of the wall on a side."""
    near, far = sorted((side.place, side.far))
    parts = (solids.low[:, side.axis] >= near - AT) & (solids.high[:, side.axis] <= far + AT)
    found = np.zeros(len(solids.blocks), dtype=bool)
    found[solids.owner[parts]] = True
    return found & np.array([not block.fixed for block in solids.blocks])


def _note(floor: _Floor, bars: Sequence[Bar]) -> str:
    """A floor in words."""
    size = floor.high - floor.low
    tonnes = floor.keys.mass * size[0] * size[1] / 1e3
    count = len({bar.keys["name"] for bar in bars if bar.where == f"{floor.where}.anchors"})
    anchors = f", {count} anchors" if count else ""
    return (
        f'floor "{floor.name}": rigid, {size[0]:.4g} m by {size[1]:.4g} m, {tonnes:.4g} t, its top at z = {floor.keys.height:.4g} m, on '
        f"seats of {floor.keys.bearing:.3g} m in the {', '.join(side.name for side in floor.seats)}{anchors}"
    )
