# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces of walls as straight edges and arcs, and the ground that the walls cover.

Paths of a drawing are taken apart into edges; those whose ends meet close to rings; rings within rings are walls around empty space, as the
even-odd rule has it. A run of short chords that lie on a circle is an arc again.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from structures.plans.entities import Entity

SAME = 2e-3  # ends this near to each other are one corner [m]
SNAPPED = 0.02  # and ends of two lines that miss each other by less are brought to one [m]
SHORTEST = 0.02  # an edge below this is a slip of the pen [m]
ON_CIRCLE = 0.012  # corners of chords lie this near to their circle [m]
CHORDS = 5  # this number of chords in a row, each turning alike, are an arc
TURN = math.radians(20.0)  # largest turn from chord to chord: a polygon of more than 18 sides
FACET = math.radians(4.0)  # of an arc that stands for it where areas are computed


class Edge(NamedTuple):
    """A straight edge, or an arc where it has a centre."""

    start: np.ndarray  # (2,) [m]
    end: np.ndarray  # (2,) [m]
    handle: str
    centre: np.ndarray | None = None  # (2,) [m]
    sweep: float = 0.0  # of an arc, counter-clockwise positive [rad]

    @property
    def length(self) -> float:
        """Along it [m]."""
        return self.radius * abs(self.sweep) if self.centre is not None else math.dist(self.start, self.end)

    @property
    def radius(self) -> float:
        """Radius of an arc [m]."""
        return math.dist(self.start, self.centre) if self.centre is not None else math.inf

    def points(self) -> np.ndarray:
        """Its corners without the last, arcs by facets, (P, 2)."""
        if self.centre is None:
            return self.start[None]
        count = max(2, math.ceil(abs(self.sweep) / FACET))
        spoke = self.start - self.centre
        return np.array([self.centre + turned(spoke, self.sweep * k / count) for k in range(count)])


def turned(vector: np.ndarray, angle: float) -> np.ndarray:
    """A vector (2,) turned counter-clockwise [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def edges_of(path: Entity) -> list[Edge]:
    """The edges of a path in their order; an arc from each bulge."""
    points = path.points
    if path.closed and len(points):
        points = np.concatenate([points, points[:1]])
    edges = []
    for a, b in pairwise(points):
        start, end, bulge = a[:2], b[:2], float(a[2])
        if math.dist(start, end) < (1e-9 if bulge else SHORTEST / 4.0):
            continue
        edges.append(_arc(start, end, bulge, path.handle) if abs(bulge) > 1e-3 else Edge(start, end, path.handle))
    return with_arcs(edges)


def _arc(start: np.ndarray, end: np.ndarray, bulge: float, handle: str) -> Edge:
    """The arc of a bulge, the tangent of a quarter of its angle."""
    chord = end - start
    centre = 0.5 * (start + end) + (1.0 - bulge**2) / (4.0 * bulge) * np.array([-chord[1], chord[0]])
    return Edge(start, end, handle, centre, 4.0 * math.atan(bulge))


def with_arcs(edges: Sequence[Edge]) -> list[Edge]:
    """Edges with runs of chords on one circle as arcs."""
    out: list[Edge] = []
    k = 0
    while k < len(edges):
        if out and _goes_on(out[-1], edges[k]):
            out[-1] = out[-1]._replace(end=edges[k].end, sweep=out[-1].sweep + edges[k].sweep)
            k += 1
            continue
        run = _chords(edges, k)
        if run >= CHORDS:
            first, last = edges[k], edges[k + run - 1]
            centre, sweep = _circle([*(edge.start for edge in edges[k : k + run]), last.end])
            out.append(Edge(first.start, last.end, first.handle, centre, sweep))
            k += run
        else:
            out.append(edges[k])
            k += 1
    return out


def _goes_on(arc: Edge, edge: Edge) -> bool:
    """Return True if an edge goes on along the circle of an arc, to less than a whole one."""
    if arc.centre is None or edge.centre is None or math.dist(arc.end, edge.start) > SAME:
        return False
    return math.dist(arc.centre, edge.centre) < SAME and arc.sweep * edge.sweep > 0.0 and abs(arc.sweep + edge.sweep) < 1.9 * math.pi


def _chords(edges: Sequence[Edge], k: int) -> int:
    """How many edges from the k-th on are chords of one circle."""
    count, turn = 1, 0.0
    while k + count < len(edges):
        a, b = edges[k + count - 1], edges[k + count]
        if a.centre is not None or b.centre is not None or math.dist(a.end, b.start) > SAME:
            break
        bend = angle_between(a.end - a.start, b.end - b.start)
        if not 1e-3 < abs(bend) < TURN or bend * turn < 0.0 or not 0.5 < a.length / b.length < 2.0:
            break
        if count >= 2:
            corners = np.array([*(edge.start for edge in edges[k : k + count + 1]), b.end])
            centre, _ = _circle(corners)
            reach = np.hypot(*(corners - centre).T)
            if np.ptp(reach) > ON_CIRCLE:
                break
        turn, count = bend, count + 1
    return count


def _circle(corners: Sequence[np.ndarray] | np.ndarray) -> tuple[np.ndarray, float]:
    """Centre of the circle through the first, the middle and the last of some corners, and the angle that they sweep."""
    a, b, c = np.asarray(corners[0]), np.asarray(corners[len(corners) // 2]), np.asarray(corners[-1])
    centre = circle_through(a, b, c)
    return centre, angle_between(a - centre, b - centre) + angle_between(b - centre, c - centre)


def circle_through(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Centre of the circle through three points, (2,) each; far away where they are in line."""
    p, q = b - a, c - a
    area = 2.0 * (p[0] * q[1] - p[1] * q[0])
    area = area if abs(area) > 1e-12 else 1e-12
    pp, qq = float(p @ p), float(q @ q)
    return a + np.array([q[1] * pp - p[1] * qq, p[0] * qq - q[0] * pp]) / area


