# SPDX-License-Identifier: GPL-3.0-or-later
r"""The lines of arches: where the joints of a ring of straight-edged voussoirs begin and end.

A ring of mid-radius R and thickness t over the embrace angle a is cut by N + 1 radial joints; intrados and extrados are
the chords between the joints, with corners at R - t/2 and R + t/2. With the clear span s and the clear rise f,

    s = 2 (R - t/2) sin(a/2),        f = (R - t/2) (1 - cos(a/2)),

so any two of span, radius, rise and embrace fix the circle; one of span and radius alone makes a semicircle. The number of
voussoirs and their straight edges are part of the mechanics: the least thickness of a semicircle varies by 4 % with them.

A pointed arch is two such arcs with centres on the springing line; its intrados radius is (s^2/4 + f^2) / s, and the joint
at the apex is vertical. A three-centred (basket-handle) arch is three arcs of 60 degrees with common tangents, the two small
ones with radius r and centres on the springing line, the large one with radius r + D:

    D = (s/2 - f) / (sin 30 - 1 + cos 30),        r = f - D (1 - cos 30).

A flat arch has a level intrados and extrados and joints that meet below, the outermost at the skew angle to the upright.

The intrados springs at z = 0 and is centred on x = 0. Joints are listed from the left springing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.units import Unit
from structures.schema import LONGEST, Length, Table, Thickness

AGREE = 1e-6  # relative difference up to which redundant keys agree
COS30 = math.sqrt(0.75)


class RingTable(Table):
    """The keys of a ring of voussoirs."""

    shape: Literal["circular", "pointed", "three-centred", "flat"] = "circular"
    """of the intrados"""
    span: Length | None = None
    """clear, between the springings of the intrados"""
    radius: Length | None = None
    """of the middle line"""
    rise: Length | None = None
    """clear, from the springing to the crown of the intrados"""
    embrace: Annotated[float, Unit("degrees")] | None = Field(None, gt=0, le=180)
    """angle between the springing joints"""
    skew: Annotated[float, Unit("degrees")] | None = Field(None, gt=0, le=45)
    """of the outermost joints of a flat arch to the upright; by default 20"""
    thickness: Thickness
    """of the ring"""
    voussoirs: int = Field(27, ge=2, le=2000)
    """to the ring"""


def joints_of(arch: RingTable) -> tuple[np.ndarray, np.ndarray]:
    """Joint ends on the intrados and on the extrados, from left to right, (N + 1, 2) x, z [m] each.

    Raises:
        InputError: keys that are missing, contradict each other or make no arch.
    """
    if arch.skew is not None and arch.shape != "flat":
        raise InputError("structure.skew", f'belongs to a flat arch, this one is "{arch.shape}"')
    if arch.span is not None and arch.thickness >= arch.span:
        raise InputError("structure.thickness", f"must be below the clear span, {arch.span:g} m, got {arch.thickness:g}")
    if arch.shape == "circular":
        return _circular(arch)
    if arch.shape == "pointed":
        return _pointed(arch)
    return _three_centred(arch) if arch.shape == "three-centred" else _flat(arch)


def ring(inner: float, outer: float, embrace: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Joint ends on the intrados and on the extrados of a circular ring, from left to right about its centre.

    The right half mirrors the left one to the bit, and the springing joints of a semicircle lie exactly on z = 0.

    Args:
        inner, outer: radii of intrados and extrados [m].
        embrace: [degrees].
        count: number of voussoirs N.

    Returns:
        Two arrays (N + 1, 2) of x, z [m].
    """
    half = [math.radians(embrace) * (0.5 - k / count) for k in range(count // 2 + 1)]  # angle from the vertical
    sines, cosines = [-math.sin(a) for a in half], [math.cos(a) for a in half]
    if embrace == 180.0:
        sines[0], cosines[0] = -1.0, 0.0
    if count % 2 == 0:
        sines[-1], cosines[-1] = 0.0, 1.0
    unit = np.array([sines, cosines]).T
    mirrored = unit[: count + 1 - len(unit)][::-1] * [-1.0, 1.0]
    unit = np.concatenate([unit, mirrored])
    return inner * unit, outer * unit


def _circular(arch: RingTable) -> tuple[np.ndarray, np.ndarray]:
    inner, embrace = _circle(arch)
    _check_agreement(arch, inner, embrace)
    intrados, extrados = ring(inner, inner + arch.thickness, embrace, arch.voussoirs)
    springing = np.array([0.0, intrados[0, 1]])
    return intrados - springing, extrados - springing


def _circle(arch: RingTable) -> tuple[float, float]:
    """Intrados radius [m] and embrace [degrees] from the keys given."""
    if arch.radius is not None:
        inner = arch.radius - 0.5 * arch.thickness
        if inner <= 0:
            limit = 2.0 * arch.radius
            raise InputError("structure.thickness", f"must be below twice the radius, {limit:g} m, got {arch.thickness:g}")
        return inner, _embrace_of_radius(arch, inner)
    if arch.span is None:
        raise InputError("structure.span", "missing; give the clear span or the radius")
    half = 0.5 * arch.span
    if arch.rise is not None:
        _check_at_most("rise", arch.rise, half, "half the span")
        return (half**2 + arch.rise**2) / (2.0 * arch.rise), 180.0 if arch.rise == half else math.degrees(4.0 * math.atan2(arch.rise, half))
    embrace = 180.0 if arch.embrace is None else arch.embrace
    sine = math.sin(math.radians(0.5 * embrace))
    if half > LONGEST * sine:
        raise InputError("structure.embrace", f"{embrace:g} degrees over a span of {arch.span:g} m make a radius above {LONGEST:g} m")
    return half / sine, embrace


def _embrace_of_radius(arch: RingTable, inner: float) -> float:
    """Embrace [degrees] of an arch whose intrados radius is known."""
    if arch.embrace is not None:
        return arch.embrace
    if arch.rise is not None:
        _check_at_most("rise", arch.rise, inner, "the intrados radius, radius - thickness/2")
        return 180.0 if arch.rise == inner else math.degrees(2.0 * math.acos(1.0 - arch.rise / inner))
    if arch.span is not None:
        _check_at_most("span", arch.span, 2.0 * inner, "twice the intrados radius, 2 radius - thickness")
        return math.degrees(2.0 * math.asin(min(0.5 * arch.span / inner, 1.0)))
    return 180.0


def _check_at_most(key: str, value: float, limit: float, what: str) -> None:
    if value > limit * (1.0 + AGREE):
        raise InputError(f"structure.{key}", f"must be at most {what}, {limit:g} m, got {value:g}")


def _check_agreement(arch: RingTable, inner: float, embrace: float) -> None:
    """Refuse redundant keys that contradict each other."""
    half = math.radians(0.5 * embrace)
    implied = {
        "span": 2.0 * inner * math.sin(half),
        "rise": inner * (1.0 - math.cos(half)),
        "embrace": embrace,
        "radius": inner + 0.5 * arch.thickness,
    }
    for key, value in implied.items():
        given = getattr(arch, key)
        if given is not None and abs(given - value) > AGREE * value:
            others = ", ".join(k for k in implied if k != key and getattr(arch, k) is not None)
            raise InputError(f"structure.{key}", f"{given:g} contradicts {others}, which make it {value:g}; leave one of them out")


def _pointed(arch: RingTable) -> tuple[np.ndarray, np.ndarray]:
    """Joint ends of a pointed arch, from left to right."""
    inner, half = _pointed_radius(arch)
    if arch.voussoirs % 2:
        raise InputError("structure.voussoirs", f"a pointed arch has a joint at its apex, so an even number, got {arch.voussoirs}")
    outer, offset = inner + arch.thickness, inner - half  # the centre of the left arc lies at x = +offset
    apex = math.acos(offset / (inner + 0.5 * arch.thickness))
    intrados, extrados = pointed(inner, outer, offset, apex, arch.voussoirs // 2)
    if min(np.diff(intrados[: arch.voussoirs // 2 + 1, 0])) <= 0:
        raise InputError("structure.voussoirs", f"too many for the joint at the apex, got {arch.voussoirs}; take fewer or a thinner ring")
    return intrados, extrados


def pointed(inner: float, outer: float, offset: float, apex: float, half: int) -> tuple[np.ndarray, np.ndarray]:
    """Joint ends on the intrados and on the extrados of a ring of two arcs, from left to right.

    Args:
        inner, outer: radii of intrados and extrados [m].
        offset: of the centre of the left arc beyond the middle [m].
        apex: angle over which the joints of an arc are spaced [rad]; that at the apex is upright.
        half: number of voussoirs of an arc N / 2.

    Returns:
        Two arrays (N + 1, 2) of x, z [m].
    """
    angles = apex * np.arange(half) / half
    unit = np.array([-libm.cos(angles), libm.sin(angles)]).T
    ends = []
    for radius in (inner, outer):
        left = radius * unit + [offset, 0.0]
        ends.append(np.concatenate([left, [[0.0, math.sqrt(radius**2 - offset**2)]], left[::-1] * [-1.0, 1.0]]))
    return ends[0], ends[1]


def _pointed_radius(arch: RingTable) -> tuple[float, float]:
    """Intrados radius [m] and half the clear span [m] of a pointed arch."""
    if arch.embrace is not None:
        raise InputError("structure.embrace", "a pointed arch is given by its span and its rise or radius")
    if arch.span is None:
        raise InputError("structure.span", "missing; a pointed arch is given by its span and its rise or radius")
    half = 0.5 * arch.span
    if arch.rise is not None:
        if arch.rise <= half:
            raise InputError("structure.rise", f"of a pointed arch must exceed half the span, {half:g} m, got {arch.rise:g}")
        inner = (half**2 + arch.rise**2) / arch.span
    elif arch.radius is not None:
        inner = arch.radius - 0.5 * arch.thickness
    else:
        inner = arch.span  # the equilateral arch
    if arch.radius is not None and abs(inner + 0.5 * arch.thickness - arch.radius) > AGREE * arch.radius:
        made = inner + 0.5 * arch.thickness
        raise InputError("structure.radius", f"{arch.radius:g} contradicts span and rise, which make it {made:g}; leave one of them out")
    if inner <= half:
        limit = half + 0.5 * arch.thickness
        raise InputError("structure.radius", f"of a pointed arch must exceed (span + thickness)/2, {limit:g} m, got {arch.radius:g}")
    return inner, half


def _span_of(arch: RingTable, *unused: str) -> float:
    """The clear span of an arch that is not given by circles; refuses keys that say nothing of it."""
    for key in unused:
        if getattr(arch, key) is not None:
            raise InputError(f"structure.{key}", f"says nothing of a {arch.shape} arch; leave it out")
    if arch.span is None:
        raise InputError("structure.span", f"missing; a {arch.shape} arch is given by its clear span")
    return arch.span


def _three_centred(arch: RingTable) -> tuple[np.ndarray, np.ndarray]:
    """Joint ends of a three-centred arch, equally spaced along the middle line."""
    span = _span_of(arch, "radius", "embrace")
    half, rise = 0.5 * span, span / 3.0 if arch.rise is None else arch.rise
    least = half * (1.0 - COS30) / 0.5
    if not least < rise < half:
        raise InputError("structure.rise", f"of a three-centred arch must be between {least:.4g} and {half:g} m, got {rise:g}")
    apart = (half - rise) / (COS30 - 0.5)  # of the centres
    small = rise - apart * (1.0 - COS30)
    middle = small + 0.5 * arch.thickness
    turn = math.pi / 3.0
    flank, crown = middle * turn, (middle + apart) * 0.5 * turn  # lengths of half the middle line
    ends: list[list[tuple[float, float]]] = [[], []]
    for k in range(arch.voussoirs // 2 + 1):
        along = 2.0 * (flank + crown) * k / arch.voussoirs
        if along <= flank:
            angle, x0, z0, extra = along / middle, half - small, 0.0, 0.0
        else:
            angle, x0, z0, extra = turn + (along - flank) / (middle + apart), 0.0, rise - small - apart, apart
        for side, radius in enumerate((small + extra, small + extra + arch.thickness)):
            ends[side].append((-x0 - radius * math.cos(angle), z0 + radius * math.sin(angle)))
    return mirrored(ends[0], arch.voussoirs), mirrored(ends[1], arch.voussoirs)


def mirrored(left: Sequence[Sequence[float]] | np.ndarray, count: int) -> np.ndarray:
    """All joint ends of a symmetric ring from those up to its middle."""
    half = np.array(left)
    if count % 2 == 0:
        half[-1, 0] = 0.0
    return np.concatenate([half, half[: count + 1 - len(half)][::-1] * [-1.0, 1.0]])


def _flat(arch: RingTable) -> tuple[np.ndarray, np.ndarray]:
    """Joint ends of a flat arch."""
    half, skew = 0.5 * _span_of(arch, "radius", "embrace", "rise"), math.radians(20.0 if arch.skew is None else arch.skew)
    return flat(half, arch.thickness, skew, arch.voussoirs)


def flat(half: float, thickness: float, skew: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Joint ends (N + 1, 2) on the soffit and on the top of a flat arch of N voussoirs over a half span [m], to its skew [rad]."""
    wide = half + thickness * math.tan(skew)
    share = (2.0 * np.arange(count + 1) - count) / count
    level = np.zeros_like(share)
    return np.stack([half * share, level], axis=1), np.stack([wide * share, level + thickness], axis=1)


def voussoirs(intrados: np.ndarray, extrados: np.ndarray) -> list[np.ndarray]:
    """The quadrilaterals (4, 2) between successive joints, given by their ends (N + 1, 2) on intrados and extrados."""
    return [np.array([intrados[k], intrados[k + 1], extrados[k + 1], extrados[k]]) for k in range(len(intrados) - 1)]
