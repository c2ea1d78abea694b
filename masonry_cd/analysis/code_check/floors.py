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

from loads.signal.code_spectrum import damping_factor
from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.table import CheckTable

RISE, FALL = 0.8, 1.1  # a and b: over T1, where the largest amplification begins and ends
BEFORE, AFTER = 1.6, 1.2  # powers of its flanks


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

    def acceleration(self, period: float, damping: float) -> float:
        """S_eZ [m/s2]."""
        most = 1.1 * damping_factor(damping) / math.sqrt(self.damping)
        first, last = RISE * self.period, FALL * self.period
        away = 0.0
        if period < first:
            away = (1.0 - period / first) ** BEFORE
        elif period >= last:
            away = (period / last - 1.0) ** AFTER
        found = most * self.peak / (1.0 + (most - 1.0) * away)
        return max(found, self.ground.acceleration(period, damping)) if period > self.period else found

    def displacement(self, period: float, damping: float) -> float:
        """Of an oscillator, not below that at the end of the amplification where its period is longer (C8.7.1.12) [m]."""
        end = FALL * self.period
        found = _displacement(self.acceleration(period, damping), period)
        return max(found, _displacement(self.acceleration(self.period, damping), end)) if period > end else found


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
