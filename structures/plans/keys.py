# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of a scene by which a drawing is read, beside ``plan`` in ``[structure]``."""

from __future__ import annotations

import fnmatch
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from structures.schema import Length, Table

ROLES = ("walls", "axes", "openings", "heights", "vaults", "columns")


def _listed(value: object) -> object:
    return (value,) if isinstance(value, str) else value


Patterns = Annotated[tuple[str, ...], BeforeValidator(_listed), Field(strict=False)]


class LayersTable(Table):
    """The table [structure.layers]: names of layers of a drawing, or patterns; * stands for anything, capitals do not count."""

    walls: Patterns = Field(
        ("wall*", "mur*", "*-wall*", "*_wall*", "masonry", "muratura*", "cut"), description="faces or outlines of walls"
    )
    axes: Patterns = Field(("axes", "axis", "assi*", "centre*", "center*"), description="middle lines of walls")
    openings: Patterns = Field(
        ("opening*", "door*", "window*", "apertur*", "port*", "finestr*", "infiss*", "vani", "nicchi*", "niche*", "*-door*", "*-glaz*"),
        description="outlines or inserts of doors, windows and niches",
    )
    heights: Patterns = Field(("height*", "level*", "quote", "quota*", "altezz*", "text*", "test*"), description="texts with heights")
    vaults: Patterns = Field(("vault*", "volt*"), description="outlines or diagonals of vaults")
    columns: Patterns = Field(("column*", "colonn*", "pillar*", "pilastr*", "pier*"), description="outlines of columns and piers")

    def role(self, layer: str) -> str:
        """What lies on a layer; empty where none of the names is its."""
        for role in ROLES:
            if any(fnmatch.fnmatchcase(layer.lower(), pattern.lower()) for pattern in getattr(self, role)):
                return role
        return ""


class PlanKeys(Table):
    """The keys by which a drawing is read."""

    units: Literal["m", "cm", "mm", "in", "ft"] | None = Field(None, description="of a drawing that does not say it, or says it wrongly")
    layers: LayersTable = Field(default_factory=lambda: LayersTable.model_validate({}), description="what lies on which layer of a drawing")
    wall_height: Length | None = Field(None, description="of walls for which the drawing has none")
    wall_thickness: Length | None = Field(None, description="of walls of which only the middle line is drawn, where no mark says it")
    thickest: Length = Field(2.5, description="two faces further apart than this are no wall")
