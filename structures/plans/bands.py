# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls as bands between two faces: the middle line and the distance of pairs of edges, straight or concentric.

Of two edges that run alike, side by side and not too far apart, the stretch that they share is a band, if the ground between them is wall.
The narrowest come first, and no ground is taken twice: so the end of a wall does not pair with the far face of the wall that it abuts.
Bands in line and of one thickness are one wall where the ground between them is wall, too, as at a junction, or an opening.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from structures.plans.edges import Edge, Faces, angle_between, turned

THINNEST = 0.06  # m: less is a line drawn twice, a lining, a pane
ALIKE = math.radians(8.0)  # faces of one wall diverge by less
TAPER = 0.5  # and differ in distance from end to end by less than this share of the mean
BRIEF = 0.12  # a band shorter than this is none [m]
FILLED = 0.95  # of the ground between two faces
TAKEN = 0.5  # of a band's ground that others have: it is none
IN_LINE = 0.04  # bands in line are off it by less [m], or by 6 % of their thickness
BRIDGED = 0.8  # of the ground between two bands in line: they are one wall


class WallStretch(NamedTuple):
    """A stretch of wall."""

    axis: Edge
    thickness: float  # [m]
    handles: tuple[str, ...]
    taper: float = 0.0  # difference of the thickness from end to end [m]

    @property
    def length(self) -> float:
        """Length of the axis [m]."""
        return self.axis.length

    def ground(self, share: float = 1.0) -> Any:
        """The polygon that it covers, or its middle strip of a share of the thickness."""
        return self.line.buffer(0.5 * share * self.thickness, cap_style="flat")

    @property
    def line(self) -> Any:
        """Its axis as a line of shapely."""
        import shapely

        return shapely.LineString(np.concatenate([self.axis.points(), self.axis.end[None]]))


def bands_of(faces: Faces, thickest: float, openings: Sequence[Any]) -> list[WallStretch]:
    """The bands of what is drawn.

    Args:
        faces: of walls.
        thickest: distance of two faces beyond which they are no wall [m].
        openings: ground of each, which may interrupt walls.
    """
    import shapely

    ground = shapely.union_all([faces.ground.buffer(1e-3), *openings]) if not faces.ground.is_empty else None
    found: list[WallStretch] = []
    pairs = [*_pairs(faces.edges, ground, thickest), *_pairs(faces.loose, None, thickest)]
    for long in (True, False):
        for band in sorted((b for b in pairs if (b.length >= b.thickness) == long), key=lambda b: (b.thickness, -b.length)):
            if not _is_taken(band, found):
                found.append(band)
        found = merged(found, ground, openings)
    return found


def _is_taken(band: WallStretch, others: Sequence[WallStretch]) -> bool:
    """Return True if others have much of a band's ground."""
    own = band.ground()
    x, y, u, v = own.bounds
    share = 0.0
    for other in others:
        theirs = other.ground()
        a, b, c, d = theirs.bounds
        if a < u and c > x and b < v and d > y:
            share += theirs.intersection(own).area
    return share > TAKEN * own.area


def _pairs(edges: Sequence[Edge], ground: Any, thickest: float) -> Iterator[WallStretch]:
    """Candidates between any two edges; without a ground, as between loose lines, what lies between them is not considered."""
    import shapely

    if ground is not None:
        shapely.prepare(ground)
    yield from (b for b in _straight([e for e in edges if e.centre is None], thickest) if _is_filled(b, ground))
    arcs = [e for e in edges if e.centre is not None]
    for k, one in enumerate(arcs):
        for other in arcs[k + 1 :]:
            band = _concentric(one, other, thickest)
            if band is not None and _is_filled(band, ground):
                yield band


def _is_filled(band: WallStretch, ground: Any) -> bool:
    import shapely

    if ground is None:
        return True
    middle = band.axis.points()[0] if band.axis.centre is not None else 0.5 * (band.axis.start + band.axis.end)
    if band.axis.centre is None and not ground.contains(shapely.Point(middle)):
        return False
    own = band.ground(0.98)
    return ground.intersection(own).area >= FILLED * own.area


