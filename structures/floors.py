# SPDX-License-Identifier: GPL-3.0-or-later
"""Floors of a structure: rigid slabs that bear on seats in walls, and may be anchored to them.

    [[structure.floors]]
    height = 3.0                             # of its top [m]
    thickness = 0.25                         # [m]
    mass = 400.0                             # with what it carries [kg/m2]
    walls = ["south", "north"]               # groups or blocks in which it has its seats
    span = 90.0                              # direction in which it spans, from the x axis [degrees]
    strips = 6                               # of a flexible floor
    bearing = 0.2                            # depth of the seats [m]
    anchors = { spacing = 1.5, diameter = 0.016, yield_force = 40e3 }

A floor is one rigid block, a diaphragm: it neither bends nor shears nor stretches in its plane. One in strips, side by side along its span,
is flexible in plan: each of them moves with the walls that it bears on. It fills the clear space about a point, of any convex plan, reaches
into the walls named by the depth of its seats, which are cut out of their blocks, and ends short of the others by a gap. Seats are
joints as all others are: they bear the floor, hold it by friction and by what bears against its edges, and open when a wall leaves it.
Anchors are short ties from within the floor to the outer face of the wall, which pull alone. A floor above the walls lies on them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Annotated

import numpy as np
from pydantic import Field

from masonry_cd.foundation.errors import Faults, InputError, parse_table
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces, Polyhedron
from masonry_cd.mechanics.model.polygon import clip, polygon_area
from masonry_cd.mechanics.model.usual import DIAMETER, TIE_MODULUS, YIELDING
from structures.geometry.checks import check
from structures.geometry.compound_block import moved
from structures.geometry.prism import between, box
from structures.layout.pockets import width_of, with_pockets
from structures.layout.rooms import AT, Plans, Side, polygon_of, room
from structures.schema import HIGH, ArealMass, Height, Length, Place, Table, Thickness
from structures.ties import MODULI, MOST, SPACING, Anchor, ConvexSolids, PlacedBar, TieRowTable, anchors_at, bar_between

KEY = "floors"
SLIVER = 0.05  # of the thickness of a floor: less than this of a block next to its seat is refused
WEB = 0.1  # least width of what two floors leave of a wall between their seats [m]
OPPOSITE = 0.999  # cosine of the angle between the normals of two seats in one wall, at least
ACROSS = 0.7071  # cosine of the angle between a span and the normal of a wall that bears it, at least


class AnchorTable(Table):
    """The table ``anchors`` of a floor."""

    spacing: Annotated[Length, SPACING] = 1.5
    """of the anchors along each wall with a seat"""
    diameter: Annotated[Length, DIAMETER] = 0.016
    """of their rods"""
    length: Length = 1.0
    """length by which they reach into the floor"""
    plate: Length | None = None
    """side of their square plates on the outer face of the wall"""
    modulus: Annotated[float, Unit("Pa"), TIE_MODULUS] = Field(MODULI["steel"], gt=0.0)
    """Young's modulus"""
    yield_force: Annotated[float, Unit("N"), YIELDING] | None = Field(None, gt=0.0)
    """force at which an anchor yields or pulls out; by default none"""
    damping: float = Field(0.02, ge=0.0, lt=1.0)
    """share of the critical damping"""
    walls: tuple[str, ...] | None = Field(None, strict=False, min_length=1)
    """walls that it is tied to; on the others it rests; by default all in which it has seats"""


class SlabTable(Table):
    """Keys of a floor that do not say where it lies."""

    thickness: Thickness = Field()
    mass: ArealMass
    """mass with what it carries, over its own plan"""
    span: Annotated[float, Unit("degrees")] | None = Field(None, ge=-360.0, le=360.0)
    """direction in which it spans, from the x axis; of the walls named only those across it then bear it"""
    strips: int = Field(1, ge=1, le=100)
    """of a floor that is flexible in plan, side by side along its span; 1 for a rigid one"""
    bearing: Length = 0.2
    """depth of its seats in the walls"""
    gap: Height = 0.01
    """to walls that are not named"""
    anchors: AnchorTable | None = None
    """anchors that tie it to the walls, { spacing = 1.5, diameter = 0.016 }"""


class FloorTable(SlabTable):
    """One entry ``[[structure.floors]]``."""

    height: Annotated[Place, HIGH]
    """z of its top"""
    walls: tuple[str, ...] = Field(strict=False, min_length=1)
    """groups or blocks in which it has seats; * stands for anything"""
    inside: tuple[Place, Place] | None = Field(None, strict=False)
    """a point [x, y] between its walls; by default the middle of the walls"""
    name: str | None = Field(None, max_length=80)
    """name of its block and group; by default floor1, floor2 ..."""


