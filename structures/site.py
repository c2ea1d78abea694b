# SPDX-License-Identifier: GPL-3.0-or-later
"""Several structures in one scene: each is built by itself, put in its place and named, and they stand on one ground.

A table [[structures]] has the keys of [structure] and three of its own,

    name     before its blocks and groups: "left.v1" of the group "left.arch"
    at       where its origin lies [m]
    rotate   about the upright axis through its origin, counter-clockwise seen from above [degrees]

Blocks of different structures touch and pound as any blocks do. Where the supports of two structures overlap in plan, an upright plane
parts them: that which leaves the widest space between all that stands, in its middle. A ground that is one upright prism is first drawn out
over the plan of all of them, so that what falls between two structures lands.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, Field, WithJsonSchema
from scipy.spatial import ConvexHull

from masonry_cd.foundation.errors import Fault, InputError, parse_table
from masonry_cd.foundation.fields import Vector
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.components import connected_components
from masonry_cd.mechanics.model.geometry import Polyhedron
from structures import MadeStructure, make
from structures.geometry.checks import check
from structures.geometry.convex import halves
from structures.geometry.prism import box
from structures.schema import Table
from structures.ties import PlacedBar

KEYS = ("name", "at", "rotate")
LEVEL = 1e-9  # of a size: closer than this is one height, and structures that overlap by less touch
FARTHEST = 1e5  # of a place from the origin [m]

Extent = np.ndarray


def _near(place: tuple[float, float, float]) -> tuple[float, float, float]:
    """A place within the reach of numbers."""
    if max(map(abs, place)) > FARTHEST:
        raise ValueError(f"should be numbers up to {FARTHEST:g} m")
    return place


_POINT: dict[str, Any] = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}


class PlaceTable(Table):
    """The keys of [[structures]] in addition to those of a structure."""

    name: str = Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=40)
    """of letters and digits, put before its blocks and groups"""
    at: Annotated[Vector, Unit("m"), AfterValidator(_near), WithJsonSchema(_POINT)] = (0.0, 0.0, 0.0)
    """position of its origin"""
    rotate: Annotated[float, Unit("degrees")] = Field(0.0, ge=-360.0, le=360.0)
    """about the upright axis through its origin, counter-clockwise seen from above"""


@dataclass(frozen=True, eq=False)
class Place:
    """Where a structure stands."""

    name: str
    turn: np.ndarray  # (3, 3)
    at: np.ndarray  # (3,) [m]

    @classmethod
    def of(cls, keys: PlaceTable) -> Place:
        """The place that a table gives; whole quarters of a turn are exact."""
        quarters = keys.rotate / 90.0
        angle = math.radians(keys.rotate)
        exact = {0: (1.0, 0.0), 1: (0.0, 1.0), 2: (-1.0, 0.0), 3: (0.0, -1.0)}
        c, s = exact[int(quarters) % 4] if quarters == int(quarters) else (math.cos(angle), math.sin(angle))
        return cls(keys.name, np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), np.array(keys.at))

    def points(self, own: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the structure in the world [m]."""
        turned = own if self.turn[0, 0] == 1.0 else np.einsum("vj,ij->vi", own, self.turn)
        return np.asarray(turned + self.at)

    def block(self, own: Block) -> Block:
        """A block of the structure in the world, under its full name."""
        parts = tuple(Polyhedron(self.points(part.vertices), part.faces) for part in own.parts)
        name, group = f"{self.name}.{own.name}", f"{self.name}.{own.group}"
        carried = None if own.carried is None else own.carried.moved(self.turn, self.points(own.carried.centre[None])[0])
        return replace(own, name=name, group=group, structure=self.name, vertices=self.points(own.vertices), parts=parts, carried=carried)

    def bar(self, own: PlacedBar, number: int) -> PlacedBar:
        """A tie of the structure in the world, of the structure with a number among all."""
        first, second = (f"{self.name}.{block}" for block in own.blocks)
        keys = {**own.keys, "name": f"{self.name}.{own.keys['name']}"}
        return PlacedBar(_among(own.where, number), (first, second), self.points(own.points), keys)


