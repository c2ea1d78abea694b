# SPDX-License-Identifier: GPL-3.0-or-later
"""The courses of a spandrel wall over the extradoses of a bridge: plane pieces, all of them convex, without a feather edge.

Each half of an arch is looked at from the support on which it stands, up to its axis:

- Where the extrados is steeper than 45 degrees, beds lie at its corners, and a course ends on its chord.
- Where it is flatter, a head joint rises from each corner, and a stone of its own, 0.5 to 1.5 courses high, levels each chord up to
  the next bed of those that are counted down from the road.
- Above it courses run on until they meet the next stone of that kind, or pass the crown and meet those of the other half.

Courses of one height that touch are one, and are cut by head joints in running bond, clear of those below.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from structures.bridge.layout import SAME, BridgeLayout, BridgeSupport
from structures.bridge.masonry import top_of
from structures.courser.bond import LEAST_BOND, cleared
from structures.courser.courses import CourseStretch, cut, heads_of, joined

STEP = 0.5  # courses: least height of a stone that levels a chord
TALL = 1.5  # courses: a steep chord of more than that is cut by beds


def bed_over(height: float, course: float, deck: float) -> float:
    """The first bed at least half a course above a height: one of those counted down from the road, or the road [m]."""
    count = math.floor((deck - height) / course - STEP + 1e-9)
    return deck - max(count, 0) * course


def _levelled(chord: np.ndarray, course: float, deck: float) -> np.ndarray:
    """The stone (4, 2) that levels a chord."""
    (x0, z0), (x1, z1) = chord
    high = bed_over(max(z0, z1), course, deck)
    return np.array([[x0, z0], [x1, z1], [x1, high], [x0, high]])


@dataclass(frozen=True, eq=False)
class Half:
    """Half of an extrados and what lies behind it, mirrored so that x grows from its support to its axis."""

    corners: np.ndarray  # (K + 1, 2) of the extrados from the springing up [m]
    axis: float  # x of the middle of the arch
    even: bool  # the last corner lies on it
    outer: float  # where the part of the support ends that belongs to it
    top: float  # level of the support at that place; that at the springing is the first corner's
    course: float
    deck: float

    @property
    def flat(self) -> int:
        """The first corner from which the extrados is flatter than 45 degrees."""
        across, up = np.diff(self.corners, axis=0).T
        return int(np.argmax(np.append(up <= across, True)))

    def bed_over(self, height: float) -> float:
        """The first bed over a height [m]."""
        return bed_over(height, self.course, self.deck)

    @property
    def slopes(self) -> bool:
        """Return True if the top of its support is not level; the extrados next to it is then a flat one."""
        return abs(self.top - float(self.corners[0, 1])) > SAME

    @property
    def over_slope(self) -> float:
        """Up to where one stone levels such a top."""
        return self.bed_over(max(self.top, float(self.corners[0, 1])))

    @property
    def levels(self) -> list[float]:
        """Beds from the springing to the road."""
        start = float(self.corners[0, 1])
        if self.slopes:
            out = [min(self.over_slope, self.bed_over(float(self.corners[1, 1])))]
        else:
            out = [start]
            for height in self.corners[1 : self.flat + 1, 1]:
                count = max(1, math.ceil((height - out[-1]) / (TALL * self.course)))
                out += [out[-1] + (float(height) - out[-1]) * i / count for i in range(1, count + 1)]
            out += [self.bed_over(out[-1])] if out[-1] < self.deck - SAME else []
        while out[-1] < self.deck - SAME:
            out.append(min(out[-1] + self.course, self.deck))
        return [min(level, self.deck) for level in out]

    def columns(self) -> list[np.ndarray]:
        """Stones that level the chords of the flat part, and a top of the support that is not level, as polygons."""
        chords = [self.corners[k : k + 2] for k in range(self.flat, len(self.corners) - 1)]
        if self.slopes:
            chords.insert(0, np.array([[self.outer, self.top], self.corners[0]]))
        return [_levelled(chord, self.course, self.deck) for chord in chords]

    def end(self, low: float, high: float) -> tuple[float, float]:
        """Where a course between two levels ends, towards the axis: x at both."""
        k = self.flat
        if high <= self.corners[k, 1] + SAME:
            x = np.interp([low, high], self.corners[: k + 1, 1], self.corners[: k + 1, 0])
            return float(x[0]), float(x[1])
        while k < len(self.corners) - 1 and self.bed_over(float(self.corners[k + 1, 1])) <= low + SAME:
            k += 1
        passes = k == len(self.corners) - 1 and (self.even or self.bed_over(float(self.corners[k, 1])) <= low + SAME)
        x_end = self.axis if passes else float(self.corners[k, 0])
        return x_end, x_end

    def courses(self) -> list[CourseStretch]:
        """From the springing to the road, from the support to where each ends."""
        found = list[CourseStretch]()
        for low, high in pairwise(self.levels):
            start = float(self.corners[0, 0]) if self.slopes and low < self.over_slope - SAME else self.outer
            if high - low > SAME:
                found.append(CourseStretch(low, high, (start, start), self.end(low, high)))
        return found


def pieces(layout: BridgeLayout, above: Sequence[float] = ()) -> list[np.ndarray]:
    """All stones of a spandrel wall over the supports and the arches, (n, 2) each, by height and then by x.

    Args:
        above: x of the upright joints of what stands on the road, of which those of the last course keep clear [m].
    """
    assert layout.keys.walls is not None
    found, rows = list[np.ndarray](), list[CourseStretch]()
    for support in layout.supports:
        for half, sign in _halves(layout, support):
            found += [_mirrored(polygon, sign) for polygon in half.columns()]
            rows += [course if sign > 0 else course.mirrored for course in half.courses()]
    for profile in layout.profiles:
        if len(profile.extrados) % 2 == 0:  # the chord over the axis belongs to both halves
            k = len(profile.extrados) // 2
            found.append(_levelled(profile.extrados[k - 1 : k + 1], layout.keys.walls.course_height, layout.deck))
    met = [(float(x), float(polygon[:, 1].max())) for polygon in found for x in (polygon[:, 0].min(), polygon[:, 0].max())]
    met += [(float(x), layout.deck) for x in above]
    for row in joined(rows):
        heads = _in_bond(layout, row, [x for x, z in met if abs(z - row.low) <= SAME or z == row.high == layout.deck])
        met += [(x, row.high) for x in heads]
        found += cut(row, heads)
    return sorted(found, key=lambda polygon: (round(float(polygon[:, 1].min()), 6), float(polygon[:, 0].min())))


def _in_bond(layout: BridgeLayout, row: CourseStretch, met: Sequence[float]) -> list[float]:
    """x of the head joints of a course, in that of two bonds which lies farther from the joints that meet its beds [m].

    It begins at the middle of the pier or at the back of the abutment that the course lies over, or at the middle of the course.
    """
    assert layout.keys.walls is not None
    unit, low, high = layout.keys.walls.unit_length, min(row.left), max(row.right)
    over = [support.split for support in layout.supports if low - SAME <= support.split <= high + SAME]
    start = over[0] if len(over) == 1 else 0.5 * (low + high)

    def apart(heads: Sequence[float]) -> float:
        return round(float(np.mean([min([0.5 * unit, *(abs(x - t) for t in met)]) for x in heads])) if heads else unit, 9)

    heads = max((heads_of(row, unit, start + shift) for shift in (0.0, 0.5 * unit)), key=apart)
    ends = max(row.left) + LEAST_BOND * unit, min(row.right) - LEAST_BOND * unit
    return [cleared(x, met, LEAST_BOND * unit, ends) for x in heads]


def _halves(layout: BridgeLayout, support: BridgeSupport) -> list[tuple[Half, float]]:
    """The halves of arches that stand on a support, and which way they go."""
    assert layout.keys.walls is not None
    line, found = top_of(support, True), list[tuple[Half, float]]()
    middle = support.split
    for profile, sign in ((support.before, -1.0), (support.after, 1.0)):
        if profile is None:
            continue
        corners = profile.extrados if sign > 0 else profile.extrados[::-1] * [-1.0, 1.0]
        count = len(corners)
        levels = [z for x, z in line if abs(x - middle) <= SAME]
        top = levels[-1 if sign > 0 else 0]
        even = count % 2 == 1
        kept = corners[: count // 2 + 1] if even else corners[: count // 2]
        found.append((Half(kept, sign * profile.axis, even, sign * middle, top, layout.keys.walls.course_height, layout.deck), sign))
    return found


def _mirrored(polygon: np.ndarray, sign: float) -> np.ndarray:
    return polygon if sign > 0 else (polygon * [-1.0, 1.0])[::-1]
