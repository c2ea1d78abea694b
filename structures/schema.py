# SPDX-License-Identifier: GPL-3.0-or-later
"""Types and keys that the tables of several kinds of structure share."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.usual import DENSITY, LENGTHS, SECTION

LONGEST = 1e6  # measure [m]: rounding then parts corners that are computed twice by 1e-9 m, far less than what is taken for one corner
SHORTEST = 1e-12  # measure [m]: what is shorter divides to more than numbers hold; each kind has bounds of its own above it

THICK = Usual(0.003, 12.0, "walls, vaults and slabs are 3 mm (a model) to 12 m (a fortress) thick", LENGTHS)
HIGH = Usual(0.003, 200.0, "masonry is at most some 170 m high", LENGTHS)
COVER = Usual(0.0, 10.0, "fill covers crowns by up to a few metres", LENGTHS)
AREAL_MASS = Usual(15.0, 3000.0, "roofs and floors have 15 to 3000 kg/m2", ("kN/m2", "t/m2"))
CARRIED = Usual(0.0, 1.0, "roofs and floors weigh less than the masonry that bears them", over="mass of the masonry")


def _not_lost(value: float) -> float:
    if 0.0 < value < SHORTEST:
        raise ValueError(f"should be at least {SHORTEST:g}")
    return value


Length = Annotated[float, Unit("m"), Field(gt=0, le=LONGEST, allow_inf_nan=False), AfterValidator(_not_lost)]
Thickness = Annotated[Length, THICK]
WallHeight = Annotated[Length, HIGH]
Area = Annotated[float, Unit("m2"), SECTION, Field(gt=0, le=LONGEST, allow_inf_nan=False)]
Height = Annotated[float, Unit("m"), Field(ge=0, le=LONGEST, allow_inf_nan=False), AfterValidator(_not_lost)]
Density = Annotated[float, Unit("kg/m3"), DENSITY, Field(gt=0, le=1e6, allow_inf_nan=False)]
ArealMass = Annotated[float, Unit("kg/m2"), AREAL_MASS, CARRIED, Field(gt=0, le=1e6, allow_inf_nan=False)]
Share = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Place = Annotated[float, Unit("m"), Field(allow_inf_nan=False)]
HeadShape = Literal["lintel", "flat", "segmental", "round"]


class Table(BaseModel):
    """A table of the scene: unknown keys are refused, values stay as read."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, use_attribute_docstrings=True)


class OpeningTable(Table):
    """One entry ``[[structure.openings]]``: a door or a window."""

    centre: Place
    """along the wall, from the middle of the wall"""
    width: Length = 1.0
    """clear"""
    sill: Height = 0.0
    """height of the sill above the foot of the wall"""
    height: WallHeight = 2.0
    """clear, from the sill to the crown of the intrados"""
    head: HeadShape = "lintel"
    """shape of its head"""
    depth: Length | None = None
    """of the lintel or of the arch; by default a course or a fifth of the width"""
    rise: Length | None = None
    """of a segmental arch; by default a sixth of the width"""
    bearing: Length | None = None
    """of a lintel on each jamb; by default a third of a block"""
