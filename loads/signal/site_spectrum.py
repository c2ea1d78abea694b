# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of a scene that say which code's response spectrum holds at a site."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, Field, model_validator

from loads.motion import STANDARD_GRAVITY, strict
from loads.signal.code_spectrum import CodeSpectrum, ec8, ntc
from masonry_cd.foundation.fields import Span
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.usual import ACCELERATIONS

Positive = Annotated[float, Field(gt=0.0)]


GROUND = Usual(0.6, 10.0, "hazard maps give 0.6 to 10 m/s2 (0.06 to 1 g) where masonry is checked", ACCELERATIONS)


class SiteSpectrum(BaseModel):
    """The elastic response spectrum of a code at a site."""

    model_config = strict

    spectrum: Literal["EC8", "NTC"] | None = None
    """Of Eurocode 8 or of the Italian code NTC."""
    ag: Annotated[Positive, Unit("m/s2"), GROUND] | None = None
    """Peak ground acceleration on rock."""
    ground: Literal["A", "B", "C", "D", "E"] = "A"
    """Ground type."""
    type: Literal[1, 2] | None = None
    """Of the spectrum, EC8 only; 1 when not given."""
    f0: Positive | None = None
    """Largest amplification at the site, NTC only."""
    tc_star: Annotated[Span, Usual(0.05, 2.0, "T*_C is 0.1 to 1 s", ("ms",))] | None = None
    """Where the constant velocity of the spectrum begins at the site, NTC only."""
    topography: Literal["T1", "T2", "T3", "T4"] | None = None
    """Category of the site, NTC only; T1 when not given."""

    @model_validator(mode="after")
    def _keys_of_one_code(self) -> Self:
        of_ntc = {"f0": self.f0, "tc_star": self.tc_star, "topography": self.topography}
        if self.spectrum is None:
            return self
        if self.ag is None:
            raise ValueError("ag: missing, a spectrum needs it")
        if self.spectrum == "EC8":
            stray = next((key for key, value in of_ntc.items() if value is not None), None)
        else:
            stray = None if self.type is None else "type"
            missing = next((key for key in ("f0", "tc_star") if of_ntc[key] is None), None)
            if missing is not None:
                raise ValueError(f"{missing}: missing, the spectrum of NTC needs it")
        if stray is not None:
            raise ValueError(f"{stray}: does not apply to a spectrum of {self.spectrum}")
        return self

    def spectrum_of_site(self, vertical: bool = False, gravity: float = STANDARD_GRAVITY) -> CodeSpectrum:
        """The spectrum; of keys that name one. Gravity [m/s2] is that of the formulas of NTC."""
        assert self.ag is not None
        if self.spectrum == "EC8":
            return ec8(self.ag, self.ground, self.type or 1, vertical)
        assert self.f0 is not None
        assert self.tc_star is not None
        return ntc(self.ag, self.f0, self.tc_star, self.ground, self.topography or "T1", vertical, gravity)
