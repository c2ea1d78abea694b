# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of openings: the hole, and the voussoirs or the lintel around it, as polygons of the face of a wall (s along it, z up).

    rectangular   jambs under a lintel; with a ring, under a flat arch between skewbacks
    round         jambs under half a circle
    segmental     jambs under an arc between inclined springings
    pointed       jambs under two arcs that meet in a crown joint
    rose          a whole circle of voussoirs
    niche         as rectangular, or segmental where it has a rise; its back is walled up

Each is an instance of a class, which says what keys it takes, what these are where they are left out, and what it draws.

Courses are cut by the frame as a whole: beds need not meet sills, springings or crowns.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
import shapely
from shapely.geometry import Polygon

from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from structures.building.table import WallOpeningTable
from structures.courser import arch_profiles
from structures.courser.arch_profiles import voussoirs
from structures.courser.wall_plan import natural_bearing, natural_ring, voussoir_width

LEAST_MEASURE = 1e-2  # of a width or a ring [m]
SLENDER = 0.6  # width of a voussoir on the intrados, in thicknesses of the ring
MOST_VOUSSOIRS = 199
LEAST_ROUND = 7  # voussoirs of a half circle
NATURAL_RISE = {"round": 0.5, "segmental": 1.0 / 6.0, "pointed": 0.5 * math.sqrt(3.0)}  # of an arch by default, in widths
LEAST_BEARING = 0.1  # of a lintel that has less masonry next to it than it should [m]
LEAST_RING = 0.12  # of an arch that has less masonry around it than it should, in widths
LEAST_LINTEL = 0.15  # and the height of such a lintel
SKEW = math.radians(20.0)  # of the skewbacks of a flat arch from the upright


Pieces = tuple[tuple[str, np.ndarray], ...]  # "voussoir" or "lintel", convex polygons (n, 2) s, z [m]


class Named(NamedTuple):
    """An opening in messages."""

    where: str  # its key
    words: str = ""  # where its key alone does not say which it is

    def __str__(self) -> str:
        return self.words or self.where


@dataclass(frozen=True, eq=False)
class Frame:
    """An opening and what closes it, s and z [m]."""

    keys: WallOpeningTable
    name: Named
    hole: Polygon
    pieces: Pieces
    hull: Polygon  # the hole and its pieces
    levels: tuple[float, ...]  # heights at which a bed is welcome

    @property
    def depth(self) -> float | None:
        """Depth of a niche [m]; None where the opening goes through."""
        return self.keys.depth if self.keys.shape == "niche" else None


@dataclass(frozen=True)
class Around:
    """Space that a frame takes from its wall [m]."""

    s: float  # of its middle, along its facet
    base: float  # z of the foot of the wall
    course: float
    unit: float
    thickness: float
    next_to: float = math.inf  # masonry next to the hole, on the side that has less of it
    top: float = math.inf  # z of the lowest part of the top over the hole


def frame_of(keys: WallOpeningTable, name: Named, around: Around) -> Frame:
    """The frame of an opening.

    Raises:
        InputError: measures that do not fit together, or a key of another shape.
    """
    shape = SHAPES[keys.shape if keys.shape != "niche" else "rectangular" if keys.rise is None else "segmental"]
    for key in ("rise", "lintel", "bearing", "depth"):
        if getattr(keys, key) is not None and key not in shape.takes and not (key == "depth" and keys.shape == "niche"):
            raise InputError("", f"{key} belongs to another shape, this one is {keys.shape}")
    keys = shape.completed(keys, around)
    if keys.shape == "niche":
        keys = keys.model_copy(update={"depth": keys.depth or around.thickness / 3.0})
        if keys.depth is not None and keys.depth > 0.8 * around.thickness:
            raise InputError("", f"its depth must be at most 0.8 of the wall, {0.8 * around.thickness:.4g} m, got {keys.depth:g}")
    for key in ("width", "height", "ring", "lintel"):
        value = getattr(keys, key)
        if value is not None and value < LEAST_MEASURE:
            raise InputError("", f"its {key} must be at least {LEAST_MEASURE:g} m, got {value:g}")
    corners, pieces, levels = shape.drawn(keys, around.course)
    foot = np.array([around.s, around.base + keys.sill])
    hole, pieces = Polygon(corners + foot), tuple((kind, polygon + foot) for kind, polygon in pieces)
    hull = shapely.union_all([hole, *(Polygon(polygon) for _, polygon in pieces)])
    if not isinstance(hull, Polygon) or len(hull.interiors):
        raise InputError("", "its head does not close; take a thicker ring")
    return Frame(keys, name, hole, pieces, hull, tuple(float(foot[1] + z) for z in levels))


