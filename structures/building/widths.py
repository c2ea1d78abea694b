# SPDX-License-Identifier: GPL-3.0-or-later
"""Widths of plane polygons: their narrow tails, and convex pieces as wide as possible."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from structures.geometry import polygons

NARROW = 0.15  # of the thickness of its wall: what is narrower in plan is a sliver
ASIDE = 1e-4  # a joint closer to the end of a sliver does not cut it [m]
TOUCH = 1e-7  # what is this close is one [m]
MITRE = 10.0  # longest corner that narrowing and widening a polygon keeps, in distances
MOST_REFLEX = 4  # corners of a polygon that point inwards, up to which all ways to cut it are tried


def without_tails(shape: Polygon, narrow: float) -> list[Polygon]:
    """A polygon as what of it is wider than a distance, and each of the rest [m]."""
    wide = shape.buffer(-0.5 * narrow, join_style="mitre", mitre_limit=MITRE).buffer(0.5 * narrow, join_style="mitre", mitre_limit=MITRE)
    tails = polygons.polygons(shape.difference(wide.buffer(TOUCH, join_style="mitre", mitre_limit=MITRE)))
    if wide.is_empty or not tails:
        return [shape]
    tails = polygons.polygons(shape.difference(wide))
    return polygons.polygons(shape.difference(shapely.union_all(tails))) + tails


def is_narrower(shape: BaseGeometry, width: float) -> bool:
    """True where the widest circle within a polygon is narrower than a width [m]."""
    if 2.0 * shape.area >= width * shape.length:  # no polygon whose circle is that narrow has so much area
        return False
    return 2.0 * float(shapely.maximum_inscribed_circle(shape, 0.01 * width).length) < width


def least_width(ring: np.ndarray) -> float:
    """Return the least width of a convex polygon (n, 2) [m]."""
    side = ring[[*range(1, len(ring)), 0]] - ring
    along = ring[:, :1] * side[:, 1] - ring[:, 1:] * side[:, 0]
    return float(((along.max(axis=0) - along.min(axis=0)) / np.hypot(side[:, 0], side[:, 1])).min())


def fat_pieces(shape: Polygon) -> list[np.ndarray]:
    """Convex polygons (n, 2) that fill one, the narrowest of them as wide as cuts from its inner corners can make it.

    None has a corner in the middle of a side: of two faces in one plane contact detection would see one.
    """
    if len(shape.exterior.coords) == 5 and polygons.is_rectangle(shape):
        left, low, right, high = shape.bounds
        return [np.array([(left, low), (right, low), (right, high), (left, high)])]
    usual = polygons.convex_pieces(shape)
    usual = [piece for piece in usual if least_width(piece) > TOUCH] or usual  # triangles along a straight side are flat
    ring = polygons.loop(shape)
    better = None
    if len(usual) > 1 and not shape.interiors and len(_reflex(ring)) <= MOST_REFLEX:
        better = _cut_up(ring, min(least_width(piece) for piece in usual))
    return [polygons.without_straight(piece) for piece in (usual if better is None else better[1])]


def _reflex(ring: np.ndarray) -> list[int]:
    """Corners of a counter-clockwise loop that point inwards: in plain numbers, which for a few corners are much faster than arrays."""
    found = []
    corners = ring.tolist()
    for k, (x, y) in enumerate(corners):
        (ax, ay), (bx, by) = corners[k - 1], corners[k + 1 - len(corners)]
        px, py, qx, qy = x - ax, y - ay, bx - x, by - y
        if px * qy - py * qx < -polygons.SAME * math.hypot(px, py) * math.hypot(qx, qy):
            found.append(k)
    return found


def _cut_up(ring: np.ndarray, least: float) -> tuple[float, list[np.ndarray]] | None:
    """The best of all ways to cut a loop from its first inner corner, and what remains in its turn: least width of a piece, and pieces.

    None where all of them leave a piece that is no wider than ``least`` [m].
    """
    inner = _reflex(ring)
    if not inner:
        width = least_width(ring)
        return (width, [ring]) if width > least else None
    best = None
    for halves in _cuts(np.roll(ring, -inner[0], axis=0)):
        reflex = [len(_reflex(half)) for half in halves]
        if max(reflex) >= len(inner):
            continue
        found = list[tuple[float, list[np.ndarray]]]()
        for half in halves if reflex[0] <= reflex[1] else halves[::-1]:  # the plainer one first: it may be too narrow
            cut = _cut_up(half, least)
            if cut is None:
                break
            found.append(cut)
        if len(found) == len(halves):
            least = min(width for width, _ in found)
            best = least, [piece for _, pieces in found for piece in pieces]
    return best


def _cuts(ring: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """A loop cut in two from its first corner: to each other corner that it sees, along its own two sides, and square to the others."""
    start, n = ring[0], len(ring)
    inside = Polygon(ring).buffer(TOUCH)
    for k in range(2, n - 1):
        if inside.covers(shapely.LineString([start, ring[k]])):
            yield ring[: k + 1], np.concatenate([ring[:1], ring[k:]])
    sides = np.roll(ring, -1, axis=0) - ring
    rays = [start - ring[1], start - ring[-1], *(sides[k] for k in range(1, n - 1))]
    rays += [np.array([-d[1], d[0]]) for d in sides]
    for ray in rays:
        hit = _hit(ring, ray / np.hypot(*ray))
        if hit is not None:
            k, point = hit
            yield np.concatenate([ring[: k + 1], point[None]]), np.concatenate([ring[:1], point[None], ring[k + 1 :]])


def _hit(ring: np.ndarray, ray: np.ndarray) -> tuple[int, np.ndarray] | None:
    """The side of a loop that a ray from its first corner meets first, and where; None where it leaves at once or meets a corner."""
    start = ring[0]
    first, last = ring[1] - start, ring[-1] - start
    if first[0] * ray[1] - first[1] * ray[0] <= 0.0 <= last[0] * ray[1] - last[1] * ray[0]:
        return None  # in the angle outside, which is less than a straight one
    best: tuple[float, int] | None = None
    for k in range(1, len(ring) - 1):
        a, d = ring[k] - start, ring[k + 1] - ring[k]
        sine = float(ray[0] * d[1] - ray[1] * d[0])
        if abs(sine) < polygons.SAME:
            continue
        t, u = float(a[0] * d[1] - a[1] * d[0]) / sine, float(a[0] * ray[1] - a[1] * ray[0]) / sine
        if t > TOUCH and -polygons.SAME < u < 1.0 + polygons.SAME and (best is None or t < best[0]):
            best = t, k
    if best is None:
        return None
    point = start + best[0] * ray
    k = best[1]
    return None if min(np.hypot(*(point - ring[k])), np.hypot(*(point - ring[k + 1]))) < TOUCH else (k, point)
