# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of a scene by which a drawing is read, next to ``plan`` in ``[structure]``."""

from __future__ import annotations

import fnmatch
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from structures.floors import SlabTable
from structures.schema import Length, Table, Thickness, WallHeight

ROLES = ("walls", "axes", "openings", "heights", "vaults", "columns")


def _listed(value: object) -> object:
    return (value,) if isinstance(value, str) else value


Patterns = Annotated[tuple[str, ...], BeforeValidator(_listed), Field(strict=False)]


class LayersTable(Table):
    """The table [structure.layers]: names of layers of a drawing, or patterns; * stands for anything, capitals do not count."""

    walls: Patterns = ("wall*", "mur*", "*-wall*", "*_wall*", "masonry", "muratura*", "cut")
    """faces or outlines of walls"""
    axes: Patterns = ("axes", "axis", "assi*", "centre*", "center*")
    """middle lines of walls"""
    openings: Patterns = (
        "opening*",
        "door*",
        "window*",
        "apertur*",
        "port*",
        "finestr*",
        "infiss*",
        "vani",
        "nicchi*",
        "niche*",
        "*-door*",
        "*-glaz*",
    )
    """outlines or inserts of doors, windows and niches"""
    heights: Patterns = ("height*", "level*", "quote", "quota*", "altezz*", "text*", "test*")
    """texts with heights"""
    vaults: Patterns = ("vault*", "volt*")
    """outlines or diagonals of vaults"""
    columns: Patterns = ("column*", "colonn*", "pillar*", "pilastr*", "pier*")
    """outlines of columns and piers"""

    def role(self, layer: str) -> str:
        """Return the role of a layer; empty where none of the names is its."""
        for role in ROLES:
            if any(fnmatch.fnmatchcase(layer.lower(), pattern.lower()) for pattern in getattr(self, role)):
                return role
        return ""


class PlanKeys(Table):
    """The keys by which a drawing is read."""

    units: Literal["m", "cm", "mm", "in", "ft"] | None = None
    """unit of a drawing that does not state it, or states it wrongly"""
    layers: LayersTable = Field(default_factory=lambda: LayersTable.model_validate({}))
    """role of each layer of a drawing"""
    wall_height: WallHeight | None = None
    """height of walls for which the drawing has none"""
    wall_thickness: Thickness | None = None
    """of walls of which only the middle line is drawn, where no mark says it"""
    thickest: Length = 2.5
    """two faces further apart than this are not the faces of one wall"""


class StoreyTable(Table):
    """One entry ``[[structure.storeys]]``, from the lowest up."""

    plan: str
    """drawing of its walls, .dxf, relative to the scene"""
    height: WallHeight
    """height from its foot to that of the next, and of its walls where the drawing has no other"""
    floor: SlabTable | None = None
    """floor over each space that its walls enclose, { thickness = 0.25, mass = 400.0 }"""
