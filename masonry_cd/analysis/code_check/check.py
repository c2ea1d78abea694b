# SPDX-License-Identifier: GPL-3.0-or-later
"""A mechanism checked by the code that a scene names."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from masonry_cd.analysis.code_check.ground import Ground, ground_of
from masonry_cd.analysis.code_check.level import Level
from masonry_cd.analysis.code_check.steps import CodeCheck, Step
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import Basis
from masonry_cd.analysis.limit.oscillator import Oscillator


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
    made: CodeCheck = table.by.check(table, oscillator, ground_of(table, folder))
    return made.resting_on(basis or Basis())


def check_at(table: CheckTable, level: Level, oscillator: Oscillator, ground: Ground, basis: Basis) -> CodeCheck:
    """Check a mechanism that is held at a level."""
    made: CodeCheck = table.by.check(table.at(level.counted), oscillator, ground)
    steps = (Step("z", level.height, "m", table.by.height, level.words), *made.steps)
    return replace(made, steps=steps, level=level).resting_on(replace(basis, doubt=level.doubt or basis.doubt))