def angle_between(a: np.ndarray, b: np.ndarray) -> float:
    """From one direction to another, counter-clockwise positive [rad]."""
    return math.atan2(a[0] * b[1] - a[1] * b[0], float(a @ b))


class Faces(NamedTuple):
    """Faces of walls as drawn."""

    edges: list[Edge]  # of rings
    loose: list[Edge]  # of open lines: pairs of them are walls
    ground: Any  # shapely: what the rings have within
    left: list[tuple[str, str]]  # handles that make no ring, with why
    snapped: list[tuple[np.ndarray, float]]  # corners (2,) to which two ends that missed each other were brought, and by how much [m]


def faces_of(paths: Iterable[Entity]) -> Faces:
    """Rings and loose lines of the paths on a layer of walls."""
    rings: list[list[Edge]] = []
    open_runs: list[list[Edge]] = []
    left = []
    for path in paths:
        edges = edges_of(path)
        if not edges:
            left.append((path.handle, "it has no length"))
        elif path.closed or math.dist(edges[0].start, edges[-1].end) < SAME:
            rings.append(edges)
        else:
            open_runs.append(edges)
    snapped = _snap(open_runs)
    closed, loose = _joined(open_runs)
    ground, kept, twice = _even_odd([*rings, *closed])
    left += [(handle, "it is drawn twice, or encloses nothing") for handle in twice]
    return Faces([edge for ring in kept for edge in ring], loose, ground, left, snapped)


def _snap(runs: list[list[Edge]]) -> list[tuple[np.ndarray, float]]:
    """Bring ends that nearly meet to one corner, where straight lines cross; the corners, and by how much each was missed [m]."""
    ends = [(k, side) for k in range(len(runs)) for side in (0, -1)]
    if len(ends) < 2:
        return []
    places = np.array([runs[k][side].end if side else runs[k][side].start for k, side in ends])
    tree = cKDTree(places)
    apart, near = tree.query(places, k=2, distance_upper_bound=SNAPPED)
    nearest, distance = near[:, 1], apart[:, 1]
    snapped = []
    for i, j in enumerate(nearest):
        if i < j < len(ends) and nearest[j] == i and distance[i] > SAME:
            (k, one), (other_run, other) = ends[i], ends[j]
            corner = _corner(runs[k][one], runs[other_run][other], 0.5 * (places[i] + places[j]))
            for run, side in (ends[i], ends[j]):
                edge = runs[run][side]
                runs[run][side] = edge._replace(end=corner) if side else edge._replace(start=corner)
            snapped.append((corner, float(distance[i])))
    return snapped


