# SPDX-License-Identifier: GPL-3.0-or-later
"""A mechanism checked by the code that a scene names."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from masonry_cd.analysis.code_check.borne import Borne, just_borne
from masonry_cd.analysis.code_check.ground import Ground, ground_of
from masonry_cd.analysis.code_check.level import Level
from masonry_cd.analysis.code_check.steps import BUILDING, CodeCheck, Step
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import Basis
from masonry_cd.analysis.limit.oscillator import Oscillator

ZETA = "NTC 2018, 8.3"
BORNE = "acceleration that is just borne"  # a part of the check


def code_check(table: CheckTable, oscillator: Oscillator, folder: Path, basis: Basis | None = None) -> CodeCheck:
    """Check a mechanism at the height of its table, and find what it just bears.

    Args:
        table: what is asked.
        oscillator: of the mechanism.
        folder: from which the path of a record is read.
        basis: what it rests on; without one, nothing is "satisfied".

    Raises:
        InputError: a record that cannot be read.
    """
    ground = ground_of(table, folder)
    return _with_borne(_checked(table, oscillator, ground), table, oscillator, ground).resting_on(basis or Basis())


def check_at(table: CheckTable, level: Level, oscillator: Oscillator, ground: Ground, basis: Basis) -> CodeCheck:
    """Check a mechanism that is held at a level."""
    made = _checked(table.at(level.counted), oscillator, ground)
    own = Step("z", level.height, "m", table.by.height, level.words, part=BUILDING)
    steps = (own, *(step for step in made.steps if step.symbol != own.symbol))
    return replace(made, steps=steps, level=level).resting_on(replace(basis, doubt=level.doubt or basis.doubt))


def with_borne(made: CodeCheck, table: CheckTable, level: Level, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """A check with the acceleration of the ground that each of its verdicts just meets: a search of some twenty checks."""
    return _with_borne(made, table.at(level.counted), oscillator, ground)


def _checked(table: CheckTable, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """The check by the code of a table; gravity is that of the mechanism in all formulas."""
    made: CodeCheck = table.by.check(table, oscillator, ground.under(oscillator.gravity))
    return made


def _with_borne(made: CodeCheck, table: CheckTable, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """A check with the acceleration of the ground that each of its verdicts just meets, and the steps that say so."""

    def met(ag: float, k: int) -> float:
        return _checked(table, oscillator, ground.scaled(ag)).verdicts[k].met

    found = [just_borne(one.check, partial(met, k=k), ground.ag) for k, one in enumerate(made.verdicts)]
    return replace(made, borne=tuple(found), steps=(*made.steps, *(step for one in found for step in _steps(one))))


def _steps(one: Borne) -> list[Step]:
    """PGA_C, PGA_D and zeta_E of a check; none where every ag is borne."""
    if one.borne is None or one.share is None:
        return []
    return [
        Step("PGA_D", one.asked, "m/s2", ZETA, "peak acceleration on rock that is asked for; of a record its own", part=BORNE),
        Step("PGA_C", one.borne, "m/s2", ZETA, f"that of the motion which the {one.check} check just bears", part=BORNE),
        Step("zeta_E", one.share, "", ZETA, "of both", "PGA_C / PGA_D", BORNE),
    ]
