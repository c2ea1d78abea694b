# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: the face of one facet of a wall, cut into stones course by course.

What a course fills of its facet in plan comes from :mod:`structures.building.footprints`. Along it head joints stand in running bond, clear
of its ends and of jambs; the frames of openings and the profile of the top cut the stones. What would be a sliver is joined to the stone
that it shares its longest side with.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon

from structures.building.axes import SAME, Facet, Leg
from structures.building.beds import course_range
from structures.building.footprints import Plan
from structures.building.frames import Frame
from structures.building.table import Bond
from structures.geometry import polygons
from structures.layout.coursing import LEAST_BOND, LEAST_UNIT

THIN = 0.3  # a stone lower than this of a course is joined to another one
SHORT = 0.15  # and one shorter than this of a block
JITTER = {"regular": 0.0, "irregular": 0.22, "rubble": 0.32}  # by how much of a block head joints are moved at most


@dataclass(frozen=True, eq=False)
class Laying:
    """How the courses of a wall are laid."""

    beds: np.ndarray  # heights (N + 1,) [m]
    course: float  # height aimed at [m]
    unit: float  # length of a block [m]
    bond: Bond
    seed: int


@dataclass(frozen=True, eq=False)
class Piece:
    """A stone of a facet."""

    course: int
    shape: Polygon  # s, z [m]
    area: Polygon  # footprint of its course, s, n [m]
    clean: tuple[float, float]  # s between which that has the whole thickness [m]
    mitre: tuple[bool, bool] = (False, False)  # whether it reaches the facet before, and the one after


def lay(plan: Plan, number: int, f: int, laying: Laying, frames: Sequence[Frame]) -> list[Piece]:
    """The stones of a facet, without those of its frames."""
    leg = plan.legs[number]
    facet = leg.facets[f]
    pieces: list[Piece] = []
    below: list[float] = []
    for course in course_range(laying.beds, leg.base, max(z for _, z in leg.tops)):
        low, high = float(laying.beds[course]), float(laying.beds[course + 1])
        hulls = [frame.hull for frame in frames if frame.hull.bounds[1] < high - SAME and frame.hull.bounds[3] > low + SAME]
        hulls = [_on_beds(hull, low, high) for hull in hulls]
        heads: list[float] = []
        for area in plan.owned(number, f, course, low, high):
            region = _region(leg, facet, area, low, high, hulls)
            if region is None:
                continue
            clean = polygons.clean_stretch(area, 0.5 * leg.thickness)
            left, _, right, _ = region.bounds
            end = 0.5 * LEAST_UNIT * laying.unit
            own = [s for s in _heads(leg, facet, clean, laying, course, below) if left + end < s < right - end]
            own = _clear_of(own, region, laying, high - low) if hulls else own
            heads += own
            pieces += _stones(facet, area, region, clean, own, course)
        below = heads
    return _without_slivers(pieces, laying)


def _on_beds(hull: Polygon, low: float, high: float) -> Polygon:
    """A frame whose corners lie in the beds of a course to the bit, where rounding alone parts them: no hair of stone runs over it."""

    def moved(points: np.ndarray) -> np.ndarray:
        for bed in (low, high):
            points[np.abs(points[:, 1] - bed) < SAME, 1] = bed
        return points

    return shapely.transform(hull, moved)


def _region(leg: Leg, facet: Facet, area: Polygon, low: float, high: float, hulls: Sequence[Polygon]) -> Polygon | None:
    """What of a course a footprint fills in its face, without frames; None where nothing."""
    left, _, right, _ = area.bounds
    tops = leg.tops_between(facet, left, right)
    foot = max(low, leg.base)
    if min(z for _, z in tops) >= high - SAME:
        region = polygons.box(left, right, foot, high)
    else:
        under = min(foot, min(z for _, z in tops)) - 1.0
        profile = Polygon([(left, under), (right, under), *reversed(tops)])
        region = profile.intersection(polygons.box(left, right, foot, high))
    if hulls:
        region = region.difference(shapely.union_all(list(hulls)))
    return region if region.area > polygons.LEAST_AREA else None


def _heads(leg: Leg, facet: Facet, clean: tuple[float, float], laying: Laying, course: int, below: Sequence[float]) -> list[float]:
    """s of the head joints of a course between the ends of its footprint."""
    least = LEAST_UNIT * laying.unit
    low, high = clean[0] + least, clean[1] - least
    if high < low:
        return []
    chained = not all(facet.open)  # facets of a bent wall have their bond each for itself
    unit = facet.length / max(1, round(facet.length / laying.unit)) if chained else laying.unit
    shift = 0.5 * (course % 2)
    first, last = math.ceil((low - SAME) / unit - shift), math.floor((high + SAME) / unit - shift)
    heads = [(k + shift) * unit for k in range(first, last + 1)]
    if not heads and clean[1] - clean[0] > 1.6 * unit:
        heads = [0.5 * (low + high)]
    jitter = JITTER[laying.bond] * unit
    if jitter and heads:
        random = np.random.default_rng([laying.seed, zlib.crc32(leg.keys.name.encode()), leg.number, course, first + 10**6])
        heads = (np.array(heads) + jitter * (2.0 * random.random(len(heads)) - 1.0)).tolist()
        heads = [min(max(_apart(x, below, LEAST_BOND * unit), low), high) for x in heads]
    return heads


