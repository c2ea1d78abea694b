# SPDX-License-Identifier: GPL-3.0-or-later
"""Who fills what of a plan in each course: the strip of a facet, drawn out to the far faces of the walls that it ends at, less what the
walls before it in the order of the course fill.

Interlocked walls take turns: of two, one is first in even courses and the other in odd ones; of more, each in its turn. At a butt joint one
is always first, and of a share of interlocked courses the other one in half as many. A wall that does not stand as high as the course, or
that slopes within it there, is never first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from masonry_cd.mechanics.model.polygon import clip
from structures.building.axes import SAME, Leg, place
from structures.building.junctions import Arm, Junction, Pair
from structures.building.widths import NARROW, without_tails
from structures.geometry.polygons import without_straight

LEAST_AREA = 1e-10  # what is smaller in plan is rounding [m2]


@dataclass(frozen=True, eq=False)
class Plan:
    """The legs of a plan with their junctions."""

    legs: Sequence[Leg]
    junctions: Sequence[Junction]
    shapes: dict[tuple[int, int], Polygon] = field(default_factory=dict)  # of leg and facet, drawn out to far faces; s, n [m]
    areas: dict[tuple[int, int, frozenset[int]], list[Polygon]] = field(default_factory=dict)  # what other legs leave of it

    def shape(self, leg: int, facet: int) -> Polygon:
        """What a facet would fill in plan if it came first everywhere; s, n [m]."""
        key = leg, facet
        if key not in self.shapes:
            self.shapes[key] = _drawn_out(self, leg, facet)
        return self.shapes[key]

    def arms(self, leg: int, facet: int) -> list[tuple[Junction, Pair, Arm, Arm]]:
        """The junctions of a facet: its arm of each pair, and the other."""
        return [
            (junction, pair, own, other)
            for junction in self.junctions
            for pair in junction.pairs
            for own, other in (pair.arms, pair.arms[::-1])
            if (own.leg, own.facet) == (leg, facet)
        ]

    def owned(self, leg: int, facet: int, course: int, low: float, high: float) -> list[Polygon]:
        """What a facet fills in plan in a course between two heights; s, n [m]."""
        before = frozenset(
            other
            for junction in {id(j): j for j, *_ in self.arms(leg, facet)}.values()
            for other in _before(order(self, junction, course, low, high), leg)
        )
        key = leg, facet, before
        if key not in self.areas:
            self.areas[key] = _left_of(self, leg, facet, before)
        return self.areas[key]


def stands(plan: Plan, arm: Arm, low: float, high: float) -> float:
    """Share of a height that a leg fills at a junction: 1 where it stands all the way up, 0 where not at all."""
    leg = plan.legs[arm.leg]
    facet = leg.facets[arm.facet]
    tops = [z for _, z in leg.tops_between(facet, arm.low, arm.high)]
    least, most = min(high, *tops) - max(low, leg.base), min(high, max(tops)) - max(low, leg.base)
    if most <= SAME:
        return 0.0
    return max(0.0, least) / (high - low) if least < high - low - SAME else 1.0


def order(plan: Plan, junction: Junction, course: int, low: float, high: float) -> list[int]:
    """The legs that stand at a junction in a course, the first of them fills it.

    Raises:
        ValueError: no leg fills it, and two do so in part.
    """
    arms = {arm.leg: arm for pair in junction.pairs for arm in pair.arms}
    share = {leg: stands(plan, arm, low, high) for leg, arm in arms.items()}
    standing = [leg for leg in junction.legs if share[leg] > 0.0 or _grazes(plan, arms[leg], low, high)]
    whole = [leg for leg in standing if share[leg] == 1.0]
    part = [leg for leg in standing if share[leg] < 1.0]
    if not whole and len(part) > 1:
        if len({round(share[leg], 6) for leg in part}) > 1 or share[part[0]] == 0.0:
            names = " and ".join(plan.legs[leg].keys.name for leg in part)
            raise ValueError(
                f"walls {names}: both tops slope or step within their junction at {place(junction.point)}, z = {low:.4g} to {high:.4g} m; "
                "let one of them be level there"
            )
        whole, part = part, []
    return [*_in_turn(junction, whole, course), *part]


def _grazes(plan: Plan, arm: Arm, low: float, high: float) -> bool:
    """Whether any of a leg stands at a junction between two heights."""
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


def _first_of(pair: Pair, course: int) -> int:
    """Which of two walls runs through in a course."""
    share = float(pair.bond == "bonded") if isinstance(pair.bond, str) else pair.bond
    other = math.floor((course + 1) * 0.5 * share + 1e-9) > math.floor(course * 0.5 * share + 1e-9)
    return 1 - pair.through if other else pair.through


def _before(legs: Sequence[int], leg: int) -> Sequence[int]:
    return legs[: legs.index(leg)] if leg in legs else legs


def _drawn_out(plan: Plan, number: int, f: int) -> Polygon:
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


def _left_of(plan: Plan, number: int, f: int, before: frozenset[int]) -> list[Polygon]:
    """What of a facet the legs before it leave; what of that is narrow is for itself."""
    facet, shape = plan.legs[number].facets[f], plan.shape(number, f)
    left: BaseGeometry = shape
    for other in sorted(before):
        for g in sorted({arm.facet for j in plan.junctions for p in j.pairs for arm in p.arms if arm.leg == other and number in j.legs}):
            across = plan.legs[other].facets[g]
            ring = np.array(plan.shape(other, g).exterior.coords)[:-1]
            left = left.difference(Polygon(_on_faces(facet.local(across.place(ring)), 0.5 * plan.legs[number].thickness)))
    parts = getattr(left, "geoms", [left])  # polygons, and lines where two only touch
    thickness = plan.legs[number].thickness
    whole = [part for part in parts if isinstance(part, Polygon) and part.area > LEAST_AREA]
    cut = [piece for part in whole for piece in (without_tails(part, NARROW * thickness) if before else [part])]
    return [_snapped(piece, 0.5 * thickness) for piece in cut]


def _snapped(shape: Polygon, half: float) -> Polygon:
    """A polygon whose corners on the faces of its wall lie in them to the bit, without corners in the middle of a side."""
    return Polygon(without_straight(_on_faces(np.array(shape.exterior.coords)[:-1], half)))


def _on_faces(ring: np.ndarray, half: float) -> np.ndarray:
    """Corners (n, 2) s, n of which those that rounding parts from a face of the wall lie in it to the bit."""
    on = np.abs(np.abs(ring[:, 1]) - half) < SAME
    out = ring.copy()
    out[on, 1] = np.copysign(half, ring[on, 1])
    return out
