# SPDX-License-Identifier: GPL-3.0-or-later
"""Ties of a structure: rods of steel and beams of timber on straight level lines, anchored where the line leaves the masonry.

    [[structure.ties]]
    along = "y"                      # across a nave that runs along x
    height = 8.0                     # of the line [m]
    at = [4.0, 12.0, 20.0]           # where along the other axis [m], or number = 3, or spacing = 8.0
    parts = ["nave_walls"]           # on whose outermost faces it ends; two names: one for each end
    diameter = 0.03                  # [m]
    plate = 0.5                      # side of its square anchor plates [m]
    yield_force = 160e3              # [N]

Each line becomes a bar between the block at its one end and that at its other (:mod:`loads.bars`): it pulls, never pushes, yields, and does
not touch what lies between. A plate hands the pull on to all blocks that it covers on the face of the wall, by the area that it covers of
each: as a bundle of bars that share the section, and that do not hold neighbouring blocks together. A point on a joint counts for the
block below it, or on the lower side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import product
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from masonry_cd.foundation.errors import Faults, InputError, of_each, suggest
from masonry_cd.foundation.fields import check_tension
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.polygon import loop_planes
from masonry_cd.mechanics.model.usual import DIAMETER, LENGTHS, TENSION, TIE_MODULUS, YIELDING
from structures.schema import HIGH, Area, Length, Place, Table

KEY = "ties"
MODULI = {"steel": 2.1e11, "timber": 1.1e10}  # [Pa]
AXES = {"x": 0, "y": 1}
GRID = 12  # points along the side of a plate
FLUSH = 0.25  # of a plate's side: faces that stand back by more are not under it
LEAST = 0.5  # of a plate has to lie on the wall: what hangs over bends and bears nothing
NUDGE = 1e-7  # [m]: a line in a joint is evaluated this much lower
MOST = 500  # ties of a table
SIDE = Usual(3e-4, 0.6, "from strips of 0.3 mm to beams of 0.6 m", LENGTHS)
SPACING = Usual(0.1, 30.0, "ties and anchors are 0.3 to 10 m apart", LENGTHS)


class LineTable(Table):
    """The keys of ties that say where they lie, and on what they hold."""

    along: Literal["x", "y"]
    """axis along which it lies"""
    height: Annotated[Place, HIGH]
    """z of its line, in the coordinates of the structure"""
    at: tuple[Place, ...] | None = Field(None, strict=False, min_length=1)
    """where along the other axis"""
    number: int | None = Field(None, ge=1, le=MOST)
    """or their number, evenly over the parts; by default one in the middle"""
    spacing: Annotated[Length, SPACING] | None = None
    """or as many as fit at this distance"""
    parts: tuple[str, ...] | None = Field(None, strict=False, min_length=1, max_length=2)  # fmt: skip
    """groups or blocks on whose outermost faces it ends, one name for each end or for both; * stands for anything; by default whatever
    is outermost"""
    anchor: Literal["face", "middle"] = "face"
    """where in the block it ends: on the outer face, or halfway through"""
    plate: Length | None = None
    """side of its square anchor plates, which spread the pull over blocks"""
    material: Literal["steel", "timber"] = "steel"
    """material, which sets the modulus"""
    modulus: Annotated[float, Unit("Pa"), TIE_MODULUS] | None = Field(None, gt=0.0)
    """Young's modulus; by default 2.1e11 of steel, 1.1e10 of timber"""
    name: str | None = Field(None, max_length=80)
    """for reports; by default tie1, tie2 ..."""

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if sum(value is not None for value in (self.at, self.number, self.spacing)) > 1:
            raise ValueError("give one of at, number and spacing")
        return self