Drawn = tuple[np.ndarray, Pieces, tuple[float, ...]]  # hole (n, 2), what is around it, levels, from the middle of the sill [m]


class Straight:
    """A level head: a lintel, or with a ring a flat arch."""

    takes: ClassVar = ("lintel", "bearing")

    def completed(self, keys: WallOpeningTable, around: Around) -> WallOpeningTable:
        """The keys with defaults for what they leave out."""
        if keys.lintel is not None and keys.ring is not None:
            raise InputError("", "give lintel or ring")
        height = keys.height or 2.0 * keys.width
        new = {"height": height}
        if keys.ring is None:
            above = around.top - around.base - keys.sill - height
            new["lintel"] = keys.lintel or _fitted(around.course, above, LEAST_LINTEL * keys.width)
            new["bearing"] = keys.bearing or _fitted(natural_bearing(keys.width, around.unit), around.next_to, LEAST_BEARING)
        return keys.model_copy(update=new)

    def drawn(self, keys: WallOpeningTable, course: float) -> Drawn:
        """The hole (4, 2), and the lintel or the flat arch over it."""
        half, top = 0.5 * keys.width, keys.height or 0.0
        hole = np.array([(-half, 0.0), (half, 0.0), (half, top), (-half, top)])
        if keys.ring is None:
            wide, high = half + (keys.bearing or 0.0), top + (keys.lintel or 0.0)
            return hole, (("lintel", np.array([(-wide, top), (wide, top), (wide, high), (-wide, high)])),), (0.0, top, high)
        lower, upper = arch_profiles.flat(half, keys.ring, SKEW, _odd(keys.width / (SLENDER * keys.ring)))
        pieces = tuple(("voussoir", polygon + [0.0, top]) for polygon in voussoirs(lower, upper))
        return hole, pieces, (0.0, top, top + keys.ring)


