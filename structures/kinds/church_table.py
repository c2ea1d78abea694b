# SPDX-License-Identifier: GPL-3.0-or-later
"""The measures of a church, as a scene gives them; :mod:`structures.kinds.church` says what they mean."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from structures.schema import ArealMass, Height, Length, Table, Thickness, WallHeight


class ChurchTable(Table):
    """The [structure] table of a church."""

    block_length: Length = 1.0
    """of a block, which steers their number"""
    course_height: WallHeight | None = None
    """by default half the length of a block"""
    length: Length = 24.0
    """of the nave with facade and triumphal arch, outer"""
    width: Length = 9.0
    """of the nave, clear"""
    height: WallHeight = 10.0
    """of the nave walls, to the eaves"""
    thickness: Thickness | None = None
    """of the walls; by default 1 m, under a vault 0.16 of the width"""
    leaves: int = Field(1, ge=1, le=4)
    """of all walls"""
    bonded: bool = True
    """false: straight joints where walls meet, from bottom to top"""
    gable: Height | None = None
    """height over the eaves; by default 2.5 m, in front of a vault its own height"""
    door_width: Height = 2.0
    """width of the door of the facade, 0 for none"""
    door_height: WallHeight = Field(4.0)
    windows: int = Field(4, ge=0, le=20)
    """in each side wall of the nave"""
    window_width: Length = Field(1.0)
    window_height: WallHeight | None = None
    """by default 2.5 m, or what fits into a lower wall"""
    arch_span: Length | None = None
    """span of the triumphal arch; by default the largest that fits before the apse"""
    apse: bool = True
    """behind the triumphal arch"""
    apse_radius: Length = 3.4
    """clear radius, to the middle of its sides"""
    apse_height: WallHeight = 6.0
    """to the springing of the half dome"""
    apse_sides: int = Field(7, ge=3, le=31)
    """flat sides of the half circle"""
    tower: bool = True
    """next to the nave"""
    tower_side: Length = 4.5
    """outer, beyond the wall it is bonded with"""
    tower_height: WallHeight = Field(20.0)
    tower_place: Length | None = None
    """x of its axis; by default at 0.7 of the length"""
    aisles: bool = False
    """on both sides of the nave"""
    aisle_width: Length = 4.0
    """clear"""
    aisle_height: WallHeight = 5.5
    """of the outer walls of the aisles"""
    bays: int = Field(4, ge=2, le=20)
    """of the arcades between nave and aisles"""
    buttresses: int | None = Field(None, ge=0, le=20)
    """on each side; by default 0, under a vault one between every two windows"""
    buttress_depth: Length | None = None
    """beyond the wall; by default its thickness, under a vault a third of the width"""
    roof: Literal["timber", "vault", "none"] = "timber"
    """of the nave"""
    roof_mass: ArealMass = 150.0
    """of a timber roof, in plan"""
    vault_thickness: Thickness | None = None
    """of a barrel vault; by default 0.07 of the width"""
