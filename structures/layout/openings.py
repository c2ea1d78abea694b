# SPDX-License-Identifier: GPL-3.0-or-later
r"""Openings in coursed walls: jambs, and the lintel or arch that closes them, matched to the courses.

A wall is cut by level beds, so what surrounds an opening is given course by course: the half-width at its bed and at its
top. Everything between two such edges is then a trapezoid, and every block is convex:

- a lintel is one block with a bearing on each jamb;
- a flat arch has joints that meet below, and skewbacks at SKEW to the upright;
- a round or segmental arch has straight-edged voussoirs. On its haunches, below STEEP, the corners of the extrados
  lie on the beds, as in rings keyed to the courses. Above, an upright joint rises from every corner to the first bed that
  leaves enough masonry over the ring, and the courses end there.

Offsets count from the axis of the opening, which is symmetric; heights are absolute.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from structures import size
from structures.schema import HeadShape, OpeningTable

SKEW = math.radians(20.0)  # of the skewbacks of a flat arch from the upright
STEEP = math.radians(62.0)  # up to this slope, measured at the centre, beds end on the extrados
FIRST = math.radians(25.0)  # the last bed that ends on the extrados lies above this
LEAST = 0.4  # masonry between a corner of the extrados and the bed above it, in courses
LEAST_MEASURE = 1e-3  # of an opening, its head or its voussoirs [m]: smaller ones are slips, and make voussoirs by the million
SAME = 1e-9  # heights closer than this are one [m]


@dataclass(frozen=True)
class Opening:
    """The measures of one opening [m]."""

    key: str  # what the key of a measure begins with: "structure.openings[0]." or "structure.door_"
    centre: float
    width: float
    sill: float
    height: float  # clear, to the crown of the intrados
    head: HeadShape
    depth: float  # of the lintel or of the ring
    rise: float  # of the intrados
    bearing: float = 0.0  # of a lintel

    @property
    def springing(self) -> float:
        """Height at which the jambs end."""
        return self.sill + self.height - self.rise

    @property
    def inner(self) -> float:
        """Radius of the intrados."""
        return (self.width**2 / 4.0 + self.rise**2) / (2.0 * self.rise)

    @property
    def depth_key(self) -> str:
        """The key that sets the depth: its own in a table of openings, else the width, of which it is a share."""
        return f"{self.key}depth" if self.key.endswith("].") else f"{self.key}width"

    @property
    def outer(self) -> float:
        """Radius of the extrados."""
        return self.inner + self.depth

    @property
    def level(self) -> float:
        """Height of the centre of the arch."""
        return self.sill + self.height - self.inner

    @property
    def start(self) -> float:
        """Angle of the springing joint above the level [rad]."""
        sine = (self.inner - self.rise) / self.inner
        return math.asin(sine) if sine > SAME else 0.0

    @property
    def skewback(self) -> float:
        """Height of the outer end of the springing joint."""
        return self.level + self.outer * math.sin(self.start) if self.rise else self.springing + self.depth

    @property
    def crown(self) -> float:
        """Height of the top of the lintel or of the crown of the extrados."""
        return self.sill + self.height + self.depth


@dataclass(frozen=True, eq=False)
class Closing:
    """An opening as the courses meet it."""

    opening: Opening
    edges: dict[int, tuple[float, float]]  # by course: half-width at its lower and at its upper bed
    pieces: list[tuple[str, np.ndarray]]  # "lintel", "voussoir" and "stone" (over the extrados), polygons of s, z

    @property
    def reach(self) -> float:
        """Largest half-width."""
        return max(max(edge) for edge in self.edges.values())


def opening_of(table: OpeningTable, key: str, course: float, unit: float, foot: float = 0.0, centre: float | None = None) -> Opening:
    """An opening from its table, with the defaults filled in.

    Raises:
        InputError: a rise that is no arch, or a measure below a millimetre.
    """
    for measure in ("width", "height", "depth", "rise", "bearing"):
        given = getattr(table, measure)
        if given is not None and given < LEAST_MEASURE:
            raise InputError(f"{key}{measure}: must be at least {LEAST_MEASURE:g} m, got {given:g}")
    rise = 0.0
    if table.head == "round":
        rise = 0.5 * table.width
    elif table.head == "segmental":
        rise = table.width / 6.0 if table.rise is None else table.rise
        if rise > 0.5 * table.width * (1.0 + 1e-9):
            raise InputError(f"{key}rise: must be at most half the width, {0.5 * table.width:g} m, got {rise:g}")
    if table.rise is not None and table.head != "segmental":
        raise InputError(f'{key}rise: belongs to a segmental head, this one is "{table.head}"')
    if table.height <= rise:
        raise InputError(f"{key}height: must exceed the rise of the arch, {rise:g} m, got {table.height:g}")
    depth = table.depth or _natural_depth(table.head, table.width, rise, course)
    bearing = 0.0
    if table.head == "lintel":
        bearing = table.bearing or natural_bearing(table.width, unit)
    elif table.bearing is not None:
        raise InputError(f'{key}bearing: belongs to a lintel, this head is "{table.head}"')
    middle = table.centre if centre is None else centre
    return Opening(key, middle, table.width, foot + table.sill, table.height, table.head, depth, rise, bearing)


def natural_bearing(width: float, unit: float) -> float:
    """Of a lintel on each jamb [m]."""
    return max(unit / 3.0, 0.15 * width)


def natural_ring(width: float, course: float) -> float:
    """Thickness of the voussoirs of a round arch: a fifth of its span, for a small one up to a course [m]."""
    return max(0.2 * width, min(0.8 * course, 0.35 * width))


def voussoir_width(ring: float, course: float) -> float:
    """Aimed at [m]."""
    return max(0.6 * ring, min(0.8 * course, 1.2 * ring))


def _natural_depth(head: HeadShape, width: float, rise: float, course: float) -> float:
    """A lintel or a flat arch of one course; a round arch of a fifth of its span; a skewback of whole courses."""
    if head == "round":
        return natural_ring(width, course)
    if head != "segmental":
        return course
    inner = (width**2 / 4.0 + rise**2) / (2.0 * rise)
    sine = 1.0 - rise / inner
    return max(1, round(0.2 * width * sine / course)) * course / sine if sine > 0.3 else max(0.2 * width, 0.8 * course)


def breaks(opening: Opening) -> list[tuple[float, str]]:
    """Heights at which the opening needs a bed, and the key that sets each."""
    found = [(opening.springing, f"{opening.key}height")]
    if opening.sill > 0:
        found.append((opening.sill, f"{opening.key}sill"))
    if opening.skewback > opening.springing + SAME:
        found.append((opening.skewback, opening.depth_key))
    return found


def haunch_break(opening: Opening, beds: Sequence[float], fixed: Sequence[float], least: float) -> tuple[float, str] | None:
    """A bed to add where the courses are too high for the arch to meet one on its haunch.

    Args:
        beds: all beds so far [m].
        fixed: those of them that must stay [m].
        least: distance to keep from these, where possible [m].
    """
    if not opening.rise or opening.start > FIRST:
        return None
    slopes = [_slope(opening, z) for z in beds if opening.springing + SAME < z < opening.level + opening.outer]
    if any(FIRST <= slope <= STEEP for slope in slopes):
        return None
    angles = 0.5 * (FIRST + STEEP) + 0.5 * (STEEP - FIRST) * np.array([0.0, 0.3, -0.3, 0.6, -0.6, 0.9, -0.9])
    heights = opening.level + opening.outer * libm.sin(angles)
    room = np.minimum(np.abs(heights[:, None] - np.array(fixed)[None, :]).min(axis=1), least)
    return float(heights[np.argmax(room)]), opening.depth_key


def _slope(opening: Opening, z: float) -> float:
    return math.asin((z - opening.level) / opening.outer)


def close(opening: Opening, levels: Sequence[float], course: float) -> Closing:
    """Fit the head of an opening to the beds of its wall.

    Args:
        opening: its sill and springing lie on beds.
        levels: heights of the beds [m], ascending.
        course: the height of a course [m].

    Raises:
        InputError: too little masonry above.
    """
    beds = np.asarray(levels)
    if opening.crown > beds[-1] - (SAME if not opening.rise else LEAST * course):
        room = opening.height + beds[-1] - opening.crown - (LEAST * course if opening.rise else 0.0)
        raise InputError(
            f"{opening.key}height: must be at most {max(0.0, room):.4g} m, the wall ends at {beds[-1]:g} m, got {opening.height:g}"
        )
    foot, springing = _index(beds, opening.sill), _index(beds, opening.springing)
    half = 0.5 * opening.width
    edges = dict.fromkeys(range(foot, springing), (half, half))
    if opening.head == "lintel":
        return _lintel(opening, beds, springing, edges)
    if opening.head == "flat":
        return _flat(opening, beds, springing, edges)
    return _arch(opening, beds, springing, edges, course)


def _index(beds: np.ndarray, z: float) -> int:
    index = int(np.argmin(np.abs(beds - z)))
    if abs(beds[index] - z) > SAME:
        raise RuntimeError(f"no bed at {z:g} m")
    return index


def _lintel(opening: Opening, beds: np.ndarray, springing: int, edges: dict[int, tuple[float, float]]) -> Closing:
    top = _index(beds, opening.skewback)
    wide, c = 0.5 * opening.width + opening.bearing, opening.centre
    edges |= dict.fromkeys(range(springing, top), (wide, wide))
    low, high = beds[springing], beds[top]
    piece = np.array([[c - wide, low], [c + wide, low], [c + wide, high], [c - wide, high]])
    return Closing(opening, edges, [("lintel", piece)])


def _flat(opening: Opening, beds: np.ndarray, springing: int, edges: dict[int, tuple[float, float]]) -> Closing:
    top = _index(beds, opening.skewback)
    half, low, high = 0.5 * opening.width, beds[springing], beds[top]
    at = np.interp(beds[springing : top + 1], [low, high], [half, half + opening.depth * math.tan(SKEW)])
    edges |= {springing + i: (float(at[i]), float(at[i + 1])) for i in range(top - springing)}
    count = _odd_count(opening, opening.width / (0.6 * opening.depth))
    return Closing(opening, edges, flat_arch(opening.centre, half, (float(low), float(high)), count))


def flat_arch(centre: float, half: float, heights: tuple[float, float], count: int) -> list[tuple[str, np.ndarray]]:
    """The voussoirs of a flat arch between skewbacks over a half-width, between two heights [m]."""
    share = (2.0 * np.arange(count + 1) - count) / count  # -1 to 1, symmetric to the bit
    wide = half + (heights[1] - heights[0]) * math.tan(SKEW)
    return _quads(*(np.stack([centre + h * share, np.full(count + 1, z)], axis=1) for h, z in zip((half, wide), heights, strict=True)))


def _quads(inner: np.ndarray, outer: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Voussoirs between successive joints, given by their ends on intrados and extrados."""
    return [("voussoir", np.array([inner[k], inner[k + 1], outer[k + 1], outer[k]])) for k in range(len(inner) - 1)]