@dataclass(frozen=True)
class Arched:
    """An arc over jambs, or two that meet in a crown joint where it is pointed; its rises in widths."""

    natural: float  # rise by default
    least: float
    most: float
    takes: tuple[str, ...]
    pointed: bool = False

    def completed(self, keys: WallOpeningTable, around: Around) -> WallOpeningTable:
        """The keys with defaults for what they leave out."""
        rise, least, most = keys.rise or self.natural * keys.width, self.least * keys.width, self.most * keys.width
        if not least <= rise <= most * (1.0 + 1e-9):
            raise InputError(
                "", f"its rise must be {least:.4g} m or more{f', and at most {most:.4g} m' if most < math.inf else ''}, got {rise:g}"
            )
        height = keys.height or max(2.0 * keys.width, rise)
        if height < rise * (1.0 - 1e-9):
            raise InputError("", f"its height must be at least the rise of its head, {rise:.4g} m, got {height:g}")
        return keys.model_copy(update={"rise": rise, "height": height, "ring": _ring(keys, height, around, around.next_to)})

    def drawn(self, keys: WallOpeningTable, course: float) -> Drawn:
        """The hole (n, 2), jambs and intrados, and the voussoirs around its head."""
        half, rise, ring = 0.5 * keys.width, keys.rise or 0.0, keys.ring or 0.0
        springing = (keys.height or 0.0) - rise
        if self.pointed:
            radius = (half**2 + rise**2) / (2.0 * half)
            end = math.atan2(rise, radius - half)
            count = max(2, round(end * radius / voussoir_width(ring, course)))
            inner, outer = arch_profiles.pointed(radius, radius + ring, radius - half, end, count)
        else:
            embrace = 180.0 if abs(rise - half) < 1e-6 * half else math.degrees(4.0 * math.atan2(rise, half))
            radius = (half**2 + rise**2) / (2.0 * rise)
            wanted = _odd(math.radians(embrace) * radius / voussoir_width(ring, course))
            inner, outer = arch_profiles.ring(radius, radius + ring, embrace, max(wanted, LEAST_ROUND if embrace == 180.0 else 3))
            inner, outer = inner + [0.0, rise - radius], outer + [0.0, rise - radius]
        inner[[0, -1], 1] = 0.0
        inner, outer = inner + [0.0, springing], outer + [0.0, springing]
        hole = np.concatenate([[(-half, 0.0), (half, 0.0)], inner[::-1]])
        pieces = tuple(("voussoir", polygon) for polygon in voussoirs(inner, outer)[::-1])
        return hole, pieces, (0.0, springing, *({float(outer[0, 1])} - {springing}))


class Rose:
    """A whole circle of voussoirs."""

    takes: ClassVar = ()

    def completed(self, keys: WallOpeningTable, around: Around) -> WallOpeningTable:
        """The keys with defaults for what they leave out."""
        if keys.height is not None and abs(keys.height - keys.width) > 1e-9:
            raise InputError("", f"a rose is as high as wide, {keys.width:g} m, got {keys.height:g}")
        ring = _ring(keys, keys.width, around, min(around.next_to, keys.sill))
        return keys.model_copy(update={"height": keys.width, "ring": ring})

    def drawn(self, keys: WallOpeningTable, course: float) -> Drawn:
        """The hole (n, 2), and the voussoirs all around it."""
        radius, ring = 0.5 * keys.width, keys.ring or 0.0
        count = max(8, 2 * round(math.pi * radius / voussoir_width(ring, course)))
        angles = 2.0 * math.pi * (np.arange(count) + 0.5) / count
        unit = np.stack([libm.cos(angles), libm.sin(angles)], axis=1)
        inner, outer = radius * unit + [0.0, radius], (radius + ring) * unit + [0.0, radius]
        return inner, tuple(("voussoir", np.array([inner[k - 1], outer[k - 1], outer[k], inner[k]])) for k in range(count)), ()


SHAPES: dict[str, Straight | Arched | Rose] = {
    "rectangular": Straight(),
    "round": Arched(NATURAL_RISE["round"], 0.01, math.inf, ()),
    "segmental": Arched(NATURAL_RISE["segmental"], 0.01, 0.5, ("rise",)),
    "pointed": Arched(NATURAL_RISE["pointed"], 0.5 * (1.0 + 1e-6), math.inf, ("rise",), pointed=True),
    "rose": Rose(),
}


def _ring(keys: WallOpeningTable, height: float, around: Around, next_to: float) -> float:
    """Thickness of the voussoirs of an arch in the masonry over and next to it [m]."""
    above = around.top - around.base - keys.sill - height
    return keys.ring or _fitted(natural_ring(keys.width, around.course), min(next_to, above), LEAST_RING * keys.width)


def _fitted(natural: float, space: float, least: float) -> float:
    """A measure of a head by default: less where there is not as much masonry, unless that is too little for any [m]."""
    return space if least <= space < natural else natural


def _odd(wanted: float) -> int:
    """The nearest odd number, three or more."""
    return min(MOST_VOUSSOIRS, max(3, 2 * round((wanted - 1) / 2) + 1))
