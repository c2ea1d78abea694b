# SPDX-License-Identifier: GPL-3.0-or-later
"""Vaults: a barrel on abutments, and the cross vault where two barrels of one profile meet over a square bay.

Either has the profile of an arch (:mod:`structures.courser.arch_profiles`), whose voussoirs become courses that run along the vault. Head
joints stand in running bond, so that no ring is separate from the next, unless requested.

Of a cross vault, the web towards +x fills x >= |y|: its courses end on the groins, the upright planes x = |y|. Seen from either web
a groin is the same line, so a stone on it has an arm in both webs, a compound block, and the four keystone courses end in one
cross-shaped boss. It stands on four fixed piers; the end of each web is the arch of the bay.

The intrados springs at z = 0. Groups: ``vault`` (barrel); ``web_east``, ``web_north``, ``web_west``, ``web_south``, ``groin`` (cross);
``base``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.blocks import Block
from structures import size
from structures.courser.arch_profiles import RingTable, joints_of
from structures.courser.vault_courses import barrel, crossing
from structures.geometry.prism import box, prism_xz
from structures.kind import Keys, StructureKind, scaled, straight_joints, value_of
from structures.kinds.arch import seat
from structures.macro_elements import AROUND, HINGES, BlockLayout, MacroElement
from structures.schema import Length, Thickness


class VaultTable(RingTable):
    """The [structure] table of a vault."""

    form: Literal["barrel", "cross"] = "barrel"
    """a barrel, or two that cross on four piers"""
    span: Length | None = 4.0
    """clear, between the springings of the intrados"""
    thickness: Thickness = Field(0.5)
    voussoirs: int = Field(15, ge=3, le=500)
    """to a ring"""
    length: Length | None = None
    """of a barrel, along y; by default its span"""
    unit_length: Length | None = None
    """of a block along the vault; by default 1.2 thicknesses"""
    pier: Length | None = None
    """width of the piers of a cross vault; by default 1.3 thicknesses"""
    bonded: bool = True
    """of a barrel; false: separate rings"""


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build a vault on its supports.

    Raises:
        InputError: a key that is unknown or out of range, or measures that do not fit together.
    """
    if "radius" in table and "span" not in table:
        table = {**table, "span": None}
    keys = parse_table(VaultTable, table, "structure")
    return _cross(keys, density) if keys.form == "cross" else _barrel(keys, density)


def _barrel(keys: VaultTable, density: float) -> list[Block]:
    if keys.pier is not None:
        raise InputError("structure.pier", "belongs to a cross vault, this one is a barrel")
    intrados, extrados = joints_of(keys)
    length = keys.length or float(intrados[-1, 0] - intrados[0, 0])
    unit = keys.unit_length or 1.2 * keys.thickness
    size.check_size(keys.voussoirs * (length / unit), "unit_length")
    blocks = barrel(intrados, extrados, (-0.5 * length, 0.5 * length), unit, density, keys.bonded)
    margin = 0.25 * keys.thickness
    for number, end in enumerate((0, -1), start=1):
        polygon = seat(intrados[end], extrados[end], intrados[1 if end == 0 else -2], keys.thickness)
        vertices, faces = prism_xz(polygon, -0.5 * length - margin, 0.5 * length + margin)
        blocks.append(Block(f"abutment{number}", vertices, faces, density, "base", fixed=True))
    return blocks


def _cross(keys: VaultTable, density: float) -> list[Block]:
    if keys.length is not None:
        raise InputError("structure.length", "belongs to a barrel; a cross vault is as long as wide")
    if not keys.bonded:
        raise InputError("structure.bonded", "belongs to a barrel; the stones of a cross vault are bonded")
    intrados, extrados = joints_of(keys)
    if extrados[0, 1] > 1e-9 * keys.thickness:
        key = "shape" if keys.shape == "flat" else "rise"
        raise InputError(
            f"structure.{key}", "a cross vault springs from level beds, so take a semicircle, a pointed or a three-centred profile"
        )
    half = float(intrados[-1, 0])
    pier = keys.pier or 1.3 * keys.thickness
    if pier <= keys.thickness * (1.0 + 1e-6):
        raise InputError("structure.pier", f"must exceed the thickness of the vault, {keys.thickness:g} m, got {pier:g}")
    unit = keys.unit_length or 1.2 * keys.thickness
    size.check_size(4.0 * keys.voussoirs * (0.5 * half + pier) / unit, "unit_length")
    return crossing(intrados, extrados, half + pier, unit, density) + _piers(half, pier, keys.thickness, density)


def _piers(half: float, pier: float, thickness: float, density: float) -> list[Block]:
    """Fixed blocks under the four corners; they reach outwards, where the thrust pushes."""
    blocks = []
    far = half + pier + thickness
    for number, (x, y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1)), start=1):
        low = (min(x * half, x * far), min(y * half, y * far), -thickness)
        high = (max(x * half, x * far), max(y * half, y * far), 0.0)
        blocks.append(Block(f"pier{number}", *box(low, high), density, "base", fixed=True))
    return blocks


def resized(table: Keys, factor: float) -> Keys:
    """Blocks are 1.2 thicknesses long by default."""
    natural = {"unit_length": 1.2 * value_of(VaultTable, table, "thickness")}
    return scaled(VaultTable, natural | table, factor, ("unit_length",), {"voussoirs": 3})


def bonds(table: Keys) -> dict[str, Keys]:
    """Separate rings, or rings in bond, of a barrel."""
    return straight_joints(table, "between rings") if value_of(VaultTable, table, "form") == "barrel" else {}


def parts(layout: BlockLayout) -> list[MacroElement]:
    """A vault as a whole, and the webs of one that crosses; by hinges, towards all sides."""
    own = np.flatnonzero(~layout.fixed)
    webs = layout.names
    found = [MacroElement("vault", "vault", own, AROUND, (HINGES,))]
    if len(webs) < 2:
        return found
    return [*found, *(MacroElement(name.replace("_", " "), "web", layout.of_groups(name), AROUND, (HINGES,)) for name in webs)]


KIND = StructureKind(
    build, VaultTable, first={"form": "barrel", "span": 4.0, "thickness": 0.5, "voussoirs": 15}, resized=resized, bonds=bonds, parts=parts
)
