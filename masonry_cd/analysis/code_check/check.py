# SPDX-License-Identifier: GPL-3.0-or-later
"""A mechanism checked by the code that a scene names."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from masonry_cd.analysis.code_check.borne import Borne, just_borne
from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.level import Level
from masonry_cd.analysis.code_check.steps import BUILDING, CodeCheck, Step
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import NO_SEARCH
from masonry_cd.analysis.limit.oscillator import Oscillator

ZETA = "NTC 2018, 8.3"
BORNE = "acceleration that is just borne"  # a part of the check


def check_at(table: CheckTable, level: Level, oscillator: Oscillator, ground: Ground, doubt: str = NO_SEARCH) -> CodeCheck:
    """Check a mechanism that is held at a level; "satisfied" does not follow where there is a ``doubt``, or one of its level."""
    made = _checked(table.at(level.counted), oscillator, ground, level.doubt or doubt)
    own = Step("z", level.height, "m", table.by.height, level.words, part=BUILDING)
    return replace(made, steps=(own, *(step for step in made.steps if step.symbol != own.symbol)), level=level)


def with_borne(made: CodeCheck, table: CheckTable, level: Level, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """A check with the acceleration of the ground that each of its verdicts just meets, a search of some twenty checks, and its steps."""
    there = table.at(level.counted)

    def met(ag: float, k: int) -> float:
        return _checked(there, oscillator, ground.scaled(ag)).verdicts[k].met

    found = [just_borne(one.check, partial(met, k=k), ground.ag) for k, one in enumerate(made.verdicts)]
    return replace(made, borne=tuple(found), steps=(*made.steps, *(step for one in found for step in _steps(one))))


def _checked(table: CheckTable, oscillator: Oscillator, ground: Ground, doubt: str = "") -> CodeCheck:
    """The check by the code of a table; gravity is that of the mechanism in all formulas."""
    made: CodeCheck = table.by.check(table, oscillator, ground.under(oscillator.gravity))
    return replace(made, verdicts=tuple(replace(one, doubt=doubt) for one in made.verdicts))


def _steps(one: Borne) -> list[Step]:
    """PGA_C, PGA_D and zeta_E of a check; none where every ag is borne."""
    if one.borne is None or one.share is None:
        return []
    return [
        Step("PGA_D", one.asked, "m/s2", ZETA, "peak acceleration on rock that is asked for; of a record its own", part=BORNE),
        Step("PGA_C", one.borne, "m/s2", ZETA, f"that of the motion which the {one.check} check just bears", part=BORNE),
        Step("zeta_E", one.share, "", ZETA, "of both", "PGA_C / PGA_D", BORNE),
    ]