def _apart(x: float, taken: Sequence[float], least: float) -> float:
    """A joint moved so far from one of the course below that the stones overlap."""
    near = min(taken, key=lambda t: abs(t - x), default=math.inf)
    return x if abs(near - x) >= least else near + math.copysign(least, x - near)


def _clear_of(heads: Sequence[float], region: Polygon, laying: Laying, height: float) -> list[float]:
    """The head joints that are clear of jambs, and of thin places over crowns."""
    least = LEAST_UNIT * laying.unit

    def clear(s: float) -> float:
        line = LineString([(s, -polygons.FAR), (s, polygons.FAR)])
        return float(region.intersection(line).length)

    return [s for s in heads if min(clear(s - least), clear(s), clear(s + least)) > THIN * height]


def _stones(facet: Facet, area: Polygon, region: Polygon, clean: tuple[float, float], heads: Sequence[float], course: int) -> list[Piece]:
    """The region of a course cut at its head joints."""
    left, low, right, high = region.bounds
    level = polygons.is_rectangle(region)
    first = not facet.open[0] and left < 0.5 * facet.length and _touches(area, facet, 0)
    last = not facet.open[1] and right > 0.5 * facet.length and _touches(area, facet, 1)
    found = []
    for a, b in pairwise([left, *heads, right]):
        parts = [polygons.box(a, b, low, high)] if level else _cut(region, a, b)
        for part in parts:
            ends = part.bounds[0] < left + SAME, part.bounds[2] > right - SAME
            found.append(Piece(course, part, area, clean, (first and ends[0], last and ends[1])))
    return found


def _touches(area: Polygon, facet: Facet, end: int) -> bool:
    """Whether a footprint reaches the mitre at an end of its facet."""
    s = facet.length if end else 0.0
    slope = facet.cuts[end]
    half = max(abs(n) for _, n in polygons.loop(area))
    line = LineString([(s - half * slope, -half), (s + half * slope, half)])
    return bool(area.exterior.intersection(line.buffer(1e-7)).length > half)


def _cut(region: Polygon, low: float, high: float) -> list[Polygon]:
    """What of a region lies between two head joints; around a hole in two halves."""
    found = []
    for part in polygons.polygons(region.intersection(polygons.box(low, high))):
        if not part.interiors:
            found.append(part)
            continue
        middle = float(np.mean([polygons.loop(Polygon(ring))[:, 0].mean() for ring in part.interiors]))
        found += _cut(part, low, middle) + _cut(part, middle, high)
    return found


def _without_slivers(pieces: Sequence[Piece], laying: Laying) -> list[Piece]:
    """The stones with slivers joined to what they share their longest side with."""
    by_course: dict[int, list[Piece]] = {}
    for piece in pieces:
        by_course.setdefault(piece.course, []).append(piece)
    for course in sorted(by_course):
        for piece in [p for p in by_course[course] if _is_sliver(p.shape, laying)]:
            if piece not in by_course[course]:
                continue
            beside = [p for p in by_course[course] if p is not piece and p.area is piece.area]
            beside += [p for j in (course - 1, course + 1) for p in by_course.get(j, []) if _both_clean(piece, p)]
            shared = [(_side(piece.shape, other.shape), k) for k, other in enumerate(beside)]
            length, k = max(shared, default=(0.0, 0), key=lambda item: (round(item[0], 9), -item[1]))
            if length < 1e-6:
                continue
            other = beside[k]
            union = polygons.polygons(shapely.union_all([piece.shape, other.shape]))
            if len(union) != 1 or union[0].interiors:
                continue
            own = by_course[other.course]
            mitre = (other.mitre[0] or piece.mitre[0], other.mitre[1] or piece.mitre[1])
            own[own.index(other)] = replace(other, shape=union[0], mitre=mitre)
            by_course[course].remove(piece)
    return [piece for course in sorted(by_course) for piece in by_course[course]]


def _is_sliver(shape: Polygon, laying: Laying) -> bool:
    left, low, right, high = shape.bounds
    return shape.area < THIN * laying.course * (right - left) or shape.area < SHORT * laying.unit * (high - low)


def _both_clean(one: Piece, other: Piece) -> bool:
    """Whether two stones of different courses have the whole thickness."""
    return all(p.clean[0] - SAME <= p.shape.bounds[0] and p.shape.bounds[2] <= p.clean[1] + SAME for p in (one, other))


def _side(one: Polygon, other: Polygon) -> float:
    """Length of what two stones share [m]."""
    a, b = one.bounds, other.bounds
    if a[0] > b[2] + SAME or b[0] > a[2] + SAME or a[1] > b[3] + SAME or b[1] > a[3] + SAME:
        return 0.0
    return float(one.exterior.intersection(other.exterior.buffer(1e-8)).length) if one.distance(other) < 1e-8 else 0.0