@dataclass(frozen=True, eq=False)
class _Floor:
    """A floor in its room."""

    keys: FloorTable
    where: str  # its table
    name: str
    seats: tuple[Side, ...]
    sides: tuple[Side, ...]  # of the slab, counter-clockwise
    cut: tuple[Side, ...]  # of what is cut out for it: it reaches over the gaps
    tied: tuple[Side, ...]  # those of the seats that have anchors

    @property
    def plan(self) -> np.ndarray:
        """Corners (n, 2) of the slab [m]."""
        return polygon_of(self.sides)

    @property
    def span(self) -> np.ndarray:
        """Unit vector (2,) of the direction in which it spans."""
        return self.seats[0].normal if self.keys.span is None else _direction(self.keys.span)

    @property
    def pocket(self) -> Polyhedron:
        """Return the solid that is cut out for it."""
        return Polyhedron(*self._prism(polygon_of(self.cut)))

    @property
    def blocks(self) -> list[Block]:
        """The floor itself: a slab, or its strips."""
        density, count = self.keys.mass / self.keys.thickness, self.keys.strips
        if count == 1:
            return [Block(self.name, *self._prism(self.plan), density, self.name)]
        across = np.array([-self.span[1], self.span[0]])
        at = np.linspace(float((self.plan @ across).min()), float((self.plan @ across).max()), count + 1)
        strips = []
        for low, high in pairwise(at):
            upper = clip(self.plan, self.plan @ across - low, AT)
            strips.append(clip(upper, high - upper @ across, AT))
        return [Block(f"{self.name}.{k}", *self._prism(strip), density, self.name) for k, strip in enumerate(strips, start=1)]

    def _prism(self, plan: np.ndarray) -> tuple[np.ndarray, Faces]:
        """Over a convex polygon (n, 2); a rectangle along the axes is a box."""
        bottom, top = self.keys.height - self.keys.thickness, self.keys.height
        if len(plan) == 4 and all(abs(side.normal).max() == 1.0 for side in self.sides) and self.keys.strips == 1:
            (x0, y0), (x1, y1) = plan.min(axis=0).tolist(), plan.max(axis=0).tolist()
            return box((x0, y0, bottom), (x1, y1, top))
        return between(*(np.column_stack([plan, np.full(len(plan), z)]) for z in (bottom, top)))


def with_floors(
    blocks: Sequence[Block], tables: Sequence[FloorTable], places: Sequence[str] = ()
) -> tuple[list[Block], list[PlacedBar], list[str]]:
    """The blocks of a structure with its floors and the seats cut for them, the anchors, and a line on each floor.

    Args:
        blocks: sound ones.
        tables: of ``structure.floors``.
        places: keys that ask for each; by default those of ``structure.floors``.

    Raises:
        InputError: no wall where a floor is to bear, a seat deeper than its wall, slivers next to a seat: the first fault of each floor;
            and of the anchors of each floor in each wall.
    """
    faults, made, floors = Faults(), list(blocks), list[_Floor]()
    for i, keys in enumerate(tables):
        with faults.of():
            floor = _placed(made, keys, places[i] if places else f"structure.{KEY}[{i}]", keys.name or f"floor{i + 1}")
            made = [*_with_seats(made, floor), *floor.blocks]
            floors.append(floor)
    solids, bars = ConvexSolids.of(made), list[PlacedBar]()
    for floor in floors:
        if floor.keys.anchors is not None:
            for side in floor.tied:
                with faults.of():
                    bars += _anchored(solids, floor, side, floor.keys.anchors)
    faults.refuse()
    check(made)
    return made, bars, [*(_note(floor, bars) for floor in floors), *_thin_webs(floors)]


def _thin_webs(floors: Sequence[_Floor]) -> Iterator[str]:
    """A line on each wall of which two floors leave a thin web between their seats."""
    for (one, a), (other, b) in combinations([(floor, seat) for floor in floors for seat in floor.seats], 2):
        level = min(one.keys.height, other.keys.height) - max(f.keys.height - f.keys.thickness for f in (one, other))
        along = np.array([-a.normal[1], a.normal[0]])
        reach = [floor.plan @ along for floor in (one, other)]
        wall = -a.place - b.place  # its thickness, where one floor lies on its one side and the other beyond it
        web = wall - one.keys.bearing - other.keys.bearing
        facing = float(a.normal @ b.normal) < -OPPOSITE and AT < wall < max(a.depth, b.depth) + AT
        if facing and level > AT and min(r.max() for r in reach) - max(r.min() for r in reach) > AT and web < WEB - AT:
            yield (
                f'floors "{one.name}" and "{other.name}": of the wall of {wall:.3g} m between them their seats leave a web of '
                f"{1e3 * web:.0f} mm, {1e3 * WEB:.0f} mm or more would be a wall; take a shallower bearing, or a span along it"
            )