def build(tables: Sequence[Mapping[str, Any]], density: float | None, folder: Path) -> MadeStructure:
    """Build the structures of a scene, see :func:`structures.make`.

    Raises:
        InputError: what is wrong with one of them, by ``structures[i].key``; a name given twice; structures in each other's way.
    """
    places = [_place_of(table, i) for i, table in enumerate(tables)]
    for i, place in enumerate(places):
        if place.name in (other.name for other in places[:i]):
            raise InputError(f"structures[{i}].name", f'"{place.name}" is given twice; each structure has a name of its own')
    made = [_made(table, density, folder, i) for i, table in enumerate(tables)]
    placed = [[place.block(block) for block in one.blocks] for place, one in zip(places, made, strict=True)]
    blocks = [block for one in on_one_ground(placed) for block in one]
    check(blocks)
    bars = [place.bar(bar, i) for i, (place, one) in enumerate(zip(places, made, strict=True)) for bar in one.ties]
    notes = [f"{place.name}: {note}" for place, one in zip(places, made, strict=True) for note in one.notes]
    fills = [
        replace(fill.placed(place.name, place.turn, place.at, place.points), where=_among(fill.where, i))
        for i, (place, one) in enumerate(zip(places, made, strict=True))
        for fill in one.fills
    ]
    return MadeStructure(blocks, notes, bars, fills)


def _place_of(table: Mapping[str, Any], number: int) -> Place:
    """The place of a structure."""
    return Place.of(parse_table(PlaceTable, {key: table[key] for key in KEYS if key in table}, f"structures[{number}]"))


def _made(table: Mapping[str, Any], density: float | None, folder: Path, number: int) -> MadeStructure:
    """A structure by itself; what is wrong with it is said by its place among the structures."""
    own = {key: value for key, value in table.items() if key not in KEYS}
    try:
        return make(own, density, folder)
    except InputError as error:
        raise error.each(lambda fault: _of_one(fault, number)) from None


def _of_one(fault: Fault, number: int) -> Fault:
    """A fault of [structure] as that of one of several."""
    if fault.place.split(".")[0] == "structure":
        return fault._replace(place=_among(fault.place, number))
    return fault if fault.place.startswith("material.") else fault.under(f"structures[{number}]")


def _among(place: str, number: int) -> str:
    """A key of [structure] as that of one of several."""
    return f"structures[{number}]{place.removeprefix('structure')}"


def on_one_ground(structures: Sequence[Sequence[Block]]) -> list[list[Block]]:
    """The blocks of each structure, with the supports of those that overlap in plan parted by upright planes.

    Raises:
        InputError: two structures between which no upright plane passes, whose supports overlap; or one whose supports are not convex.
    """
    plans = [_extent([block for block in blocks if block.fixed]) for blocks in structures]
    near = [(i, j) for i, j in combinations(range(len(structures)), 2) if _overlap(plans[i], plans[j])]
    if not near:
        return [list(blocks) for blocks in structures]
    label = connected_components(np.array(near)[:, 0], np.array(near)[:, 1], len(structures))
    planes: list[list[tuple[np.ndarray, float]]] = [[] for _ in structures]
    for i, j in combinations(range(len(structures)), 2):
        if label[i] == label[j]:
            normal, offset = _between(structures[i], structures[j])
            planes[i].append((normal, offset))
            planes[j].append((-normal, -offset))
    out = []
    for i, blocks in enumerate(structures):
        whole = _extent([block for j, one in enumerate(structures) if label[j] == label[i] for block in one if block.fixed])
        out.append(list(blocks) if not planes[i] or whole is None else _on_its_part(blocks, planes[i], whole))
    return out


