# SPDX-License-Identifier: GPL-3.0-or-later
"""The clear space between walls at the height of a floor: a convex polygon about a point that no block reaches into.

Blocks count by the plans of their convex parts. They are taken from the nearest outwards, and each that reaches into what is left takes off
what lies beyond its side that is farthest from the point; so its own walls bound it before those of its neighbours are looked at.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.polygon import clip

NAMES = ("east", "north-east", "north", "north-west", "west", "south-west", "south", "south-east")  # x points east and y north
AT = 1e-6  # [m]: faces closer to an edge than this bound it
EXACT = 1e-9  # normals closer to an axis than this lie along it


@dataclass(frozen=True, eq=False)
class Side:
    """A side of the clear space, or of the plan of a block: the line ``normal . x = place``."""

    normal: np.ndarray  # unit vector (2,), out of the room
    place: float  # of its wall's face, along the normal [m]
    far: float  # of the other face of that wall [m]; its own where there is none
    owners: frozenset[int] = frozenset()  # blocks that bound it; none where it is open

    @property
    def name(self) -> str:
        """Name by the compass."""
        return NAMES[round(4.0 * math.atan2(self.normal[1], self.normal[0]) / math.pi) % 8]

    @property
    def depth(self) -> float:
        """Depth of its wall [m]."""
        return self.far - self.place

    def moved(self, by: float) -> Side:
        """Out of the room by a distance [m]."""
        return replace(self, place=self.place + by)


@dataclass(frozen=True, eq=False)
class Plans:
    """The plans of P convex parts, and the block of each."""

    loops: list[np.ndarray]  # P of (n, 2), counter-clockwise [m]
    sides: list[list[Side]]  # of each
    owner: np.ndarray  # (P,)

    @classmethod
    def between(cls, blocks: Sequence[Block], bottom: float, top: float) -> Plans:
        """Plans of the free blocks between two heights [m]."""
        from structures.geometry.polygons import plan_of

        loops, owner = [], []
        for i, block in enumerate(blocks):
            for part in () if block.fixed else block.convex_parts:
                if part.vertices[:, 2].min() < top - AT and part.vertices[:, 2].max() > bottom + AT:
                    loops.append(plan_of(part.vertices))
                    owner.append(i)
        return cls(loops, [_sides_of(loop) for loop in loops], np.array(owner, dtype=int))

    def beyond(self, p: int, point: np.ndarray) -> float:
        """How far a point (2,) lies out of a plan [m]; negative within it."""
        return max(float(side.normal @ point) - side.place for side in self.sides[p])

    def around(self, point: np.ndarray) -> list[int]:
        """Numbers of those in which a point (2,) lies."""
        return [p for p in range(len(self.loops)) if self.beyond(p, point) < -AT]


def _sides_of(loop: np.ndarray) -> list[Side]:
    """The sides of a convex polygon, outward."""
    along = np.roll(loop, -1, axis=0) - loop
    length = np.sqrt((along * along).sum(axis=1))
    normals = np.column_stack([along[:, 1], -along[:, 0]]) / length[:, None]
    return [_side(normal, corner) for normal, corner in zip(normals, loop, strict=True)]


def _side(normal: np.ndarray, through: np.ndarray) -> Side:
    """A line through a point; one along an axis is that to the bit."""
    axis = int(np.abs(normal).argmax())
    if abs(normal[1 - axis]) < EXACT:
        normal = np.sign(normal[axis]) * np.eye(2)[axis]
        place = float(normal[axis] * through[axis])
    else:
        place = float(normal @ through)
    return Side(normal, place, place)


def room(plans: Plans, point: np.ndarray, extent: np.ndarray) -> list[Side]:
    """The sides of the room about a point, counter-clockwise.

    Args:
        plans: of what stands at its height; none of them is around the point.
        point: (2,) [m].
        extent: (2, 2) lowest and highest x and y beyond which it does not reach [m].
    """
    corners = np.array([(extent[i, 0], extent[j, 1]) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
    bounds = _sides_of(corners)
    away = [plans.beyond(p, point) for p in range(len(plans.loops))]
    for p in np.argsort(away, kind="stable").tolist():
        if _overlap(plans.sides[p], corners) and _overlap(bounds, plans.loops[p]):
            nearest = max(plans.sides[p], key=lambda side: round(float(side.normal @ point) - side.place, 9))
            edge = Side(-nearest.normal + 0.0, -nearest.place, -nearest.place)
            bounds.append(edge)
            corners = clip(corners, edge.place - corners @ edge.normal, AT)
    sides = [side for side in bounds if _length(side, corners) > AT]
    order = sorted(_once(sides), key=lambda side: math.atan2(side.normal[1], side.normal[0]))
    return [_with_wall(plans, side, corners) for side in order]


def _overlap(sides: Sequence[Side], corners: np.ndarray) -> bool:
    """Return True if none of some sides has all the corners of a polygon beyond it."""
    return all(float((corners @ side.normal).min()) < side.place - AT for side in sides)


def _length(side: Side, corners: np.ndarray) -> float:
    """Return the length of the share of a line that bounds a polygon [m]."""
    on = corners[np.abs(corners @ side.normal - side.place) < 2.0 * AT]
    return float(np.ptp(on @ [-side.normal[1], side.normal[0]])) if len(on) > 1 else 0.0


def _once(sides: Sequence[Side]) -> list[Side]:
    """One of each lines that are the same."""
    found: list[Side] = []
    for side in sides:
        if not any(np.abs(side.normal - one.normal).max() < AT and abs(side.place - one.place) < 2.0 * AT for one in found):
            found.append(side)
    return found


def _with_wall(plans: Plans, side: Side, corners: np.ndarray) -> Side:
    """A side of the clear space (n, 2) with the blocks that bound it, as deep as these reach."""
    along = np.array([-side.normal[1], side.normal[0]])
    on = corners[np.abs(corners @ side.normal - side.place) < 2.0 * AT] @ along
    owners, far = set[int](), side.place
    for loop, owner in zip(plans.loops, plans.owner.tolist(), strict=True):
        reach, across = loop @ along, loop @ side.normal
        if abs(across.min() - side.place) <= 2.0 * AT and reach.min() < on.max() - AT and reach.max() > on.min() + AT:
            owners.add(owner)
            far = max(far, float(across.max()))
    return replace(side, owners=frozenset(owners), far=far)


def polygon_of(sides: Sequence[Side]) -> np.ndarray:
    """Corners (n, 2) of the convex polygon within sides that follow on each other counter-clockwise [m]."""
    corners = []
    for one, other in zip(sides, [*sides[1:], sides[0]], strict=True):
        (a, b), (c, d) = one.normal, other.normal
        turn = a * d - b * c
        corners.append(((one.place * d - b * other.place) / turn, (a * other.place - one.place * c) / turn))
    return np.array(corners)
