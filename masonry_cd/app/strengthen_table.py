# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of the table ``[strengthen]``: what is asked of a structure, which ties may be built into it, and what these cost."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from loads.motion import DirectionKey
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.usual import DIAMETER
from structures.schema import Length, Table
from structures.ties import SPACING, LineTable

PLAIN = (0.012, 0.016, 0.020, 0.024, 0.028, 0.032, 0.036, 0.040, 0.050)  # diameters of plain round bars [m]
LONGEST = 500.0  # force of a bar that is taken, in MN
Price = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Force = Annotated[float, Unit("N"), Field(gt=0.0, le=1e6 * LONGEST, allow_inf_nan=False)]


class CandidateTable(LineTable):
    """One entry ``[[strengthen.ties]]``: ties whose yield force is looked for."""

    largest_force: Force | None = None
    """at which its anchorage gives way; by default that of the largest bar"""


class BarTable(Table):
    """One entry ``[[strengthen.bars]]``: a bar that can be bought."""

    diameter: Annotated[Length, DIAMETER]
    """Diameter of its section."""
    yield_force: Force | None = None
    """Force at which it yields; by default that of its section at the yield stress."""
    price: Price | None = None
    """Price per metre; by default by its yield force."""


class PricesTable(Table):
    """The table ``[strengthen.prices]``, in any currency."""

    force: Price = 0.0
    """Price of a tie per kN of its yield force."""
    force_length: Price | None = None
    """Price of a tie per kN of its yield force and metre of its length, as its steel weighs; 1 where no price is given."""
    anchor: Price = 0.0
    """Price of each of the two anchors of a tie."""

    @property
    def per_kn_m(self) -> float:
        """Price per kN and metre."""
        if self.force_length is None:
            return 0.0 if self.force or self.anchor else 1.0
        return self.force_length


class StrengthenTable(Table):
    """The table ``[strengthen]``: the least ties that bring a structure to a load factor, for ``masonry-cd strengthen``."""

    factor: float | None = Field(None, gt=0.0, le=5.0)
    """Load factor that every mechanism must reach."""
    zeta_E: float | None = Field(None, gt=0.0, le=10.0)
    """The share of the acceleration of [limit.check] that every mechanism has to bear at least, by accelerations."""
    pushes: tuple[DirectionKey, ...] | None = Field(None, strict=False, min_length=1)
    """Directions in which the whole is pushed, ["y", "-y"]; by default that of the scene's push."""
    macro_elements: bool = False
    """Every macro-element of the structure's kind under its own pushes as well; those of [[limit.mechanism]] are looked at in any case."""
    ties: tuple[CandidateTable, ...] = Field((), strict=False)
    """Candidates, [[strengthen.ties]] each."""
    rules: tuple[Literal["floors", "roofs", "corners"], ...] = Field((), strict=False)
    """Candidates from the geometry: under floors, under roofs and vaults at their springing, along walls from corner to corner."""
    spacing: Annotated[Length, SPACING] = 4.0
    """Distance of the ties of rules."""
    plate: Length | None = None
    """Side of the square anchor plates of the ties of rules."""
    yield_stress: Annotated[float, Unit("Pa")] = Field(235e6, gt=0.0, le=5e9)
    """f_y of bars without a yield force."""
    bars: tuple[BarTable, ...] = Field((), strict=False)
    """Available bars, [[strengthen.bars]] each; by default plain round ones of 12, 16, 20, 24, 28, 32, 36, 40 and 50 mm."""
    prices: PricesTable = PricesTable()
    """Prices of ties, [strengthen.prices]."""
    fewest: bool = False
    """The fewest ties possible, at the least cost."""

    @field_validator("rules")
    @classmethod
    def _once(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(value)) < len(value):
            raise ValueError("should name each rule once")
        return value

    @model_validator(mode="after")
    def _fits(self) -> StrengthenTable:
        if (self.factor is None) == (self.zeta_E is None):
            raise ValueError("give exactly one of factor and zeta_E")
        if not self.ties and not self.rules:
            raise ValueError('no candidates: give [[strengthen.ties]], or rules = ["roofs"]')
        if not self.bars and any(row.material == "timber" for row in self.ties):
            raise ValueError("timber: the usual bars are of steel; give [[strengthen.bars]] with diameter and yield_force")
        return self

    @property
    def target(self) -> float:
        """The target factor or zeta_E."""
        return float(self.zeta_E if self.factor is None else self.factor)  # type: ignore[arg-type]  # one of them is given

    @property
    def catalogue(self) -> tuple[BarTable, ...]:
        """The bars with their yield forces [N], the weakest first."""
        bars = self.bars or tuple(BarTable(diameter=each) for each in PLAIN)
        forces = [bar.yield_force or float(round(self.yield_stress * 0.25 * math.pi * bar.diameter**2)) for bar in bars]
        strong = [bar.model_copy(update={"yield_force": force}) for bar, force in zip(bars, forces, strict=True)]
        return tuple(sorted(strong, key=lambda bar: bar.yield_force or 0.0))
