# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls from bands: their axes are drawn out to meet those of their neighbours, and bands that go on round a bend are one wall."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from structures.plans.bands import WallStretch, turn_between
from structures.plans.edges import Edge, angle_between, reversed_run, turned

FLATTEST = math.radians(10.0)  # two axes that cross at less do not meet
SLACK = 0.12  # m: how far a drawing's ends may be from where walls meet
SOFT = math.radians(50.0)  # a bend below this is within a wall; above it two walls meet
ALIKE = 0.08  # share by which thicknesses of one wall may differ
TANGENT = math.radians(12.0)  # an arc goes over into a straight wall at less
SHARPEST = math.radians(25.0)  # two walls that cross at less make no junction
LEAST_OVERLAP = 1e-7  # m2
SET_BACK = 0.15  # of the thickness of the wall between two in line, by which each of these ends before its middle
INTO = 0.05  # m: an arc ends so far within the wall that it meets


class WallAxis(NamedTuple):
    """A wall of the plan."""

    name: str
    pieces: tuple[Edge, ...]  # of the axis
    thickness: float  # [m]
    handles: tuple[str, ...]
    taper: float = 0.0  # [m]

    @property
    def length(self) -> float:
        """Length of the axis [m]."""
        return sum(piece.length for piece in self.pieces)

    @property
    def line(self) -> Any:
        """The axis as a line of shapely."""
        import shapely

        return shapely.LineString(np.concatenate([*(piece.points() for piece in self.pieces), self.pieces[-1].end[None]]))

    def ground(self, more: float = 0.0, cap: str = "flat") -> Any:
        """The polygon that it covers, wider by a distance on each face [m]."""
        return self.line.buffer(0.5 * self.thickness + more, cap_style=cap, join_style="mitre")

    def along(self, point: Sequence[float]) -> float:
        """Distance of a point's foot on the axis from its start [m]."""
        import shapely

        line = self.line
        return float(line.project(shapely.Point(point)) * self.length / line.length)


class _End(NamedTuple):
    """Where an axis ends up: its corner, and the band and side that it meets, if it is an end of that one."""

    corner: np.ndarray  # (2,)
    met: tuple[int, int] | None
    joined: bool = True  # whether it meets a wall at all
    thickness: float = 0.0  # of that wall, along this one [m]


def walls_of(bands: Sequence[WallStretch], ground: Any) -> list[WallAxis]:
    """The walls of bands, without names, from the lower left to the upper right."""
    ends = {(k, side): _end(bands, k, side, ground) for k in range(len(bands)) for side in (0, 1)}
    longer = [_drawn_out(band, ends[k, 0], ends[k, 1]) for k, band in enumerate(bands)]
    for (k, side), end in ends.items():  # where several walls meet, some reach others only once these are drawn out
        if not end.joined:
            ends[k, side] = _end(longer, k, side, ground)
    links = _links(bands, ends)
    walls, used = [], set[int]()
    for k in _first_of_chains(len(bands), links):
        if k in used:
            continue
        walls.append(_wall(bands, ends, _chain(k, links, used)))
    walls = [wall for wall in walls if wall.pieces]  # of what is so short that it ends where it begins none is left
    return sorted((_forward(wall) for wall in _set_back(walls)), key=_place)


def _set_back(walls: Sequence[WallAxis]) -> list[WallAxis]:
    """Walls nearly in line on both sides of another one, whose ends would overlap in it, end a little before its middle."""
    import shapely

    out = list(walls)
    for i, one in enumerate(out):
        for j, other in enumerate(out[:i]):
            if one.ground().intersection(other.ground()).area < LEAST_OVERLAP:
                continue
            a, b = min(((a, b) for a in (0, -1) for b in (0, -1)), key=lambda e: math.dist(_corner(out[i], e[0]), _corner(out[j], e[1])))
            pieces = out[i].pieces[a], out[j].pieces[b]
            tip = shapely.Point(_corner(out[i], a))
            crossed = [wall for k, wall in enumerate(out) if k not in (i, j) and wall.ground(cap="square").distance(tip) < 1e-6]
            if crossed and all(p.centre is None for p in pieces) and turn_between(*pieces) < SHARPEST:
                depth = SET_BACK * crossed[0].thickness
                out[i], out[j] = _shortened(out[i], a, depth), _shortened(out[j], b, depth)
    return out


def _corner(wall: WallAxis, end: int) -> np.ndarray:
    return wall.pieces[-1].end if end else wall.pieces[0].start