def _placed(blocks: Sequence[Block], keys: FloorTable, where: str, name: str) -> _Floor:
    """A floor in the room about its point.

    Raises:
        InputError: there is none, or no wall in which it can have its seats.
    """
    if any(name in (block.name, block.group) for block in blocks):
        raise InputError(f"{where}.name", f'"{name}" is the name of other blocks')
    bottom, top = keys.height - keys.thickness, keys.height
    solids = ConvexSolids.of(blocks)
    if keys.anchors is not None and keys.anchors.walls is not None:
        solids.any_of(keys.anchors.walls, f"{where}.anchors.walls")
    named = solids.any_of(keys.walls, f"{where}.walls")
    plans = Plans.between(blocks, bottom, top)
    if not named[plans.owner].any():  # it lies on the walls
        plans = Plans.between(blocks, bottom - 0.5 * keys.thickness, bottom)
    own = [loop for loop, owner in zip(plans.loops, plans.owner, strict=True) if named[owner]]
    if not own:
        raise InputError(f"{where}.height", f"no block of {', '.join(keys.walls)} stands at or below z = {bottom:g} to {top:g} m")
    extent = np.array([np.min([loop.min(axis=0) for loop in own], axis=0), np.max([loop.max(axis=0) for loop in own], axis=0)])
    point = extent.mean(axis=0) if keys.inside is None else np.array(keys.inside)
    within = plans.around(point)
    if within or not ((extent[0] < point) & (point < extent[1])).all():
        what = f'block "{blocks[plans.owner[within[0]]].name}" stands there' if within else "it lies outside the walls"
        raise InputError(f"{where}.inside", f"no room about x = {point[0]:.4g} m, y = {point[1]:.4g} m at this height: {what}")
    sides = room(plans, point, extent)
    seats = [side for side in sides if named[list(side.owners)].any()]
    if not seats:
        raise InputError(
            f"{where}.walls", f"none of {', '.join(keys.walls)} bounds the room about x = {point[0]:.4g} m, y = {point[1]:.4g} m"
        )
    seats = _spanned(keys, seats, where)
    shallow = min(seats, key=lambda side: side.depth)
    if keys.bearing > shallow.depth + AT:
        raise InputError(
            f"{where}.bearing", f"must be at most the depth of its wall in the {shallow.name}, {shallow.depth:.4g} m, got {keys.bearing:g}"
        )
    into = [keys.bearing if side in seats else 0.0 for side in sides]
    short = [keys.gap if side.owners and side not in seats else 0.0 for side in sides]
    slab = tuple(side.moved(a - b) for side, a, b in zip(sides, into, short, strict=True))
    cut = tuple(side.moved(a) for side, a in zip(sides, into, strict=True))
    return _Floor(keys, where, name, tuple(seats), slab, cut, _tied(solids, tuple(seats), keys.anchors, where))


def _direction(degrees: float) -> np.ndarray:
    """Unit vector (2,) at an angle from the x axis; a quarter turn is exact."""
    angle = math.radians(degrees)
    return np.round([math.cos(angle), math.sin(angle)], 15)


def _spanned(keys: FloorTable, seats: list[Side], where: str) -> list[Side]:
    """Those of the sides with seats that lie across the span; all without one.

    Raises:
        InputError: there is none.
    """
    if keys.span is None:
        return seats
    along = _direction(keys.span)
    found = [side for side in seats if abs(side.normal @ along) > ACROSS]
    if not found:
        raise InputError(f"{where}.span", f"none of {', '.join(keys.walls)} lies across {keys.span:g} degrees next to it")
    return found


def _with_seats(blocks: Sequence[Block], floor: _Floor) -> list[Block]:
    """The blocks with a floor cut out of them; slivers next to it go to the stones around.

    Raises:
        InputError: a sliver that no stone next to it can take.
    """
    thin = SLIVER * floor.keys.thickness
    made = with_pockets(blocks, [floor.pocket], thin)
    before, names = {id(block) for block in blocks}, {block.name: block for block in blocks}
    for block in made:
        if id(block) in before:
            continue
        whole = names.get(block.name) or names[block.name.rpartition(".s")[0]]
        width = width_of(block)
        if width < min(thin, 0.999 * width_of(whole)):
            raise InputError(
                floor.where,
                f'of block "{whole.name}" a sliver of {1e3 * width:.3g} mm would remain next to it; another height, thickness or bearing',
            )
    return made


