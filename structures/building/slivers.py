# SPDX-License-Identifier: GPL-3.0-or-later
"""Slivers: what is too narrow in plan to be a stone, or a part of one, moves with the neighbour that it shares its longest side with.

Where walls meet at odd angles, what one of them leaves of another may be a wedge of a few millimetres. It is joined to the stone next to it
from which the fattest convex parts can then be made. Nothing is lost or added: only who a piece belongs to changes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry
from shapely.strtree import STRtree

from masonry_cd.mechanics.model.geometry import Shell
from structures.building.stones import WELD, upright
from structures.building.widths import ASIDE, TOUCH, fat_pieces, is_narrower, least_width
from structures.geometry import polygons

SQUARE = 0.5  # sine of the angle between a joint that cuts a sliver and its longest side, at least


@dataclass(frozen=True, eq=False)
class Stone:
    """A stone of a wall before it is a block."""

    leg: int
    course: int
    parts: tuple[Shell, ...]
    narrow: float  # what of its wall is a sliver [m]
    label: str = ""  # in its course; by default its number
    group: str = ""  # by default that of its wall

    @property
    def heights(self) -> tuple[float, float]:
        """z of its lowest and highest corner [m]."""
        z = np.concatenate([vertices[:, 2] for vertices, _ in self.parts])
        return float(z.min()), float(z.max())

    @cached_property
    def is_upright(self) -> bool:
        """Return True if all its parts are upright prisms between two heights, over one polygon."""
        low, high = self.heights
        return isinstance(self.plan, Polygon) and all(_is_prism(vertices, low, high) for vertices, _ in self.parts)

    @cached_property
    def plan(self) -> BaseGeometry:
        """Plan that it covers, x, y [m]."""
        return _united([_hull(vertices) for vertices, _ in self.parts])

    @property
    def least_width(self) -> float:
        """Least width of its parts in plan [m]."""
        return min(least_width(np.array(_hull(vertices).exterior.coords)[:-1]) for vertices, _ in self.parts)


def joined(stones: Sequence[Stone]) -> list[Stone]:
    """The stones with each sliver joined to a neighbour; of the others those with narrow parts cut better."""
    stones = _cut_at_joints(stones)
    found: list[Stone | None] = list(stones)
    tree = STRtree([stone.plan for stone in stones])
    moved: dict[int, int] = {}  # number of a sliver, and of the stone that it is now part of
    for k in sorted((k for k, stone in enumerate(stones) if is_narrower(stone.plan, stone.narrow)), key=lambda k: stones[k].plan.area):
        sliver = found[k]
        assert sliver is not None
        near = {_last(moved, int(i)) for i in tree.query(stones[k].plan.buffer(TOUCH))} - {k}
        best = max(_unions(sliver, [(i, stone) for i in sorted(near) for stone in [found[i]] if stone]), key=lambda u: u[0], default=None)
        if best is not None:
            found[best[1]], found[k], moved[k] = best[2], None, best[1]
    return [_recut(stone) for stone in found if stone is not None]


def _cut_at_joints(stones: Sequence[Stone]) -> list[Stone]:
    """The stones with slivers cut where two of their neighbours meet, so that each can take what lies along it."""
    tree = STRtree([stone.plan for stone in stones])
    found = list[Stone]()
    for stone in stones:
        if not is_narrower(stone.plan, stone.narrow) or not stone.is_upright:
            found.append(stone)
            continue
        shapes = [stone.plan]
        for i in tree.query(stone.plan.buffer(TOUCH)):
            other = stones[i]
            if other is not stone and other.is_upright and np.abs(np.subtract(other.heights, stone.heights)).max() < WELD:
                for point, along in _joints_on(stone.plan, other.plan):
                    shapes = [half for shape in shapes for half in _halves(shape, point, along)]
        rings = [polygons.loop(shape) for shape in shapes]
        found += [replace(stone, parts=tuple(upright(p, *stone.heights) for p in fat_pieces(Polygon(ring)))) for ring in rings]
    return found


def _joints_on(sliver: Polygon, other: Polygon) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Corners (2,) of a neighbour in the middle of the sides of a sliver, and the directions (2,) of its sides that leave from there."""
    own, ring = polygons.loop(sliver), polygons.loop(other)
    sides = np.roll(own, -1, axis=0) - own
    longest = sides[np.hypot(*sides.T).argmax()]
    for k, corner in enumerate(ring):
        if sliver.boundary.distance(shapely.Point(corner)) > TOUCH or np.hypot(*(own - corner).T).min() < ASIDE:
            continue
        away = np.array([ring[k - 1] - corner, ring[(k + 1) % len(ring)] - corner])
        away /= np.hypot(*away.T)[:, None] * np.hypot(*longest)
        square = np.abs(away[:, 0] * longest[1] - away[:, 1] * longest[0])
        if square.max() > SQUARE:
            yield corner, away[square.argmax()]