def _extent(blocks: Sequence[Block]) -> Extent | None:
    """Lowest and highest x and y of some blocks, (2, 2) [m]; None of none."""
    if not blocks:
        return None
    points = np.concatenate([block.vertices[:, :2] for block in blocks])
    return np.array([points.min(axis=0), points.max(axis=0)])


def _overlap(a: Extent | None, b: Extent | None) -> bool:
    """Return True if two extents overlap in plan by more than rounding."""
    if a is None or b is None:
        return False
    slack = LEVEL * float(np.abs(np.concatenate([a, b])).max())
    return bool((np.minimum(a[1], b[1]) - np.maximum(a[0], b[0]) > slack).all())


def _between(a: Sequence[Block], b: Sequence[Block]) -> tuple[np.ndarray, float]:
    """The upright plane ``normal . x = offset`` in the middle of the widest space between two structures, the first on its lower side.

    Raises:
        InputError: they are entangled in plan.
    """
    first, second = (_hull([block for block in blocks if not block.fixed] or blocks) for blocks in (a, b))
    best = (-math.inf, np.zeros(2), 0.0)
    for towards in _directions(first, second):
        low, high = float(np.max(np.sum(first * towards, axis=1))), float(np.min(np.sum(second * towards, axis=1)))
        if high - low > best[0]:
            best = (high - low, towards, 0.5 * (low + high))
    if best[0] < -LEVEL * float(np.abs(np.concatenate([first, second])).max()):
        one, other = a[0].structure, b[0].structure
        raise InputError(
            "structures",
            f'"{one}" and "{other}" overlap in plan by {-best[0]:.3g} m, no upright plane parts the ground of one '
            f"from that of the other; move one of them (at)",
        )
    return np.append(best[1], 0.0), best[2]


def _hull(blocks: Sequence[Block]) -> np.ndarray:
    """Corners of the convex hull in plan, counter-clockwise, (n, 2) [m]."""
    points = np.concatenate([block.vertices[:, :2] for block in blocks])
    return np.asarray(points[ConvexHull(points).vertices])


def _directions(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 2) among which is the normal of the widest space between two hulls: those of their sides and between corners."""
    sides = [np.roll(hull, -1, axis=0) - hull for hull in (first, second)]
    outward = [np.stack([side[:, 1], -side[:, 0]], axis=1) for side in sides]
    apart = (second[:, None] - first[None]).reshape(-1, 2)
    every = np.concatenate([outward[0], -outward[1], apart])
    length = np.sqrt((every * every).sum(axis=1))
    kept = length > LEVEL * float(np.abs(every).max())
    return np.asarray(every[kept] / length[kept, None])


def _on_its_part(blocks: Sequence[Block], planes: Sequence[tuple[np.ndarray, float]], whole: Extent) -> list[Block]:
    """A structure whose supports are cut by planes; a ground that is one upright prism first reaches over the whole plan."""
    supports = [block for block in blocks if block.fixed]
    if any(block.parts for block in supports):
        raise InputError("structures", f'the supports of "{blocks[0].structure}" overlap others in plan, and only convex ones can be cut')
    drawn_out = _drawn_out(supports[0], whole) if len(supports) == 1 else None
    kept: list[Block] = []
    for block in blocks:
        piece: Block | None = drawn_out if block.fixed and drawn_out is not None else block
        for normal, offset in planes if block.fixed else ():
            piece = None if piece is None else halves(piece, normal, offset)[0]
        if piece is not None:
            kept.append(piece)
    return kept


def _drawn_out(ground: Block, whole: Extent) -> Block | None:
    """A ground over the whole plan (2, 2) [m]; None where it is not an upright prism with a level top."""
    z = ground.vertices[:, 2]
    low, high = float(z.min()), float(z.max())
    if not np.all((z == low) | (z == high)):
        return None
    vertices, faces = box((float(whole[0, 0]), float(whole[0, 1]), low), (float(whole[1, 0]), float(whole[1, 1]), high))
    return replace(ground, vertices=vertices, faces=faces)
