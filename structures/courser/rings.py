# SPDX-License-Identifier: GPL-3.0-or-later
"""Rings of stones over a regular polygon: drums, the walls of an apse, domes of flat sides.

A ring of N sides is made of rows. In the upright plane through the middle of a side, a row is a quadrilateral of distances d from
the axis and heights z; along the side it reaches to the mitre planes, s = -d tan(pi/N) to d tan(pi/N). All faces are
plane, and those of neighbours match exactly, because a row has the same quadrilateral in all sides.

Head joints are upright planes normal to their side. In one row joints also lie on the mitres; in the next they are shifted by half a
block, and a stone turns round every corner as a compound block (:mod:`structures.geometry.compound_block`), so that no joint runs along a
meridian. A ring may be open, as an apse is; then it ends on two mitre planes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from masonry_cd.foundation import libm
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Shell
from structures.courser.bond import even
from structures.geometry.compound_block import compound_block
from structures.geometry.prism import between

LEAST = 0.3  # between a head joint and a mitre or jamb, in blocks


@dataclass(frozen=True)
class Ring:
    """The sides of a ring in plan."""

    sides: int  # of the full polygon
    count: int  # that are built
    start: float = 0.0  # direction of the first corner [rad]
    centre: tuple[float, float] = (0.0, 0.0)  # [m]

    @property
    def closed(self) -> bool:
        """True when all sides are built."""
        return self.count == self.sides

    @property
    def slope(self) -> float:
        """Half the length of a side at unit distance from the axis."""
        return math.tan(math.pi / self.sides)

    def place(self, side: int, d: np.ndarray, s: np.ndarray, z: np.ndarray) -> np.ndarray:
        """World coordinates (n, 3) of points of a side."""
        angle = self.start + (side + 0.5) * 2.0 * math.pi / self.sides
        c, n = math.cos(angle), math.sin(angle)
        return np.stack([self.centre[0] + d * c - s * n, self.centre[1] + d * n + s * c, z], axis=1)

    def corners(self, d: float, z: float) -> np.ndarray:
        """The corners of the polygon at a distance of its sides and a height, (count or count + 1, 3)."""
        sides = [*range(self.count)] + ([] if self.closed else [self.count - 1])
        ends = [-d * self.slope] * self.count + ([] if self.closed else [d * self.slope])
        return np.concatenate([self.place(i, np.array([d]), np.array([s]), np.array([z])) for i, s in zip(sides, ends, strict=True)])


@dataclass(frozen=True, eq=False)
class RingCourse:
    """One course of a ring."""

    group: str
    profile: np.ndarray  # (4, 2) d, z: lower inner, lower outer, upper outer, upper inner
    gaps: dict[int, float] = field(default_factory=dict)  # by side: half-width of an opening in the middle of the side
    lintels: dict[int, float] = field(default_factory=dict)  # by side: half-length of a lintel there
    ends: tuple[Shell, ...] = ()  # of an open ring: parts joined to its first and to its last stone


def build(ring: Ring, rows: Sequence[RingCourse], unit: float, density: float, bonded: bool = True) -> list[Block]:
    """The blocks ``GROUP.ROW.NUMBER`` of a ring, from its lowest row up.

    Args:
        unit: length of a block at the inner face [m].
        density: [kg/m3].
        bonded: False makes a free lune of every side, of one stone to a row.
    """
    blocks = []
    bond = _Bond(1, True)
    for number, row in enumerate(rows, start=1):
        half = float(row.profile[:, 0].min()) * ring.slope
        bond = bond.next(max(1, round(2.0 * half / unit))) if bonded else _Bond(1, False)
        stones = _stones(ring, row, half, bond)
        if row.ends:
            stones[0].append(row.ends[0])
            stones[-1].append(row.ends[1])
        for k, parts in enumerate(stones, start=1):
            blocks.append(compound_block(f"{row.group}.{number}.{k}", parts, density, row.group))
    return blocks


@dataclass(frozen=True)
class _Bond:
    """The head joints of a row: a number of blocks to a side, with joints on the mitres or turning round the corners."""

    count: int
    turning: bool

    def heads(self) -> np.ndarray:
        """Head joints within a side, as shares of half its length."""
        return np.array(even(-1.0, 1.0, self.count, self.turning))

    def next(self, wanted: int) -> _Bond:
        """The bond of the row above; the number of blocks changes where their joints do not then run through."""
        choices = [_Bond(n, t) for n in (wanted, self.count) for t in (not self.turning, self.turning)]
        return max(choices, key=lambda bond: (min(0.1, self._overlap(bond)), bond.count == wanted, self._overlap(bond)))

    def _overlap(self, other: _Bond) -> float:
        """Least distance between joints of two rows, as a share of half a side."""
        own, others = (np.append(b.heads(), [] if b.turning else [-1.0, 1.0]) for b in (self, other))
        return float(np.abs(own[:, None] - others[None, :]).min())


def _stones(ring: Ring, row: RingCourse, half: float, bond: _Bond) -> list[list[Shell]]:
    """The parts of each stone of a row, in order round the ring."""
    stones: list[list[Shell]] = []
    for side in range(ring.count):
        for low, high in _stretches(list(map(float, half * bond.heads())), row, side, LEAST * 2.0 * half / bond.count):
            part = _part(ring, side, row.profile, low, high)
            if bond.turning and low is None and side > 0:
                stones[-1].append(part)
            else:
                stones.append([part])
    if bond.turning and ring.closed:
        stones[-1] += stones.pop(0)
    return stones


def _stretches(heads: list[float], row: RingCourse, side: int, least: float) -> list[tuple[float | None, float | None]]:
    """Ends of the stones of one side, None for a mitre."""
    wide = row.gaps.get(side, row.lintels.get(side, 0.0))
    if not wide:
        ends = [None, *heads, None]
        return list(pairwise(ends))
    left = [x for x in heads if x < -wide - least]
    right = [x for x in heads if x > wide + least]
    one, other = [None, *left, -wide], [wide, *right, None]
    middle = [(-wide, wide)] if side in row.lintels else []
    return [*pairwise(one), *middle, *pairwise(other)]


def _part(ring: Ring, side: int, profile: np.ndarray, low: float | None, high: float | None) -> Shell:
    """A stretch of a row of one side."""
    d, z = profile.T
    first = ring.place(side, d, -d * ring.slope if low is None else np.full(4, low), z)
    second = ring.place(side, d, d * ring.slope if high is None else np.full(4, high), z)
    return between(first, second)


def wall_rows(group: str, inner: float, thickness: float, beds: Sequence[float]) -> list[RingCourse]:
    """Upright rows between level beds [m]."""
    d0, d1 = inner, inner + thickness
    return [RingCourse(group, np.array([[d0, a], [d1, a], [d1, b], [d0, b]])) for a, b in pairwise(beds)]


def dome_rows(group: str, inner: float, thickness: float, level: float, count: int, top: float) -> list[RingCourse]:
    """Rows of a dome, a circular profile between radial beds.

    Args:
        inner: radius of the intrados [m].
        level: height of its centre, where it springs [m].
        count: number of rows.
        top: angle of the last bed above the springing [rad].
    """
    angles = top * np.arange(count + 1) / count
    unit = np.stack([libm.cos(angles), libm.sin(angles)], axis=1)
    low, high = inner * unit + [0.0, level], (inner + thickness) * unit + [0.0, level]
    return [RingCourse(group, np.array([low[k], high[k], high[k + 1], low[k + 1]])) for k in range(count)]


def key(ring: Ring, last: RingCourse, density: float, name: str, group: str) -> Block:
    """The stone that fills a ring over its last row; of an open ring, half of it."""
    (outer, z1), (inner, z0) = last.profile[2], last.profile[3]
    return Block(name, *between(ring.corners(float(inner), float(z0)), ring.corners(float(outer), float(z1))), density, group)
