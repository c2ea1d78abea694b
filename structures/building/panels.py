# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: the face of one facet of a wall, cut into stones course by course.

What a course fills of its facet in plan comes from :mod:`structures.building.footprints`. Along it head joints stand in running bond, clear
of its ends and of jambs; the frames of openings and the profile of the top cut the stones. What would be a sliver is joined to the stone
that it shares its longest side with.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon

from structures.building.axes import SAME, Facet, Leg
from structures.building.beds import course_range
from structures.building.footprints import BuildingPlan
from structures.building.frames import Frame
from structures.building.junctions import Arm
from structures.building.table import Bond
from structures.building.widths import ASIDE, is_narrower
from structures.courser import bond
from structures.geometry import polygons

THIN = 0.3  # of a course: a stone that is lower on the average, or narrower throughout, is joined to another one
SHORT = 0.15  # of a block: and one that is shorter on the average
TONGUE = 0.1  # of a course over the head of an opening that may end at a head joint, at least
LONG = 1.6  # of a stone without head joint, at most, in blocks
JITTER = {"regular": 0.0, "irregular": 0.22, "rubble": 0.32}  # by how much of a block head joints are moved at most


@dataclass(frozen=True, eq=False)
class Leaves:
    """The leaves of a wall, see :mod:`structures.building.leaves`."""

    bounds: np.ndarray  # (L + 1,) n between which they lie [m]
    through: int = 3  # every through-th stone of every through-th course reaches through all of them; 0: none
    core: bool = False  # the middle one of three is a core
    hollow: bool = False  # which is left out

    def ties(self, course: int) -> bool:
        """Return True if a course, counted from the foot, has through-stones."""
        return self.through > 0 and course % self.through == self.through - 1


@dataclass(frozen=True, eq=False)
class Laying:
    """How the courses of a wall are laid."""

    beds: np.ndarray  # heights (N + 1,) [m]
    course: float  # height aimed at [m]
    unit: float  # length of a block [m]
    bond: Bond = "regular"
    seed: int = 0
    anchor: float = 0.0  # s at which the bond begins [m]
    leaves: Leaves | None = None  # through the thickness, where there are several


class CourseBand(NamedTuple):
    """A stretch of a course: s of its ends at the lower and at the upper bed, and how long its end stones must be at least [m]."""

    left0: float
    left1: float
    right0: float
    right1: float
    bond_left: float = 0.0
    bond_right: float = 0.0


@dataclass(frozen=True, eq=False)
class Stretch:
    """Area of a course that a facet fills in one place."""

    area: Polygon  # in plan, s, n [m]
    clean: tuple[float, float]  # s between which that has the whole thickness [m]
    region: Polygon  # in its face, s, z [m]
    band: CourseBand  # between whose ends its head joints lie
    cut: bool = False  # by a frame that does not keep to the courses


@dataclass(frozen=True, eq=False)
class FacetStone:
    """A stone of a facet."""

    course: int
    shape: Polygon  # s, z [m]
    area: Polygon  # footprint of its course, s, n [m]
    clean: tuple[float, float]  # s between which that has the whole thickness [m]
    mitre: tuple[bool, bool] = (False, False)  # whether it reaches the facet before, and the one after


def running(course: int) -> float:
    """Return the share of a block by which a course is shifted along its wall: half of one in every other."""
    return 0.5 * (course % 2)


def lay(
    plan: BuildingPlan, number: int, f: int, laying: Laying, frames: Sequence[Frame], shift: Callable[[int], float] = running
) -> list[FacetStone]:
    """The stones of a facet, without those of its frames."""
    leg = plan.legs[number]
    facet = leg.facets[f]
    courses = course_range(laying.beds, leg.base, max(z for _, z in leg.tops))
    rows = {course: list(stretches(plan, number, f, laying, frames, course)) for course in courses}
    pieces: list[FacetStone] = []
    below: list[float] = []
    for course, row in rows.items():
        above = [s for stretch in rows.get(course + 1, []) for s in (stretch.band.left0, stretch.band.right0)]
        heads: list[float] = []
        for stretch in row:
            own = _heads(leg, facet, stretch, laying, (course, shift(course)), [*below, *above])
            heads += own
            pieces += _stones(facet, stretch, own, course)
        below = heads + [s for stretch in row for s in (stretch.band.left1, stretch.band.right1)]
    return _without_slivers(pieces, laying)


