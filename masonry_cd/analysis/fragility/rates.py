# SPDX-License-Identifier: GPL-3.0-or-later
"""The fragilities of a study over the hazard of its site: how often a year each limit state is exceeded, with the band of the bootstrap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from masonry_cd.analysis.fragility.bootstrap import LEVEL, band
from masonry_cd.analysis.fragility.fits import Fit
from masonry_cd.analysis.hazard.curve import Hazard
from masonry_cd.analysis.hazard.frequency import YEARS, frequency, probability
from masonry_cd.analysis.hazard.table import same_measure

APART = 0.01  # share by which both bounds may differ and be said as one number
COLUMNS = (
    "limit_state", "method", "frequency", "frequency_least", "frequency_low", "frequency_high", "return_period_years",
    "probability_50_years", "probability_low", "probability_high",
)  # fmt: skip


@dataclass(frozen=True)
class Rate:
    """How often a year a limit state is exceeded [1/year]; ``most`` counts what lies beyond the rows of the hazard in full."""

    limit: str
    method: str  # of the fit
    most: float
    least: float
    band: tuple[float, float]  # of most, 95 %

    @property
    def is_bounded(self) -> bool:
        """True where the rows of the hazard end within what contributes."""
        return self.most - self.least > APART * self.most

    def row(self) -> dict[str, Any]:
        """The columns of a table."""
        numbers = (self.most, self.least, *self.band, 1.0 / self.most if self.most else np.inf)
        chance = probability(np.array([self.most, *self.band])).tolist()
        return dict(zip(COLUMNS, (self.limit, self.method, *numbers, *chance), strict=True))

    @property
    def line(self) -> str:
        """``collapse: exceeded 3.2e-04 times a year (95 %: ...), 1.6 % in 50 years``"""
        low, high = self.band
        row = self.row()
        text = f"{self.limit}: exceeded {self.most:.2g} times a year ({100 * LEVEL:.0f} %: {low:.2g} to {high:.2g})"
        text += f", {100 * row['probability_50_years']:.2g} % in {YEARS:g} years"
        end = f"; at least {self.least:.2g}: the rows of the hazard end within what contributes, and the rest counts in full"
        return text + (end if self.is_bounded else "")


def hazard_of(numbers: Mapping[str, Any] | None) -> Hazard | None:
    """The hazard that study.json keeps."""
    if numbers is None:
        return None
    return Hazard(str(numbers["measure"]), np.array(numbers["intensity"]), np.array(numbers["frequency"]), notes=tuple(numbers["notes"]))


def mismatch(hazard: Hazard, measure: str | None) -> str:
    """Why a hazard says nothing of the fragilities over a measure; empty where it does."""
    if measure is not None and same_measure(measure) == hazard.measure:
        return ""
    return f"the hazard is of {hazard.measure}, and the study's measure is {measure or 'none'}: no frequencies"


def annual_loss(rates: Sequence[Rate], ratios: Mapping[str, float]) -> float | None:
    """The mean annual loss over the cost of reconstruction, sum (L_i - L_{i-1}) lambda_i of limit states from the lightest on.

    None where a limit state with a ratio has no rate.
    """
    often = {rate.limit: rate.most for rate in rates}
    if not ratios or not set(ratios) <= set(often):
        return None
    order = sorted(ratios, key=lambda name: ratios[name])
    before = [0.0, *(ratios[name] for name in order[:-1])]
    return sum((ratios[name] - less) * often[name] for name, less in zip(order, before, strict=True))


def rates_of(fits: Sequence[Fit], hazard: Hazard) -> list[Rate]:
    """The rates of some fits that have a median and a beta."""
    out = []
    for fit in fits:
        found = frequency(hazard, np.array([fit.theta]), np.array([fit.beta]))
        replicated = frequency(hazard, fit.replicated.theta, fit.replicated.beta)
        out.append(Rate(fit.limit.name, fit.method, float(found.most[0]), float(found.least[0]), band(replicated.most)))
    return out
