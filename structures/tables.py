# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of the table [structure]: those of every kind, and the model of each kind's own. Nothing is built with it."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field

from masonry_cd.foundation.table_schema import rows
from structures.floors import FloorTable
from structures.layout.foundations import FoundationsTable
from structures.layout.ground import HEIGHT
from structures.noise import NoiseTable
from structures.schema import Table
from structures.size import MOST
from structures.ties import TieRowTable


class CommonTable(Table):
    """The keys that every kind of structure takes beside its own."""

    most_blocks: int = Field(MOST, ge=1)
    """how many blocks a structure may have; a slip in its measures is refused before it is built"""
    foundations: Literal["whole", "corners", "parts"] | FoundationsTable = "whole"
    """in pieces, which may settle by themselves: corners, parts, or strips { x = 4 }"""
    ground: bool | Annotated[float, HEIGHT] | None = None
    """a fixed slab under a structure, for what falls: true, false, or the height of its top; by default under supports with nothing
    between them, but not for kind file"""
    floors: tuple[dict[str, Any], ...] = Field((), strict=False, json_schema_extra=rows(FloorTable))
    """rigid floors on seats in walls, [[structure.floors]] each"""
    ties: tuple[dict[str, Any], ...] = Field((), strict=False, json_schema_extra=rows(TieRowTable))
    """rods and beams that tie parts together, [[structure.ties]] each"""
    noise: NoiseTable | None = None
    """seeded noise on all corners, { size = 1e-6, seed = 0 }"""


def table_of(kind: str) -> type[BaseModel] | None:
    """The model of a kind's own keys, the class ``KindTable`` of its module; None where it has none of that name."""
    return model_of(import_module(f"structures.kinds.{kind}"), kind)


def model_of(module: ModuleType, kind: str) -> type[BaseModel] | None:
    """The class ``KindTable`` of a module, for a kind."""
    found = getattr(module, f"{kind.capitalize()}Table", None)
    return found if isinstance(found, type) and issubclass(found, BaseModel) else None