def _arch(opening: Opening, beds: np.ndarray, springing: int, edges: dict[int, tuple[float, float]], course: float) -> Closing:
    angles, haunch = _corners(opening, beds, voussoir_width(opening.depth, course))
    unit = np.stack([libm.cos(angles), libm.sin(angles)], axis=1)
    if opening.start == 0.0:
        unit[0] = (1.0, 0.0)
    centre = np.array([0.0, opening.level])
    inner, outer = opening.inner * unit + centre, opening.outer * unit + centre
    inner[0] = 0.5 * opening.width, beds[springing]
    for k in range(haunch + 1):  # corners that were put on a bed lie on it to the bit
        near = beds[np.argmin(np.abs(beds - outer[k, 1]))]
        outer[k, 1] = near
    if opening.start > 0:
        skew = _index(beds, opening.skewback)
        at = np.interp(beds[springing : skew + 1], [inner[0, 1], outer[0, 1]], [inner[0, 0], outer[0, 0]])
        edges |= {springing + i: (float(at[i]), float(at[i + 1])) for i in range(skew - springing)}
    else:
        skew = springing
    last = _index(beds, float(outer[haunch, 1]))
    at = np.interp(beds[skew : last + 1], outer[: haunch + 1, 1], outer[: haunch + 1, 0])
    edges |= {skew + i: (float(at[i]), float(at[i + 1])) for i in range(last - skew)}
    stones = _over(opening, beds, outer[haunch:], last, edges, course)
    mirror = np.array([-1.0, 1.0])
    place = np.array([opening.centre, 0.0])
    both = [np.concatenate([side * mirror, side[::-1]]) + place for side in (inner, outer)]
    return Closing(opening, edges, _quads(*both) + [("stone", polygon + place) for polygon in stones])


