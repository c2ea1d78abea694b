# SPDX-License-Identifier: GPL-3.0-or-later
r"""Elastic response spectra of the codes: EN 1998-1:2004 (EC8), 3.2.2.2 and 3.2.2.3, and NTC 2018, 3.2.3.2.

Both have one shape, with eta = sqrt(10 / (5 + 100 xi)) >= 0.55 for the damping xi, a start s at T = 0 and a plateau at P eta:

    S(T) = a (s + (P eta - s) T / T_B)      0   <= T <= T_B
           a P eta                          T_B <= T <= T_C
           a P eta T_C / T                  T_C <= T <= T_D
           a P eta T_C T_D / T^2            T_D <= T

    EC8, level:     a = ag S,        s = 1,       P = 2.5;     S, T_B, T_C, T_D by type of spectrum and ground
    EC8, vertical:  a = avg,         s = 1,       P = 3.0;     avg = 0.90 ag (type 1) or 0.45 ag (type 2)
    NTC, level:     a = ag SS ST,    s = 1,       P = F0;      T_C = CC TC*, T_B = T_C / 3, T_D = 4 ag/g + 1.6
    NTC, vertical:  a = ag ST,       s = FV / F0, P = FV;      FV = 1.35 F0 sqrt(ag/g); SS = 1

The displacement of an oscillator is S (T / 2 pi)^2 up to T_E, and from there on comes down to that of the ground at T_F (EN 1998-1,
annex A, type 1; NTC 2018, 3.2.3.2.3):

    S_D(T) = 0.025 a T_C T_D (P eta + (1 - P eta) (T - T_E) / (T_F - T_E)),     T_E <= T <= T_F
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import BaseModel, model_validator

from loads.motion import STANDARD_GRAVITY, Positive, strict
from masonry_cd.foundation.fields import Span
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.usual import ACCELERATIONS

EC8_LEVEL = {  # type of spectrum, ground: S, T_B, T_C, T_D (tables 3.2 and 3.3)
    (1, "A"): (1.0, 0.15, 0.4, 2.0),
    (1, "B"): (1.2, 0.15, 0.5, 2.0),
    (1, "C"): (1.15, 0.20, 0.6, 2.0),
    (1, "D"): (1.35, 0.20, 0.8, 2.0),
    (1, "E"): (1.4, 0.15, 0.5, 2.0),
    (2, "A"): (1.0, 0.05, 0.25, 1.2),
    (2, "B"): (1.35, 0.05, 0.25, 1.2),
    (2, "C"): (1.5, 0.10, 0.25, 1.2),
    (2, "D"): (1.8, 0.10, 0.30, 1.2),
    (2, "E"): (1.6, 0.05, 0.25, 1.2),
}
EC8_VERTICAL = {1: 0.90, 2: 0.45}  # avg / ag (table 3.4)
NTC_AMPLIFICATION = {  # SS = low <= base - slope F0 ag/g <= high (table 3.2.IV)
    "A": (1.0, 0.0, 1.0, 1.0),
    "B": (1.4, 0.4, 1.0, 1.2),
    "C": (1.7, 0.6, 1.0, 1.5),
    "D": (2.4, 1.5, 0.9, 1.8),
    "E": (2.0, 1.1, 1.0, 1.6),
}
NTC_PERIOD = {"A": (1.0, 0.0), "B": (1.1, -0.20), "C": (1.05, -0.33), "D": (1.25, -0.50), "E": (1.15, -0.40)}  # CC = factor TC*^power
NTC_TOPOGRAPHY = {"T1": 1.0, "T2": 1.2, "T3": 1.2, "T4": 1.4}  # ST (table 3.2.V)
VERTICAL_PERIODS = (0.05, 0.15, 1.0)  # T_B, T_C, T_D of both codes
LONG_PERIODS = {"A": (4.5, 10.0), "B": (5.0, 10.0), "C": (6.0, 10.0), "D": (6.0, 10.0), "E": (6.0, 10.0)}  # T_E, T_F of both codes


@dataclass(frozen=True)
class CodeSpectrum:
    """An elastic response spectrum of the shape above."""

    size: float  # a [m/s2]
    start: float  # s
    plateau: float  # P
    corners: tuple[float, float, float]  # T_B, T_C, T_D [s]
    long: tuple[float, float] | None = None  # T_E, T_F [s]; None where a code has none
    soil: float = 1.0  # S of EC8, SS of NTC
    hill: float = 1.0  # ST
    stretch: float = 1.0  # CC

    def at(self, period: np.ndarray, damping: float = 0.05) -> np.ndarray:
        """Pseudo-acceleration at periods (n,) of zero or more [m/s2]."""
        t, (b, c, d) = np.asarray(period, dtype=float), self.corners
        top = self.plateau * damping_factor(damping)
        rise = self.start + (top - self.start) * np.minimum(t, b) / b
        fall = np.minimum(1.0, c / np.maximum(t, c)) * np.minimum(1.0, d / np.maximum(t, d))
        return np.asarray(self.size * rise * fall)

    def displacement(self, period: np.ndarray, damping: float = 0.05) -> np.ndarray:
        """Displacement at periods (n,) of zero or more, relative to the ground [m]."""
        t = np.asarray(period, dtype=float)
        short = self.at(t, damping) * (t / (2.0 * np.pi)) ** 2
        if self.long is None:
            return np.asarray(short)
        top, (begin, end) = self.plateau * damping_factor(damping), self.long
        share = np.clip((t - begin) / (end - begin), 0.0, 1.0)
        falling = 0.025 * self.size * self.corners[1] * self.corners[2] * (top + (1.0 - top) * share)
        return np.where(t > begin, falling, short)


def damping_factor(damping: float) -> float:
    """eta of a damping ratio: what it makes of a spectrum for 5 %."""
    return float(max(0.55, np.sqrt(10.0 / (5.0 + 100.0 * damping))))


def ec8(ag: float, ground: str = "A", type_: int = 1, vertical: bool = False) -> CodeSpectrum:
    """EN 1998-1 for a design ground acceleration on rock (times the importance factor) [m/s2], ground A to E, type 1 or 2."""
    if vertical:
        return CodeSpectrum(EC8_VERTICAL[type_] * ag, 1.0, 3.0, VERTICAL_PERIODS)
    soil, *corners = EC8_LEVEL[type_, ground]
    return CodeSpectrum(soil * ag, 1.0, 2.5, (corners[0], corners[1], corners[2]), LONG_PERIODS[ground] if type_ == 1 else None, soil)


def ntc(
    ag: float,
    f0: float,
    tc_star: float,
    ground: str = "A",
    topography: str = "T1",
    vertical: bool = False,
    gravity: float = STANDARD_GRAVITY,
) -> CodeSpectrum:
    """NTC 2018 for the site's ag [m/s2], F0 and TC* [s], category of ground A to E and of topography T1 to T4; gravity [m/s2]."""
    share, hill = ag / gravity, NTC_TOPOGRAPHY[topography]
    if vertical:
        fv = 1.35 * f0 * np.sqrt(share)
        return CodeSpectrum(ag * hill, float(fv / f0), float(fv), VERTICAL_PERIODS)
    base, slope, low, high = NTC_AMPLIFICATION[ground]
    soil = float(np.clip(base - slope * f0 * share, low, high))
    factor, power = NTC_PERIOD[ground]
    stretch = factor * tc_star**power
    tc = stretch * tc_star
    return CodeSpectrum(ag * soil * hill, 1.0, f0, (tc / 3.0, tc, 4.0 * share + 1.6), LONG_PERIODS[ground], soil, hill, stretch)


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
