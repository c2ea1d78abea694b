# SPDX-License-Identifier: GPL-3.0-or-later
"""EN 1998-1, 3.2.3.1.2(4), which 3.2.3.1.3 asks of recorded accelerograms as well: what a set must fulfil.

a) at least 3 records; with 7 or more the mean of the responses may be used (4.3.3.4.3(3)), with fewer their maximum;
b) the mean of the ordinates at period zero is at least a_g S;
c) from 0.2 T1 to 2 T1 the mean of the elastic spectra for 5 % damping is nowhere below 90 % of that of the code.

Means are arithmetic.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FEWEST, OF_MEANS = 3, 7  # records
SHARE = 0.9
RANGE = (0.2, 2.0)  # of T1
ROUNDING = 1e-9


@dataclass(frozen=True)
class Rule:
    """How a set meets the rule."""

    count: int  # records
    least: float  # mean spectrum over target
    at: float  # period of it [s]
    rigid: float  # mean ordinate at period zero over a_g S

    @property
    def lift(self) -> float:
        """The factor on all records by which b) and c) just hold."""
        return max(SHARE / self.least, 1.0 / self.rigid)

    @property
    def holds(self) -> tuple[bool, bool, bool]:
        """Return True for each of a), b) and c) that holds."""
        return self.count >= FEWEST, self.rigid >= 1.0 - ROUNDING, self.least >= SHARE * (1.0 - ROUNDING)

    def lines(self) -> list[str]:
        """A line on each condition, below a verdict."""
        texts = (
            f"a) {self.count} records, at least {FEWEST} are needed, {OF_MEANS} to use the mean of their responses",
            f"b) mean at period zero {self.rigid:.3f} of a_g S, at least 1 is needed",
            f"c) mean spectrum {self.least:.3f} of the target at {self.at:.3g} s, its worst period, at least {SHARE:g} is needed",
        )
        words = ("does not hold", "holds")
        below = [f"  {text}: {words[one]}" for text, one in zip(texts, self.holds, strict=True)]
        return [f"EN 1998-1, 3.2.3.1.2(4): {words[all(self.holds)]}", *below]


def judge(periods: np.ndarray, spectra: np.ndarray, target: np.ndarray) -> Rule:
    """The rule for a set.

    Args:
        periods: (m,), the first of them zero, the others from 0.2 T1 to 2 T1 [s].
        spectra: (n, m) Sa of each record [m/s2].
        target: (m,) Sa of the code [m/s2].
    """
    ratio = spectra.mean(axis=0) / target
    worst = 1 + int(ratio[1:].argmin())
    return Rule(len(spectra), float(ratio[worst]), float(periods[worst]), float(ratio[0]))
