# SPDX-License-Identifier: GPL-3.0-or-later
r"""The motion at a height of a building, by its first mode.

**Circolare 2019**, C7.2.3, equations C7.2.5 to C7.2.7, with the participation gamma and the mode psi = z / H (C7.2.10):

    a_Z = S_e(T1, xi1) |gamma psi| sqrt(1 + 0.0004 xi1^2)            xi1 in per cent
    S_eZ(T) = A a_Z / (1 + (A - 1) |1 - T / c|^p)                    c = 0.8 T1, p = 1.6 below it;  c = 1.1 T1, p = 1.2 above
    S_eZ(T) = A a_Z                                                  between the two;   not below S_e(T) where T > T1

with A = 1.1 eta(xi) / sqrt(xi1). There xi1 is a ratio: of 5 % A is 4.9, while per cent would make it 0.49, a floor that vibrates less in
resonance than at rest. So has it the source of the formula: Degli Abbati, Cattari & Lagomarsino, Earthquakes and Structures 15(5), 2018.

**EN 1998-1**, 4.3.5.2, equation 4.25: S_a = alpha S (3 (1 + z/H) / (1 + (1 - Ta/T1)^2) - 0.5), not below alpha S.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from loads.signal.spectra.shape import damping_factor
from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.steps import CodeQuantity, Working
from masonry_cd.analysis.code_check.table import CheckTable

RISE, FALL = 0.8, 1.1  # a and b: over T1, where the largest amplification begins and ends
BEFORE, AFTER = 1.6, 1.2  # powers of its flanks
AMPLIFIED = "[C7.2.6], [C7.2.9]"
ROWS = {
    "H": CodeQuantity("m", "C7.2.3", "height of the building"),
    "z": CodeQuantity("m", "C7.2.3", "height at which the mechanism is held, above the foundation"),
    "T1": CodeQuantity("s", "C7.2.3", "period of the building"),
    "xi1": CodeQuantity("", "C7.2.3", "damping of the building"),
    "eta1": CodeQuantity("", "C7.2.3", "what it makes of the spectrum", "max(0.55, sqrt(10 / (5 + 100 xi1)))"),
    "Se(T1, xi1)": CodeQuantity("m/s2", "[C7.2.7]", "elastic spectrum at that period"),
    "n": CodeQuantity("", "[C7.2.10]", "storeys"),
    "gamma1": CodeQuantity("", "[C7.2.10]", "participation of its first mode"),
    "psi1(z)": CodeQuantity("", "C7.2.3", "mode at the height of the mechanism", "z / H"),
    "aZ": CodeQuantity("m/s2", "[C7.2.7], [C7.2.8]", "peak acceleration there", "Se(T1, xi1) gamma1 psi1(z) sqrt(1 + 0.0004 (100 xi1)^2)"),
    "A": CodeQuantity("", AMPLIFIED, "largest amplification", "1.1 eta / sqrt(xi1)"),
    "F": CodeQuantity("", AMPLIFIED, "how far the period is from that of the building, zero in resonance"),
    "SeZ(T)": CodeQuantity("m/s2", "[C7.2.5], [C7.2.6]", "spectrum of the floor at that period"),
}


@dataclass(frozen=True)
class Floor:
    """The spectrum of the Circolare of 2019 at a height."""

    ground: Ground
    period: float  # T1 [s]
    damping: float  # xi1
    share: float  # gamma psi

    @classmethod
    def of(cls, table: CheckTable, ground: Ground) -> Floor:
        """At the height of a table's mechanism."""
        assert table.building_period is not None
        return cls(ground, table.building_period, table.building_damping, table.gamma * table.share)

    @property
    def peak(self) -> float:
        """a_Z, the largest acceleration of the floor [m/s2]."""
        per_cent = 100.0 * self.damping
        return self.ground.acceleration(self.period, self.damping) * self.share * math.sqrt(1.0 + 0.0004 * per_cent**2)

    def at(self, period: float, damping: float) -> tuple[float, float, float, float]:
        """A, |1 - T / c|^p, S_e and S_eZ at a period [s]: accelerations [m/s2]."""
        most, peak = 1.1 * damping_factor(damping) / math.sqrt(self.damping), self.peak
        first, last = RISE * self.period, FALL * self.period
        away = 0.0
        if period < first:
            away = (1.0 - period / first) ** BEFORE
        elif period >= last:
            away = (period / last - 1.0) ** AFTER
        found, ground = most * peak / (1.0 + (most - 1.0) * away), self.ground.acceleration(period, damping)
        return most, away, ground, max(found, ground) if period > self.period else found

    def put(self, made: Working, period: float, damping: float, of: str) -> float:
        """Note S_eZ at a period whose symbol is ``of``, and what it is made of; return it [m/s2]."""
        most, away, ground, there = self.at(period, damping)
        if made.known.get("A") != most:
            made.put("eta", damping_factor(damping))
            made.put("A", most)
        flank = f"(1 - {of} / ({RISE:g} T1))^{BEFORE:g}" if period < RISE * self.period else f"({of} / ({FALL:g} T1) - 1)^{AFTER:g}"
        made.put("F", away, flank if away else "")
        formula = "A aZ / (1 + (A - 1) F)"
        if period > self.period:
            made.put(f"Se({of})", ground, self.ground.formula(period, of, True), like="Se(T)")
            formula = f"max({formula}, Se({of}))"
        return made.put(f"SeZ({of})", there, formula, like="SeZ(T)")

    def displaced(self, made: Working, period: float, damping: float, of: str) -> tuple[float, str]:
        """The displacement that is required at a period whose symbol is ``of`` [m], and its formula; notes what that needs."""
        self.put(made, period, damping, of)
        formula, found = f"SeZ({of}) {of}^2 / (4 pi^2)", self._displacement(period, damping)
        if period <= FALL * self.period:
            return found, formula
        self.put(made, self.period, damping, "T1")
        return found, f"max({formula}, SeZ(T1) ({FALL:g} T1)^2 / (4 pi^2))"

    def _displacement(self, period: float, damping: float) -> float:
        """The displacement at a period, not below that at the end of the amplification where it is longer (C8.7.1.12) [m]."""
        found, end = _displacement(self.at(period, damping)[-1], period), FALL * self.period
        return found if period <= end else max(found, _displacement(self.at(self.period, damping)[-1], end))

    def spectrum_at(self, periods: np.ndarray, damping: float) -> tuple[np.ndarray, np.ndarray]:
        """Acceleration [m/s2] and displacement [m] at periods, (n,) each."""
        found = np.array([self.at(period, damping)[-1] for period in periods.tolist()])
        return found, np.array([self._displacement(period, damping) for period in periods.tolist()])


def _displacement(acceleration: float, period: float) -> float:
    return acceleration * (period / (2.0 * math.pi)) ** 2


def part_acceleration(peak: float, share: float, ratio: float) -> float:
    """S_a g of EN 1998-1, 4.3.5.2 [m/s2].

    Args:
        peak: ag S [m/s2].
        share: z / H.
        ratio: Ta / T1.
    """
    return peak * max(1.0, 3.0 * (1.0 + share) / (1.0 + (1.0 - ratio) ** 2) - 0.5)