class TieRowTable(LineTable):
    """One entry ``[[structure.ties]]``."""

    diameter: Annotated[Length, DIAMETER] | None = None
    """diameter of its section"""
    area: Area | None = None
    """area of its section, instead of a diameter"""
    section: tuple[Annotated[Length, SIDE], Annotated[Length, SIDE]] | None = Field(None, strict=False)
    """width and depth of its section, instead of a diameter"""
    yield_force: Annotated[float, Unit("N"), YIELDING] | None = Field(None, gt=0.0)
    """force at which it or its anchorage yields; by default none"""
    tension: Annotated[float, Unit("N"), TENSION] = Field(0.0, ge=0.0)
    """at the start"""
    damping: float = Field(0.02, ge=0.0, lt=1.0)
    """share of the critical damping"""
    from_start: bool = False
    """there while elastic joints take up the weight; else it keeps its tension meanwhile"""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if sum(value is not None for value in (self.diameter, self.area, self.section)) != 1:
            raise ValueError("give exactly one of diameter, area and section")
        check_tension(self.tension, self.yield_force)
        return self

    @property
    def size(self) -> float:
        """Area of the section [m2]."""
        if self.section is not None:
            return self.section[0] * self.section[1]
        return self.area if self.area is not None else 0.25 * math.pi * (self.diameter or 0.0) ** 2


class PlacedBar(NamedTuple):
    """A tie between two blocks, or one of the bars that it is spread over."""

    where: str  # the table that requests it
    blocks: tuple[str, str]
    points: np.ndarray  # (2, 3) [m]
    keys: Mapping[str, Any]  # name, area, modulus, tension, yield_force, damping, from_start, as a load of kind "tie" takes them

    def load(self) -> dict[str, Any]:
        """The table of a load."""
        return {"kind": "tie", "blocks": list(self.blocks), "points": self.points.tolist(), **self.keys}


def lines_of(bars: Sequence[PlacedBar]) -> list[np.ndarray]:
    """A line (2, 3) for each tie [m], between the means of what its bars hold on to."""
    found = []
    for name in dict.fromkeys(bar.keys["name"] for bar in bars):
        mine = [bar for bar in bars if bar.keys["name"] == name]
        found.append(np.average([bar.points for bar in mine], axis=0, weights=[bar.keys["area"] for bar in mine]))
    return found


class Anchor(NamedTuple):
    """A block that an end holds on to."""

    block: int
    point: np.ndarray  # (3,) [m]
    share: float  # of the pull


def ties_of(blocks: Sequence[Block], tables: Sequence[TieRowTable]) -> tuple[list[PlacedBar], list[str]]:
    """The bars of all ties of a structure, and a line on each table.

    Args:
        blocks: of the structure.
        tables: of ``structure.ties``.

    Raises:
        InputError: parts that no block has, an end that lies in no block: the first fault of each table.
    """
    if not tables:
        return [], []
    faults, solids, bars, notes = Faults(), ConvexSolids.of(blocks), list[PlacedBar](), list[str]()
    for i, keys in enumerate(tables):
        where = f"structure.{KEY}[{i}]"
        with faults.of():
            solids.any_of(keys.parts or (), f"{where}.parts")
            made = list(_row(solids, keys, where, keys.name or f"tie{i + 1}"))
            if {bar.keys["name"] for bar in bars} & {bar.keys["name"] for bar in made}:
                raise InputError(f"{where}.name", f'"{keys.name}" is the name of other ties')
            bars += made
            notes.append(_note(keys, keys.name or f"tie{i + 1}", made))
    faults.refuse()
    return bars, notes