def stretches(plan: BuildingPlan, number: int, f: int, laying: Laying, frames: Sequence[Frame], course: int) -> Iterator[Stretch]:
    """Yield the stretches of a course that a facet fills, from its start on."""
    leg = plan.legs[number]
    facet = leg.facets[f]
    low, high = float(laying.beds[course]), float(laying.beds[course + 1])
    hulls = [frame.hull for frame in frames if frame.hull.bounds[1] < high - SAME and frame.hull.bounds[3] > low + SAME]
    hulls = [_on_beds(hull, low, high) for hull in hulls]
    first = list(plan.first_at(number, f, course, low, high))
    for area in sorted(plan.owned(number, f, course, low, high), key=lambda shape: shape.bounds[0]):
        region = _region(leg, facet, area, low, high, hulls)
        if region is None:
            continue
        clean = polygons.clean_stretch(area, 0.5 * leg.thickness)
        for part in polygons.polygons(region):
            cut = bool(hulls) and not polygons.is_rectangle(part)
            yield Stretch(area, clean, part, _bonded(_band(part, clean), first, laying.unit), cut)


def _band(part: Polygon, clean: tuple[float, float]) -> CourseBand:
    """The ends of what a course fills in one place, at its foot and at its top; not beyond where it has the whole thickness."""
    s, z = polygons.loop(part).T
    ends = [float(np.clip(end, *clean)) for on in (z < z.min() + SAME, z > z.max() - SAME) for end in (s[on].min(), s[on].max())]
    return CourseBand(ends[0], ends[2], ends[1], ends[3])


def _bonded(band: CourseBand, first: Sequence[Arm], unit: float) -> CourseBand:
    """A band whose end stones reach beyond the walls that they lie over where it ends."""
    for arm in first:
        if abs(band.left0 - arm.low) < SAME or (arm.end < 0 and band.left0 < arm.high):
            band = band._replace(bond_left=arm.high - band.left0 + bond.LEAST_HEAD * unit)
        if abs(band.right0 - arm.high) < SAME or (arm.end > 0 and band.right0 > arm.low):
            band = band._replace(bond_right=band.right0 - arm.low + bond.LEAST_HEAD * unit)
    return band


def _on_beds(hull: Polygon, low: float, high: float) -> Polygon:
    """A frame whose corners lie in the beds of a course to the bit, where rounding alone parts them: no hair of stone runs over it."""

    def moved(points: np.ndarray) -> np.ndarray:
        for bed in (low, high):
            points[np.abs(points[:, 1] - bed) < SAME, 1] = bed
        return points

    return shapely.transform(hull, moved)


def _region(leg: Leg, facet: Facet, area: Polygon, low: float, high: float, hulls: Sequence[Polygon]) -> Polygon | None:
    """Return the region of a course that a footprint fills in its face, without frames; None where nothing."""
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


