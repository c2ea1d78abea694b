# SPDX-License-Identifier: GPL-3.0-or-later
"""A spectrum from which the demand of a check is read, as curves over the period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.code_check.verdicts import CheckResult


@dataclass(frozen=True, eq=False)
class Spectrum:
    """What one check is read from, in its unit: accelerations [m/s2] or displacements [m]."""

    check: CheckResult
    period: np.ndarray  # (n,) [s]
    ground: np.ndarray  # (n,)
    raised: np.ndarray | None  # (n,) asked for at the height of the mechanism; None on the ground, and where a code has none

    @property
    def asked(self) -> np.ndarray:
        """(n,) of which the value at the period of the check is asked for, before it is divided by q."""
        return self.ground if self.raised is None else self.raised

    @property
    def largest(self) -> int:
        """Where the largest value up to the period of the check is: with a record, what is asked for by displacements."""
        return int(np.argmax(self.asked[self.period <= self.check.period]))