@dataclass(frozen=True, eq=False)
class ConvexSolids:
    """The convex parts of all blocks, for lines through them."""

    blocks: Sequence[Block]
    owner: np.ndarray  # (P,)
    low: np.ndarray  # (P, 3) [m]
    high: np.ndarray  # (P, 3) [m]
    planes: list[tuple[np.ndarray, np.ndarray]]  # outward normals (F, 3) and offsets (F,) of each

    @classmethod
    def of(cls, blocks: Sequence[Block]) -> ConvexSolids:
        parts = [(i, part) for i, block in enumerate(blocks) for part in block.convex_parts]
        planes = [loop_planes([part.vertices[list(face)] for face in part.faces]) for _, part in parts]
        low, high = (np.array([edge(part.vertices, axis=0) for _, part in parts]) for edge in (np.min, np.max))
        return cls(blocks, np.array([i for i, _ in parts]), low, high, planes)

    def along(self, axis: int, through: np.ndarray, allowed: np.ndarray) -> list[tuple[float, float, int]]:
        """Where a line along an axis through a point (3,) enters and leaves each part of the blocks allowed (B,) bool, and its block."""
        others = [k for k in range(3) if k != axis]
        near = (self.low[:, others] <= through[others]) & (through[others] <= self.high[:, others])
        found = []
        for p in np.flatnonzero(near.all(axis=1) & allowed[self.owner]):
            normals, offsets = self.planes[p]
            slope, rest = normals[:, axis], offsets - np.sum(normals[:, others] * through[others], axis=1)
            level = np.abs(slope) < 1e-12
            if (rest[level] < 0.0).any():
                continue
            cut = rest[~level] / slope[~level]
            enters, leaves = cut[slope[~level] < 0.0].max(), cut[slope[~level] > 0.0].min()
            if enters < leaves:
                found.append((float(enters), float(leaves), int(self.owner[p])))
        return found

    def any_of(self, names: Sequence[str], where: str) -> np.ndarray:
        """(B,) the blocks of any of some names, groups or patterns. ``where`` is the key that names them.

        Raises:
            InputError: all names that no block has.
        """
        return np.any([np.zeros(len(self.blocks), dtype=bool), *of_each(lambda name: self.members(name, where), names)], axis=0)

    def members(self, name: str | None, where: str) -> np.ndarray:
        """(B,) the blocks of a name, a group or a pattern; all without one. ``where`` is the key that names them."""
        if name is None:
            return np.ones(len(self.blocks), dtype=bool)
        found = np.array([fnmatchcase(block.name, name) or fnmatchcase(block.group, name) for block in self.blocks])
        if not found.any():
            groups = list(dict.fromkeys(block.group for block in self.blocks))
            raise InputError(where, f'"{name}" is not a group or block{suggest(name, groups)}; groups: {", ".join(groups)}')
        return found


def _row(solids: ConvexSolids, keys: TieRowTable, where: str, name: str) -> Iterator[PlacedBar]:
    """The bars of a table."""
    axis = AXES[keys.along]
    names = keys.parts or (None,)
    sides = [solids.members(part, f"{where}.parts") for part in (names[0], names[-1])]
    if len(names) == 2:  # the first of the two lies on the lower side
        middle = [np.mean([solids.blocks[b].vertices[:, axis].mean() for b in np.flatnonzero(side).tolist()]) for side in sides]
        sides = sides if middle[0] <= middle[1] else sides[::-1]
    places = places_of(solids, keys, axis, sides[0] | sides[1], where)
    for k, place in enumerate(places):
        through = np.empty(3)
        through[axis], through[1 - axis], through[2] = 0.0, place, keys.height
        ends = [anchors_at(solids, keys, axis, through, side, sign, where) for side, sign in zip(sides, (-1, 1), strict=True)]
        if {anchor.block for anchor in ends[0]} & {anchor.block for anchor in ends[1]}:
            both = solids.blocks[ends[0][0].block].name
            raise InputError(where, f'{_line(keys, place)} has both ends in block "{both}"; a tie needs two')
        for a, b in product(*ends):
            yield bar_between(solids, keys, a, b, where, name if len(places) == 1 else f"{name}.{k + 1}")


def bar_between(solids: ConvexSolids, keys: TieRowTable, a: Anchor, b: Anchor, where: str, name: str) -> PlacedBar:
    """The bar of a tie between two of its anchors, with its share of the section and of the forces."""
    share = a.share * b.share
    shared = {
        "name": name,
        "area": share * keys.size,
        "modulus": keys.modulus or MODULI[keys.material],
        "tension": share * keys.tension,
        "from_start": keys.from_start,
        "damping": keys.damping,
    }
    limit = {} if keys.yield_force is None else {"yield_force": share * keys.yield_force}
    held = (solids.blocks[a.block].name, solids.blocks[b.block].name)
    return PlacedBar(where, held, np.array([a.point, b.point]), shared | limit)