def _heads(leg: Leg, facet: Facet, stretch: Stretch, laying: Laying, at: tuple[int, float], taken: Sequence[float]) -> list[float]:
    """s of the head joints of a stretch of a course, given by its number and its shift in blocks, and those of its neighbours."""
    (course, shift), band = at, stretch.band
    least = bond.LEAST_HEAD * laying.unit
    low, high = max(band.left0, band.left1) + max(least, band.bond_left), min(band.right0, band.right1) - max(least, band.bond_right)
    if high < low - SAME:
        return []
    chained = not all(facet.open)  # facets of a bent wall have their bond each for itself
    unit = facet.length / max(1, round(facet.length / laying.unit)) if chained else laying.unit
    heads = bond.running(low, high, unit, laying.anchor + shift * unit)
    if not heads and min(band.right0 - band.left0, band.right1 - band.left1) > LONG * unit:
        heads = [min(max(0.5 * (low + high), low), high)]
    jitter = JITTER[laying.bond] * unit
    if jitter and heads:
        first = math.ceil((low - laying.anchor - shift * unit - SAME) / unit)
        random = np.random.default_rng([laying.seed, zlib.crc32(leg.keys.name.encode()), leg.number, course, first + 10**6])
        heads = (np.array(heads) + jitter * (2.0 * random.random(len(heads)) - 1.0)).tolist()
    heads = [bond.cleared(min(max(s, low), high), taken, bond.LEAST_BOND * unit, (low, high)) for s in heads]
    height = float(laying.beds[course + 1] - laying.beds[course])
    return _over_heads(_clear_of(heads, stretch, least, THIN * height), stretch, unit, TONGUE * height)


def _clear_of(heads: Sequence[float], stretch: Stretch, least: float, thin: float) -> list[float]:
    """The head joints that are clear of ends, and of jambs and thin places over crowns where an opening cuts the course."""
    left, _, right, _ = stretch.region.bounds
    heads = [s for s in heads if left + 0.5 * least < s < right - 0.5 * least]
    return [s for s in heads if not stretch.cut or min(_clear(stretch, at) for at in (s - least, s, s + least)) > thin]


def _over_heads(heads: Sequence[float], stretch: Stretch, unit: float, thin: float) -> list[float]:
    """The head joints of a stretch, and those over the head of an opening without which one long stone would bridge it."""
    if not stretch.cut:
        return list(heads)
    left, _, right, _ = stretch.region.bounds
    found = list(heads)
    for a, b in pairwise([left, *sorted(heads), right]):
        count = round((b - a) / unit) if b - a > LONG * unit else 1
        between = [a + (b - a) * k / count for k in range(1, count)]
        found += [s for s in between if _clear(stretch, s) > thin]
    return sorted(found)


def _clear(stretch: Stretch, s: float) -> float:
    """Height of what a stretch fills over a place [m]."""
    return float(stretch.region.intersection(LineString([(s, -polygons.FAR), (s, polygons.FAR)])).length)


def _stones(facet: Facet, stretch: Stretch, heads: Sequence[float], course: int) -> list[FacetStone]:
    """A stretch of a course cut at its head joints."""
    area, region = stretch.area, stretch.region
    left, low, right, high = region.bounds
    level = polygons.is_rectangle(region)
    first = not facet.open[0] and left < min(0.5 * facet.length, area.bounds[0] + SAME) and _touches(area, facet, 0)
    last = not facet.open[1] and right > max(0.5 * facet.length, area.bounds[2] - SAME) and _touches(area, facet, 1)
    found = []
    for a, b in pairwise([left, *heads, right]):
        parts = [polygons.box(a, b, low, high)] if level else _cut(region, a, b)
        for part in parts:
            ends = part.bounds[0] < left + SAME, part.bounds[2] > right - SAME
            found.append(FacetStone(course, part, area, stretch.clean, (first and ends[0], last and ends[1])))
    return found


def _touches(area: Polygon, facet: Facet, end: int) -> bool:
    """Return True if a footprint reaches the mitre at an end of its facet."""
    s = facet.length if end else 0.0
    slope = facet.cuts[end]
    half = max(abs(n) for _, n in polygons.loop(area))
    line = LineString([(s - half * slope, -half), (s + half * slope, half)])
    return bool(area.exterior.intersection(line.buffer(1e-7)).length > half)


