# SPDX-License-Identifier: GPL-3.0-or-later
r"""How fill spreads the wheels of a vehicle onto the arches and supports below.

The share of an axle at X that a strip of the extrados from x_a to x_b at depth d below the road bears is F(x_b - X) - F(x_a - X) over the
sum of these of the whole road, so that all of them sum to the axle's load. F is, over the length c of a wheel's contact,

    2:1            even over c + d, one across for two down,
    Boussinesq     of the stress under a line load, 2 P d^3 / (pi (x^2 + d^2)^2), within 30 degrees of the vertical: with t = x / d,
                   F = (theta + sin theta cos theta + A) / (2 A), theta = arctan t, A its value at 30 degrees,

and across the road likewise about each wheel. With ``across = "strip"`` a load is W / b times as heavy on the whole width W between the
walls, b being what 2:1 reaches from both wheels up to the edges, or twice the narrower one where they do not meet. A strip passes its share
to the block below it, upright, where it lies. What is spread to the road before and behind the bridge, and what lies on fixed blocks, the
ground bears.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation import libm
from masonry_cd.mechanics.model.fill import Fill, FillFace

THIRTY = math.pi / 6.0  # where Boussinesq's stresses are cut off
ALONG, ACROSS, LINES = 3, 8, 5  # strips of a face along the road, and across it; lines that stand for a contact
FINE = 12  # cells along either side of a triangle of a face that wheels press
LEAST_DEPTH = 0.01  # [m] at which a load is spread at least, so that none falls between two strips
ON = ("extrados", "top")


class Known(NamedTuple):
    """A vehicle by name."""

    loads: tuple[float, ...]  # [N]
    spacing: tuple[float, ...]  # [m]
    track: float  # [m]
    contact: tuple[float, float]  # of a wheel along and across [m]


@dataclass(frozen=True, eq=False)
class Strips:
    """S strips of the extradoses and tops of a bridge under the road, as a vehicle on it loads them."""

    face: np.ndarray  # (S,) its face
    ends: np.ndarray  # (S, 2) along the road [m]
    depth: np.ndarray  # (S,) [m]
    place: np.ndarray  # (S, 3) where the load of the strip acts, world frame [m]
    share: np.ndarray  # (S,) of a load on its part of the road that the strip bears, of those that lie next to each other
    heavier: np.ndarray  # (S,) times which it is on the whole width, as one on the width that carries it

    def weights(self, at: np.ndarray, fill: Fill, contact: float) -> np.ndarray:
        """Shares (M, S) of loads at M places along the road, none of those off the bridge; the road next to it bears the rest."""
        low, high = self.ends.T
        before, behind = (float(self.depth[k]) for k in (int(np.argmin(low)), int(np.argmax(high))))
        own = self.share * (_below(high - at[:, None], self.depth, contact, fill) - _below(low - at[:, None], self.depth, contact, fill))
        rest = _below(low.min() - at, before, contact, fill) + 1.0 - _below(high.max() - at, behind, contact, fill)
        on = (at >= fill.deck[0]) & (at <= fill.deck[1])
        return np.asarray(np.where(on[:, None], own / (own.sum(axis=1) + rest)[:, None], 0.0))


def _below(x: np.ndarray, depth: np.ndarray | float, contact: float, fill: Fill) -> np.ndarray:
    """F of the head of this file at x [m]: the share of a load that is spread to less than x."""
    d = np.maximum(depth, LEAST_DEPTH)
    if fill.spread == "2:1":
        return np.asarray(np.clip(0.5 + x / (contact + d), 0.0, 1.0))
    whole = THIRTY + 0.25 * math.sqrt(3.0)
    total = np.zeros(np.broadcast(x, d).shape)
    for k in range(LINES):
        t = np.clip((x - contact * ((k + 0.5) / LINES - 0.5)) / d, -math.tan(THIRTY), math.tan(THIRTY))
        total = total + 0.5 * (libm.atan(t) + t / (1.0 + t * t) + whole) / whole
    return total / LINES


@lru_cache(maxsize=8)  # they are those of all places of a vehicle, which is evaluated at many
def strips_of(fill: Fill, vehicle: Known, line: str, offset: float) -> Strips:
    """Cut the faces below the road into strips, and share the wheels of an axle among those next to each other; ``line`` and ``offset`` are
    the keys ``across`` and ``offset`` of the vehicle."""
    rows = list[tuple[int, np.ndarray, float, np.ndarray, float]]()
    for number, face in enumerate(fill.faces):
        if face.kind in ON:
            rows += [(number, *row) for row in _of_face(face, fill, vehicle, offset if line == "wheels" else None)]
    face_of, ends, depth, place, across = zip(*rows, strict=True)
    heavier = [1.0 if line != "strip" else _heavier(d, fill, vehicle, offset) for d in depth]
    return Strips(np.array(face_of), np.array(ends), np.array(depth), np.array(place), np.array(across), np.array(heavier))


def _heavier(depth: float, fill: Fill, vehicle: Known, offset: float) -> float:
    """W / b at a depth: the whole width over that which carries an axle."""
    low, high = fill.clear
    reach = 0.5 * (vehicle.contact[1] + max(depth, 0.0))
    wheels = (offset - 0.5 * vehicle.track, offset + 0.5 * vehicle.track)
    (a, b), (c, d) = ((max(low, wheel - reach), min(high, wheel + reach)) for wheel in wheels)
    return (high - low) / (d - a if c <= b else 2.0 * min(b - a, d - c))


def _of_face(face: FillFace, fill: Fill, vehicle: Known, offset: float | None) -> list[tuple[np.ndarray, float, np.ndarray, float]]:
    """Ends along the road, depth, place and share across of the strips of one face, a quadrilateral over a line across the road; a vehicle
    without an offset is a line."""
    own = fill.along(face.corners)
    own[:, 0] -= fill.slant * own[:, 1]
    (x0, z0), (x1, z1) = own[0, [0, 2]], own[1, [0, 2]]
    near, far = float(own[0, 1]), float(own[2, 1])
    cuts = np.linspace(near, far, (ACROSS if fill.slant else 1) + 1)  # a slanted joint lies elsewhere under each wheel
    found = []
    for k, (a, b) in product(range(ALONG), pairwise(cuts.tolist())):
        m = (k + 0.5) / ALONG
        z = z0 + m * (z1 - z0)
        share, y = _across(a, b, fill.level - z, fill, vehicle, offset)
        place = np.array([x0 + m * (x1 - x0) + fill.slant * y, y, z])
        ends = x0 + (x1 - x0) * np.array([k, k + 1]) / ALONG + fill.slant * y
        if share > 0.0:
            found.append((ends, fill.level - z, fill.in_world(place), share))
    return found


def _across(near: float, far: float, depth: float, fill: Fill, vehicle: Known, offset: float | None) -> tuple[float, float]:
    """The share of an axle that a strip between two places across the road bears, of all that is between the walls, and its middle."""
    ends = np.linspace(near, far, ACROSS + 1)
    if offset is None:
        wide = fill.clear[1] - fill.clear[0]
        return (far - near) / wide, 0.5 * (near + far)
    part, whole = np.zeros(ACROSS), 0.0
    for wheel in (offset - 0.5 * vehicle.track, offset + 0.5 * vehicle.track):
        part = part + np.diff(_below(ends - wheel, depth, vehicle.contact[1], fill))
        whole += float(np.diff(_below(np.array(fill.clear) - wheel, depth, vehicle.contact[1], fill))[0])
    share = float(part.sum()) / whole
    middle = 0.5 * (ends[1:] + ends[:-1])
    return share, float(np.sum(part * middle) / part.sum()) if part.sum() > 0.0 else 0.5 * (near + far)


def stress_under(fill: Fill, vehicle: Known, line: str, offset: float, axles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The upright stress (N,) [Pa] of axles at places (A,) along the road, even over what 2:1 reaches, at points (N, 3) in the world.

    ``line`` and ``offset`` are those of :func:`strips_of`; an axle that is not on the road loads nothing.
    """
    own = fill.along(points)
    depth = np.maximum(fill.level - own[:, 2], LEAST_DEPTH)
    long, low, high = vehicle.contact[0] + depth, *fill.clear
    wheels = (offset - 0.5 * vehicle.track, offset + 0.5 * vehicle.track)
    spread = [(wheel, vehicle.contact[1] + depth, 0.5) for wheel in wheels]
    if line == "line":
        spread = [(0.5 * (low + high), np.full_like(depth, high - low), 1.0)]
    total = np.zeros(len(own))
    for load, at in zip(vehicle.loads, axles, strict=True):
        if fill.deck[0] <= at <= fill.deck[1]:
            for middle, wide, share in spread:
                under = (np.abs(own[:, 0] - at) <= 0.5 * long) & (np.abs(own[:, 1] - middle) <= 0.5 * wide * (1.0 + 1e-9))
                total += np.where(under, share * load / (long * wide), 0.0)
    return total


def places_on(face: FillFace) -> tuple[np.ndarray, np.ndarray]:
    """Places (N, 3) all over a face, and the area of each (N,) [m, m2]: cells of a grid on the triangles about its middle.

    They are symmetric where the face is, so that a bridge stays in its plane.
    """
    first, grid = face.corners.mean(axis=0), (np.arange(FINE) + 0.5) / FINE
    u, v = np.sqrt(grid)[:, None, None], grid[None, :, None]
    places, areas = list[np.ndarray](), list[np.ndarray]()
    for b, c in zip(face.corners, np.roll(face.corners, -1, axis=0), strict=True):
        places.append(((1.0 - u) * first + u * (1.0 - v) * b + u * v * c).reshape(-1, 3))
        areas.append(np.full(FINE**2, 0.5 * math.sqrt(float((np.cross(b - first, c - first) ** 2).sum())) / FINE**2))
    return np.concatenate(places), np.concatenate(areas)
