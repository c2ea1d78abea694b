# SPDX-License-Identifier: GPL-3.0-or-later
r"""The hazard of a site: annual frequencies lambda_j at intensities im_j, a power law between two rows, T_R = 1 / lambda.

    ln p = ln p_1 + ln(p_2 / p_1) ln(T_R / T_1) / ln(T_2 / T_1),        p: ag, F0 and TC*

is the interpolation of annex A to NTC 2008 (D.M. 14 January 2008), to which NTC 2018, 3.2, refers. Beyond the rows nothing is known: a
return period is then a bound, and an intensity is refused.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.analysis.hazard.life import GRID, Life
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError

PGA = "PGA"
G = 9.80665  # standard gravity, by which the bounds of ETA are given [m/s2]
ETA = ((0.25, 0.49), (0.15, 0.43), (0.05, 0.356), (0.0, 0.34))  # from ag/g on: 1 / eta of T_C = T_D (PGA_C / PGA_D)^eta
GUIDELINE = "Linee guida, D.M. 65/2017, annex A"


class Period(NamedTuple):
    """A return period, or a bound of it."""

    years: float
    bound: str = ""  # ">=" beyond the last row, "<=" before the first

    @property
    def words(self) -> str:
        """``612 years``, or ``>= 2475 years``."""
        return f"{self.bound} {self.years:.4g} years".strip()


class HazardRow(NamedTuple):
    """The hazard at a return period."""

    intensity: float
    f0: float | None
    tc_star: float | None  # [s]


@dataclass(frozen=True, eq=False)
class Hazard:
    """The hazard of a site: n rows of intensity, rising, and annual frequency, falling."""

    measure: str  # of the intensity, as a study names it; PGA of a table of return periods is that on rock
    intensity: np.ndarray  # (n,) SI
    frequency: np.ndarray  # (n,) [1/year]
    f0: np.ndarray | None = None  # (n,)
    tc_star: np.ndarray | None = None  # (n,) [s]
    life: Life = field(default_factory=Life)
    notes: tuple[str, ...] = ()

    @property
    def known(self) -> bool:
        """True of one with rows; without it is a reference life alone."""
        return len(self.intensity) > 0

    @property
    def is_of_ag(self) -> bool:
        """True where the rows are of the ag that a code asks for."""
        return self.known and self.measure == PGA

    @property
    def ends(self) -> tuple[float, float]:
        """Return periods of the first and the last row [years]."""
        return float(1.0 / self.frequency[0]), float(1.0 / self.frequency[-1])

    @property
    def words(self) -> str:
        """A line."""
        first, last = self.ends
        return f"hazard: {self.measure}, {len(self.intensity)} rows, return periods of {first:.4g} to {last:.4g} years"

    def return_period(self, intensity: float) -> Period:
        """The return period of an intensity."""
        first, last = self.ends
        if intensity > self.intensity[-1]:
            return Period(last, ">=")
        if intensity < self.intensity[0]:
            return Period(first, "<=")
        return Period(math.exp(-np.interp(math.log(intensity), libm.log(self.intensity), libm.log(self.frequency))))

    def at(self, years: float, where: str = "hazard") -> HazardRow:
        """The hazard at a return period [years].

        Raises:
            InputError: a return period beyond the rows; names ``where``.
        """
        first, last = self.ends
        if not first * (1.0 - 1e-12) <= years <= last * (1.0 + 1e-12):
            raise InputError(where, f"has return periods of {first:.4g} to {last:.4g} years, and {years:.4g} is required; give more rows")
        return self.nearest(years)

    def nearest(self, years: float) -> HazardRow:
        """The hazard at a return period [years], beyond the rows that of the last or the first."""
        logs, at = -libm.log(self.frequency), math.log(years)

        def value(column: np.ndarray | None) -> float | None:
            return None if column is None else math.exp(np.interp(at, logs, libm.log(column)))

        return HazardRow(math.exp(np.interp(at, logs, libm.log(self.intensity))), value(self.f0), value(self.tc_star))

    def around(self, intensity: float) -> tuple[int, int]:
        """The two rows between which an intensity lies, or the two at the end beyond which it does."""
        k = int(np.clip(np.searchsorted(self.intensity, intensity), 1, len(self.intensity) - 1))
        return k - 1, k

    def through(self, ag: float, years: float) -> Hazard:
        """The hazard of PGA that the guideline assumes where only one ag [m/s2] and its return period [years] are known."""
        power = exponent(ag)
        note = f"no table of return periods: T_C = T_D (PGA_C / PGA_D)^eta, 1 / eta = {power:g} ({GUIDELINE}, note 4)"
        found = np.array([ag * (end / years) ** power for end in GRID])
        return replace(self, measure=PGA, intensity=found, frequency=1.0 / np.array(GRID), notes=(*self.notes, note))

    def numbers(self) -> dict[str, Any]:
        """The numbers of it in JSON, from which a study's folder makes it again."""
        rows: dict[str, Any] = {"intensity": self.intensity.tolist(), "frequency": self.frequency.tolist()}
        rows |= {name: None if column is None else column.tolist() for name, column in (("f0", self.f0), ("tc_star", self.tc_star))}
        own = {"nominal_life": self.life.nominal, "use_class": self.life.use, "reference_life": self.life.reference}
        return {"measure": self.measure, **rows, **own, "notes": list(self.notes)}


def exponent(ag: float) -> float:
    """1 / eta of the guideline for an ag on rock [m/s2]."""
    return next(value for least, value in ETA if ag >= least * G)
