# SPDX-License-Identifier: GPL-3.0-or-later
r"""The acceleration of the ground that a mechanism just bears, and its share of the one that is required.

    PGA_C = the ag at which capacity = demand(ag),        zeta_E = PGA_C / PGA_D,       PGA_D = the ag of the site and limit state

Both are peak accelerations on rock; of a record they are its own, and the record grows as a whole. The mechanism, its height, the building
with its period and damping and q stay as they are; what a code makes a function of ag follows it: SS and TD of NTC. F0 and TC* follow it
where the hazard of the site has them, and stay as they are without one.

The demand grows with ag, nearly everywhere: on ground D of NTC ag SS falls by 6 % between F0 ag/g = 0.8 and 1.07. There several ag meet the
capacity, and the one is taken that goes with the verdict: upwards from an ag that is borne, and from zero below one that is not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from scipy.optimize import brentq

from masonry_cd.analysis.hazard.curve import Period

STEP = 1.1  # by which the search goes up until the demand is met no more
LEAST, MOST = 1e-6, 1e3  # ag over that of the site between which it is looked for
CLOSE = 1e-12  # relative, of the root


@dataclass(frozen=True)
class Borne:
    """The acceleration of the ground that a check just meets."""

    check: str  # linear or non-linear
    borne: float | None  # PGA_C [m/s2]; None where every ag is borne, 0 where none is
    asked: float  # PGA_D [m/s2]
    period: Period | None = None  # the return period of what is borne, where the hazard of the site is known

    @property
    def share(self) -> float | None:
        """zeta_E; None where every ag is borne."""
        return None if self.borne is None else self.borne / self.asked

    @property
    def words(self) -> str:
        """A line."""
        if self.borne is None:
            return f"{self.check} check: every ag is borne, up to {MOST:g} times the {self.asked:.4g} m/s2 required"
        if self.borne == 0.0:
            return f"{self.check} check: no ag is borne, zeta_E = 0: the mechanism has no capacity"
        share = f"zeta_E = PGA_C / PGA_D = {self.borne:.4g} / {self.asked:.4g} = {self.share:.4g}"
        often = "" if self.period is None else f", return period of PGA_C {self.period.words}"
        return f"{self.check} check: just borne is PGA_C = {self.borne:.4g} m/s2, {share}{often}"

    def numbers(self) -> dict[str, Any]:
        """The numbers of it in check.json."""
        found = asdict(self) | {"share": self.share, "words": self.words}
        del found["period"]
        years, bound = (None, "") if self.period is None else self.period
        return found | {"return_period_years": years, "return_period_bound": bound}


def just_borne(check: str, met: Callable[[float], float], asked: float) -> Borne:
    """Look for the ag of a check.

    Args:
        check: its name.
        met: the share of the demand that is met at an ag [m/s2].
        asked: the ag of the site and limit state [m/s2].
    """
    here = met(asked)
    if here <= 0.0:
        return Borne(check, 0.0, asked)
    # soil and TD at most halve or double what would be in proportion to ag
    low = asked * (math.sqrt(here) if here >= 1.0 else here / 2.0)
    while met(low) < 1.0:
        low /= 2.0
        if low < LEAST * asked:
            return Borne(check, 0.0, asked)
    high = low
    while met(high) >= 1.0:
        if high > MOST * asked:
            return Borne(check, None, asked)
        low, high = high, STEP * high
    return Borne(check, float(brentq(lambda ag: met(ag) - 1.0, low, high, rtol=CLOSE)), asked)
