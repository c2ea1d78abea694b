# SPDX-License-Identifier: GPL-3.0-or-later
"""A mechanism checked by the code that a scene names."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from masonry_cd.analysis.code_check import ec8, ntc2008, ntc2018
from masonry_cd.analysis.code_check.ground import Ground, ground_of
from masonry_cd.analysis.code_check.level import Level
from masonry_cd.analysis.code_check.steps import CodeCheck, Step
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import Basis
from masonry_cd.analysis.limit.oscillator import Oscillator

CODES = {"NTC2018": ntc2018.check, "NTC2008": ntc2008.check, "EC8": ec8.check}
HEIGHT = {"NTC2018": "C7.2.3", "NTC2008": ntc2008.CLAUSE, "EC8": ec8.PART}  # clauses that count it


def code_check(table: CheckTable, oscillator: Oscillator, folder: Path, basis: Basis | None = None) -> CodeCheck:
    """Check a mechanism.

    Args:
        table: what is asked.
        oscillator: of the mechanism.
        folder: from which the path of a record is read.
        basis: what it rests on; without one, nothing is "satisfied".

    Raises:
        InputError: a record that cannot be read.
    """
    return CODES[table.code](table, oscillator, ground_of(table, folder)).resting_on(basis or Basis())


def check_at(table: CheckTable, level: Level, oscillator: Oscillator, ground: Ground, basis: Basis) -> CodeCheck:
    """Check a mechanism that is held at a level."""
    made = CODES[table.code](table.at(level.counted), oscillator, ground)
    steps = (Step("z", level.height, "m", HEIGHT[table.code], level.words), *made.steps)
    return replace(made, steps=steps, level=level).resting_on(replace(basis, doubt=level.doubt or basis.doubt))
