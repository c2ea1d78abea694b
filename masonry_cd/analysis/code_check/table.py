# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of ``[limit.check]``: by which code a mechanism is checked, for which motion of the ground, and where in a building it is."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from loads.signal.accelerogram import Accelerogram, Scaled
from loads.signal.code_spectrum import SiteSpectrum
from masonry_cd.foundation.extensions import Entries
from masonry_cd.foundation.fields import Span
from masonry_cd.foundation.units import Unit, Usual

Height = Annotated[float, Unit("m"), Field(gt=0.0, le=1000.0)]
Damping = Annotated[float, Field(gt=0.0, le=0.3)]


CODES: Entries[Any] = Entries("masonry_cd.analysis.code_check.codes", "CODES")  # a Code of code.py each, which gets this table


def _known(name: object) -> object:
    """The name of a code."""
    if name not in CODES:
        raise ValueError(f"is none of {', '.join(CODES)}")
    return name


def _codes(schema: dict[str, Any]) -> None:
    """The names of the codes in the JSON schema."""
    schema["enum"] = [*CODES]


class CheckRecord(Scaled, Accelerogram):
    """A record in place of the spectrum of a code: the keys of a load of kind ``record`` that say which and how large."""


class CheckTable(SiteSpectrum):
    """The table ``[limit.check]``."""

    code: Annotated[str, BeforeValidator(_known), Field(json_schema_extra=_codes)] = "NTC2018"
    """Code of the check: NTC 2018 with its Circolare of 2019, NTC 2008 with that of 2009, or Eurocode 8."""
    limit_state: Literal["SLD", "SLV", "SLC"] = "SLV"
    """Limit state of the motion of the ground: damage, life safety, or collapse; SLD and SLC are of the Italian codes only."""
    confidence_factor: Annotated[float, Field(ge=1.0, le=2.0)] = 1.35
    """Divisor of the capacity; 1.35 where the strength of the masonry plays no part, as here (C8.7.1.2.1.3)."""
    behaviour_factor: Annotated[float, Usual(1.0, 2.0, "codes give local mechanisms and parts 2 at the most"), Field(ge=1.0, le=4.0)] = 2.0
    """q of the linear check at SLV, q_a of Eurocode 8."""
    displacements: bool = True
    """Check SLV and SLC by displacements, too: the mechanism is then followed to its end, some forty limit analyses."""
    record: CheckRecord | None = None
    """Record in place of a spectrum: path, units, scale and so on, as of a load of kind record."""
    foundation: Annotated[float, Unit("m"), Field(ge=-1e4, le=1e4)] | None = None
    """z of the foundation of the building that these blocks are, or are part of, from which the line at which each mechanism is held
    counts; that of the lowest block when not given. A parapet modelled from z = 0 on a roof 6.4 m up has -6.4."""
    height: Annotated[float, Unit("m"), Field(ge=0.0, le=1000.0)] = 0.0
    """Height above the foundation, in its place, at which all of these blocks are held at least, whole and parts."""
    building_height: Height | None = None
    """H of the building, above the foundation; with it each mechanism is checked against the motion at its own height."""
    building_period: Span | None = None
    """Fundamental period T1 of the building, in the direction of the push."""
    building_damping: Damping = 0.05
    """Equivalent viscous damping xi1 of the building; 0.1 to 0.2 where it is damaged as well."""
    storeys: Annotated[int, Field(ge=1, le=200)] | None = None
    """Number n of its storeys: the participation of its mode is 3 n / (2 n + 1)."""
    participation: Annotated[float, Field(gt=0.0, le=3.0)] | None = None
    """Coefficient of participation of that mode, instead."""
    element_period: Span | None = None
    """T0 of a part that is free to vibrate before it gives way, as a parapet or a pinnacle; rigid when not given."""

    @model_validator(mode="after")
    def _one_motion(self) -> Self:
        if self.record is None and self.spectrum is None:
            raise ValueError('spectrum: missing; give that of a code, a "table", or a record')
        stray = self.model_fields_set & set(self.keys_of_kinds())
        if self.record is not None and stray:
            raise ValueError(f"{min(stray)}: does not apply with a record")
        if "limit_state" in self.model_fields_set and self.limit_state not in self.by.limit_states:
            raise ValueError(f"limit_state: {self.limit_state} does not apply to {self.code}")
        if self.limit_state == "SLC" and not self.displacements:
            raise ValueError("displacements: SLC is checked by displacements only")
        vibrate = self.by.parts_vibrate
        if self.element_period is not None and (not vibrate or (vibrate == "above the ground" and not (self.height or self.building))):
            raise ValueError(f"element_period: does not apply to {self.code}{' on the ground' if vibrate else ''}")
        return self

    @model_validator(mode="after")
    def _a_building_for_a_height(self) -> Self:
        by_storeys = {"storeys", "participation"}
        given = self.model_fields_set
        if self.height and self.foundation is not None:
            raise ValueError("height: does not apply with foundation, from which each mechanism has a height of its own")
        if not self.building and not self.height and self.foundation is None:
            stray = given & {"building_period", "building_damping", *by_storeys}
            if stray:
                raise ValueError(f"{min(stray)}: needs building_height as well")
            return self
        missing = next((key for key in ("building_height", "building_period") if getattr(self, key) is None), None)
        if missing:
            raise ValueError(f"{missing}: missing, a mechanism above the ground needs it")
        if not self.by.storeys:
            stray = given & (by_storeys | {"building_damping"})
            if stray:
                raise ValueError(f"{min(stray)}: does not apply to {self.code}")
        elif (self.storeys is None) == (self.participation is None):
            raise ValueError("give storeys or participation, one of the two")
        if self.building_height is not None and self.height > self.building_height:
            raise ValueError(f"height: {self.height:g} m is above the building of {self.building_height:g} m")
        return self

    @property
    def by(self) -> Any:
        """The :class:`~masonry_cd.analysis.code_check.code.Code` by which it is checked."""
        return CODES[self.code]

    @property
    def building(self) -> bool:
        """Return True if the building is known whose motion above the ground is required."""
        return self.building_height is not None

    def at(self, height: float) -> CheckTable:
        """The table of a mechanism that is held at a height above the foundation [m]; 0 on the ground."""
        return self.model_copy(update={"height": height, "foundation": None})

    @property
    def checks_displacements(self) -> bool:
        """Return True if a check by displacements is made."""
        return self.displacements and self.limit_state in self.by.by_displacements

    @property
    def share(self) -> float:
        """psi(z), of a first mode that grows evenly with height."""
        return self.height / (self.building_height or 1.0)

    @property
    def gamma(self) -> float:
        """The coefficient of participation, 3 n / (2 n + 1) of n storeys."""
        if self.participation is not None:
            return self.participation
        storeys = self.storeys or 1
        return 3.0 * storeys / (2.0 * storeys + 1.0)
