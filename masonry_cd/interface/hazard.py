# SPDX-License-Identifier: GPL-3.0-or-later
"""The hazard of a site in Python, with or without a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.hazard import frequency as rates
from masonry_cd.analysis.hazard.curve import Hazard as Curve
from masonry_cd.analysis.hazard.curve import HazardRow, Period
from masonry_cd.analysis.hazard.life import PROBABILITY
from masonry_cd.analysis.hazard.table import HazardTable, hazard_of
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.values import plain


class Hazard(Sealed):
    """How often a year an intensity is exceeded at a site, from arrays or a file: the keys of the table ``[hazard]``.

    ``mc.Hazard(return_period=years, ag=peaks)``, ``mc.Hazard(measure="Sa(0.5)", intensity=levels, frequency=often)``, and
    ``mc.Hazard(path="hazard.csv", lon=13.4, lat=42.35)``, relative to the working folder.

    Raises:
        InputError: an unknown key, rows that are no hazard, a file that cannot be read.

    >>> import masonry_cd as mc
    >>> site = mc.Hazard(return_period=[50, 475, 975], ag=["0.1 g", "0.25 g", "0.32 g"])
    >>> site.return_period(0.25 * 9.80665).words
    '475 years'
    >>> site.return_period(5.0)
    Period(years=975.0, bound='>=')
    """

    def __init__(self, **keys: Any) -> None:
        self._curve: Curve = hazard_of(parse_table(HazardTable, plain(keys, "hazard"), "hazard"), Path())
        if not self._curve.known:
            raise InputError("hazard", "needs rows: return_period and ag, intensity and frequency, or path")

    @property
    def measure(self) -> str:
        """Intensity measure; of a table of return periods PGA on rock."""
        return self._curve.measure

    @property
    def intensities(self) -> np.ndarray:
        """(n,) of the rows, rising, SI."""
        return self._curve.intensity.copy()

    @property
    def frequencies(self) -> np.ndarray:
        """(n,) of the rows, falling [1/year]."""
        return self._curve.frequency.copy()

    def return_period(self, intensity: float) -> Period:
        """The return period of an intensity: ``years``, with ``bound`` ">=" or "<=" beyond the rows."""
        return self._curve.return_period(intensity)

    def at(self, return_period: float) -> HazardRow:
        """The ``intensity`` of a return period [years], and ``f0`` and ``tc_star`` where the rows have them.

        Raises:
            InputError: a return period beyond the rows.
        """
        return self._curve.at(return_period)

    def of_limit_state(self, state: str) -> HazardRow:
        """Return the row that NTC asks for at "SLO", "SLD", "SLV" or "SLC", by the nominal life and the class of use.

        Raises:
            InputError: another one, or a return period beyond the rows.
        """
        if state not in PROBABILITY:
            raise InputError("state", f'"{state}" is none of {", ".join(PROBABILITY)}')
        return self._curve.at(self._curve.life.return_period(state))

    def frequency(self, theta: float, beta: float) -> tuple[float, float]:
        """The mean annual frequency at which a lognormal fragility is exceeded: least and most, which differ as far as the rows end within
        what contributes [1/year].

        Args:
            theta: median, SI.
            beta: standard deviation of its logarithm.

        Raises:
            InputError: numbers that are not above zero.
        """
        if not theta > 0.0 or not beta > 0.0:
            raise InputError("theta" if not theta > 0.0 else "beta", "should be above 0")
        found = rates.frequency(self._curve, np.array([theta]), np.array([beta]))
        return float(found.least[0]), float(found.most[0])

    def __str__(self) -> str:
        return self._curve.words

    def __repr__(self) -> str:
        return f"<Hazard of {self.measure}: {self._curve.words.partition(': ')[2]}>"