def _shortened(wall: WallAxis, end: int, depth: float) -> WallAxis:
    """A wall whose axis ends earlier [m]."""
    piece = wall.pieces[end]
    d = depth * (piece.end - piece.start) / piece.length
    piece = piece._replace(end=piece.end - d) if end else piece._replace(start=piece.start + d)
    return wall._replace(pieces=(*wall.pieces[:-1], piece) if end else (piece, *wall.pieces[1:]))


def _drawn_out(band: WallStretch, start: _End, end: _End) -> WallStretch:
    """A straight band from corner to corner."""
    return band if band.axis.centre is not None else band._replace(axis=band.axis._replace(start=start.corner, end=end.corner))


def _place(wall: WallAxis) -> tuple[float, ...]:
    return tuple(round(float(x), 3) for x in (*wall.pieces[0].start, *wall.pieces[-1].end))


def _forward(wall: WallAxis) -> WallAxis:
    """The wall from its left end, or the lower one, to the other."""
    a, b = (tuple(np.round(p, 3)) for p in (wall.pieces[0].start, wall.pieces[-1].end))
    return wall if a <= b else wall._replace(pieces=tuple(reversed_run(wall.pieces)))


def _tip(band: WallStretch, side: int) -> tuple[np.ndarray, np.ndarray]:
    """An end of a band's axis, and the direction in which it points out of the band."""
    axis = band.axis
    point = axis.end if side else axis.start
    if axis.centre is None:
        out = (axis.end - axis.start) / axis.length
    else:
        spoke = point - axis.centre
        out = math.copysign(1.0, axis.sweep) * np.array([-spoke[1], spoke[0]]) / axis.radius
    return point, out if side else -out


def _end(bands: Sequence[WallStretch], k: int, side: int, ground: Any) -> _End:
    """The nearest place where a band drawn out, or cut back, meets the axis of another one."""
    point, out = _tip(bands[k], side)
    best: tuple[float, _End] | None = None
    for j, other in enumerate(bands):
        if j == k:
            continue
        for distance, met in _meetings(bands[k], point, out, other):
            if best is not None and abs(distance) >= abs(best[0]) - 1e-9:
                continue
            if distance > SLACK and ground is not None and not _is_over_wall(point, point + distance * out, ground):
                continue
            best = (distance, _End(point + distance * out, None if met is None else (j, met), True, other.thickness))
    return best[1] if best is not None else _End(point, None, False)


def _is_over_wall(a: np.ndarray, b: np.ndarray, ground: Any) -> bool:
    import shapely

    line = shapely.LineString([a, b])
    return bool(ground.is_empty or ground.buffer(0.02).intersection(line).length > 0.6 * line.length)


def _meetings(band: WallStretch, point: np.ndarray, out: np.ndarray, other: WallStretch) -> list[tuple[float, int | None]]:
    """Distances along a direction at which another axis is met, each with the side of its end there, if it is one."""
    axis = other.axis
    if axis.centre is not None:
        return _meetings_arc(point, out, other) + _tangent(band, point, out, other)
    if not axis.length:  # drawn out from both sides to one corner, it is none
        return []
    d = (axis.end - axis.start) / axis.length
    sine = float(out[0] * d[1] - out[1] * d[0])
    if abs(sine) < math.sin(FLATTEST):
        return _tangent(band, point, out, other) if band.axis.centre is not None else []
    to = axis.start - point
    distance = float(to[0] * d[1] - to[1] * d[0]) / sine
    along = float((point + distance * out - axis.start) @ d)
    tangent = min(abs(float(out @ d)) / abs(sine), 3.0)
    own = 0.5 * other.thickness / abs(sine) + 0.5 * band.thickness * tangent + SLACK
    theirs = 0.5 * band.thickness / abs(sine) + 0.5 * other.thickness * tangent + SLACK
    if abs(distance) > own or not -theirs < along < axis.length + theirs:
        return []
    near = min((abs(along), 0), (abs(along - axis.length), 1))
    return [(distance, near[1] if near[0] < theirs else None)]


def _meetings_arc(point: np.ndarray, out: np.ndarray, other: WallStretch) -> list[tuple[float, int | None]]:
    """As :func:`_meetings`, of an arc: where a straight line crosses its circle."""
    axis = other.axis
    assert axis.centre is not None
    to = point - axis.centre
    b, c = float(to @ out), float(to @ to) - axis.radius**2
    if b * b - c <= 0.0:
        return []
    found: list[tuple[float, int | None]] = []
    for distance in (-b - math.sqrt(b * b - c), -b + math.sqrt(b * b - c)):
        place = point + distance * out
        spoke = (place - axis.centre) / axis.radius
        sine = abs(float(out @ spoke))
        if sine < math.sin(FLATTEST) or abs(distance) > 0.5 * other.thickness / sine + SLACK:
            continue
        middle = axis.centre + _halfway(axis)
        if abs(angle_between(middle - axis.centre, spoke)) < 0.5 * abs(axis.sweep) + SLACK / axis.radius:
            found.append((distance, None))
    return found


