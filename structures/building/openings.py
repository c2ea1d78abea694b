# SPDX-License-Identifier: GPL-3.0-or-later
"""The openings of walls in their facets: where each lies, and that it lies in masonry, clear of junctions, bends and others."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType

import numpy as np
from shapely.geometry import Polygon

from masonry_cd.foundation.errors import Faults, InputError
from structures.building.axes import SAME, Leg
from structures.building.beds import course_range
from structures.building.footprints import BuildingPlan
from structures.building.frames import Around, Frame, Named, frame_of
from structures.building.panels import Laying
from structures.building.table import BuildingTable, WallOpeningTable
from structures.building.widths import fat_pieces
from structures.courser.bond import even
from structures.courser.courses import divided
from structures.geometry import polygons
from structures.plans.places import place

LEAST_JAMB = 0.05  # masonry between a frame and an end of its wall, a junction or another frame [m]
Frames = dict[tuple[int, int], list[Frame]]


def frames(
    plan: BuildingPlan, table: BuildingTable, faults: Faults, places: Mapping[tuple[int, int], str] = MappingProxyType({})
) -> Frames:
    """The frames of all openings by leg and facet; one beyond its wall is a fault. Presets are keyed by wall and opening."""
    legs = plan.legs
    found: Frames = {}
    for number, wall in enumerate(table.walls):
        for i, keys in enumerate(wall.openings):
            own = [leg.where for leg in legs if leg.wall == number]
            name = Named(f"{own[0]}.openings[{i}]", f"opening {keys.name or f'o{i + 1}'} of wall {wall.name} at {keys.at:g} m")
            name = Named(places[number, i], "") if (number, i) in places else name
            with faults.of(*name):
                there = _facet_at(legs, number, keys.at)
                leg, f = legs[there[0]], there[1]
                around = Around(
                    leg.facets[f].s_of(keys.at), leg.base, wall.course_height or table.course_height,
                    wall.block_length or table.block_length, wall.thickness, *_masonry(plan, there, keys),
                )  # fmt: skip
                found.setdefault(there, []).append(frame_of(keys, name, around))
    return found


def _masonry(plan: BuildingPlan, there: tuple[int, int], keys: WallOpeningTable) -> tuple[float, float]:
    """Masonry next to a hole, on the side that has less of it, and z of the lowest part of the top over it [m]."""
    leg, facet = plan.legs[there[0]], plan.legs[there[0]].facets[there[1]]
    s, half = facet.s_of(keys.at), 0.5 * keys.width
    bends = [0.5 * leg.thickness * abs(cut) for cut in facet.cuts]
    taken = [(-math.inf, bends[0]), (facet.length - bends[1], math.inf)]
    taken += [
        (arm.low, arm.high) for _, _, arm, other in plan.arms(*there) if max(z for _, z in plan.legs[other.leg].tops) > leg.base + keys.sill
    ]
    holes = [(o, facet.s_of(o.at)) for o in leg.keys.openings if o is not keys and _heights_meet(o, keys)]
    spaces = [max(low - s, s - high) - half - LEAST_JAMB for low, high in taken]
    spaces += [0.5 * (abs(at - s) - half - 0.5 * o.width) - SAME for o, at in holes]
    left, right = max(0.0, s - half), min(facet.length, s + half)
    top = min(z for _, z in leg.tops_between(facet, left, right)) if left < right else math.inf
    return min(spaces), top


def _heights_meet(one: WallOpeningTable, other: WallOpeningTable) -> bool:
    """Return True if two openings of a wall may have masonry in common next to them: one does not begin well above the other."""
    top = [o.sill + (o.height or 2.0 * o.width) + 0.5 * o.width for o in (one, other)]
    return one.sill < top[1] and other.sill < top[0]


def _facet_at(legs: Sequence[Leg], wall: int, at: float) -> tuple[int, int]:
    """Leg and facet of a place along the axis of a wall.

    Raises:
        InputError: it is beyond the wall.
    """
    own = [(facet, k, f) for k, leg in enumerate(legs) if leg.wall == wall for f, facet in enumerate(leg.facets)]
    for facet, k, f in own:
        if facet.span[0] - SAME <= at <= facet.span[1] + SAME:
            return k, f
    raise InputError("", f"it is beyond the wall, which is {max(facet.span[1] for facet, *_ in own):.4g} m long")


def check(plan: BuildingPlan, layings: Sequence[Laying], found: Frames, faults: Faults) -> None:
    """Each frame lies in the masonry of its facet, clear of what else is there."""
    for (k, f), some in found.items():
        facet = plan.legs[k].facets[f]
        for i, frame in enumerate(some):
            with faults.of(*frame.name):
                _check_within(plan, k, f, frame, layings[k])
            for other in some[:i]:
                if frame.hull.distance(other.hull) < SAME and frame.hull.intersection(other.hull).area > polygons.LEAST_AREA:
                    at = facet.place(np.array([frame.hull.intersection(other.hull).centroid.x, 0.0]))
                    with faults.of(*frame.name):
                        raise InputError("", f"with its head it overlaps {other.name}, at {place(at)}")


def _check_within(plan: BuildingPlan, number: int, f: int, frame: Frame, laying: Laying) -> None:
    """Refuse a frame that reaches beyond the top of its wall or its end, over a bend or a junction.

    Raises:
        InputError: says which.
    """
    leg, facet = plan.legs[number], plan.legs[number].facets[f]
    left, low, right, high = frame.hull.bounds
    margin = LEAST_JAMB
    profile = leg.tops_between(facet, left, right)
    wall = Polygon(
        [
            (left - margin, leg.base - 1.0),
            (right + margin, leg.base - 1.0),
            *reversed([(left - margin, profile[0][1]), *profile, (right + margin, profile[-1][1])]),
        ]
    )
    if low < leg.base - SAME:
        raise InputError("", f"with its ring it reaches down to z = {low:.4g} m, the wall begins at {leg.base:.4g} m")
    if not wall.buffer(1e-7).contains(frame.hull):
        top = min(z for _, z in profile)
        raise InputError("", f"with its head it reaches up to z = {high:.4g} m, the wall there to {top:.4g} m")
    for course in course_range(laying.beds, low, high):
        z0, z1 = float(laying.beds[course]), float(laying.beds[course + 1])
        fits = [polygons.clean_stretch(area, 0.5 * leg.thickness) for area in plan.owned(number, f, course, z0, z1)]
        if any(a + margin <= left + SAME and right <= b - margin + SAME for a, b in fits):
            continue
        near = [
            (junction, other) for junction, _, own, other in plan.arms(number, f) if own.low - margin < right and left < own.high + margin
        ]
        if near:
            names = " and ".join(dict.fromkeys(plan.legs[other.leg].keys.name for _, other in near))
            raise InputError("", f"with its head it lies over the junction with wall {names} at {place(near[0][0].point)}")
        end = facet.place(np.array([0.0 if left < margin + 0.5 * leg.thickness else facet.length, 0.0]))
        what = "the end of the wall" if all(facet.open) else "a bend or the end of the wall"
        raise InputError("", f"with its head, {right - left:.3g} m wide, it comes closer than {margin:g} m to {what} at {place(end)}")


def back(frame: Frame, course: float, unit: float) -> Iterator[list[np.ndarray]]:
    """Convex polygons s, z of each stone at the back of a niche."""
    left, low, right, high = frame.hole.bounds
    columns = max(1, round((right - left) / unit))
    for j, bed in enumerate(pairwise(divided(low, high, course))):
        for a, b in pairwise([left, *even(left, right, columns, odd=j % 2 == 1 and columns > 1), right]):
            for part in polygons.polygons(frame.hole.intersection(polygons.box(a, b, *bed))):
                yield fat_pieces(part)
