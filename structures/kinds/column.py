"""Columns: a plinth, drums that taper, a capital and its abacus.

A drum is a frustum over a regular polygon, with sides across x and y, so that a column of 12 sides or more rocks much as a
round one does; its corners lie on the circle of the given diameter. The capital widens from the shaft to the abacus, a square slab
as wide as the plinth.

The default, 6 m of seven drums 0.9 m thick at the foot and 0.76 m at the top, is of Doric slenderness. Groups: ``plinth``, ``shaft``,
``capital`` and ``base``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field

from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces
from structures.geometry.checks import check
from structures.geometry.prism import between, box
from structures.layout import wall_plan
from structures.schema import Height, Length, Table


class ColumnTable(Table):
    """The [structure] table of a column."""

    height: Length = Field(6.0, description="with plinth and capital")
    diameter: Length = Field(0.9, description="of the shaft at its foot")
    top_diameter: Length | None = Field(None, description="of the shaft at its top; by default 0.85 of the foot")
    drums: int = Field(7, ge=1, le=500, description="of the shaft")
    sides: int = Field(12, ge=4, le=64, description="flat sides of a drum")
    plinth: Height = Field(0.3, description="height of the plinth, 0 for none")
    capital: Height = Field(0.5, description="height of the capital with its abacus, 0 for none")
    width: Length | None = Field(None, description="of plinth and abacus; by default 1.3 diameters")
    base_depth: Length = Field(0.5, description="of the base")


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build a column on its base.

    Raises:
        InputError: a key that is unknown or out of range, or measures that do not fit together.
    """
    keys = parse_table(ColumnTable, table, "structure")
    top = keys.top_diameter or 0.85 * keys.diameter
    width = keys.width or 1.3 * keys.diameter
    if top > keys.diameter:
        raise InputError(f"structure.top_diameter: must be at most the diameter, {keys.diameter:g} m, got {top:g}")
    if width < keys.diameter:
        raise InputError(f"structure.width: must be at least the diameter, {keys.diameter:g} m, got {width:g}")
    if keys.plinth + keys.capital >= keys.height:
        raise InputError(f"structure.height: must exceed plinth and capital, {keys.plinth + keys.capital:g} m, got {keys.height:g}")
    blocks = column((0.0, 0.0), 0.0, keys, density)
    blocks.append(wall_plan.ground(blocks, keys.base_depth, density))
    check(blocks)
    return blocks


def column(centre: tuple[float, float], foot: float, keys: ColumnTable, density: float, prefix: str = "", group: str = "") -> list[Block]:
    """The blocks of a column: ``plinth``, ``drum1`` ..., ``capital``, ``abacus``.

    Args:
        centre: x, y of its axis [m].
        foot: height of its foot [m].
        prefix: of the names.
        group: of all blocks; by default ``plinth``, ``shaft`` and ``capital``.
    """
    top = keys.top_diameter or 0.85 * keys.diameter
    half = 0.5 * (keys.width or 1.3 * keys.diameter)
    low, high = foot + keys.plinth, foot + keys.height - keys.capital
    blocks = []
    if keys.plinth:
        blocks.append(Block(f"{prefix}plinth", *_slab(centre, half, foot, low), density, group or "plinth"))
    beds = np.linspace(low, high, keys.drums + 1)
    radii = np.linspace(0.5 * keys.diameter, 0.5 * top, keys.drums + 1)
    for k in range(keys.drums):
        lower, upper = (_polygon(centre, radii[i], beds[i], keys.sides) for i in (k, k + 1))
        blocks.append(Block(f"{prefix}drum{k + 1}", *between(lower, upper), density, group or "shaft"))
    if keys.capital:
        neck = high + 0.6 * keys.capital
        lower, upper = _polygon(centre, 0.5 * top, high, keys.sides), _polygon(centre, 0.98 * half, neck, keys.sides)
        blocks.append(Block(f"{prefix}capital", *between(lower, upper), density, group or "capital"))
        blocks.append(Block(f"{prefix}abacus", *_slab(centre, half, neck, foot + keys.height), density, group or "capital"))
    return blocks


def _slab(centre: tuple[float, float], half: float, low: float, high: float) -> tuple[np.ndarray, Faces]:
    return box((centre[0] - half, centre[1] - half, low), (centre[0] + half, centre[1] + half, high))


def _polygon(centre: tuple[float, float], radius: float, z: float, sides: int) -> np.ndarray:
    """A level regular polygon (sides, 3)."""
    angles = 2.0 * math.pi * (np.arange(sides) + 0.5) / sides
    return np.stack([centre[0] + radius * libm.cos(angles), centre[1] + radius * libm.sin(angles), np.full(sides, z)], axis=1)
