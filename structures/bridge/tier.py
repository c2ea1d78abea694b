# SPDX-License-Identifier: GPL-3.0-or-later
"""One tier of an aqueduct, a bridge whose spandrels are masonry over its whole width: its outline and its joints in the x-z plane.

Where its piers stand and its rings lie is the layout of a bridge (:mod:`structures.bridge.layout`). The spandrels between the rings are
filled up to a level top in courses that are keyed to equal rings and run through over the crowns; those of spandrel walls
(:mod:`structures.bridge.spandrels`) fit arches of any shape, and end at each of them.
Every spandrel block is convex and touches the ring along whole chords, without a gap or a feather edge:

- On the haunches, where the extrados is steeper than 45 degrees, beds lie at the corners of the extrados, as in
  courses keyed to the voussoirs. A corner in the middle of a course gets a bed of its own up to the next head joint.
- Towards the crown, where it is flatter, a head joint rises from each corner, and a bed ends where less than half a course
  would be left between it and the ring.
- From the first bed that runs over the crown upwards, courses run in bond along the whole tier.

Elsewhere head joints stand in running bond. Heights in this file count from the springing unless they are said to be
absolute; offsets count from the axis of an arch, which is symmetric.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from structures.bridge.layout import Layout, laid_out
from structures.bridge.profile import profile_of, voussoirs_of
from structures.bridge.table import BridgeTable
from structures.courser.bond import even, running
from structures.geometry.solid import Segment

LEAST_BED = 0.5  # between a bed and the ring below it, in courses
LEAST_UNIT = 0.35  # between a head joint and the end of its course, in units
LEAST_BOND = 0.1  # between head joints of successive courses, in units: a shorter overlap is no bond, only a bad contact


@dataclass(frozen=True, eq=False)
class Tier:
    """A bridge of equal semicircular spans on equal piers, P of them, whose spandrels are masonry; the measures in [m]."""

    number: int
    keys: BridgeTable
    centre: float  # x of the middle of the tier
    pier_courses: int
    pier_blocks: int
    course: float
    unit: float  # length of a spandrel block

    @cached_property
    def layout(self) -> Layout:
        """The spans on their piers."""
        return laid_out(self.keys)

    @property
    def springing(self) -> float:
        """Absolute height of the springing."""
        return self.keys.spans[0].springing

    @property
    def foot(self) -> float:
        """Absolute height of the foot of the piers."""
        return self.springing - self.keys.piers[0].height

    @property
    def spans(self) -> int:
        """Number of arches, P - 1."""
        return len(self.keys.spans)

    @property
    def clear_span(self) -> float:
        """Between the faces of the piers."""
        return self.keys.spans[0].span

    @property
    def pier_width(self) -> float:
        """Along the aqueduct."""
        return self.keys.piers[0].width

    @property
    def ring_thickness(self) -> float:
        """Of the arches."""
        return self.keys.spans[0].thickness

    @property
    def voussoirs(self) -> int:
        """To an arch."""
        return voussoirs_of(self.keys.spans[0])

    @property
    def cover(self) -> float:
        """Masonry above the crown."""
        return self.keys.cover or 0.0

    @property
    def width(self) -> float:
        """Along y."""
        return self.keys.width

    @property
    def outer(self) -> float:
        """Radius of the corners of the extrados."""
        return 0.5 * self.clear_span + self.ring_thickness

    @property
    def pitch(self) -> float:
        """Distance between the axes of neighbouring piers."""
        return self.clear_span + self.pier_width

    @property
    def length(self) -> float:
        """Length of the whole tier."""
        return self.spans * self.pitch + self.pier_width

    @cached_property
    def left(self) -> np.ndarray:
        """x of the left face of each pier, (P,): that of its support, all by one sum, so that a stone over an axis is in the middle."""
        return self.centre - 0.5 * self.length + self.pitch * np.arange(self.spans + 1)

    @cached_property
    def right(self) -> np.ndarray:
        """x of the right face of each pier, (P,)."""
        return self.left + self.pier_width

    @cached_property
    def axes(self) -> np.ndarray:
        """x of the axis of each arch, (P - 1,)."""
        return 0.5 * (self.right[:-1] + self.left[1:])

    @cached_property
    def arch(self) -> tuple[np.ndarray, np.ndarray]:
        """Joint ends (N + 1, 2) on intrados and extrados of one arch about its centre."""
        own = profile_of(self.keys.spans[0].model_copy(update={"springing": 0.0}), -0.5 * self.clear_span)
        return own.intrados, own.extrados

    @cached_property
    def corners(self) -> np.ndarray:
        """Corners of one half of the extrados, from the springing up: offset and height, (K + 1, 2)."""
        return self.arch[1][: self.voussoirs // 2 + 1] * [-1.0, 1.0]

    @cached_property
    def first_flat(self) -> int:
        """The first corner of the extrados above 45 degrees."""
        return int(np.argmax(self.corners[:, 1] > self.corners[:, 0] * (1.0 + 1e-9)))

    @cached_property
    def beds(self) -> list[float]:
        """Heights of the beds of the spandrels, from the springing (0) to the level top."""
        beds = [0.0]
        for height in self.corners[1 : self.first_flat, 1]:
            step = height - beds[-1]
            if step >= 0.75 * self.course:
                count = math.ceil(step / (1.5 * self.course))
                beds += [beds[-1] + step * i / count for i in range(1, count)] + [float(height)]
        over = math.floor(self.cover / self.course - LEAST_BED + 1e-9)  # courses above the one that levels the crown
        top = float(self.corners[-1, 1]) + self.cover
        level = top - over * self.course
        count = max(1, round((level - beds[-1]) / self.course))
        between = [beds[-1] + (level - beds[-1]) * i / count for i in range(1, count)]
        return beds + [self._snapped(bed) for bed in between] + [level + self.course * i for i in range(over)] + [top]

    def _snapped(self, bed: float) -> float:
        """Move a bed to a corner of the extrados nearby."""
        nearest = float(self.corners[np.argmin(np.abs(self.corners[:, 1] - bed)), 1])
        return nearest if abs(nearest - bed) < 0.15 * self.course else bed

    @property
    def top(self) -> float:
        """Absolute height of the level top."""
        return self.springing + self.beds[-1]

    @cached_property
    def first_complete(self) -> int:
        """The first bed that runs over the crowns."""
        return next(i for i, bed in enumerate(self.beds) if self.bed_end(bed) == 0.0)

    def reach(self, height: float) -> float:
        """Offset of the extrados at a height."""
        return float(np.interp(height, self.corners[:, 1], self.corners[:, 0]))

    def bed_end(self, height: float) -> float:
        """Offset at which a bed ends: on the extrados, on a head joint over the haunch, or at the axis (0)."""
        offsets, heights = self.corners.T
        k, last = self.first_flat, len(heights) - 1
        if height <= heights[k]:
            return self.reach(height)
        least = LEAST_BED * self.course - 1e-9
        while k < last and height >= heights[k + 1] + least:
            k += 1
        return 0.0 if k == last and height >= heights[last] + least else float(offsets[k])

    def zone(self, pier: int, height: float) -> tuple[float, float]:
        """x of the two ends of a bed of the spandrel over a pier."""
        end = self.bed_end(height)
        low = self.left[0] if pier == 0 else self.axes[pier - 1] + end
        high = self.right[-1] if pier == self.spans else self.axes[pier] - end
        return float(low), float(high)


def outline(tier: Tier) -> np.ndarray:
    """The figure of a tier, (n, 2) absolute x, z: along the feet, over the openings, and back along the level top."""
    points: list[tuple[float, float]] = []
    intrados = tier.arch[0]
    for pier in range(tier.spans + 1):
        points += [(tier.left[pier], tier.foot), (tier.right[pier], tier.foot)]
        if pier < tier.spans:
            points += [(tier.axes[pier] + x, tier.springing + z) for x, z in intrados]
    points += [(tier.right[-1], tier.top), (tier.left[0], tier.top)]
    return np.array(points)


def joints(tier: Tier, above: Sequence[float] = ()) -> list[Segment]:
    """All joints of a tier, absolute.

    Args:
        above: x of what stands on the level top, for its head joints to keep clear of (:func:`feet` of the next tier).
    """
    found = _pier_joints(tier) + _ring_joints(tier)
    for pier in range(tier.spans + 1):
        found += _spandrel_joints(tier, pier)
    for axis in tier.axes:
        found += [_upright(x, tier.springing + low, tier.springing + high) for x, low, high in _risers(tier, float(axis))]
    return found + _bond_over_crowns(tier, above)


def feet(tier: Tier) -> list[float]:
    """x of the faces of the piers and of the head joints in their first course."""
    heads = [x for pier in range(tier.spans + 1) for x in _pier_heads(tier, pier, 0)]
    return [*(float(x) for x in tier.left), *(float(x) for x in tier.right), *heads]


def _level(x0: float, x1: float, z: float) -> Segment:
    return (float(x0), float(z)), (float(x1), float(z))


def _upright(x: float, z0: float, z1: float) -> Segment:
    return (float(x), float(z0)), (float(x), float(z1))


def _cleared(heads: Sequence[float], taken: Sequence[float], least: float) -> list[float]:
    """Move head joints that nearly meet one of the next course to the least distance from it."""
    out = []
    for x in heads:
        near = [t for t in taken if abs(t - x) < least]
        if near:
            moved = [t + side * least for t in near for side in (-1.0, 1.0)]
            x = max(moved, key=lambda m: (round(min(least, *(abs(m - t) for t in taken)), 9), -abs(m - x)))
        out.append(x)
    return out


def _pier_joints(tier: Tier) -> list[Segment]:
    """Beds of the piers up to the springing, and head joints where a course has two blocks."""
    found = []
    for pier in range(tier.spans + 1):
        for course in range(tier.pier_courses):
            low, high = tier.foot + course * tier.course, tier.foot + (course + 1) * tier.course
            found.append(_level(tier.left[pier], tier.right[pier], high))
            found += [_upright(x, low, high) for x in _pier_heads(tier, pier, course)]
    return found


def _pier_heads(tier: Tier, pier: int, course: int) -> list[float]:
    """x of the head joint of a course of a pier: at one third and two thirds in turn."""
    if tier.pier_blocks == 1:
        return []
    heads = [float(tier.left[pier] + tier.pier_width * (1 if course % 2 else 2) / 3.0)]
    if course < tier.pier_courses - 1:
        return heads
    rings = [float(tier.left[pier] + tier.ring_thickness)] * (pier > 0) + [float(tier.right[pier] - tier.ring_thickness)] * (
        pier < tier.spans
    )
    return _cleared(heads, rings + _heads(tier, pier, 0), LEAST_BOND * tier.unit)


def _ring_joints(tier: Tier) -> list[Segment]:
    """Radial joints of the rings, and the chords of their extrados."""
    found = []
    for axis in tier.axes:
        inner, outer = ([(float(axis + x), float(tier.springing + z)) for x, z in side] for side in tier.arch)
        found += list(zip(inner[1:-1], outer[1:-1], strict=True)) + list(pairwise(outer))
    return found


def _spandrel_joints(tier: Tier, pier: int) -> list[Segment]:
    """Beds and head joints over a pier, up to the first bed that runs over the crowns."""
    found = []
    beds = tier.beds[: tier.first_complete + 1]
    for course, (low, high) in enumerate(pairwise(beds)):
        if course > 0:
            found.append(_level(*tier.zone(pier, low), tier.springing + low))
        heads = _heads(tier, pier, course)
        found += [_upright(x, tier.springing + low, tier.springing + high) for x in heads]
        for offset, height in tier.corners[: tier.first_flat]:
            if low < height < high:
                found += _short_beds(tier, pier, float(offset), float(height), heads)
    return found


def _heads(tier: Tier, pier: int, course: int) -> list[float]:
    """x of the head joints of a course over a pier: running bond about its axis, or from the end of the wall."""
    low = tier.beds[course]
    start, end = tier.zone(pier, low)
    ends = {0: tier.left[0], tier.spans: tier.right[-1]}
    anchor = ends.get(pier, 0.5 * (tier.left[pier] + tier.right[pier])) + 0.5 * tier.unit * (course % 2)
    margin = LEAST_UNIT * tier.unit
    heads = running(start + margin, end - margin, tier.unit, float(anchor))
    below = [x for axis in tier.axes for x, _, stop in _risers(tier, float(axis)) if stop == low]
    return _cleared(heads, below, LEAST_BOND * tier.unit)


def _short_beds(tier: Tier, pier: int, offset: float, height: float, heads: list[float]) -> list[Segment]:
    """From a corner of the haunch within a course to the next head joint, or to what the course ends at."""
    found, z = [], tier.springing + height
    if pier > 0:
        far = tier.right[-1] if pier == tier.spans else tier.axes[pier] - offset
        found.append(_level(tier.axes[pier - 1] + offset, heads[0] if heads else far, z))
    if pier < tier.spans:
        far = tier.left[0] if pier == 0 else tier.axes[pier - 1] + offset
        found.append(_level(heads[-1] if heads else far, tier.axes[pier] - offset, z))
    return found


def _risers(tier: Tier, axis: float) -> list[tuple[float, float, float]]:
    """Head joints that rise from the corners of the crown to the first bed that passes over them: x and two heights."""
    found = []
    inner = [*tier.corners[1:, 0], 0.0]
    for k in range(tier.first_flat, len(tier.corners)):
        offset, height = (float(v) for v in tier.corners[k])
        stop = next(bed for bed in tier.beds if bed > height and tier.bed_end(bed) <= inner[k])
        found += [(axis + side * offset, height, stop) for side in (-1.0, 1.0)]
    return found


def _bond_over_crowns(tier: Tier, above: Sequence[float]) -> list[Segment]:
    """The courses that run over the whole tier: beds, and head joints in running bond."""
    found = []
    low, high = float(tier.left[0]), float(tier.right[-1])
    count = max(1, round((high - low) / tier.unit))
    beds, last = tier.beds[tier.first_complete :], len(tier.beds) - 2
    for course, (bottom, top) in enumerate(pairwise(beds)):
        found.append(_level(low, high, tier.springing + bottom))
        heads = even(low, high, count, odd=course % 2 == 1)
        taken = list(above) if tier.first_complete + course == last else []
        if course == 0:
            taken += [x for axis in tier.axes for x, _, stop in _risers(tier, float(axis)) if stop == bottom]
            taken += [x for pier in range(tier.spans + 1) for x in _heads(tier, pier, tier.first_complete - 1)]
        heads = _cleared(heads, taken, LEAST_BOND * tier.unit)
        found += [_upright(x, tier.springing + bottom, tier.springing + top) for x in heads]
    return found