def _halves(shape: Polygon, point: np.ndarray, along: np.ndarray) -> list[Polygon]:
    """A polygon on both sides of a line."""
    d = 1e3 * along / np.hypot(*along)
    left = np.array([-d[1], d[0]])
    return [
        part
        for side in (left, -left)
        for part in polygons.polygons(shape.intersection(Polygon([point - d, point + d, point + d + side, point - d + side])))
    ]


def _last(moved: dict[int, int], k: int) -> int:
    while k in moved:
        k = moved[k]
    return k


def _unions(sliver: Stone, others: Sequence[tuple[int, Stone]]) -> Iterator[tuple[tuple[bool, float], int, Stone]]:
    """Yield the union of a sliver with each of its neighbours: how good it is, the number of the neighbour, the stone."""
    low, high = sliver.heights
    for k, other in others:
        bottom, top = other.heights
        tall = min(high, top) - max(low, bottom)
        if tall < WELD:
            continue
        length = float(sliver.plan.boundary.intersection(other.plan.buffer(TOUCH)).length)
        if length < 10.0 * TOUCH:
            continue
        whole = replace(other, parts=(*other.parts, *sliver.parts))
        level = sliver.is_upright and other.is_upright and max(abs(low - bottom), abs(high - top)) < WELD
        if level:
            union = _united([other.plan, sliver.plan])
            if not isinstance(union, Polygon):
                continue
            pieces = fat_pieces(union)
            whole = replace(other, parts=tuple(upright(piece, bottom, top) for piece in pieces))
            level = min(least_width(piece) for piece in pieces) > 0.5 * sliver.narrow
        yield (level, length * tall), k, whole


def _recut(stone: Stone) -> Stone:
    """A stone of several parts, one of them narrow, cut into fatter ones where that is possible."""
    if len(stone.parts) == 1 or not stone.is_upright or stone.least_width >= stone.narrow:
        return stone
    pieces = fat_pieces(stone.plan)
    if min(least_width(piece) for piece in pieces) <= stone.least_width:
        return stone
    return replace(stone, parts=tuple(upright(piece, *stone.heights) for piece in pieces))


def _is_prism(vertices: np.ndarray, low: float, high: float) -> bool:
    """Return True if a convex part is an upright prism between two heights."""
    foot, top = vertices[vertices[:, 2] < low + WELD, :2], vertices[vertices[:, 2] > high - WELD, :2]
    if len(foot) != len(top) or 2 * len(foot) != len(vertices):
        return False
    return bool((np.abs(foot[:, None] - top[None]).max(axis=2).min(axis=1) < WELD).all())


def _hull(vertices: np.ndarray) -> Polygon:
    return shapely.MultiPoint(vertices[:, :2]).convex_hull


def _united(shapes: Sequence[BaseGeometry]) -> BaseGeometry:
    """Polygons that touch as one, without the hairs that rounding leaves between them."""
    whole = shapely.union_all(shapes, grid_size=WELD / 10.0) if len(shapes) > 1 else shapes[0]
    found = polygons.polygons(whole)
    return Polygon(_straightened(polygons.loop(found[0]))) if len(found) == 1 and not found[0].interiors else whole


def _straightened(ring: np.ndarray) -> np.ndarray:
    """A loop without corners that rounding has put next to the line between their neighbours."""
    k = 0
    while k < len(ring) and len(ring) > 3:
        a, b, c = ring[k - 1], ring[k], ring[(k + 1) % len(ring)]
        off = abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / max(np.hypot(*(c - a)), WELD)
        if off < WELD:
            ring = np.delete(ring, k, axis=0)
        else:
            k += 1
    return ring
