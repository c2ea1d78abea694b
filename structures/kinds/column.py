# SPDX-License-Identifier: GPL-3.0-or-later
"""Columns: a plinth, drums that taper, a capital and its abacus.

A drum is a frustum over a regular polygon, with sides across x and y, so that a column of 12 sides or more rocks much as a
round one does; its corners lie on the circle of the given diameter. The capital widens from the shaft to the abacus, a square slab
as wide as the plinth.

The default, 6 m of seven drums 0.9 m thick at the foot and 0.76 m at the top, is of Doric slenderness. Groups: ``plinth``, ``shaft``,
``capital`` and ``base``.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.blocks import Block
from structures.courser.columns import ColumnTable, column
from structures.kind import StructureKind, scaled
from structures.layout.ground import ground
from structures.macro_elements import whole


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build a column on its base.

    Raises:
        InputError: a key that is unknown or out of range, or measures that do not fit together.
    """
    keys = parse_table(ColumnTable, table, "structure")
    top = keys.top_diameter or 0.85 * keys.diameter
    width = keys.width or 1.3 * keys.diameter
    if top > keys.diameter:
        raise InputError("structure.top_diameter", f"must be at most the diameter, {keys.diameter:g} m, got {top:g}")
    if width < keys.diameter:
        raise InputError("structure.width", f"must be at least the diameter, {keys.diameter:g} m, got {width:g}")
    if keys.plinth + keys.capital >= keys.height:
        raise InputError("structure.height", f"must exceed plinth and capital, {keys.plinth + keys.capital:g} m, got {keys.height:g}")
    blocks = column((0.0, 0.0), 0.0, keys, density)
    blocks.append(ground(blocks, keys.base_depth, density))
    return blocks


KIND = StructureKind(
    build, ColumnTable, first={"height": 6.0, "diameter": 0.9, "drums": 7},
    resized=partial(scaled, ColumnTable, counts={"drums": 1}), parts=whole,
)  # fmt: skip
