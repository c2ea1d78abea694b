# SPDX-License-Identifier: GPL-3.0-or-later
"""Eurocode 8: the force on a part by EN 1998-1:2004, 4.3.5.2, against the factor of the mechanism over the confidence factor of EN 1998-3.

EN 1998-3:2005 has no method for mechanisms of rigid bodies; how a mechanism becomes an acceleration is that of the Italian Circolare.
"""

from __future__ import annotations

from masonry_cd.analysis.code_check.code import Code
from masonry_cd.analysis.code_check.floors import part_acceleration
from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.steps import Clauses, CodeCheck, Step, capacity
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import CheckResult
from masonry_cd.analysis.limit.oscillator import Oscillator

EDITION = "EN 1998-1:2004, 4.3.5.2, with EN 1998-3:2005"
BY_ITALY = "Circolare 7/2019"
AT = Clauses(f"{BY_ITALY} [C8.7.1.1]", f"{BY_ITALY} [C8.7.1.5]", "EN 1998-3, table 3.1", f"{BY_ITALY} [C8.7.1.3]", f"{BY_ITALY} [C8.7.1.4]")
PART = "EN 1998-1, 4.3.5.2"


def check(table: CheckTable, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """Check a mechanism by accelerations; there is no check by displacements."""
    steps = capacity(oscillator, table.confidence_factor, AT)
    own = table.element_period or 0.0
    ratio = own / table.building_period if table.building_period else 0.0
    raised = part_acceleration(ground.peak, table.share, ratio) if table.height else ground.peak
    asked = raised / table.behaviour_factor
    steps.append(Step("ag S", ground.peak, "m/s2", ground.clause, "peak acceleration of the ground"))
    if table.height:
        steps.append(Step("z/H", table.share, "", PART, "height of the mechanism over that of the building"))
        steps.append(Step("Ta/T1", ratio, "", PART, "period of the part over that of the building"))
    steps.append(Step("Sa g", raised, "m/s2", PART, "acceleration of the part"))
    steps.append(Step("qa", table.behaviour_factor, "", "EN 1998-1, 4.3.5.4", "behaviour factor of the part"))
    steps.append(Step("a asked", asked, "m/s2", PART, "acceleration over qa, the importance factor of the part being 1"))
    note = "Eurocode 8 of 2004 and 2005 has no check by displacements of such mechanisms"
    verdict = CheckResult("linear", asked, oscillator.acceleration() / table.confidence_factor, "m/s2", PART)
    return CodeCheck("EC8", EDITION, "", ground.words, tuple(steps), (verdict,), (note,))


CODES = {"EC8": Code(check, PART, parts_vibrate="above the ground")}
