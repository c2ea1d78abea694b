# SPDX-License-Identifier: GPL-3.0-or-later
"""``[structure] kind = "stack"``: equal cubes on top of one another, on a fixed plate."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from masonry_cd import Block, box
from masonry_cd.foundation.errors import parse_table


class StackTable(BaseModel):
    """The keys; others are refused by name."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)

    cubes: int = Field(3, ge=1, le=1000)
    side: float = Field(0.5, gt=0.0)  # of a cube [m]


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build it, its foot at z = 0. Whatever is returned is checked: closed, convex or in convex parts, without overlaps."""
    keys = parse_table(StackTable, table, "structure")
    a = keys.side
    plate = Block("plate", *box((-a, -a, -a), (2 * a, 2 * a, 0.0)), density, "base", fixed=True)
    cubes = [Block(f"cube{k + 1}", *box((0.0, 0.0, k * a), (a, a, (k + 1) * a)), density, "stack") for k in range(keys.cubes)]
    return [plate, *cubes]
