r"""Arches of straight-edged voussoirs: semicircular, segmental and pointed.

A ring of mid-radius R and thickness t over the embrace angle a is cut by N + 1 radial joints; intrados and extrados are
the chords between the joints, with corners at R - t/2 and R + t/2. With the clear span s and the clear rise f,

    s = 2 (R - t/2) sin(a/2),        f = (R - t/2) (1 - cos(a/2)),

so any two of span, radius, rise and embrace fix the circle; one of span and radius alone makes a semicircle. A pointed
arch is two such arcs with centres on the springing line; its intrados radius is (s^2/4 + f^2) / s, and the joint at the
apex is vertical. The number of voussoirs and their straight edges are part of the mechanics: the least thickness of a
semicircle varies by 4 % with them.

The intrados springs at z = 0 and is centred on x = 0, y = 0. Voussoirs are numbered from the left springing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from masonry_cd.blocks import Block
from masonry_cd.errors import InputError, parse_table
from structures.checks import check
from structures.prism import prism_xz

AGREE = 1e-6  # relative difference up to which redundant keys agree


def _abutment(value: Any) -> float | None:
    """true -> nan (the default depth), false -> None, a number -> itself."""
    if isinstance(value, bool):
        return math.nan if value else None
    if isinstance(value, (int, float)) and 0 < value < math.inf:
        return float(value)
    raise ValueError("must be true, false or the depth of the abutments above 0 [m]")


Length = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class ArchTable(BaseModel):
    """The [structure] table of an arch."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    shape: Literal["circular", "pointed"] = "circular"
    span: Length | None = Field(None, description="clear, between the springings of the intrados [m]")
    radius: Length | None = Field(None, description="of the middle line [m]")
    rise: Length | None = Field(None, description="clear, from the springing to the crown of the intrados [m]")
    embrace: float | None = Field(None, gt=0, le=180, description="angle between the springing joints [degrees]")
    thickness: Length = Field(description="of the ring [m]")
    width: Length = Field(1.0, description="across the arch, along y [m]")
    voussoirs: int = Field(27, ge=2, le=2000)
    abutment: Annotated[float | None, BeforeValidator(_abutment)] = math.nan


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build an arch on its abutments: blocks ``v1`` to ``vN`` in the group ``arch``, fixed ones in ``base``.

    Raises:
        InputError: a key that is missing, unknown, out of range or in contradiction with another.
    """
    arch = parse_table(ArchTable, table, "structure")
    intrados, extrados = _pointed(arch) if arch.shape == "pointed" else _circular(arch)
    polygons = voussoirs(intrados, extrados)
    blocks = [_block(f"v{i + 1}", polygon, arch.width, density, "arch") for i, polygon in enumerate(polygons)]
    if arch.abutment is not None:
        depth = arch.thickness if math.isnan(arch.abutment) else arch.abutment
        left = _seat(intrados[0], extrados[0], intrados[1], depth)
        right = _seat(intrados[-1], extrados[-1], intrados[-2], depth)
        blocks.append(_block("abutment1", left, 1.5 * arch.width, density, "base", fixed=True))
        blocks.append(_block("abutment2", right, 1.5 * arch.width, density, "base", fixed=True))
    check(blocks)
    return blocks


def _block(name: str, polygon: np.ndarray, width: float, density: float, group: str, fixed: bool = False) -> Block:
    vertices, faces = prism_xz(polygon, -0.5 * width, 0.5 * width)
    return Block(name, vertices, faces, density, group, fixed)


def voussoirs(intrados: np.ndarray, extrados: np.ndarray) -> list[np.ndarray]:
    """The quadrilaterals (4, 2) between successive joints, given by their ends (N + 1, 2) on intrados and extrados."""
    return [np.array([intrados[k], intrados[k + 1], extrados[k + 1], extrados[k]]) for k in range(len(intrados) - 1)]


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


def _circular(arch: ArchTable) -> tuple[np.ndarray, np.ndarray]:
    inner, embrace = _circle(arch)
    _agree(arch, inner, embrace)
    intrados, extrados = ring(inner, inner + arch.thickness, embrace, arch.voussoirs)
    springing = np.array([0.0, intrados[0, 1]])
    return intrados - springing, extrados - springing


def _circle(arch: ArchTable) -> tuple[float, float]:
    """Intrados radius [m] and embrace [degrees] from the keys given."""
    if arch.radius is not None:
        inner = arch.radius - 0.5 * arch.thickness
        if inner <= 0:
            limit = 2.0 * arch.radius
            raise InputError(f"structure.thickness: must be below twice the radius, {limit:g} m, got {arch.thickness:g}")
        return inner, _embrace_of_radius(arch, inner)
    if arch.span is None:
        raise InputError("structure.span: missing; give the clear span or the radius")
    half = 0.5 * arch.span
    if arch.rise is not None:
        _at_most("rise", arch.rise, half, "half the span")
        return (half**2 + arch.rise**2) / (2.0 * arch.rise), 180.0 if arch.rise == half else math.degrees(4.0 * math.atan2(arch.rise, half))
    embrace = 180.0 if arch.embrace is None else arch.embrace
    return half / math.sin(math.radians(0.5 * embrace)), embrace


def _embrace_of_radius(arch: ArchTable, inner: float) -> float:
    """Embrace [degrees] of an arch whose intrados radius is known."""
    if arch.embrace is not None:
        return arch.embrace
    if arch.rise is not None:
        _at_most("rise", arch.rise, inner, "the intrados radius, radius - thickness/2")
        return 180.0 if arch.rise == inner else math.degrees(2.0 * math.acos(1.0 - arch.rise / inner))
    if arch.span is not None:
        _at_most("span", arch.span, 2.0 * inner, "twice the intrados radius, 2 radius - thickness")
        return math.degrees(2.0 * math.asin(min(0.5 * arch.span / inner, 1.0)))
    return 180.0


def _at_most(key: str, value: float, limit: float, what: str) -> None:
    if value > limit * (1.0 + AGREE):
        raise InputError(f"structure.{key}: must be at most {what}, {limit:g} m, got {value:g}")


def _agree(arch: ArchTable, inner: float, embrace: float) -> None:
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
            raise InputError(f"structure.{key}: {given:g} contradicts {others}, which make it {value:g}; leave one of them out")


def _pointed(arch: ArchTable) -> tuple[np.ndarray, np.ndarray]:
    """Joint ends of a pointed arch, from left to right."""
    inner, half = _pointed_radius(arch)
    if arch.voussoirs % 2:
        raise InputError(f"structure.voussoirs: a pointed arch has a joint at its apex, so an even number, got {arch.voussoirs}")
    outer, offset = inner + arch.thickness, inner - half  # the centre of the left arc lies at x = +offset
    apex = math.acos(offset / (inner + 0.5 * arch.thickness))
    angles = apex * np.arange(arch.voussoirs // 2) / (arch.voussoirs // 2)
    unit = np.array([-np.cos(angles), np.sin(angles)]).T
    top = np.array([[0.0, math.sqrt(inner**2 - offset**2)], [0.0, math.sqrt(outer**2 - offset**2)]])
    ends = []
    for radius, crown in ((inner, top[0]), (outer, top[1])):
        left = radius * unit + [offset, 0.0]
        ends.append(np.concatenate([left, crown[None], left[::-1] * [-1.0, 1.0]]))
    if min(np.diff(ends[0][: arch.voussoirs // 2 + 1, 0])) <= 0:
        raise InputError(f"structure.voussoirs: too many for the joint at the apex, got {arch.voussoirs}; take fewer or a thinner ring")
    return ends[0], ends[1]


def _pointed_radius(arch: ArchTable) -> tuple[float, float]:
    """Intrados radius [m] and half the clear span [m] of a pointed arch."""
    if arch.embrace is not None:
        raise InputError("structure.embrace: a pointed arch is given by its span and its rise or radius")
    if arch.span is None:
        raise InputError("structure.span: missing; a pointed arch is given by its span and its rise or radius")
    half = 0.5 * arch.span
    if arch.rise is not None:
        if arch.rise <= half:
            raise InputError(f"structure.rise: of a pointed arch must exceed half the span, {half:g} m, got {arch.rise:g}")
        inner = (half**2 + arch.rise**2) / arch.span
    elif arch.radius is not None:
        inner = arch.radius - 0.5 * arch.thickness
    else:
        inner = arch.span  # the equilateral arch
    if arch.radius is not None and abs(inner + 0.5 * arch.thickness - arch.radius) > AGREE * arch.radius:
        made = inner + 0.5 * arch.thickness
        raise InputError(f"structure.radius: {arch.radius:g} contradicts span and rise, which make it {made:g}; leave one of them out")
    if inner <= half:
        limit = half + 0.5 * arch.thickness
        raise InputError(f"structure.radius: of a pointed arch must exceed (span + thickness)/2, {limit:g} m, got {arch.radius:g}")
    return inner, half


def _seat(intrados: np.ndarray, extrados: np.ndarray, towards: np.ndarray, depth: float) -> np.ndarray:
    """An abutment: the springing joint prolonged at both ends and drawn back from the arch by its depth.

    The joint is prolonged so that a voussoir which slides at the springing keeps its seat.
    """
    along = extrados - intrados
    overhang = min(0.5, 0.5 * abs(intrados[0]) / math.hypot(*along)) * along
    back = np.array([along[1], -along[0]]) / math.hypot(*along)
    if back @ (towards - intrados) > 0:
        back = -back
    inside, outside = intrados - overhang, extrados + overhang
    return np.array([inside, outside, outside + depth * back, inside + depth * back])
