# SPDX-License-Identifier: GPL-3.0-or-later
"""The measures of a church, as a scene gives them; :mod:`structures.kinds.church` says what they mean."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from structures.schema import ArealMass, Height, Length, Table


class ChurchTable(Table):
    """The [structure] table of a church."""

    block_length: Length = Field(1.0, description="of a block, which steers their number")
    course_height: Length | None = Field(None, description="by default half the length of a block")
    length: Length = Field(24.0, description="of the nave with facade and triumphal arch, outer")
    width: Length = Field(9.0, description="of the nave, clear")
    height: Length = Field(10.0, description="of the nave walls, to the eaves")
    thickness: Length | None = Field(None, description="of the walls; by default 1 m, under a vault 0.16 of the width")
    leaves: int = Field(1, ge=1, le=4, description="of all walls")
    bonded: bool = Field(True, description="false: straight joints where walls meet, from bottom to top")
    gable: Height | None = Field(None, description="height over the eaves; by default 2.5 m, in front of a vault its own height")
    door_width: Height = Field(2.0, description="of the facade, 0 for none")
    door_height: Length = Field(4.0)
    windows: int = Field(4, ge=0, le=20, description="in each side wall of the nave")
    window_width: Length = Field(1.0)
    window_height: Length | None = Field(None, description="by default 2.5 m, or what fits into a lower wall")
    arch_span: Length | None = Field(None, description="of the triumphal arch; by default what fits before the apse")
    apse: bool = Field(True, description="behind the triumphal arch")
    apse_radius: Length = Field(3.4, description="clear, to the middle of its sides")
    apse_height: Length = Field(6.0, description="to the springing of the half dome")
    apse_sides: int = Field(7, ge=3, le=31, description="flat sides of the half circle")
    tower: bool = Field(True, description="beside the nave")
    tower_side: Length = Field(4.5, description="outer, beyond the wall it is bonded with")
    tower_height: Length = Field(20.0)
    tower_place: Length | None = Field(None, description="x of its axis; by default at 0.7 of the length")
    aisles: bool = Field(False, description="on both sides of the nave")
    aisle_width: Length = Field(4.0, description="clear")
    aisle_height: Length = Field(5.5, description="of the outer walls of the aisles")
    bays: int = Field(4, ge=2, le=20, description="of the arcades between nave and aisles")
    buttresses: int | None = Field(None, ge=0, le=20, description="on each side; by default 0, under a vault one between every two windows")
    buttress_depth: Length | None = Field(None, description="beyond the wall; by default its thickness, under a vault a third of the width")
    roof: Literal["timber", "vault", "none"] = Field("timber", description="of the nave")
    roof_mass: ArealMass = Field(150.0, description="of a timber roof, in plan")
    vault_thickness: Length | None = Field(None, description="of a barrel vault; by default 0.07 of the width")
