# SPDX-License-Identifier: GPL-3.0-or-later
r"""The return period that a limit state asks for: NTC 2018, 2.4 and 3.2.1.

    V_R = C_U V_N,        T_R = - V_R / ln(1 - P_VR)

C_U is that of the class of use (table 2.4.II), P_VR the probability of the limit state in V_R (table 3.2.I). V_R is at least 35 years
(Circolare 7/2019, table C2.4.I), and T_R of the Italian codes lies between 30 and 2475 years, the ends of the national grid (C3.2.1).
"""

from __future__ import annotations

import math
from typing import NamedTuple

USE = {"I": 0.7, "II": 1.0, "III": 1.5, "IV": 2.0}  # C_U
PROBABILITY = {"SLO": 0.81, "SLD": 0.63, "SLV": 0.10, "SLC": 0.05}  # P_VR
SHORTEST_LIFE = 35.0  # V_R at least [years]
GRID = (30.0, 2475.0)  # T_R of the national grid [years]


class Life(NamedTuple):
    """Nominal life and class of use of a building."""

    nominal: float = 50.0  # V_N [years]
    use: str = "II"

    @property
    def reference(self) -> float:
        """V_R [years]."""
        return max(USE[self.use] * self.nominal, SHORTEST_LIFE)

    def asked(self, state: str) -> float:
        """T_R of a limit state by its probability [years]."""
        return -self.reference / math.log1p(-PROBABILITY[state])

    def return_period(self, state: str, limited: bool = True) -> float:
        """T_R of a limit state [years], within the national grid where it is ``limited``."""
        asked = self.asked(state)
        return min(max(asked, GRID[0]), GRID[1]) if limited else asked

    def notes(self, state: str, limited: bool = True) -> tuple[str, ...]:
        """A line where V_R or T_R is not what life and class of use give."""
        product, asked, taken = USE[self.use] * self.nominal, self.asked(state), self.return_period(state, limited)
        out = []
        if product < SHORTEST_LIFE:
            out.append(f"V_R = {product:g} years is below {SHORTEST_LIFE:g}, which is taken (Circolare 7/2019, table C2.4.I)")
        if taken != asked:
            out.append(f"T_R of {state} is {asked:.4g} years, beyond the national grid: {taken:g} is taken")
        return tuple(out)