def _cut(region: Polygon, low: float, high: float) -> list[Polygon]:
    """Return the parts of a region between two head joints; around a hole in two halves."""
    return [whole for part in polygons.polygons(region.intersection(polygons.box(low, high))) for whole in polygons.without_holes(part)]


def _without_slivers(pieces: Sequence[FacetStone], laying: Laying) -> list[FacetStone]:
    """The stones with slivers joined to what they share their longest side with, under several stones in pieces."""
    by_course: dict[int, list[FacetStone]] = {}
    for piece in pieces:
        by_course.setdefault(piece.course, []).append(piece)
    for course in sorted(by_course):
        own, slivers = by_course[course], [piece for piece in by_course[course] if _is_sliver(piece.shape, laying)]
        while slivers:
            piece = slivers.pop(0)
            if piece not in own:
                continue
            adjacent = [p for p in own if p is not piece and p.area is piece.area]
            if laying.leaves is None:  # which have some courses in common, and others each for itself
                adjacent += [p for j in (course - 1, course + 1) for p in by_course.get(j, []) if _are_both_clean(piece, p)]
            shared = [(_side(piece.shape, other.shape), k) for k, other in enumerate(adjacent)]
            length, k = max(shared, default=(0.0, 0), key=lambda item: (round(item[0], 9), -item[1]))
            if length < 1e-6:
                continue
            parts = _along(
                piece, [p for (side, _), p in zip(shared, adjacent, strict=True) if side > SAME and p.course == adjacent[k].course]
            )
            if len(parts) > 1:
                own[own.index(piece) : own.index(piece) + 1] = parts
                slivers = parts + slivers
            elif (union := _joined(piece, adjacent[k])) is not None:
                others = by_course[adjacent[k].course]
                others[others.index(adjacent[k])] = union
                own.remove(piece)
    return [piece for course in sorted(by_course) for piece in by_course[course]]


def _along(piece: FacetStone, neighbours: Sequence[FacetStone]) -> list[FacetStone]:
    """A sliver cut at the head joints between the stones of the course above or below it."""
    left, _, right, _ = piece.shape.bounds
    ends = {s for p in neighbours if p.course != piece.course for s in p.shape.bounds[::2] if left + ASIDE < s < right - ASIDE}
    return [replace(piece, shape=part) for a, b in pairwise([left, *sorted(ends), right]) for part in _cut(piece.shape, a, b)]


def _joined(piece: FacetStone, other: FacetStone) -> FacetStone | None:
    """Two stones as one, in the course of the second; None where that has a hole."""
    union = polygons.polygons(shapely.union_all([piece.shape, other.shape]))
    if len(union) != 1 or union[0].interiors:
        return None
    return replace(other, shape=union[0], mitre=(other.mitre[0] or piece.mitre[0], other.mitre[1] or piece.mitre[1]))


def _is_sliver(shape: Polygon, laying: Laying) -> bool:
    """True of a stone that is too low, too short, or too narrow throughout."""
    left, low, right, high = shape.bounds
    thin = shape.area < THIN * laying.course * (right - left) or shape.area < SHORT * laying.unit * (high - low)
    return thin or is_narrower(shape, THIN * min(laying.course, laying.unit))


def _are_both_clean(one: FacetStone, other: FacetStone) -> bool:
    """Return True if two stones of different courses have the whole thickness, each of them also in the course of the other."""
    low, high = max(one.clean[0], other.clean[0]), min(one.clean[1], other.clean[1])
    return all(low - SAME <= p.shape.bounds[0] and p.shape.bounds[2] <= high + SAME for p in (one, other))


def _side(one: Polygon, other: Polygon) -> float:
    """Length of what two stones share [m]."""
    a, b = one.bounds, other.bounds
    if a[0] > b[2] + SAME or b[0] > a[2] + SAME or a[1] > b[3] + SAME or b[1] > a[3] + SAME:
        return 0.0
    return float(one.exterior.intersection(other.exterior.buffer(1e-8)).length) if one.distance(other) < 1e-8 else 0.0