def _halfway(arc: Edge) -> np.ndarray:
    """Spoke to the middle of an arc."""
    assert arc.centre is not None
    return turned(arc.start - arc.centre, 0.5 * arc.sweep)


def _tangent(band: WallStretch, point: np.ndarray, out: np.ndarray, other: WallStretch) -> list[tuple[float, int | None]]:
    """An end of another band that goes on from this one in its direction, one of the two being an arc."""
    for side in (0, 1):
        place, away = _tip(other, side)
        if math.dist(place, point) < 2.0 * SLACK and abs(angle_between(out, -away)) < TANGENT:
            return [(max(0.0, 0.5 * float((place - point) @ out)), side)]
    return []


def _links(bands: Sequence[WallStretch], ends: dict[tuple[int, int], _End]) -> dict[tuple[int, int], tuple[int, int]]:
    """Pairs of ends at which one wall goes on: they meet each other and no third, bend softly, and are of one thickness."""
    links = {}
    for own, end in ends.items():
        met = end.met
        if met is None or ends[met].met != own:
            continue
        one, other = bands[own[0]], bands[met[0]]
        bend = abs(angle_between(_tip(one, own[1])[1], -_tip(other, met[1])[1]))
        alone = sum(math.dist(each.corner, end.corner) < 0.5 * one.thickness for each in ends.values()) == 2
        if bend < SOFT and alone and abs(one.thickness - other.thickness) < max(ALIKE * one.thickness, 0.03):
            links[own] = met
    return links


def _first_of_chains(count: int, links: dict[tuple[int, int], tuple[int, int]]) -> list[int]:
    """Bands with at most one neighbour first, so that chains begin at an end."""
    return sorted(range(count), key=lambda k: ((k, 0) in links) + ((k, 1) in links))


def _chain(first: int, links: dict[tuple[int, int], tuple[int, int]], used: set[int]) -> list[tuple[int, int]]:
    """Bands from one end of a chain to the other, each with the side at which it is left."""
    side = 1 if (first, 1) in links or (first, 0) not in links else 0
    chain, here = [], first
    while here not in used:
        used.add(here)
        chain.append((here, side))
        if (here, side) not in links:
            break
        here, entered = links[here, side]
        side = 1 - entered
    return chain


def _wall(bands: Sequence[WallStretch], ends: dict[tuple[int, int], _End], chain: Sequence[tuple[int, int]]) -> WallAxis:
    """A wall along a chain of bands."""
    pieces: list[Edge] = []
    for k, side in chain:
        axis = bands[k].axis._replace(start=ends[k, 0].corner, end=ends[k, 1].corner) if bands[k].axis.centre is None else bands[k].axis
        if axis.centre is not None:
            for end in (0, 1):
                axis = _reaching(axis, end, ends[k, end], bands[k])
        pieces.append(axis if side else reversed_run([axis])[0])
    for k, (one, following) in enumerate(pairwise(tuple(pieces))):
        if one.centre is None:
            pieces[k] = pieces[k]._replace(end=following.start)
        elif following.centre is None:
            pieces[k + 1] = pieces[k + 1]._replace(start=one.end)
    long = sum(bands[k].length for k, _ in chain)
    thickness = sum(bands[k].thickness * bands[k].length for k, _ in chain) / long
    handles = tuple(dict.fromkeys(handle for k, _ in chain for handle in bands[k].handles))
    return WallAxis("", tuple(piece for piece in pieces if piece.length > 1e-6), thickness, handles, max(bands[k].taper for k, _ in chain))


def _reaching(arc: Edge, side: int, end: _End, band: WallStretch) -> Edge:
    """An arc drawn out along its circle until it reaches into the wall that it meets."""
    if not end.joined or end.met is not None or arc.centre is None:
        return arc
    point, out = _tip(band, side)
    short = float((end.corner - point) @ out) - 0.5 * end.thickness
    if short < -INTO:
        return arc
    angle = math.copysign((short + INTO) / arc.radius, arc.sweep)
    place = point - arc.centre
    moved = arc.centre + turned(place, angle if side else -angle)
    return arc._replace(sweep=arc.sweep + angle, **{"end" if side else "start": moved})
