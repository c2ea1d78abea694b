# SPDX-License-Identifier: GPL-3.0-or-later
"""A mechanism checked by the code that a scene names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from masonry_cd.analysis.code_check.borne import Borne, just_borne
from masonry_cd.analysis.code_check.ground import CodeGround, Ground
from masonry_cd.analysis.code_check.level import HeldLevel
from masonry_cd.analysis.code_check.site import BORNE, HAZARD, RISK, period_steps, with_site
from masonry_cd.analysis.code_check.steps import BUILDING, CodeCheck, Step
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import NO_SEARCH
from masonry_cd.analysis.hazard.curve import Hazard, HazardRow
from masonry_cd.analysis.limit.oscillator import Oscillator

ZETA = "NTC 2018, 8.3"


def check_at(table: CheckTable, level: HeldLevel, oscillator: Oscillator, ground: Ground, doubt: str = NO_SEARCH) -> CodeCheck:
    """Check a mechanism that is held at a level; "satisfied" does not follow where there is a ``doubt``, or one of its level."""
    made = _checked(table.at(level.counted), oscillator, ground, level.doubt or doubt)
    own = Step("z", level.height, "m", table.by.height, level.words, part=BUILDING)
    return replace(made, steps=(own, *(step for step in made.steps if step.symbol != own.symbol)), level=level)


def with_borne(made: CodeCheck, table: CheckTable, level: HeldLevel, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """A check with the acceleration of the ground that each of its verdicts just meets, a search of some twenty checks, and its steps.

    Where the hazard of the site is known, with its return period and the class of risk.
    """
    hazard = ground.hazard if isinstance(ground, CodeGround) else None
    found = _just_borne(made, table.at(level.counted), oscillator, ground)
    if hazard is not None:
        found = [one if one.borne is None else replace(one, period=hazard.return_period(one.borne)) for one in found]
    made = replace(made, borne=tuple(found), steps=(*made.steps, *(step for one in found for step in _steps(one, hazard))))
    if hazard is None:
        return made

    def search(state: str, row: HazardRow) -> Sequence[Borne]:
        of_row = {"ag": row.intensity, "f0": row.f0, "tc_star": row.tc_star}
        other = table.model_copy(update={"limit_state": state} | {key: value for key, value in of_row.items() if value is not None})
        if state not in table.by.limit_states or (state == "SLC" and not other.checks_displacements):
            return ()
        there, motion = other.at(level.counted), CodeGround(other, hazard=hazard)
        return _just_borne(_checked(there, oscillator, motion), there, oscillator, motion)

    return with_site(made, table, hazard, search)


def borne_by_another(made: CodeCheck, other: CodeCheck, note: str) -> CodeCheck:
    """A check with what another mechanism just bears, its return period and class of risk, and a ``note`` that says so."""
    asked = tuple(step for step in other.steps if step.part == HAZARD)
    added = tuple(step for step in other.steps if step.part in (BORNE, RISK))
    notes, left_open = (tuple(dict.fromkeys(both)) for both in ((*made.notes, *other.notes, note), (*made.left_open, *other.left_open)))
    return replace(made, borne=other.borne, risk=other.risk, steps=(*asked, *made.steps, *added), notes=notes, left_open=left_open)


def _just_borne(made: CodeCheck, table: CheckTable, oscillator: Oscillator, ground: Ground) -> list[Borne]:
    """Return the acceleration that each verdict of a check just meets."""

    def met(ag: float, k: int) -> float:
        return _checked(table, oscillator, ground.scaled(ag)).verdicts[k].met

    return [just_borne(one.check, partial(met, k=k), ground.ag) for k, one in enumerate(made.verdicts)]


def _checked(table: CheckTable, oscillator: Oscillator, ground: Ground, doubt: str = "") -> CodeCheck:
    """The check by the code of a table; gravity is that of the mechanism in all formulas."""
    made: CodeCheck = table.by.check(table, oscillator, ground.under(oscillator.gravity))
    return replace(made, verdicts=tuple(replace(one, doubt=doubt) for one in made.verdicts))


def _steps(one: Borne, hazard: Hazard | None) -> list[Step]:
    """PGA_C, PGA_D and zeta_E of a check, and the return period where the hazard is known; none where every ag is borne."""
    if one.borne is None or one.share is None:
        return []
    return [
        Step("PGA_D", one.asked, "m/s2", ZETA, "peak acceleration on rock that is required; of a record its own", part=BORNE),
        Step("PGA_C", one.borne, "m/s2", ZETA, f"that of the motion which the {one.check} check just bears", part=BORNE),
        Step("zeta_E", one.share, "", ZETA, "of both", "PGA_C / PGA_D", BORNE),
        *([] if hazard is None else period_steps(hazard, one)),
    ]
