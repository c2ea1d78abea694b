# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of openings: the hole, and the voussoirs or the lintel around it, as polygons of the face of a wall (s along it, z up).

    rectangular   jambs under a lintel; with a ring, under a flat arch between skewbacks
    round         jambs under half a circle
    segmental     jambs under an arc between inclined springings
    pointed       jambs under two arcs that meet in a crown joint
    rose          a whole circle of voussoirs
    niche         as rectangular, or segmental where it has a rise; its back is walled up

Courses are cut by the frame as a whole: beds need not meet sills, springings or crowns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import Polygon

from masonry_cd.foundation import libm
from structures.building.table import WallOpeningTable
from structures.layout.openings import natural_bearing, natural_ring, voussoir_width

LEAST_MEASURE = 1e-2  # of a width or a ring [m]
SLENDER = 0.6  # width of a voussoir on the intrados, in thicknesses of the ring
MOST_VOUSSOIRS = 199
LEAST_ROUND = 7  # voussoirs of a half circle
LEAST_BEARING = 0.1  # of a lintel that has less masonry beside it than it should [m]
LEAST_RING = 0.12  # of an arch that has less masonry around it than it should, in widths
LEAST_LINTEL = 0.15  # and the height of such a lintel
SKEW = math.radians(20.0)  # of the skewbacks of a flat arch from the upright


Pieces = tuple[tuple[str, np.ndarray], ...]  # "voussoir" or "lintel", convex polygons (n, 2) s, z [m]


@dataclass(frozen=True, eq=False)
class Frame:
    """An opening and what closes it, s and z [m]."""

    keys: WallOpeningTable
    name: str
    hole: Polygon
    pieces: Pieces
    hull: Polygon  # the hole and its pieces
    levels: tuple[float, ...]  # heights at which a bed is welcome

    @property
    def depth(self) -> float | None:
        """Of a niche [m]; None where the opening goes through."""
        return self.keys.depth if self.keys.shape == "niche" else None


@dataclass(frozen=True)
class Around:
    """What a frame takes from its wall [m]."""

    s: float  # of its middle, along its facet
    base: float  # z of the foot of the wall
    course: float
    unit: float
    thickness: float
    beside: float = math.inf  # masonry beside the hole, on the side that has less of it
    top: float = math.inf  # z of the lowest part of the top over the hole


def frame_of(keys: WallOpeningTable, name: str, around: Around) -> Frame:
    """The frame of an opening.

    Raises:
        ValueError: measures that do not fit together, or a key of another shape.
    """
    keys = _with_defaults(keys, around)
    s, sill = around.s, around.base + keys.sill
    assert keys.height is not None
    if keys.shape == "rose":
        return _rose(keys, name, s, sill + 0.5 * keys.width, around.course)
    springing, half = sill + keys.height - (keys.rise or 0.0), 0.5 * keys.width
    box = np.array([(s - half, sill), (s + half, sill), (s + half, springing), (s - half, springing)])
    if keys.rise is None:
        return _straight(keys, name, box)
    inner, outer = _profiles(keys, around.course)
    inner, outer = inner + [s, springing], outer + [s, springing]
    inner[0, 1], inner[-1, 1] = springing, springing
    pieces = tuple(("voussoir", np.array([inner[k], outer[k], outer[k + 1], inner[k + 1]])) for k in range(len(inner) - 1))
    hole = Polygon([*box[:2], *inner])
    levels = (sill, springing, *({float(outer[0, 1])} - {springing}))
    return _framed(keys, name, hole, pieces, levels)


