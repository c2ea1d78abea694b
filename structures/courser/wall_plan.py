# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls along x and y with their openings: what kinds of structure with keys of their own draw of a plan.

The engine of buildings makes the blocks (:mod:`structures.building.square_plan`). Where the footprints of two walls overlap, at a corner,
a junction or a crossing, the courses take turns: in even ones the wall along x runs through and the wall along y stops against it, in odd
ones the other way round. So the walls are interlocked without a cut stone, and no upright joint runs from bottom to top. Unbonded walls
leave every such place to one of the two, a straight joint: a real and dangerous condition, so it must be requested. The frames of openings
are those of all buildings (:mod:`structures.building.frames`). Heights are absolute, places count along the wall.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from structures.schema import HeadShape, OpeningTable

CORE = "core"  # group of the middle one of three leaves
SAME = 1e-9  # lengths closer than this are one [m]


class Sizes(NamedTuple):
    """Sizes of stones that are aimed at [m]."""

    course: float
    unit: float


@dataclass(frozen=True)
class Opening:
    """The measures of one opening [m]."""

    key: str  # that draws it, for messages: "structure.openings[0]" or "structure.door_width"
    centre: float
    width: float
    sill: float
    height: float  # clear, to the crown of the intrados
    head: HeadShape
    depth: float  # of the lintel or of the ring
    rise: float | None = None  # of a segmental intrados
    bearing: float | None = None  # of a lintel

    @property
    def crown(self) -> float:
        """Height of the top of the lintel or of the crown of the extrados."""
        return self.sill + self.height + self.depth


@dataclass(frozen=True, eq=False)
class PlanWall:
    """One straight wall [m]. It may end at, run through or cross walls along the other axis."""

    name: str
    group: str
    axis: int  # 0: along x, 1: along y
    start: float  # along its axis
    end: float
    near: float  # across
    far: float
    foot: float
    top: float  # the eaves, where there is a gable
    openings: tuple[Opening, ...] = ()
    gable: float = 0.0  # height of the gable above the top
    leaves: int = 1
    through: int = 3  # with two leaves or more: every through-th stone of every through-th course reaches through all of them; 0: none
    voids: tuple[tuple[float, float, float, float], ...] = ()  # s0, s1, z0, z1 left out for what is bonded in from outside the plan
    anchor: float | None = None  # where its bond starts; its own start by default
    shoulder: tuple[float, float, float] | None = None  # from this height up it only reaches from the second to the third
    core: tuple[float, float] | None = None  # of three leaves: where the middle one begins and ends, across
    hollow: bool = False  # the core is left out

    @property
    def profile(self) -> list[tuple[float, float]]:
        """The top, s and z of its corners [m]."""
        low, start, end = self.shoulder or (self.top, self.start, self.end)
        gable = [(0.5 * (start + end), self.top + self.gable)] if self.gable else []
        upper = [(start, self.top), *gable, (end, self.top)]
        return [(self.start, low), (start, low), *upper, (end, low), (self.end, low)] if self.shoulder else upper


def opening_of(table: OpeningTable, key: str, course: float) -> Opening:
    """An opening in a wall whose foot is at z = 0, from its table, with the depth of its head filled in."""
    depth = table.depth or (course if table.head in ("lintel", "flat") else natural_ring(table.width, course))
    return Opening(key, table.centre, table.width, table.sill, table.height, table.head, depth, table.rise, table.bearing)


def natural_bearing(width: float, unit: float) -> float:
    """Length of a lintel on each jamb [m], where none is given."""
    return max(unit / 3.0, 0.15 * width)


def natural_ring(width: float, course: float) -> float:
    """Thickness of the voussoirs of an arch: a fifth of its span, for a small one up to a course [m]."""
    return max(0.2 * width, min(0.8 * course, 0.35 * width))


def voussoir_width(ring: float, course: float) -> float:
    """Width of a voussoir that is aimed at [m]."""
    return max(0.6 * ring, min(0.8 * course, 1.2 * ring))