def _straight(edges: Sequence[Edge], thickest: float) -> Iterator[WallStretch]:
    """Bands between straight edges that run alike."""
    if len(edges) < 2:
        return
    start, end = (np.array([getattr(edge, side) for edge in edges]) for side in ("start", "end"))
    length = np.hypot(*(end - start).T)
    along = (end - start) / length[:, None]
    for i in range(len(edges) - 1):
        d, p = along[i], start[i]
        cross = along[i + 1 :, 0] * d[1] - along[i + 1 :, 1] * d[0]
        a, b = start[i + 1 :] - p, end[i + 1 :] - p
        s, t = a @ d, b @ d
        across_a, across_b = (np.abs(v[:, 0] * d[1] - v[:, 1] * d[0]) for v in (a, b))
        near = (np.abs(cross) < math.sin(ALIKE)) & (np.minimum(s, t) < length[i] - BRIEF) & (np.maximum(s, t) > BRIEF)
        near &= (np.minimum(across_a, across_b) < 1.5 * thickest) & (np.maximum(across_a, across_b) > THINNEST)
        for j in np.flatnonzero(near) + i + 1:
            band = _between(edges[i], edges[int(j)], thickest)
            if band is not None:
                yield band


def _between(one: Edge, other: Edge, thickest: float) -> WallStretch | None:
    """The band that two straight edges share, whose axis halves the angle between them."""
    d, e = (one.end - one.start) / one.length, (other.end - other.start) / other.length
    e = e if float(d @ e) > 0.0 else -e
    d = (d * one.length + e * other.length) / np.hypot(*(d * one.length + e * other.length))
    n = np.array([-d[1], d[0]])
    low, high = max(_span(one, d)[0], _span(other, d)[0]), min(_span(one, d)[1], _span(other, d)[1])
    if high - low < BRIEF:
        return None
    offsets = np.array([[_offset(edge, d, n, place) for place in (low, high)] for edge in (one, other)])  # (edge, place)
    apart = offsets[1] - offsets[0]
    thickness = abs(float(apart.mean()))
    if not THINNEST < thickness <= thickest or apart[0] * apart[1] < 0.0 or abs(float(np.ptp(np.abs(apart)))) > TAPER * thickness:
        return None
    middle = offsets.mean(axis=0)
    start, end = low * d + middle[0] * n, high * d + middle[1] * n
    return WallStretch(Edge(start, end, one.handle), thickness, (one.handle, other.handle), float(np.ptp(np.abs(apart))))


def _span(edge: Edge, d: np.ndarray) -> tuple[float, float]:
    a, b = float(edge.start @ d), float(edge.end @ d)
    return min(a, b), max(a, b)


def _offset(edge: Edge, d: np.ndarray, n: np.ndarray, place: float) -> float:
    """How far an edge lies from the origin along n where its place along d is a given one."""
    a, b = float(edge.start @ d), float(edge.end @ d)
    share = (place - a) / (b - a)
    return float(edge.start @ n) * (1.0 - share) + float(edge.end @ n) * share


def _concentric(one: Edge, other: Edge, thickest: float) -> WallStretch | None:
    """The band between two arcs about nearly one centre."""
    if one.centre is None or other.centre is None:
        return None
    thickness = abs(one.radius - other.radius)
    if not THINNEST < thickness <= thickest or math.dist(one.centre, other.centre) > max(0.25 * thickness, IN_LINE):
        return None
    centre = 0.5 * (one.centre + other.centre)
    first, second = _ccw(one, centre), _ccw(other, centre)
    shift = 2.0 * math.pi * round((first[0] + 0.5 * first[1] - second[0] - 0.5 * second[1]) / (2.0 * math.pi))
    low = max(first[0], second[0] + shift)
    high = min(first[0] + first[1], second[0] + second[1] + shift)
    radius = 0.5 * (one.radius + other.radius)
    if (high - low) * radius < BRIEF:
        return None
    start, end = (centre + radius * np.array([math.cos(a), math.sin(a)]) for a in (low, high))
    return WallStretch(Edge(start, end, one.handle, centre, high - low), thickness, (one.handle, other.handle))


def _ccw(arc: Edge, centre: np.ndarray) -> tuple[float, float]:
    """Angle of an arc's first point about a centre, and its sweep, counter-clockwise."""
    first = arc.start if arc.sweep > 0.0 else arc.end
    spoke = first - centre
    return math.atan2(spoke[1], spoke[0]), abs(arc.sweep)


