# SPDX-License-Identifier: GPL-3.0-or-later
"""``[structure] kind = "stack"``: equal cubes on top of one another, on a fixed plate."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from masonry_cd import Block, box
from masonry_cd.foundation.errors import parse_table
from masonry_cd.foundation.units import Unit, Usual
from structures.kind import Keys, StructureKind, value_of
from structures.macro_elements import whole


class StackTable(BaseModel):
    """The keys; others are refused by name. What stands under a key is its text in the schema, in starter scenes and references."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True)

    cubes: int = Field(3, ge=1, le=1000)
    """on top of one another"""
    side: Annotated[float, Unit("m"), Usual(0.01, 5.0, "cubes are 1 cm (a model) to 5 m wide", ("mm", "cm"))] = Field(0.5, gt=0.0)
    """of a cube"""


def build(table: Mapping[str, Any], density: float, folder: Path) -> list[Block]:
    """Build it, its foot at z = 0. Whatever is returned is checked: closed, convex or in convex parts, without overlaps."""
    keys = parse_table(StackTable, table, "structure")
    a = keys.side
    plate = Block("plate", *box((-a, -a, -a), (2 * a, 2 * a, 0.0)), density, "base", fixed=True)
    cubes = [Block(f"cube{k + 1}", *box((0.0, 0.0, k * a), (a, a, (k + 1) * a)), density, "stack") for k in range(keys.cubes)]
    return [plate, *cubes]


def resized(table: Keys, factor: float) -> Keys:
    """A stack as high, of cubes of another size; how many is a whole number, and the side follows."""
    cubes, side = (value_of(StackTable, table, name) for name in ("cubes", "side"))
    count = max(1, round(cubes / factor))
    return table | {"cubes": count, "side": side * cubes / count}


STACK = StructureKind(build, StackTable, first={"cubes": 4, "side": 0.5}, resized=resized, parts=whole)
