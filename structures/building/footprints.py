# SPDX-License-Identifier: GPL-3.0-or-later
"""Who fills what of a plan in each course: the strip of a facet, drawn out to the far faces of the walls that it ends at, less what the
walls before it in the order of the course fill.

Interlocked walls take turns: of two, one is first in even courses and the other in odd ones; of more, each in its turn. At a butt joint one
is always first, and of a share of interlocked courses the other one in half as many. A wall that does not stand as high as the course, or
that slopes within it there, is never first; of two such walls each fills what of the junction lies under its own top, where that is higher.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from masonry_cd.mechanics.model.polygon import clip
from structures.building.axes import SAME, Facet, Leg
from structures.building.junctions import Arm, FacetPair, Junction
from structures.building.widths import NARROW, without_tails
from structures.geometry import polygons

LEAST_AREA = 1e-10  # what is smaller in plan is rounding [m2]
LEVEL = 1e-7  # tops that differ by less are as high [m]
FAR = 1e4  # beyond any strip [m]


Rival = tuple[int, bool]  # another leg that does not stand all the way up, and whether it comes first where both are as high


class Turns(NamedTuple):
    """The legs of a junction in a course, in their order."""

    whole: list[int]  # that stand all the way up: the first fills it
    part: list[int]  # that do not: of the rest each fills what it is the highest over


@dataclass(frozen=True, eq=False)
class BuildingPlan:
    """The legs of a plan with their junctions."""

    legs: Sequence[Leg]
    junctions: Sequence[Junction]
    shapes: dict[tuple[int, int], Polygon] = field(default_factory=dict)  # of leg and facet, drawn out to far faces; s, n [m]
    areas: dict[tuple[int, int, frozenset[int], frozenset[Rival]], list[Polygon]] = field(default_factory=dict)  # what others leave of it
    orders: dict[tuple[Junction, int, float, float], Turns] = field(default_factory=dict)  # by junction, course and heights

    def shape(self, leg: int, facet: int) -> Polygon:
        """Return the area that a facet would fill in plan if it came first everywhere; s, n [m]."""
        key = leg, facet
        if key not in self.shapes:
            self.shapes[key] = _drawn_out(self, leg, facet)
        return self.shapes[key]

    def arms(self, leg: int, facet: int) -> list[tuple[Junction, FacetPair, Arm, Arm]]:
        """The junctions of a facet: its arm of each pair, and the other."""
        return [
            (junction, pair, own, other)
            for junction in self.junctions
            for pair in junction.pairs
            for own, other in (pair.arms, pair.arms[::-1])
            if (own.leg, own.facet) == (leg, facet)
        ]

    def owned(self, leg: int, facet: int, course: int, low: float, high: float) -> list[Polygon]:
        """Return the areas that a facet fills in plan in a course between two heights; s, n [m]."""
        before, rivals = set[int](), set[Rival]()
        for junction in {id(j): j for j, *_ in self.arms(leg, facet)}.values():
            turns = self.order(junction, course, low, high)
            before |= {*turns.whole[: turns.whole.index(leg)]} if leg in turns.whole else {*turns.whole}
            rivals |= {
                (other, turns.part.index(other) < turns.part.index(leg)) for other in turns.part if leg in turns.part and other != leg
            }
            before |= {*turns.part} if leg not in turns.whole and leg not in turns.part else set()
        key = leg, facet, frozenset(before), frozenset(rivals)
        if key not in self.areas:
            self.areas[key] = _left_of(self, *key)
        return self.areas[key]

    def order(self, junction: Junction, course: int, low: float, high: float) -> Turns:
        """See :func:`order`."""
        key = junction, course, low, high
        if key not in self.orders:
            self.orders[key] = order(self, *key)
        return self.orders[key]

    def first_at(self, leg: int, facet: int, course: int, low: float, high: float) -> Iterator[Arm]:
        """The arms of a facet at which it lies over another wall in a course between two heights, and interlocks with it."""
        for junction, pair, own, other in self.arms(leg, facet):
            turns = self.order(junction, course, low, high)
            legs = [*turns.whole, *turns.part]
            if pair.bond != "butt" and leg in legs and other.leg in legs and legs.index(leg) < legs.index(other.leg):
                yield own


def stands(plan: BuildingPlan, arm: Arm, low: float, high: float) -> float:
    """Share of a height that a leg fills at a junction: 1 where it stands all the way up, 0 where not at all."""
    leg = plan.legs[arm.leg]
    facet = leg.facets[arm.facet]
    tops = [z for _, z in leg.tops_between(facet, arm.low, arm.high)]
    least, most = min(high, *tops) - max(low, leg.base), min(high, max(tops)) - max(low, leg.base)
    if most <= SAME:
        return 0.0
    return max(0.0, least) / (high - low) if least < high - low - SAME else 1.0


def order(plan: BuildingPlan, junction: Junction, course: int, low: float, high: float) -> Turns:
    """The legs that stand at a junction in a course, those that do so all the way up first."""
    arms = {arm.leg: arm for pair in junction.pairs for arm in pair.arms}
    share = {leg: stands(plan, arm, low, high) for leg, arm in arms.items()}
    standing = [leg for leg in junction.legs if share[leg] > 0.0 or _grazes(plan, arms[leg], low, high)]
    whole, part = ([leg for leg in standing if (share[leg] == 1.0) == up] for up in (True, False))
    return Turns(_in_turn(junction, whole, course), _in_turn(junction, part, course))


def _grazes(plan: BuildingPlan, arm: Arm, low: float, high: float) -> bool:
    """Return True if any of a leg stands at a junction between two heights."""
    leg = plan.legs[arm.leg]
    tops = [z for _, z in leg.tops_between(leg.facets[arm.facet], arm.low, arm.high)]
    return max(tops) > low + SAME and leg.base < high - SAME


def _in_turn(junction: Junction, legs: Sequence[int], course: int) -> list[int]:
    """Legs that all stand, in the order of a course."""
    pairs = [pair for pair in junction.pairs if all(arm.leg in legs for arm in pair.arms)]
    if len(legs) > 2 and all(pair.bond in ("bonded", 1.0) for pair in pairs):
        first = course % len(legs)
        return [*legs[first:], *legs[:first]]
    wins = dict.fromkeys(legs, 0)
    for pair in pairs:
        wins[pair.arms[_first_of(pair, course)].leg] += 1
    return sorted(legs, key=lambda leg: -wins[leg])


def _first_of(pair: FacetPair, course: int) -> int:
    """Which of two walls runs through in a course."""
    share = float(pair.bond == "bonded") if isinstance(pair.bond, str) else pair.bond
    other = math.floor((course + 1) * 0.5 * share + 1e-9) > math.floor(course * 0.5 * share + 1e-9)
    return 1 - pair.through if other else pair.through


def _drawn_out(plan: BuildingPlan, number: int, f: int) -> Polygon:
    """The strip of a facet, at junctions where it ends up to the far face of each wall there."""
    leg = plan.legs[number]
    facet, half = leg.facets[f], 0.5 * leg.thickness
    arms = plan.arms(number, f)
    at = {end: [(pair, own, other) for _, pair, own, other in arms if own.end == end] for end in (-1, 1)}
    (low, high), length = facet.cuts, facet.length
    first, last = min([0.0, *(own.low for _, own, _ in at[-1])]), max([length, *(own.high for _, own, _ in at[1])])
    corners = np.array(
        [(first - half * low, -half), (last - half * high, -half), (last + half * high, half), (first + half * low, half)], dtype=float
    )
    for end in (-1, 1):
        for pair, _, other in at[end]:
            across = plan.legs[other.leg].facets[other.facet]
            body = facet.place(np.array([0.5 * length, 0.0])) - pair.point
            normal = across.left if across.left @ body < 0.0 else -across.left
            edge = 0.5 * plan.legs[other.leg].thickness - (facet.place(corners) - pair.point) @ normal
            corners = clip(corners, edge, SAME)
    return Polygon(corners)


def _left_of(plan: BuildingPlan, number: int, f: int, before: frozenset[int], rivals: frozenset[Rival]) -> list[Polygon]:
    """Return the part of a facet that the legs before it leave, and its rivals where they are higher; narrow parts are by themselves."""
    left: BaseGeometry = plan.shape(number, f)
    for other in sorted(before):
        for g in _met(plan, number, other):
            left = left.difference(_seen_from(plan, (number, f), (other, g)))
    for other, first in sorted(rivals):
        for g in _met(plan, number, other):
            left = left.difference(_higher(plan, (number, f), (other, g), first))
    parts = getattr(left, "geoms", [left])  # polygons, and lines where two only touch
    thickness = plan.legs[number].thickness
    whole = [half for part in parts if isinstance(part, Polygon) and part.area > LEAST_AREA for half in polygons.without_holes(part)]
    cut = [piece for part in whole for piece in (without_tails(part, NARROW * thickness) if before or rivals else [part])]
    return [_snapped(piece, 0.5 * thickness) for piece in cut]


def _met(plan: BuildingPlan, number: int, other: int) -> list[int]:
    """The facets of another leg that meet one."""
    return sorted({arm.facet for j in plan.junctions if number in j.legs for p in j.pairs for arm in p.arms if arm.leg == other})


def _seen_from(plan: BuildingPlan, own: tuple[int, int], other: tuple[int, int]) -> Polygon:
    """The footprint of a facet in the coordinates s, n of another."""
    facet, across = (plan.legs[leg].facets[f] for leg, f in (own, other))
    ring = np.array(plan.shape(*other).exterior.coords)[:-1]
    return Polygon(_on_faces(facet.local(across.place(ring)), 0.5 * plan.legs[own[0]].thickness))


def _higher(plan: BuildingPlan, own: tuple[int, int], other: tuple[int, int], first: bool) -> BaseGeometry:
    """Where another facet is higher than one, s, n of this; where both are as high, all or nothing of it."""
    (leg, facet), (rival, across) = ((plan.legs[k], plan.legs[k].facets[f]) for k, f in (own, other))
    shared = plan.shape(*own).intersection(_seen_from(plan, own, other))
    found = []
    for (a, low), (b, high) in _slopes(leg, facet, plan.shape(*own)):
        for (c, lower), (d, upper) in _slopes(rival, across, plan.shape(*other)):
            strip = Polygon(facet.local(across.place(np.array([(c, -FAR), (d, -FAR), (d, FAR), (c, FAR)]))))
            for cell in polygons.polygons(shared.intersection(polygons.box(a, b)).intersection(strip), LEAST_AREA):
                ring = polygons.loop(cell)
                there = across.local(facet.place(ring))[:, 0]
                above = lower + (upper - lower) * (there - c) / (d - c) - low - (high - low) * (ring[:, 0] - a) / (b - a)
                if np.abs(above).max() < LEVEL:
                    found += [cell] if first else []
                elif len(corners := clip(ring, above, SAME)) > 2:
                    found.append(Polygon(corners))
    return shapely.union_all([cell for cell in found if cell.area > LEAST_AREA])


def _slopes(leg: Leg, facet: Facet, shape: Polygon) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """The straight pieces s, z of the top over a footprint, without its steps."""
    left, _, right, _ = shape.bounds
    return [(a, b) for a, b in pairwise(leg.tops_between(facet, left, right)) if b[0] - a[0] > SAME]


def _snapped(shape: Polygon, half: float) -> Polygon:
    """A polygon whose corners on the faces of its wall lie in them to the bit, without corners in the middle of a side."""
    return Polygon(polygons.without_straight(_on_faces(np.array(shape.exterior.coords)[:-1], half)))


def _on_faces(ring: np.ndarray, half: float) -> np.ndarray:
    """Corners (n, 2) s, n of which those that rounding parts from a face of the wall lie in it to the bit."""
    on = np.abs(np.abs(ring[:, 1]) - half) < SAME
    out = ring.copy()
    out[on, 1] = np.copysign(half, ring[on, 1])
    return out
