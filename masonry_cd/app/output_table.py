# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[output]`` of a scene: where one looks, besides the frames: points, joints, cracks and supports, in every step."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import Field, field_validator, model_validator

from masonry_cd.foundation.fields import Flag, Table, Vector
from masonry_cd.foundation.units import Unit

CORNER = re.compile(r"(?:([+-])x)?(?:([+-])y)?(?:([+-])z)?")

Place = Annotated[Vector, Unit("m")]


class PointGaugeTable(Table):
    """``[[output.point]]``: how a point of a block moves."""

    block: str | None = None
    """Name of the block; that on which the place lies when not given."""
    corner: str | None = None
    """Corner of the block that is outermost in some directions: "+x+z", "-x+y-z"."""
    place: Place | None = None
    """The point as built; the centre of mass of the block when neither is given."""
    relative: Flag = True
    """Displacements relative to the support that moves least; false for displacements in the world."""
    name: Annotated[str, Field(min_length=1, max_length=60)] | None = None
    """Name in tables and plots."""

    @field_validator("corner")
    @classmethod
    def _known(cls, value: str | None) -> str | None:
        if value is not None and (not value or CORNER.fullmatch(value) is None):
            raise ValueError('must be made of signs and axes in the order x, y, z, such as "+x+z"')
        return value

    @model_validator(mode="after")
    def _one_place(self) -> PointGaugeTable:
        if self.corner is not None and self.place is not None:
            raise ValueError("give corner or place, not both")
        if self.block is None and self.place is None:
            raise ValueError("give a block, a place, or both")
        return self


class JointTable(Table):
    """``[[output.joint]]``: opening, slip, forces, moment and compressed depth of a joint."""

    blocks: tuple[str, str] | None = Field(None, strict=False)
    """The two blocks that it joins."""
    place: Place | None = None
    """A place, instead of blocks: the joint whose centre is the nearest."""
    name: Annotated[str, Field(min_length=1, max_length=60)] | None = None
    """Name in tables and plots."""

    @model_validator(mode="after")
    def _one_place(self) -> JointTable:
        if (self.blocks is None) == (self.place is None):
            raise ValueError("give exactly one of blocks and place")
        return self


class CrackTable(Table):
    """``[[output.crack]]``: a crack gauge between two points of two blocks."""

    points: Annotated[tuple[Vector, Vector], Unit("m")] = Field(strict=False)
    """Its two end points as built, each on its own block."""
    blocks: tuple[str, str] | None = Field(None, strict=False)
    """The blocks on which they are, where the places alone do not say it."""
    name: Annotated[str, Field(min_length=1, max_length=60)] | None = None
    """Name in tables and plots."""


class SupportGaugeTable(Table):
    """``[[output.support]]``: the reaction of a fixed block, summed over all that touches it."""

    block: str
    """Its name."""
    name: Annotated[str, Field(min_length=1, max_length=60)] | None = None
    """Name in tables and plots."""


class OutputTable(Table):
    """The table ``[output]``."""

    point: list[PointGaugeTable] = Field(default_factory=list)
    """Points whose displacement, velocity and acceleration are kept, [[output.point]] each."""
    joint: list[JointTable] = Field(default_factory=list)
    """Joints whose opening, slip, forces, moment and compressed depth are kept, [[output.joint]] each."""
    crack: list[CrackTable] = Field(default_factory=list)
    """Crack gauges between two points, [[output.crack]] each."""
    support: list[SupportGaugeTable] = Field(default_factory=list)
    """Supports whose reaction is kept, [[output.support]] each."""
