# SPDX-License-Identifier: GPL-3.0-or-later
"""Columns in layers: plinth, drums over a regular polygon that taper, a capital that widens, and an abacus."""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from masonry_cd.foundation import libm
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces
from structures.geometry.prism import between, box
from structures.schema import Height, Length, Table, WallHeight

MOST_DRUMS = 500  # of a column: more are slices


class ColumnTable(Table):
    """The [structure] table of a column."""

    height: WallHeight = 6.0
    """with plinth and capital"""
    diameter: Length = 0.9
    """of the shaft at its foot"""
    top_diameter: Length | None = None
    """of the shaft at its top; by default 0.85 of the foot"""
    drums: int = Field(7, ge=1, le=MOST_DRUMS)
    """of the shaft"""
    sides: int = Field(12, ge=4, le=64)
    """flat sides of a drum"""
    plinth: Height = 0.3
    """height of the plinth, 0 for none"""
    capital: Height = 0.5
    """height of the capital with its abacus, 0 for none"""
    width: Length | None = None
    """of plinth and abacus; by default 1.3 diameters"""
    base_depth: Length = 0.5
    """of the base"""


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
