# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of the table [structure] that every kind takes; those of a kind are its ``table`` (:mod:`structures.kind`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import Field

from masonry_cd.foundation.errors import Faults, parse_table
from masonry_cd.foundation.table_schema import rows
from structures.floors import FloorTable
from structures.layout.foundations import FoundationsTable
from structures.layout.ground import HEIGHT
from structures.schema import Table
from structures.size import MOST
from structures.ties import TieRowTable

Row = TypeVar("Row", bound=Table)


class CommonTable(Table):
    """The keys that every kind of structure takes in addition to its own."""

    most_blocks: int = Field(MOST, ge=1)
    """largest number of blocks of a structure: an error in its dimensions is refused before it is built"""
    foundations: Literal["whole", "corners", "parts"] | FoundationsTable = "whole"
    """foundations in pieces that may settle separately: corners, parts, or strips { x = 4 }"""
    ground: bool | Annotated[float, HEIGHT] | None = None
    """a fixed slab under a structure, for what falls: true, false, or the height of its top; by default under supports with nothing
    between them, but not for kind file"""
    floors: tuple[dict[str, Any], ...] = Field((), strict=False, json_schema_extra=rows(FloorTable))
    """rigid floors on seats in walls, [[structure.floors]] each"""
    ties: tuple[dict[str, Any], ...] = Field((), strict=False, json_schema_extra=rows(TieRowTable))
    """rods and beams that tie parts together, [[structure.ties]] each"""


def own_keys(table: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of a table [structure] that are its kind's own."""
    return {key: value for key, value in table.items() if key != "kind" and key not in CommonTable.model_fields}


def rows_of(model: type[Row], tables: object, where: str, faults: Faults) -> list[Row]:
    """The tables of a list, read; keys that are wrong are added to the faults."""
    found = list[Row]()
    if not isinstance(tables, (list, tuple)) or not all(isinstance(table, Mapping) for table in tables):
        faults.add(where, f"each is a table of its own, headed [[{where}]]")
        return found
    for i, table in enumerate(tables):
        with faults.of():
            found.append(parse_table(model, table, f"{where}[{i}]"))
    return found
