# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: the face of a wall cut into courses, and the courses into blocks.

A panel lives in the plane of its wall, s along it and z up. Each course fills one or more bands between its two beds; a
band is a trapezoid whose ends are the end of the wall, a jamb, an extrados or the slope of a gable. Head joints divide the
bands in running bond: successive courses are shifted by half a block, joints keep their distance from the ends of their band,
and those that would nearly meet an upright joint of the course below are moved away from it, because an overlap of a few
millimetres is no bond.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.errors import InputError
from structures import size
from structures.layout.openings import Closing, Opening, haunch_break
from structures.layout.openings import breaks as breaks_of

LEAST_UNIT = 0.35  # between a head joint and the end of its band, in blocks
LEAST_JAMB = 0.2  # between an opening and the end of its band, in blocks
LEAST_BOND = 0.12  # between head joints of successive courses, in blocks
LEAST_COURSE = 0.4  # height of the lowest course between two given levels, in courses
SAME = 1e-9  # lengths closer than this are one [m]


class Band(NamedTuple):
    """A stretch of one course: s of its ends at the lower and at the upper bed, and how long its end blocks must be."""

    left0: float
    left1: float
    right0: float
    right1: float
    bond_left: float = 0.0
    bond_right: float = 0.0


@dataclass(frozen=True, eq=False)
class Piece:
    """One block of a panel."""

    polygon: np.ndarray  # (n, 2) s, z
    course: int
    kind: str  # stone, voussoir, lintel
    number: int  # within its course, or within its opening
    opening: int = -1  # the opening that it closes, -1 for none


Bands = Callable[[int], Sequence[Band]]
Shift = Callable[[int], float]


def levels(foot: float, top: float, openings: Sequence[Opening], course: float, more: Sequence[tuple[float, str]] = ()) -> list[float]:
    """Heights of all beds: courses of nearly one height between the levels that sills, springings and the like need.

    Args:
        foot, top: of the wall [m].
        course: the height of a course that is aimed at [m].
        more: further heights that need a bed, and the key that sets each.

    Raises:
        InputError: two levels that are too close for a course between them.
    """
    fixed = [(foot, "foot"), (top, "structure.height"), *more]
    for opening in openings:
        fixed += breaks_of(opening)
    beds = _divided(fixed, course)
    for opening in openings:
        extra = haunch_break(opening, beds, [z for z, _ in fixed], LEAST_COURSE * course)
        if extra:
            fixed.append(extra)
            beds = _divided(fixed, course)
    return beds


def _divided(fixed: Sequence[tuple[float, str]], course: float) -> list[float]:
    ordered = sorted(fixed, key=lambda item: item[0])
    size.within((ordered[-1][0] - ordered[0][0]) / course, ordered[-1][1].removeprefix("structure."))  # a block to a course, at least
    beds = [ordered[0][0]]
    below = ordered[0]
    for level, key in ordered[1:]:
        step = level - below[0]
        if step < SAME:
            continue
        if step < LEAST_COURSE * course - SAME:
            what, other = (key, below) if key != "structure.height" else (below[1], (level, key))
            raise InputError(
                f"{what}: asks for a bed {1e3 * step:.3g} mm from the one of {other[1]} at {other[0]:g} m; "
                f"bring them to one level, or {LEAST_COURSE * course:g} m apart or more, or take lower courses"
            )
        count = max(1, round(step / course))
        beds += [below[0] + step * i / count for i in range(1, count)] + [level]
        below = (level, key)
    return beds


def lay_courses(
    beds: Sequence[float], bands: Bands, closings: Sequence[Closing], unit: float, shift: Shift, anchor: float = 0.0
) -> list[Piece]:
    """Lay a wall in courses of blocks, around its openings.

    Args:
        beds: heights of the beds (N + 1,) [m].
        bands: the solid stretches of each course, without openings.
        closings: the openings.
        unit: length of a block [m].
        shift: of the bond of each course along the wall, in blocks; half a block in every other course makes a running bond.
        anchor: s at which the bond starts [m].

    Raises:
        InputError: an opening that is not inside the panel, or too near to an end or to another opening.
    """
    solid = [_pierced(list(bands(j)), j, closings, LEAST_JAMB * unit, beds) for j in range(len(beds) - 1)]
    pieces: list[Piece] = []
    below: list[float] = []
    for j, course in enumerate(solid):
        low, high = beds[j], beds[j + 1]
        above = [x for band in solid[j + 1] for x in (band.left0, band.right0)] if j + 2 < len(beds) else []
        ends = [x for band in course for x in (band.left1, band.right1)]
        heads: list[float] = []
        number = 0
        for band in course:
            inner = _heads(band, anchor + shift(j) * unit, unit, [*below, *above])
            heads += inner
            for polygon in _trapezoids(band, inner, low, high):
                pieces.append(Piece(polygon, j, "stone", number))
                number += 1
        below = heads + ends
    for opening, closing in enumerate(closings):
        for number, (kind, polygon) in enumerate(closing.pieces):
            lowest = int(np.searchsorted(beds, float(polygon[:, 1].min()) + SAME)) - 1
            pieces.append(Piece(polygon, lowest, kind, number, opening))
    return pieces