def _corner(one: Edge, other: Edge, middle: np.ndarray) -> np.ndarray:
    """The crossing of two straight edges near the middle between their ends; otherwise this middle."""
    d, e = one.end - one.start, other.end - other.start
    sine = float(d[0] * e[1] - d[1] * e[0])
    if one.centre is not None or other.centre is not None or abs(sine) < math.sin(TURN) * one.length * other.length:
        return middle
    to = other.start - one.start
    crossing = one.start + float(to[0] * e[1] - to[1] * e[0]) / sine * d
    return crossing if math.dist(crossing, middle) < SNAPPED else middle


def _joined(runs: list[list[Edge]]) -> tuple[list[list[Edge]], list[Edge]]:
    """Runs of edges whose ends meet closed to rings; the edges of the others."""
    at: dict[tuple[int, int], list[int]] = {}
    for k, run in enumerate(runs):
        for corner in (run[0].start, run[-1].end):
            at.setdefault(_cell(corner), []).append(k)
    rings, used = [], set[int]()
    for k, first in enumerate(runs):
        if k in used:
            continue
        chain, members, here = list(first), [k], first[-1].end
        while math.dist(here, chain[0].start) >= SAME:
            i, j = _cell(here)
            near = {k for p in (-1, 0, 1) for q in (-1, 0, 1) for k in at.get((i + p, j + q), ())}
            following = sorted(near - used - set(members))
            if len(following) != 1:
                break
            run = runs[following[0]]
            run = run if math.dist(run[0].start, here) < 2 * SAME else reversed_run(run)
            chain, here = chain + run, run[-1].end
            members.append(following[0])
        if len(chain) > 1 and math.dist(here, chain[0].start) < SAME:
            rings.append(with_arcs(chain))
            used.update(members)
    return rings, [edge for k, run in enumerate(runs) if k not in used for edge in run]


def _cell(corner: np.ndarray) -> tuple[int, int]:
    return round(float(corner[0]) / SAME), round(float(corner[1]) / SAME)


def reversed_run(run: Sequence[Edge]) -> list[Edge]:
    """Edges from their end to their start."""
    return [edge._replace(start=edge.end, end=edge.start, sweep=-edge.sweep) for edge in reversed(run)]


def polygon(ring: Sequence[Edge]) -> Any:
    """A ring as a valid polygon of shapely, or an empty one."""
    import shapely

    corners = np.concatenate([edge.points() for edge in ring])
    if len(corners) < 3:
        return shapely.Polygon()
    shape = shapely.Polygon(corners)
    if shape.is_valid:
        return shape
    parts = shapely.get_parts(shapely.get_parts(shapely.make_valid(shape)))  # lines, too, where a ring runs to and fro
    return shapely.union_all([part for part in parts if part.geom_type == "Polygon"])


def _even_odd(rings: list[list[Edge]]) -> tuple[Any, list[list[Edge]], list[str]]:
    """The ground within rings, those that count, and the handles of those drawn twice or empty."""
    import shapely

    shaped = sorted(((polygon(ring), ring) for ring in rings), key=lambda pair: -pair[0].area)
    kept: list[tuple[Any, list[Edge]]] = []
    dropped = []
    for shape, ring in shaped:
        same = any(
            abs(other.area - shape.area) < 0.01 * shape.area and other.intersection(shape).area > 0.99 * shape.area for other, _ in kept
        )
        if shape.area < SHORTEST**2 or same:
            dropped.append(ring[0].handle)
        else:
            kept.append((shape, ring))
    ground = shapely.Polygon()
    for shape, _ in kept:
        within = shape.area - ground.intersection(shape).area < 0.02 * shape.area
        ground = ground.difference(shape) if within else ground.union(shape)
    return ground, [ring for _, ring in kept], dropped