def _with_defaults(keys: WallOpeningTable, around: Around) -> WallOpeningTable:
    """The keys with what they leave out.

    Raises:
        ValueError: see :func:`frame_of`.
    """
    shape, width = keys.shape, keys.width
    new: dict[str, float] = {}
    arched = shape in ("round", "segmental", "pointed") or (shape == "niche" and keys.rise is not None)
    for key, belongs in (
        ("rise", shape in ("segmental", "pointed", "niche")),
        ("lintel", shape == "rectangular" or (shape == "niche" and not arched)),
        ("bearing", shape == "rectangular" or (shape == "niche" and not arched)),
        ("depth", shape == "niche"),
    ):
        if getattr(keys, key) is not None and not belongs:
            raise ValueError(f"{key} belongs to another shape, this one is {shape}")
    if shape == "rectangular" and keys.lintel is not None and keys.ring is not None:
        raise ValueError("give lintel or ring")
    if shape == "rose":
        if keys.height is not None and abs(keys.height - width) > 1e-9:
            raise ValueError(f"a rose is as high as wide, {width:g} m, got {keys.height:g}")
        new["height"] = width
    else:
        new["height"] = keys.height or 2.0 * width
    if arched:
        natural = {"round": 0.5 * width, "segmental": width / 6.0, "pointed": 0.5 * math.sqrt(3.0) * width}
        new["rise"] = keys.rise or natural.get(shape, 0.0)
        most = 0.5 * width if shape in ("segmental", "niche") else math.inf
        least = 0.5 * width * (1.0 + 1e-6) if shape == "pointed" else 0.01 * width
        if not least <= new["rise"] <= most * (1.0 + 1e-9):
            raise ValueError(
                f"its rise must be {least:.4g} m or more{f', and at most {most:.4g} m' if most < math.inf else ''}, got {new['rise']:g}"
            )
        new["height"] = keys.height or max(new["height"], new["rise"])
        if new["height"] < new["rise"] * (1.0 - 1e-9):
            raise ValueError(f"its height must be at least the rise of its head, {new['rise']:.4g} m, got {new['height']:g}")
    above = around.top - around.base - keys.sill - new["height"]
    if arched or shape == "rose":
        space = min(around.beside, above, keys.sill if shape == "rose" else math.inf)
        new["ring"] = keys.ring or _fitted(natural_ring(width, around.course), space, LEAST_RING * width)
    elif keys.ring is None:
        new["lintel"] = keys.lintel or _fitted(around.course, above, LEAST_LINTEL * width)
        new["bearing"] = keys.bearing or _fitted(natural_bearing(width, around.unit), around.beside, LEAST_BEARING)
    if shape == "niche":
        new["depth"] = keys.depth or around.thickness / 3.0
        if new["depth"] > 0.8 * around.thickness:
            raise ValueError(f"its depth must be at most 0.8 of the wall, {0.8 * around.thickness:.4g} m, got {new['depth']:g}")
    for key in ("width", "height", "ring", "lintel"):
        value = new.get(key, getattr(keys, key))
        if value is not None and value < LEAST_MEASURE:
            raise ValueError(f"its {key} must be at least {LEAST_MEASURE:g} m, got {value:g}")
    return keys.model_copy(update=new)


def _fitted(natural: float, space: float, least: float) -> float:
    """A measure of a head by default: less where there is not as much masonry, unless that is too little for any [m]."""
    return space if least <= space < natural else natural


def _straight(keys: WallOpeningTable, name: str, box: np.ndarray) -> Frame:
    """Under a lintel, or a flat arch."""
    (left, sill), (right, _), (_, top), _ = box
    if keys.ring is None:
        assert keys.bearing is not None and keys.lintel is not None
        a, b, high = left - keys.bearing, right + keys.bearing, top + keys.lintel
        piece = np.array([(a, top), (b, top), (b, high), (a, high)])
        return _framed(keys, name, Polygon(box), (("lintel", piece),), (sill, top, high))
    high, count = top + keys.ring, _odd((right - left) / (SLENDER * keys.ring))
    return _framed(keys, name, Polygon(box), _flat_arch((left, right), (top, high), count), (sill, top, high))


