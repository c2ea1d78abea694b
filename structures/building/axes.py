# SPDX-License-Identifier: GPL-3.0-or-later
"""Axes of walls: arcs become chords, and an axis falls into legs, each of them straight or gently bent.

A wall turns a corner where its axis bends by more than GENTLE: the two legs there meet as two walls do. Where it bends by less, and between
the chords of an arc, the two facets end on the mitre plane that halves the angle between them.

Each facet has coordinates of its own: s along its chord from its start, n to its left, z up.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.errors import InputError
from structures.building.table import ArcTable, BuildingWallTable
from structures.plans.places import place

GENTLE = math.radians(25.0)  # an axis that bends by more turns a corner
SHARPEST = math.radians(60.0)  # bend between two chords of an arc
STEP = math.radians(15.0)  # of an arc to a facet, at most
SAME = 1e-9  # lengths closer than this are one [m]
DIGITS = 9  # of the height of a top [m]: beds have as many, and a top that rounding parts from its bed would leave a hair over it
THINNEST = 1e-3  # wall [m]
AT_END = 1e-3  # a place of a top this close to an end of its wall is at the end [m]
LEAST_CHORD = 1.2  # of a facet of an arc, in thicknesses
JAMB = 0.12  # of a facet next to the head of its opening, at least [m]
INNER = 0.12  # by how much of the thickness its inner face is shorter at each end


Span = tuple[float, float]  # a stretch of an axis, from its start [m]


class AxisEnd(NamedTuple):
    """The end of a piece of an axis."""

    point: np.ndarray  # (2,) [m]
    length: float  # of the axis up to it [m]
    curved: bool = False  # within an arc


@dataclass(frozen=True, eq=False)
class Facet:
    """A straight piece of a wall in plan."""

    start: np.ndarray  # (2,) [m]
    end: np.ndarray  # (2,) [m]
    span: tuple[float, float]  # of the axis that it stands for, from the axis' start [m]
    cuts: tuple[float, float] = (0.0, 0.0)  # n times this is by how much s of its start, and of its end, exceeds that of the axis
    open: tuple[bool, bool] = (True, True)  # whether the leg ends at its start, and at its end

    @cached_property
    def length(self) -> float:
        """Length of its chord [m]."""
        return float(np.hypot(*(self.end - self.start)))

    @cached_property
    def along(self) -> np.ndarray:
        """Unit vector (2,) of s."""
        return np.asarray((self.end - self.start) / self.length)

    @cached_property
    def left(self) -> np.ndarray:
        """Unit vector (2,) of n."""
        x, y = self.along
        return np.array([-y, x])

    def place(self, plan: np.ndarray) -> np.ndarray:
        """World x, y (..., 2) of points s, n (..., 2) [m]."""
        return np.asarray(self.start + plan[..., :1] * self.along + plan[..., 1:2] * self.left)

    def local(self, points: np.ndarray) -> np.ndarray:
        """s, n (..., 2) of world points x, y (..., 2) [m]."""
        return np.stack([(points - self.start) @ self.along, (points - self.start) @ self.left], axis=-1)

    def sine(self, other: Facet) -> float:
        """Return the sine of the angle from its direction to that of another."""
        (ax, ay), (bx, by) = self.along, other.along
        return float(ax * by - ay * bx)

    def crossing(self, other: Facet) -> tuple[float, float]:
        """s on it, and on another that is not parallel to it, of the point in which their lines cross [m]."""
        (bx, by), gap = other.along, other.start - self.start
        s = float(gap[0] * by - gap[1] * bx) / self.sine(other)
        return s, float((self.start + s * self.along - other.start) @ other.along)

    def s_of(self, at: float) -> float:
        """s of a distance along the axis [m]."""
        low, high = self.span
        return (at - low) * self.length / (high - low)

    def at_of(self, s: float) -> float:
        """The distance along the axis of an s [m]."""
        low, high = self.span
        return low + s * (high - low) / self.length


@dataclass(frozen=True, eq=False)
class Leg:
    """A wall, or a part of one between two of its corners."""

    wall: int  # number of its wall
    number: int  # among the legs of its wall
    keys: BuildingWallTable
    facets: tuple[Facet, ...]
    closed: bool = False  # its last facet goes on in its first
    length: float = math.inf  # of the axis of its wall [m]
    tops: tuple[tuple[float, float], ...] = field(default=())  # distance along the axis, z, of the profile of its top [m]
    where: str = ""  # key of its wall

    @property
    def thickness(self) -> float:
        """Thickness of the wall [m]."""
        return self.keys.thickness

    @property
    def base(self) -> float:
        """z of the foot [m]."""
        return self.keys.base

    def top(self, facet: Facet, s: float, after: bool = True) -> float:
        """z of the top over a place of one of its facets [m], at a step that after or before it.

        Beyond the ends of the axis, up to the far faces of the walls there, a top that falls goes on falling, one that rises ends level.
        """
        at, z = zip(*self.tops, strict=True)
        there = facet.at_of(s)
        step = [k for k, place in enumerate(at) if abs(place - there) < SAME]
        level = z[step[-1 if after else 0]] if step else float(np.interp(there, at, z))
        for end, inner, beyond in ((0, 1, there - at[0]), (-1, -2, at[-1] - there)):
            run = abs(at[inner] - at[end])
            ends = abs(at[end] - (0.0, self.length)[end]) < AT_END
            if beyond < 0.0 and ends and run > 1e-6 and z[inner] > z[end]:
                level = max(self.base, z[end] + beyond * (z[inner] - z[end]) / run)
        return level

    def tops_between(self, facet: Facet, low: float, high: float) -> list[tuple[float, float]]:
        """s, z of the profile between two places of a facet, both of them included [m]."""
        if len(self.tops) == 2 and self.tops[0][1] == self.tops[1][1]:
            return [(low, self.tops[0][1]), (high, self.tops[0][1])]
        inner = [(facet.s_of(at), z) for at, z in self.tops]
        inner = [(s, z) for s, z in inner if low + SAME < s < high - SAME]
        return [(low, self.top(facet, low)), *inner, (high, self.top(facet, high, after=False))]


def legs_of(number: int, keys: BuildingWallTable, whole: Sequence[Span] = (), where: str = "") -> list[Leg]:
    """The legs of a wall by its key; stretches of its axis that are to be whole lie in one facet of an arc each [m].

    Raises:
        InputError: a wall like a sheet, or an axis that turns back on itself, stays on the spot or has an arc that is none; says where.
    """
    if keys.thickness < THINNEST:
        raise InputError("", f"its thickness, {keys.thickness:g} m, is less than {1e3 * THINNEST:g} mm")
    bends = list(_bends(keys, whole))
    for a, b in pairwise(bends):
        if b.length - a.length < 1e-3:
            raise InputError("", f"its axis stays on the spot at {place(a.point)}")
    closed = len(bends) > 3 and float(np.hypot(*(bends[0].point - bends[-1].point))) < 1e-6
    facets = [Facet(a.point, b.point, (a.length, b.length)) for a, b in pairwise(bends)]
    turns = [_turn(a, b) for a, b in pairwise([*facets, facets[0]] if closed else facets)]
    for facet, turn in zip(facets, turns, strict=False):
        if abs(turn) > math.pi - GENTLE:
            raise InputError("", f"its axis turns back by {math.degrees(abs(turn)):.0f} degrees at {place(facet.end)}")
    tops = _profile(keys, bends[-1].length)
    curved = [bend.curved for bend in bends[1:]]
    gentle = [abs(turn) <= (SHARPEST if c else GENTLE) for turn, c in zip(turns, curved, strict=False)]
    chains = _chains(facets, [turn if g else None for turn, g in zip(turns, gentle, strict=True)], closed)
    if closed and len(chains) == 1 and gentle[-1]:
        return [Leg(number, 0, keys, chains[0], True, bends[-1].length, tops, where)]
    return [Leg(number, k, keys, chain, False, bends[-1].length, tops, where) for k, chain in enumerate(chains)]


def _turn(first: Facet, second: Facet) -> float:
    """Angle by which the axis turns to the left from one facet to the next [rad]."""
    (ax, ay), (bx, by) = first.along, second.along
    return math.atan2(ax * by - ay * bx, ax * bx + ay * by)


def _chains(facets: Sequence[Facet], turns: Sequence[float | None], closed: bool) -> list[tuple[Facet, ...]]:
    """The facets of each leg, with the mitres between them; a turn of None is a corner."""
    cuts = [None if turn is None else math.tan(0.5 * turn) for turn in turns]
    ends = cuts if closed else [*cuts, None]
    starts = [ends[-1], *ends[:-1]]
    cut = [
        Facet(f.start, f.end, f.span, (low or 0.0, -(high or 0.0)), (low is None, high is None))
        for f, low, high in zip(facets, starts, ends, strict=True)
    ]
    if closed and any(e is None for e in ends) and ends[-1] is not None:  # begin at a corner
        first = next(k for k, e in enumerate(ends) if e is None) + 1
        cut = cut[first:] + cut[:first]
    chains: list[list[Facet]] = [[]]
    for facet in cut:
        chains[-1].append(facet)
        if facet.open[1]:
            chains.append([])
    return [tuple(chain) for chain in chains if chain]


def _profile(keys: BuildingWallTable, length: float) -> tuple[tuple[float, float], ...]:
    """Distance along the axis and z of the profile of the top.

    Raises:
        InputError: neither or both of height and top, places that do not rise, a top that comes down to the base.
    """
    if (keys.height is None) == (keys.top is None):
        raise InputError("", "give height, or top, the profile of its top" if keys.top is None else "give one of height and top")
    if keys.height is not None:
        return ((0.0, round(keys.base + keys.height, DIGITS)), (length, round(keys.base + keys.height, DIGITS)))
    assert keys.top is not None
    at = [s for s, _ in keys.top]
    for a, b in pairwise(at):
        if b < a:
            raise InputError("", f"the places of its top must not go back, got {a:g} and then {b:g} m")
    if min(at) < -1e-6 or max(at) > length + 1e-6:
        raise InputError("", f"its top has a place at {max(at, key=lambda s: abs(s - 0.5 * length)):g} m, its axis is {length:.4g} m long")
    if min(z for _, z in keys.top) < 0.0 or max(z for _, z in keys.top) <= 0.0:
        raise InputError("", "its top comes down below its base")
    return tuple((s, round(keys.base + z, DIGITS)) for s, z in keys.top)


def _bends(keys: BuildingWallTable, whole: Sequence[Span]) -> Iterator[AxisEnd]:
    """The corners of an axis with its arcs as chords."""
    first = keys.axis[0]
    if isinstance(first, ArcTable):
        raise InputError("", "its axis begins with an arc; begin with a point")
    point, length = np.array(first, dtype=float), 0.0
    yield AxisEnd(point, length)
    for piece in keys.axis[1:]:
        if isinstance(piece, ArcTable):
            chords = _arc(point, piece, _stretches(keys, whole, length), keys)
            for k, (there, along) in enumerate(chords):
                yield AxisEnd(there, length + along, k < len(chords) - 1)
            length, point = length + along, there
        else:
            there = np.array(piece, dtype=float)
            length, point = length + float(np.hypot(*(there - point))), there
            yield AxisEnd(point, length)


def _arc(start: np.ndarray, arc: ArcTable, fixed: Sequence[Span], keys: BuildingWallTable) -> list[tuple[np.ndarray, float]]:
    """The ends of the chords of an arc and its length up to each [m]; of fixed stretches each is in one of them."""
    through, end = np.array(arc.through, dtype=float), np.array(arc.to, dtype=float)
    full = float(np.hypot(*(end - start))) < 1e-9  # a whole circle: the point is opposite
    if full:
        centre = 0.5 * (start + through)
        radius = float(np.hypot(*(start - centre)))
        if radius < 1e-3:
            raise InputError("", f"its arc from {place(start)} is a point")
        sweep = 2.0 * math.pi
    else:
        a, b = through - start, end - start
        cross = float(a[0] * b[1] - a[1] * b[0])
        if abs(cross) < 1e-9 * float(a @ a + b @ b):
            raise InputError("", f"its arc from {place(start)} passes through a point that is in line with its ends")
        square = np.array([a @ a, b @ b])
        centre = start + np.array([b[1] * square[0] - a[1] * square[1], a[0] * square[1] - b[0] * square[0]]) / (2.0 * cross)
        radius = float(np.hypot(*(start - centre)))
        u, v = (start - centre) / radius, (end - centre) / radius
        sweep = math.atan2(float(u[0] * v[1] - u[1] * v[0]), float(u @ v))
        sweep += 2.0 * math.pi * (cross < 0.0 and sweep > 0.0) * -1.0 + 2.0 * math.pi * (cross > 0.0 and sweep < 0.0)
    if radius < 0.5 * keys.thickness + 1e-3:
        raise InputError("", f"its arc from {place(start)} has a radius of {radius:.4g} m, less than half its thickness")
    angle = math.atan2(*(start - centre)[::-1])
    found = []
    for along in _breaks(abs(sweep) * radius, radius, fixed, keys.thickness):
        turn = math.copysign(along / radius, sweep)
        found.append((centre + radius * np.array([math.cos(angle + turn), math.sin(angle + turn)]), along))
    return [*found, (end, abs(sweep) * radius)]


def _stretches(keys: BuildingWallTable, whole: Sequence[Span], before: float) -> list[Span]:
    """Return the stretches that lie in one facet, from the start of an arc at a length of the axis: openings, and whole ones [m]."""
    found = []
    for opening in keys.openings:
        half = 0.5 * opening.width + (opening.ring or opening.bearing or 0.35 * opening.width) + JAMB + INNER * keys.thickness
        found.append((opening.at - half, opening.at + half))
    joined: list[Span] = []
    for low, high in sorted([*found, *whole]):
        if joined and whole and low < joined[-1][1]:
            joined[-1] = joined[-1][0], max(high, joined[-1][1])
        else:
            joined.append((low, high))
    return [(low - before, high - before) for low, high in joined]


def _breaks(total: float, radius: float, stretches: Sequence[Span], thickness: float) -> list[float]:
    """Where along an arc its facets end, without the last one [m]: a facet to each stretch, the rest evenly."""
    within = [(low, high) for low, high in stretches if 0.0 < 0.5 * (low + high) < total or low < 0.0 < high or low < total < high]
    fixed = [(0.0, 0.0), *((max(low, 0.0), min(high, total)) for low, high in within), (total, total)]
    breaks: list[float] = []
    for (_, low), (high, end) in pairwise(fixed):
        gap = high - low
        if gap < 0.6 * thickness:  # too short for a facet: what is next to it takes it up
            breaks += [0.5 * (low + high)] if low > 0.0 and end < total else []
            continue
        count = max(math.ceil(gap / radius / GENTLE * 1.001), min(math.ceil(gap / radius / STEP), int(gap / (LEAST_CHORD * thickness))), 1)
        breaks += [low + gap * k / count for k in range(count + 1)]
    return sorted({round(b, 9) for b in breaks if SAME < b < total - SAME})