def _odd_count(opening: Opening, wanted: float) -> int:
    """The odd number of voussoirs, one of them a keystone, that is nearest to a number.

    Raises:
        InputError: more than the structure may have blocks.
    """
    size.within(wanted, opening.depth_key.removeprefix("structure."))
    return max(3, 2 * round((wanted - 1) / 2) + 1)


def _corners(opening: Opening, beds: np.ndarray, target: float) -> tuple[np.ndarray, int]:
    """Angles [rad] of the joints from the springing to the keystone, and the last of them that lies on a bed."""
    found = [opening.start]
    if opening.start < FIRST:
        slopes = [_slope(opening, float(z)) for z in beds if opening.skewback + SAME < z < opening.level + opening.outer]
        steep = [slope for slope in slopes if slope <= STEEP]
        if not steep or steep[-1] < FIRST:
            raise InputError(f"{opening.depth_key}: no bed meets the haunches of this arch; take lower courses")
        for slope in steep[:-1]:
            if min(slope - found[-1], steep[-1] - slope) * opening.outer >= 0.7 * target:
                found.append(slope)
        found.append(steep[-1])
    rest = math.pi - 2.0 * found[-1]
    count = _odd_count(opening, rest * opening.outer / target)
    haunch = len(found) - 1
    found += [found[-1] + rest * i / count for i in range(1, count // 2 + 1)]
    return np.array(found), haunch


def _over(
    opening: Opening, beds: np.ndarray, corners: np.ndarray, first: int, edges: dict[int, tuple[float, float]], course: float
) -> list[np.ndarray]:
    """Stones between the ring and the first bed that passes over them; the edges of the courses beside them are entered."""
    tops = []
    for k in range(len(corners)):  # the strip between corner k and k + 1; the last one spans the keystone
        inner = min(k + 1, len(corners) - 1)
        above = np.flatnonzero(beds >= corners[inner, 1] + LEAST * course - SAME)
        if not len(above):
            raise InputError(f"{opening.key}height: no bed passes over its arch; the wall ends at {beds[-1]:g} m")
        tops.append(max(int(above[0]), first + 1))
    for j in range(first, tops[-1]):
        k = next(k for k, top in enumerate(tops) if top > j)
        edges[j] = (float(corners[k, 0]), float(corners[k, 0]))
    stones = []
    for k in range(len(corners) - 1):
        (x0, z0), (x1, z1), top = corners[k], corners[k + 1], beds[tops[k]]
        stones.append(np.array([[x1, z1], [x0, z0], [x0, top], [x1, top]]))
        stones.append(np.array([[-x0, z0], [-x1, z1], [-x1, top], [-x0, top]]))
    (x, z), top = corners[-1], beds[tops[-1]]
    stones.append(np.array([[-x, z], [x, z], [x, top], [-x, top]]))
    return stones
