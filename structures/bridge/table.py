# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of a bridge."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.fill import ACTIVE_AT
from structures.schema import COVER, Density, Length, Place, Table, Thickness, WallHeight

MOST_SPANS = 60
Angle = Annotated[float, Unit("degrees")]


class SpanTable(Table):
    """One entry ``[[structure.spans]]``, from the left."""

    shape: Literal["segmental", "semicircular", "elliptical", "pointed"] = "segmental"
    """of the intrados"""
    span: Length
    """clear, along the road"""
    rise: Length | None = None
    """of the intrados; of a semicircle half the span"""
    thickness: Thickness
    """of the arch at the crown"""
    thickness_springing: Length | None = None
    """thickness at the springings, from which it varies linearly; by default the same"""
    rings: int = Field(1, ge=1, le=20)
    """of equal thickness, with joints between them that may slide"""
    voussoirs: int | None = Field(None, ge=3, le=400)
    """to a ring; by default about 0.2 m or 0.6 of the thickness long"""
    springing: Place = 0.0
    """height of the springings"""
    start: Place | None = None
    """x of the left springing; by default behind the pier before it"""


class BridgeSupportTable(Table):
    """A pier or an abutment."""

    width: Length = 1.2
    """along the road"""
    height: WallHeight = 3.0
    """height below the lower of its springings"""
    rigid: bool = False
    """one fixed block; else courses of blocks on a fixed foot"""
    course_height: WallHeight = 0.5
    """approximate height of the courses of its blocks"""


class AbutmentTable(BridgeSupportTable):
    """An abutment."""

    width: Length = 1.5
    """along the road"""
    height: WallHeight = 1.0
    """below the springing"""
    rigid: bool = True
    """one fixed block; else courses of blocks on a fixed foot, with fill behind them"""


class SpandrelTable(Table):
    """The spandrel walls, and what belongs to them."""

    thickness: Thickness = Field(0.4)
    course_height: WallHeight = 0.3
    """of their blocks, about"""
    unit_length: Length = 0.6
    """of their blocks, about"""
    wing_length: Length | None = None
    """length of wing walls behind the abutments, parallel to the road; none by default"""
    parapet_height: WallHeight | None = None
    """height above the road; none by default"""
    parapet_thickness: Thickness | None = None
    """by default that of the walls"""


class BackingTable(Table):
    """Masonry over the piers and abutments, between the haunches, up to a level: a rigid block over each, of the group backing."""

    height: WallHeight
    """above the lower springing of each pier and abutment, below the crowns next to it"""
    density: Density | None = None
    """density; that of the material when not given. Its strength is that of its joints, material.joints"""


class FillTable(Table):
    """The table ``[structure.fill]``."""

    density: Density = Field(2000.0)
    friction_angle: Annotated[Angle, Usual(10.0, 60.0, "fill has 20 to 50 degrees", ("rad",))] = Field(30.0, ge=0.0, lt=60.0)
    """of the fill"""
    spread: Literal["2:1", "boussinesq"] = "boussinesq"
    """spread of wheel loads through the fill: 2:1 (one across for two down), or Boussinesq's line load within 30 degrees"""
    pressure: Literal["at_rest", "active", "none"] = "at_rest"
    """pressure on spandrel walls, wing walls and the backs of abutments of blocks before they move: K_0 = 1 - sin phi, or Rankine's K_a"""
    active_at: float = Field(ACTIVE_AT, ge=1e-4, le=0.1)
    """in runs: movement of such a face away from the fill, over the depth of its lower edge, at which K_0 has fallen to K_a: for sand 0.001
    (dense) to 0.004 (loose)"""
    gone_at: float | None = Field(None, gt=0.0, le=10.0)
    """in runs: movement at which the pressure vanishes because the fill has run out; by default 1 / (6 tan phi), at most 1"""
    passive: float = Field(1.0 / 3.0, ge=0.0, le=1.0)
    """share of Rankine's K_p that resists at most where the arch moves into the fill; 0: none"""
    passive_shaken: float = Field(0.3, ge=0.0, le=1.0)
    """the share under loads that shake or push"""
    mobilised_at: Length = 0.02
    """displacement at which the share is reached, in runs; it grows linearly up to there"""


class BridgeTable(Table):
    """The [structure] table of a bridge."""

    spans: tuple[SpanTable, ...] = Field(strict=False, min_length=1, max_length=MOST_SPANS)
    """from left to right"""
    piers: tuple[BridgeSupportTable, ...] = Field((BridgeSupportTable.model_validate({}),), strict=False, max_length=MOST_SPANS)
    """one for all, or one between each two spans"""
    abutments: tuple[AbutmentTable, ...] = Field((AbutmentTable.model_validate({}),), strict=False, min_length=1, max_length=2)
    """one for both, or the left and the right"""
    width: Length = 4.0
    """across the road, along y"""
    skew: Angle = Field(0.0, ge=-45.0, le=45.0)
    """between the springings and a line across the road"""
    strips: int = Field(1, ge=1, le=40)
    """voussoirs across the width, in bond"""
    cover: Annotated[Length, COVER] | None = None
    """of fill over the highest crown; by default 0.3 m"""
    deck: Place | None = None
    """or the level of the road"""
    walls: SpandrelTable | None = None
    """spandrel walls, wing walls and parapets; without them a strip that may move in its plane"""
    backing: BackingTable | None = None
    """over piers and abutments; without it the fill reaches down to them"""
    fill: FillTable = FillTable.model_validate({})
    """between the arches and the road"""