def _anchored(solids: ConvexSolids, floor: _Floor, side: Side, keys: AnchorTable) -> Iterator[PlacedBar]:
    """The anchors of a floor on one side, evenly along its seat, from within it to the outer face of the wall."""
    where = f"{floor.where}.anchors"
    along = np.array([-side.normal[1], side.normal[0]])
    if keys.length > float(np.ptp(floor.plan @ side.normal)):
        raise InputError(f"{where}.length", f"must be at most that of the floor there, got {keys.length:g}")
    edge = floor.plan[np.abs(floor.plan @ side.normal - side.place - floor.keys.bearing) < AT] @ along
    wanted = float(np.ptp(edge)) / keys.spacing
    if not wanted <= MOST:
        raise InputError(f"{where}.spacing", f"makes {wanted:.4g} anchors on a wall, at most {MOST} are allowed")
    count = max(1, round(wanted))
    axis = int(np.abs(side.normal).argmax())
    turn = np.eye(2) if abs(side.normal[axis]) == 1.0 else np.array([side.normal, along])  # (2, 2) to axes of which one is the normal
    axis, sign = (axis, int(side.normal[axis])) if (turn == np.eye(2)).all() else (0, 1)
    turned = solids if (turn == np.eye(2)).all() else ConvexSolids.of([_turned(block, turn) for block in solids.blocks])
    line = {"along": "xy"[axis], "height": floor.keys.height - 0.5 * floor.keys.thickness}
    row = parse_table(TieRowTable, line | keys.model_dump(exclude={"spacing", "length", "walls"}), where)
    allowed = _in_wall(turned, axis, sorted((sign * side.place, sign * side.far)))
    for k in range(count):
        on = side.normal * side.place + along * (edge.min() + (k + 0.5) * float(np.ptp(edge)) / count)
        through, inner = (np.append(turn @ point, row.height) for point in (on, on - side.normal * keys.length))
        through[axis] = 0.0
        slab = _slab_at(solids, floor, on - side.normal * keys.length)
        for anchor in anchors_at(turned, row, axis, through, allowed, sign, where):
            bar = bar_between(turned, row, Anchor(slab, inner, 1.0), anchor, where, f"{floor.name}.{side.name}{k + 1}")
            yield bar._replace(points=np.column_stack([bar.points[:, :2] @ turn, bar.points[:, 2]]))


def _turned(block: Block, turn: np.ndarray) -> Block:
    """A block with its plan turned by (2, 2)."""

    def put(points: np.ndarray) -> np.ndarray:
        return np.column_stack([points[:, :2] @ turn.T, points[:, 2]])

    return moved(block, put)


def _slab_at(solids: ConvexSolids, floor: _Floor, point: np.ndarray) -> int:
    """The number of the slab, or of the strip, in which a point (2,) lies, or that is nearest to it."""
    own = [i for i, block in enumerate(solids.blocks) if block.group == floor.name]
    across = np.array([-floor.span[1], floor.span[0]])
    return min(own, key=lambda i: abs(float((solids.blocks[i].vertices[:, :2] @ across).mean() - point @ across)))


def _tied(solids: ConvexSolids, seats: tuple[Side, ...], keys: AnchorTable | None, where: str) -> tuple[Side, ...]:
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
            raise InputError(f"{where}.anchors.walls", f'the floor has no seat in "{wall}"')
        tied += [side for side in sides if side not in tied]
    return tuple(tied)


def _in_wall(solids: ConvexSolids, axis: int, reach: Sequence[float]) -> np.ndarray:
    """(B,) the free blocks within the thickness of a wall, which it has along an axis between two places [m]."""
    parts = (solids.low[:, axis] >= reach[0] - AT) & (solids.high[:, axis] <= reach[1] + AT)
    found = np.zeros(len(solids.blocks), dtype=bool)
    found[solids.owner[parts]] = True
    return found & np.array([not block.fixed for block in solids.blocks])


def _note(floor: _Floor, bars: Sequence[PlacedBar]) -> str:
    """A floor as text."""
    size, tonnes = np.ptp(floor.plan, axis=0), floor.keys.mass * polygon_area(floor.plan) / 1e3
    kind = "rigid" if floor.keys.strips == 1 else f"of {floor.keys.strips} strips"
    count = len({bar.keys["name"] for bar in bars if bar.where == f"{floor.where}.anchors"})
    anchors = f", {count} anchors" if count else ""
    return (
        f'floor "{floor.name}": {kind}, {size[0]:.4g} m by {size[1]:.4g} m, {tonnes:.4g} t, its top at z = {floor.keys.height:.4g} m, on '
        f"seats of {floor.keys.bearing:.3g} m in the {', '.join(side.name for side in floor.seats)}{anchors}"
    )
