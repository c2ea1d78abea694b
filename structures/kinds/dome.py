# SPDX-License-Identifier: GPL-3.0-or-later
"""Domes over a regular polygon: plane voussoirs in level rows, on a drum or on the ground, closed by a key or open in an oculus.

A dome of flat sides is the cloister vault of many sides; with 16 sides its volume is within 1.3 % of the round one's. Stones of odd
rows turn round the corners (:mod:`structures.courser.rings`), so that no joint runs along a meridian: whether meridians open is
left to the mechanics. With ``bonded = false`` every side is a free lune, as in Heyman's analysis (The Stone Skeleton, 1995, chapter 3).

The default, 6 m clear and 0.5 m thick, stands by itself. The intrados springs at z = 0, or at the top of the drum. Groups:
``dome``, ``drum``, ``key`` and ``base``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.courser import rings
from structures.courser.courses import divided
from structures.kind import Keys, StructureKind, scaled, straight_joints, value_of
from structures.layout.ground import ground
from structures.macro_elements import whole
from structures.schema import HIGH, Height, Length, Table, Thickness


class DomeTable(Table):
    """The [structure] table of a dome."""

    span: Length = 6.0
    """clear, between opposite sides"""
    thickness: Thickness = Field(0.5)
    sides: int = Field(16, ge=4, le=128)
    """flat sides in plan"""
    rows: int | None = Field(None, ge=2, le=500)
    """by default stones as high as the dome is thick"""
    unit_length: Length | None = None
    """of a stone along its row; by default 1.5 thicknesses"""
    bonded: bool = True
    """false: free lunes, a side each, of one stone to a row"""
    oculus: Height = 0.0
    """clear width of the opening at the top; 0: closed by a key"""
    drum_height: Annotated[Height, HIGH] = 0.0
    """of the upright wall below"""
    drum_thickness: Thickness | None = None
    """by default 1.6 thicknesses"""
    base_depth: Length | None = None
    """of the base; by default the thickness"""


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build a dome on its base.

    Raises:
        InputError: a key that is unknown or out of range, or measures that do not fit together.
    """
    keys = parse_table(DomeTable, table, "structure")
    inner, unit = 0.5 * keys.span, keys.unit_length or 1.5 * keys.thickness
    if not keys.bonded and keys.unit_length is not None:
        raise InputError("structure.unit_length", "belongs to a dome in bond; a free lune has one stone to a row, as wide as its side")
    ring = rings.Ring(keys.sides, keys.sides, start=math.pi / keys.sides)
    high = keys.drum_height / keys.thickness + 0.6 * (keys.rows or 0.25 * math.pi * keys.span / keys.thickness)  # 0.6: rows get shorter
    size.check_size(high * max(1.0, 2.0 * inner * ring.slope / unit) * keys.sides, "unit_length" if keys.unit_length else "thickness")
    rows: list[rings.RingCourse] = []
    level = 0.0
    if keys.drum_height:
        thick = keys.drum_thickness or 1.6 * keys.thickness
        if thick < keys.thickness:
            raise InputError("structure.drum_thickness", f"must be at least that of the dome, {keys.thickness:g} m, got {thick:g}")
        rows = rings.wall_rows("drum", inner, thick, divided(0.0, keys.drum_height, keys.thickness))
        level = keys.drum_height
    elif keys.drum_thickness is not None:
        raise InputError("structure.drum_height", "missing; it makes the drum whose thickness is given")
    rows += shell(keys, level)
    blocks = rings.build(ring, rows, unit, density, keys.bonded)
    if not keys.oculus:
        blocks.append(rings.key(ring, rows[-1], density, "key", "key"))
    blocks.append(ground(blocks, keys.base_depth or keys.thickness, density))
    return blocks


def shell(keys: DomeTable, level: float) -> list[rings.RingCourse]:
    """The rows of a dome that springs at a height, up to its oculus or key.

    Raises:
        InputError: an oculus as wide as the dome.
    """
    inner = 0.5 * keys.span
    if keys.oculus > 0.9 * keys.span:
        raise InputError("structure.oculus", f"must be at most 0.9 of the span, {0.9 * keys.span:g} m, got {keys.oculus:g}")
    open_ = 0.5 * keys.oculus or min(0.25 * inner, 0.8 * keys.thickness)
    top = math.acos(open_ / inner)
    count = keys.rows or max(2, round(top * (inner + 0.5 * keys.thickness) / keys.thickness))
    return rings.dome_rows("dome", inner, keys.thickness, level, count, top)


def resized(table: Keys, factor: float) -> Keys:
    """Rows follow the thickness by default: pi / 4 span / thickness of them, about, in a hemisphere."""
    thick, span = value_of(DomeTable, table, "thickness"), value_of(DomeTable, table, "span")
    natural = {"rows": max(2, round(0.25 * math.pi * span / thick))}
    natural |= {"unit_length": 1.5 * thick} if value_of(DomeTable, table, "bonded") else {}
    return scaled(DomeTable, natural | table, factor, ("unit_length",), {"rows": 2})


def bonds(table: Keys) -> dict[str, Keys]:
    """Free lunes, or a dome in bond."""
    return {name: keys for name, keys in straight_joints(table, "between lunes").items() if "unit_length" not in table}


KIND = StructureKind(build, DomeTable, first={"span": 6.0, "thickness": 0.5, "sides": 16}, resized=resized, bonds=bonds, parts=whole)