def _pierced(bands: list[Band], j: int, closings: Sequence[Closing], least: float, beds: Sequence[float]) -> list[Band]:
    """The bands of a course without the openings in it."""
    for closing in closings:
        if j not in closing.edges:
            continue
        (h0, h1), c = closing.edges[j], closing.opening.centre
        left0, left1, right0, right1 = c - h0, c - h1, c + h0, c + h1
        for i, band in enumerate(bands):
            room_left = min(left0 - band.left0, left1 - band.left1) - least
            room_right = min(band.right0 - right0, band.right1 - right1) - least
            if min(room_left, room_right) >= -SAME:
                bands[i : i + 1] = [
                    band._replace(right0=left0, right1=left1, bond_right=0.0),
                    band._replace(left0=right0, left1=right1, bond_left=0.0),
                ]
                break
        else:
            raise InputError(_no_room(bands, closing, max(h0, h1) + least, 0.5 * (beds[j] + beds[j + 1])))
    return bands


def _no_room(bands: Sequence[Band], closing: Closing, half: float, z: float) -> str:
    """Where the opening would fit in this course."""
    free = [(max(b.left0, b.left1) + half, min(b.right0, b.right1) - half) for b in bands]
    free = [(low, high) for low, high in free if high >= low]
    c, key = closing.opening.centre, closing.opening.key
    if not free:
        widest = max((min(b.right0, b.right1) - max(b.left0, b.left1) for b in bands), default=0.0)
        most = max(0.0, closing.opening.width + widest - 2.0 * half)
        return f"{key}width: must be at most {most:.4g} m for the masonry at z = {z:.4g} m, got {closing.opening.width:g}"
    low, high = min(free, key=lambda f: max(f[0] - c, c - f[1]))
    return f"{key}centre: must be between {low:.4g} and {high:.4g} m for its head and jambs to stay in the wall, got {c:g}"


def _heads(band: Band, start: float, unit: float, taken: Sequence[float]) -> list[float]:
    """s of the head joints of a band."""
    least = LEAST_UNIT * unit
    low = max(band.left0, band.left1) + max(least, band.bond_left)
    high = min(band.right0, band.right1) - max(least, band.bond_right)
    if high < low - SAME:
        return []
    first, last = math.ceil((low - start) / unit - 1e-9), math.floor((high - start) / unit + 1e-9)
    heads = [start + i * unit for i in range(first, last + 1)]
    if not heads and min(band.right0 - band.left0, band.right1 - band.left1) > 1.6 * unit:
        heads = [min(max(0.5 * (low + high), low), high)]
    return [_cleared(x, taken, LEAST_BOND * unit, low, high) for x in heads]


def _cleared(x: float, taken: Sequence[float], least: float, low: float, high: float) -> float:
    """Move a head joint that nearly meets one of the next course to the least distance from it, where there is room."""
    near = [t for t in taken if abs(t - x) < least - SAME]
    if not near:
        return x
    moved = [m for t in near for m in (t - least, t + least) if low <= m <= high]
    free = [m for m in moved if all(abs(m - t) >= least - SAME for t in taken)]
    return min(free or [x], key=lambda m: abs(m - x))


def _trapezoids(band: Band, heads: Sequence[float], low: float, high: float) -> list[np.ndarray]:
    """The blocks of a band; a block without length at one bed is a triangle."""
    lower, upper = [band.left0, *heads, band.right0], [band.left1, *heads, band.right1]
    found = []
    for k in range(len(lower) - 1):
        corners = [(lower[k], low)]
        if lower[k + 1] - lower[k] > SAME:
            corners.append((lower[k + 1], low))
        corners.append((upper[k + 1], high))
        if upper[k + 1] - upper[k] > SAME:
            corners.append((upper[k], high))
        found.append(np.array(corners))
    return found