def places_of(solids: ConvexSolids, keys: LineTable, axis: int, allowed: np.ndarray, where: str) -> list[float]:
    """Where the ties of a table lie along the other axis [m]."""
    if keys.at is not None:
        return list(keys.at)
    free = np.array([not block.fixed for block in solids.blocks])
    there = (allowed & free)[solids.owner]
    if not ((solids.low[:, 2] <= keys.height) & (keys.height <= solids.high[:, 2]) & there).any():
        raise InputError(f"{where}.height", f"no block of the parts stands at z = {keys.height:g} m")
    low, high = float(solids.low[there, 1 - axis].min()), float(solids.high[there, 1 - axis].max())
    wanted = keys.number or ((high - low) / keys.spacing if keys.spacing else 1.0)
    if not wanted <= MOST:
        raise InputError(f"{where}.spacing", f"makes {wanted:.4g} ties, at most {MOST} are allowed")
    count = max(1, round(wanted))
    apart = keys.spacing or (high - low) / count
    return [0.5 * (low + high) + (k - 0.5 * (count - 1)) * apart for k in range(count)]


def anchors_at(
    solids: ConvexSolids, keys: TieRowTable, axis: int, through: np.ndarray, allowed: np.ndarray, sign: int, where: str
) -> list[Anchor]:
    """The blocks that an end holds on to: the lower end of a line for sign -1, the upper for +1.

    Raises:
        InputError: the line, or all of its plate, meets no block.
    """
    found = _outermost(solids, axis, through, allowed, sign, keys.anchor)
    if found is None:
        of_parts = f" of {', '.join(keys.parts)}" if keys.parts else ""
        raise InputError(
            where, f"{_line(keys, float(through[1 - axis]))} meets no block{of_parts}: its end would hold on to nothing (an opening?)"
        )
    if keys.plate is None:
        point = through.copy()
        point[axis] = found[0]
        return [Anchor(found[1], point, 1.0)]
    steps = ((np.arange(GRID) + 0.5) / GRID - 0.5) * keys.plate
    under: dict[int, list[np.ndarray]] = {}
    for across, up in product(steps, steps):
        point = through.copy()
        point[1 - axis] += across
        point[2] += up
        there = _outermost(solids, axis, point, allowed, sign, keys.anchor)
        if there is not None and abs(there[0] - found[0]) <= FLUSH * keys.plate:
            point[axis] = there[0]
            under.setdefault(there[1], []).append(point)
    count = sum(len(points) for points in under.values())
    if count < LEAST * GRID**2:
        share = f"{100 * count / GRID**2:.2g} %" if count else "next to nothing"
        raise InputError(f"{where}.plate", f"{keys.plate:g} m is so wide that {share} of it lies on the wall; at least half has to")
    return [Anchor(block, np.mean(points, axis=0), len(points) / count) for block, points in under.items()]


def _outermost(
    solids: ConvexSolids, axis: int, through: np.ndarray, allowed: np.ndarray, sign: int, anchor: str
) -> tuple[float, int] | None:
    """Where along the axis an end of a line lies [m], and its block; None where the line meets none."""
    lower = through.copy()
    lower[[1 - axis, 2]] -= NUDGE
    found = solids.along(axis, lower, allowed)
    if not found:
        return None
    enters, leaves, block = min(found) if sign < 0 else max(found, key=lambda part: part[1])
    if anchor == "middle":
        return 0.5 * (enters + leaves), block
    return (enters if sign < 0 else leaves), block


def _line(keys: TieRowTable, place: float) -> str:
    """A line as text."""
    return f"the line along {keys.along} at {'yx'[AXES[keys.along]]} = {place:.4g} m, z = {keys.height:.4g} m"


def _note(keys: TieRowTable, name: str, bars: Sequence[PlacedBar]) -> str:
    """A table as text."""
    count = len({bar.keys["name"] for bar in bars})
    longest = max(math.hypot(*(bar.points[1] - bar.points[0])) for bar in bars)
    held = len({block for bar in bars for block in bar.blocks})
    limit = "" if keys.yield_force is None else f", yielding at {keys.yield_force / 1e3:.4g} kN"
    return (
        f'ties "{name}": {count} of {keys.material} along {keys.along} at z = {keys.height:.4g} m, {longest:.4g} m long, '
        f"{1e4 * keys.size:.4g} cm2{limit}, on {held} blocks"
    )
