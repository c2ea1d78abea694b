# SPDX-License-Identifier: GPL-3.0-or-later
"""How wide plane polygons are: their narrow tails, and convex pieces that are as wide as can be."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely.geometry import Polygon

from structures.geometry import polygons

NARROW = 0.15  # of the thickness of its wall: what is narrower in plan is a sliver
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


def least_width(ring: np.ndarray) -> float:
    """Of a convex polygon (n, 2) [m]."""
    side = np.roll(ring, -1, axis=0) - ring
    out = np.column_stack([side[:, 1], -side[:, 0]]) / np.hypot(*side.T)[:, None]
    along = ring @ out.T
    return float(np.ptp(along, axis=0).min())


def fat_pieces(shape: Polygon) -> list[np.ndarray]:
    """Convex polygons (n, 2) that fill one, the narrowest of them as wide as cuts from its inner corners can make it."""
    usual = polygons.convex_pieces(shape)
    usual = [piece for piece in usual if least_width(piece) > TOUCH] or usual  # triangles along a straight side are flat
    ring = polygons.loop(shape)
    if len(usual) == 1 or shape.interiors or len(_reflex(ring)) > MOST_REFLEX:
        return usual
    return max(usual, _cut_up(ring), key=lambda pieces: min(least_width(piece) for piece in pieces))


def _reflex(ring: np.ndarray) -> list[int]:
    """Corners of a counter-clockwise loop that point inwards."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    return np.flatnonzero(turn < -polygons.SAME * np.hypot(*before.T) * np.hypot(*after.T)).tolist()


def _cut_up(ring: np.ndarray) -> list[np.ndarray]:
    """The best of all ways to cut a loop from its first inner corner, and what remains in its turn."""
    inner = _reflex(ring)
    if not inner:
        return [ring]
    best: tuple[float, list[np.ndarray]] = (-1.0, [ring])
    for one, other in _cuts(np.roll(ring, -inner[0], axis=0)):
        if max(len(_reflex(one)), len(_reflex(other))) >= len(inner):
            continue
        pieces = _cut_up(one) + _cut_up(other)
        width = min(least_width(piece) for piece in pieces)
        if width > best[0]:
            best = width, pieces
    return best[1]


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