def merged(bands: Sequence[WallStretch], ground: Any, openings: Sequence[Any]) -> list[WallStretch]:
    """Bands in line, with wall or an opening between them, as one."""
    out = sorted(bands, key=lambda b: (-b.length, *b.axis.start))
    again = True
    while again:
        again = False
        for i, one in enumerate(out):
            joined = next(((j, both) for j in range(i + 1, len(out)) if (both := _one_of(one, out[j], ground, openings)) is not None), None)
            if joined is not None:
                out[i] = joined[1]
                del out[joined[0]]
                again = True
                break
    return out


def _one_of(one: WallStretch, other: WallStretch, ground: Any, openings: Sequence[Any]) -> WallStretch | None:
    """Two bands as one, or None."""
    if abs(one.thickness - other.thickness) > max(IN_LINE, 0.08 * one.thickness):
        return None
    if one.axis.centre is not None or other.axis.centre is not None:
        return _one_arc(one, other, ground, openings)
    ends = [one.axis.start, one.axis.end, other.axis.start, other.axis.end]
    far = max(((a, b) for a in ends for b in ends), key=lambda pair: math.dist(*pair))
    long = math.dist(*far)
    d = (far[1] - far[0]) / long
    n = np.array([-d[1], d[0]])
    if max(abs(float((end - far[0]) @ n)) for end in ends) > max(IN_LINE, 0.06 * one.thickness):
        return None
    spans = sorted(sorted((float((band.axis.start - far[0]) @ d), float((band.axis.end - far[0]) @ d))) for band in (one, other))
    low, high = spans[0][1], spans[1][0]
    share = (one.length, other.length)
    thickness = (one.thickness * share[0] + other.thickness * share[1]) / sum(share)
    gap = WallStretch(Edge(far[0] + low * d, far[0] + high * d, ""), thickness, ())
    if high - low > 0.02 and not _is_bridged(gap, ground, openings):
        return None
    handles = tuple(dict.fromkeys((*one.handles, *other.handles)))
    return WallStretch(Edge(far[0], far[1], one.axis.handle), thickness, handles, max(one.taper, other.taper))


def _is_bridged(gap: WallStretch, ground: Any, openings: Sequence[Any]) -> bool:
    """Return True if wall, or one opening, fills a gap between two bands."""
    strip = gap.ground(0.5)
    if ground is not None and ground.intersection(strip).area >= BRIDGED * strip.area:
        return True
    along = gap.line
    return any(along.intersection(opening.buffer(0.5 * gap.thickness + 0.05)).length >= BRIDGED * along.length for opening in openings)


def _one_arc(one: WallStretch, other: WallStretch, ground: Any, openings: Sequence[Any]) -> WallStretch | None:
    """Two curved bands about one centre that meet or overlap as one."""
    if one.axis.centre is None or other.axis.centre is None or math.dist(one.axis.centre, other.axis.centre) > IN_LINE:
        return None
    if abs(one.axis.radius - other.axis.radius) > IN_LINE:
        return None
    a, b = _ccw(one.axis, one.axis.centre), _ccw(other.axis, one.axis.centre)
    between = (b[0] - a[0]) % (2.0 * math.pi)
    first, second = (one, other) if between <= math.pi else (other, one)
    start, sweep = _ccw(first.axis, one.axis.centre)
    gap = (_ccw(second.axis, one.axis.centre)[0] - start) % (2.0 * math.pi) - sweep
    if gap * one.axis.radius > 0.02:
        ends = [one.axis.centre + turned(first.axis.points()[0] - one.axis.centre, angle) for angle in (sweep, sweep + gap)]
        if first.axis.sweep < 0.0 or not _is_bridged(
            WallStretch(Edge(ends[0], ends[1], "", one.axis.centre, gap), one.thickness, ()), ground, openings
        ):
            return None
    total = max(sweep, sweep + gap + abs(second.axis.sweep))
    if total >= 2.0 * math.pi:
        return None
    begin = first.axis.start if first.axis.sweep > 0.0 else first.axis.end
    end = one.axis.centre + turned(begin - one.axis.centre, total)
    handles = tuple(dict.fromkeys((*one.handles, *other.handles)))
    return WallStretch(Edge(begin, end, one.axis.handle, one.axis.centre, total), one.thickness, handles)


def turn_between(one: Edge, other: Edge) -> float:
    """Angle between two straight edges, 0 to a quarter turn [rad]."""
    angle = abs(angle_between(one.end - one.start, other.end - other.start))
    return min(angle, math.pi - angle)