def _flat_arch(jambs: tuple[float, float], heights: tuple[float, float], count: int) -> Pieces:
    """The voussoirs of a flat arch between skewbacks over two jambs, between two heights [m]."""
    centre, half = 0.5 * (jambs[0] + jambs[1]), 0.5 * (jambs[1] - jambs[0])
    share = (2.0 * np.arange(count + 1) - count) / count  # -1 to 1, symmetric to the bit
    wide = half + (heights[1] - heights[0]) * math.tan(SKEW)
    low, high = (np.stack([centre + h * share, np.full(count + 1, z)], axis=1) for h, z in zip((half, wide), heights, strict=True))
    return tuple(("voussoir", np.array([low[k], low[k + 1], high[k + 1], high[k]])) for k in range(count))


def _rose(keys: WallOpeningTable, name: str, s: float, z: float, course: float) -> Frame:
    """A whole circle of voussoirs."""
    assert keys.ring is not None
    radius = 0.5 * keys.width
    count = max(8, 2 * round(math.pi * radius / voussoir_width(keys.ring, course)))
    angles = 2.0 * math.pi * (np.arange(count) + 0.5) / count
    unit = np.stack([libm.cos(angles), libm.sin(angles)], axis=1)
    inner, outer = [s, z] + radius * unit, [s, z] + (radius + keys.ring) * unit
    pieces = tuple(("voussoir", np.array([inner[k - 1], outer[k - 1], outer[k], inner[k]])) for k in range(count))
    return _framed(keys, name, Polygon(inner), pieces, ())


def _profiles(keys: WallOpeningTable, course: float) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the joints on intrados and extrados (n, 2), from the right springing to the left, seen from its middle."""
    assert keys.rise is not None and keys.ring is not None
    half, rise, ring = 0.5 * keys.width, keys.rise, keys.ring
    if keys.shape == "pointed":  # each side is an arc about a point on the springing line
        radius = (half**2 + rise**2) / (2.0 * half)
        centre, end = half - radius, math.atan2(rise, radius - half)
        count = max(2, round(end * radius / voussoir_width(ring, course)))
        angles = end * np.arange(count + 1) / count
        unit = np.stack([libm.cos(angles), libm.sin(angles)], axis=1)
        inner, outer = ([centre, 0.0] + r * unit for r in (radius, radius + ring))
        inner[-1], outer[-1] = (0.0, rise), (0.0, math.sqrt((radius + ring) ** 2 - centre**2))
        mirror = np.array([-1.0, 1.0])
        return np.concatenate([inner, inner[-2::-1] * mirror]), np.concatenate([outer, outer[-2::-1] * mirror])
    radius = (half**2 + rise**2) / (2.0 * rise)
    start = math.asin(min(1.0, (radius - rise) / radius))
    start = start if start > 1e-6 else 0.0
    count = max(_odd((math.pi - 2.0 * start) * radius / voussoir_width(ring, course)), LEAST_ROUND if start == 0.0 else 3)
    angles = start + (math.pi - 2.0 * start) * np.arange(count + 1) / count
    unit = np.stack([libm.cos(angles), libm.sin(angles)], axis=1)
    unit[-1] = unit[0] * [-1.0, 1.0]
    middle = np.array([0.0, rise - radius])
    return middle + radius * unit, middle + (radius + ring) * unit


def _odd(wanted: float) -> int:
    """The nearest odd number, three or more."""
    return min(MOST_VOUSSOIRS, max(3, 2 * round((wanted - 1) / 2) + 1))


def _framed(keys: WallOpeningTable, name: str, hole: Polygon, pieces: Pieces, levels: tuple[float, ...]) -> Frame:
    """A frame with its hull."""
    hull = shapely.union_all([hole, *(Polygon(polygon) for _, polygon in pieces)])
    if not isinstance(hull, Polygon) or len(hull.interiors):
        raise ValueError("its head does not close; take a thicker ring")
    return Frame(keys, name, hole, pieces, hull, tuple(float(z) for z in levels))
