# SPDX-License-Identifier: GPL-3.0-or-later
"""The spectra from which the demands of a check are read, as curves over the period."""

from __future__ import annotations

import numpy as np

from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.steps import CodeCheck
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import LINEAR, CheckResult, CheckSpectrum

COUNT = 400  # of periods
FURTHER = 1.25  # over the period at which the demand is read, where the curves end
LEAST_END = 1.5  # [s]


def spectra(made: CodeCheck, table: CheckTable, ground: Ground, gravity: float) -> tuple[CheckSpectrum, ...]:
    """The spectra of a check at its level, one for each of its verdicts; gravity [m/s2]."""
    assert made.level is not None
    there = table.at(made.level.counted)
    return tuple(_spectrum(one, there, ground.under(gravity)) for one in made.verdicts)


def _spectrum(check: CheckResult, table: CheckTable, ground: Ground) -> CheckSpectrum:
    """The spectrum of a check; its periods include the one of the check."""
    end = min(ground.longest, max(LEAST_END, FURTHER * check.period, FURTHER * (table.building_period or 0.0) if table.height else 0.0))
    periods = np.union1d(np.linspace(0.0, end, COUNT), [check.period])
    which = 0 if check.check == LINEAR else 1
    by = table.by.raised if table.height else None
    raised = None if by is None else by(table, ground, periods, check.damping)[which]
    return CheckSpectrum(check, periods, ground.spectrum_at(periods, check.damping)[which], raised)
