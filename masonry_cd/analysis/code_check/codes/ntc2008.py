# SPDX-License-Identifier: GPL-3.0-or-later
"""NTC 2008 with Circolare 617 of 2 February 2009, appendix C8A.4: the older wording of the Italian check of local mechanisms."""

from __future__ import annotations

import math

from masonry_cd.analysis.code_check.code import Code
from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.steps import Clauses, CodeCheck, Step, capacity, no_end
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import CheckResult
from masonry_cd.analysis.limit.oscillator import Oscillator

EDITION = "NTC 2008 with Circolare 617/2009"
CLAUSE = "C8A.4"
AT = Clauses(*5 * (CLAUSE,))
ULTIMATE, SECANT = 0.4, 0.4  # du* over d0*, ds* over du*


def check(table: CheckTable, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """Check a mechanism at SLD by accelerations, at SLV by accelerations over q and by displacements."""
    steps, verdicts, notes = capacity(oscillator, table.confidence_factor, AT), [], []
    asked = _asked(table, ground, steps)
    borne = oscillator.acceleration() / table.confidence_factor
    if table.limit_state == "SLD":
        verdicts.append(CheckResult("linear", asked, borne, "m/s2", CLAUSE))
    else:
        steps.append(Step("q", table.behaviour_factor, "", CLAUSE, "behaviour factor"))
        asked /= table.behaviour_factor
        steps.append(Step("a asked", asked, "m/s2", CLAUSE, "the acceleration over q"))
        verdicts.append(CheckResult("linear", asked, borne, "m/s2", CLAUSE))
        if table.by_displacements and oscillator.falls:
            verdicts.append(_non_linear(table, oscillator, ground, steps))
        elif table.by_displacements:
            notes.append(no_end(oscillator))
    return CodeCheck("NTC2008", EDITION, table.limit_state, ground.words, tuple(steps), tuple(verdicts), tuple(notes))


def _asked(table: CheckTable, ground: Ground, steps: list[Step]) -> float:
    """The acceleration asked for, before q: that of the ground, above it also Se(T1) psi(Z) gamma [m/s2]."""
    steps.append(Step("ag S", ground.peak, "m/s2", ground.clause, "peak acceleration of the ground"))
    if not table.height:
        return ground.peak
    assert table.building_period is not None
    there = ground.acceleration(table.building_period)
    raised = there * table.share * table.gamma
    steps.append(Step("T1", table.building_period, "s", CLAUSE, "period of the building"))
    steps.append(Step("Se(T1)", there, "m/s2", CLAUSE, "elastic spectrum at that period"))
    steps.append(Step("psi(Z)", table.share, "", CLAUSE, "mode at the height of the mechanism, Z / H"))
    steps.append(Step("gamma", table.gamma, "", CLAUSE, "participation of the mode"))
    steps.append(Step("Se psi gamma", raised, "m/s2", CLAUSE, "acceleration at that height"))
    return max(raised, ground.peak)


def _non_linear(table: CheckTable, oscillator: Oscillator, ground: Ground, steps: list[Step]) -> CheckResult:
    """By the secant period at ds* = 0.4 du*, du* = 0.4 d0*."""
    ultimate = ULTIMATE * oscillator.last
    secant = SECANT * ultimate
    there = oscillator.acceleration(secant) / table.confidence_factor
    period = 2.0 * math.pi * math.sqrt(secant / there)
    steps.append(Step("du*", ultimate, "m", CLAUSE, "displacement borne, 0.4 d0*"))
    steps.append(Step("ds*", secant, "m", CLAUSE, "0.4 du*"))
    steps.append(Step("as*", there, "m/s2", CLAUSE, "capacity at ds*"))
    steps.append(Step("Ts", period, "s", CLAUSE, "secant period, 2 pi sqrt(ds* / as*)"))
    asked = ground.furthest(period, period)
    steps.append(Step("SDe(Ts)", asked, "m", CLAUSE, "displacement of the elastic spectrum"))
    if table.height:
        first = table.building_period or 0.0
        ratio = period / first
        raised = ground.furthest(first, first) * table.share * table.gamma * ratio**2 / math.sqrt((1.0 - ratio) ** 2 + 0.02 * ratio)
        words = "at the height: SDe(T1) psi gamma (Ts/T1)^2 / sqrt((1 - Ts/T1)^2 + 0.02 Ts/T1)"
        steps.append(Step("d raised", raised, "m", CLAUSE, words))
        asked = max(asked, raised)
    return CheckResult("non-linear", asked, ultimate, "m", CLAUSE)


CODES = {"NTC2008": Code(check, CLAUSE, ("SLD", "SLV"), ("SLV",), storeys=True)}
