# SPDX-License-Identifier: GPL-3.0-or-later
"""NTC 2018 with Circolare 7 of 21 January 2019, C8.7.1.2.1: local mechanisms of existing masonry by accelerations and displacements."""

from __future__ import annotations

import math

from masonry_cd.analysis.code_check.code import Code
from masonry_cd.analysis.code_check.floors import Floor
from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.steps import Clauses, CodeCheck, Step, capacity, no_end
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import CheckResult
from masonry_cd.analysis.limit.oscillator import Oscillator

EDITION = "NTC 2018 with Circolare 7/2019"
AT = Clauses("[C8.7.1.1]", "[C8.7.1.5]", "C8.7.1.2.1.3", "[C8.7.1.3]", "[C8.7.1.4]")
LC1 = 1.35  # FC of the lowest level of knowledge
LIMITS = {"SLV": (0.4, 1.68, "[C8.7.1.10]", 0.08), "SLC": (0.6, 1.56, "[C8.7.1.11]", 0.10)}  # of d0, factor and clause of T, damping


def check(table: CheckTable, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """Check a mechanism."""
    steps = capacity(oscillator, table.confidence_factor, AT)
    starts = _asked_at_once(table, ground, steps)
    verdicts, notes = [], []
    borne = oscillator.acceleration() / table.confidence_factor
    if table.limit_state != "SLC":
        verdicts.append(_linear(table, starts, borne, steps))
    if table.by_displacements and oscillator.falls:
        verdicts.append(_non_linear(table, oscillator, ground, borne / starts, steps))
    elif table.by_displacements:
        notes.append(no_end(oscillator))
    return CodeCheck(
        "NTC2018", EDITION, table.limit_state, ground.words, tuple(steps), tuple(verdicts), tuple(notes), left_open=left_open(table)
    )


def left_open(table: CheckTable) -> tuple[str, ...]:
    """What the clauses leave to the engineer, and what was taken."""
    factor = f"FC = {table.confidence_factor:g}"
    asked = "alpha0 does not account for the compressive strength, for which C8.7.1.2.1.3 asks for the 1.35 of LC1"
    out = [f"{factor}: {asked}" if table.confidence_factor == LC1 else f"{factor} as given: where {asked}"]
    if not table.height:
        if not table.building:
            out.append("not looked at: the motion at a height of the building (C7.2.3), the mechanism counts as held at the ground")
        return tuple(out)
    ratio = 1.1 / math.sqrt(table.building_damping)
    out.append(
        f"[C7.2.6]: xi1 is taken as a ratio, 1.1 xi1^-0.5 = {ratio:.3g}; the text says per cent, which makes it {0.1 * ratio:.2g}, less in "
        "resonance than at rest"
    )
    out.append("not looked at: the second and higher modes of the building ([C7.2.5]), whose shares add to SeZ")
    return tuple(out)


def _asked_at_once(table: CheckTable, ground: Ground, steps: list[Step]) -> float:
    """The acceleration that is asked of a mechanism which must not start [m/s2]."""
    steps.append(Step("ag S", ground.peak, "m/s2", ground.clause, "peak acceleration of the ground"))
    free = table.element_period
    if not table.height:
        if free is None:
            return ground.peak
        asked = ground.acceleration(free)
        steps.append(Step("Se(T0)", asked, "m/s2", "[C8.7.1.9]", f"of a part that is free to vibrate, T0 = {free:g} s"))
        return asked
    floor = Floor.of(table, ground)
    steps.append(Step("T1", floor.period, "s", "C7.2.3", "period of the building"))
    steps.append(Step("Se(T1, xi1)", ground.acceleration(floor.period, floor.damping), "m/s2", "[C7.2.7]", f"xi1 = {floor.damping:g}"))
    steps.append(Step("gamma1", table.gamma, "", "[C7.2.10]", "participation of its first mode"))
    steps.append(Step("psi1(z)", table.share, "", "C7.2.3", "mode at the height of the mechanism, z / H"))
    steps.append(Step("aZ", floor.peak, "m/s2", "[C7.2.7], [C7.2.8]", "peak acceleration at that height"))
    if free is None:
        return max(floor.peak, ground.peak)
    asked = floor.acceleration(free, 0.05)
    steps.append(Step("SeZ(T0)", asked, "m/s2", "[C7.2.5], [C7.2.6]", f"of a part that is free to vibrate, T0 = {free:g} s"))
    return max(asked, ground.peak)


def _linear(table: CheckTable, asked: float, borne: float, steps: list[Step]) -> CheckResult:
    """By accelerations; at SLV they are divided by q."""
    if table.limit_state == "SLD":
        return CheckResult("linear", asked, borne, "m/s2", "C8.7.1.2.1.5")
    steps.append(Step("q", table.behaviour_factor, "", "C8.7.1.2.1.7", "behaviour factor"))
    asked /= table.behaviour_factor
    steps.append(Step("a asked", asked, "m/s2", "C8.7.1.2.1.7", "the acceleration over q"))
    return CheckResult("linear", asked, borne, "m/s2", "C8.7.1.2.1.7")


def _non_linear(table: CheckTable, oscillator: Oscillator, ground: Ground, unmoved: float, steps: list[Step]) -> CheckResult:
    """By displacements, at SLV or SLC."""
    state = table.limit_state
    share, factor, clause, damping = LIMITS[state]
    ultimate = share * oscillator.last
    there = oscillator.acceleration(ultimate) / table.confidence_factor
    period = factor * math.pi * math.sqrt(ultimate / there)
    steps.append(Step(f"d{state}", ultimate, "m", "C8.7.1.2.1.6", f"displacement borne, {share:g} d0*"))
    steps.append(Step(f"a(d{state})", there, "m/s2", "[C8.7.1.3]", "capacity at that displacement"))
    steps.append(Step(f"T{state}", period, "s", clause, f"equivalent period, {factor:g} pi sqrt(d / a)"))
    steps.append(Step("xi", damping, "", "C8.7.1.2.1.8", "equivalent damping of the mechanism"))
    if table.height:
        asked, by = Floor.of(table, ground).displacement(period, damping), "[C8.7.1.12]"
    else:
        asked, by = ground.furthest(table.element_period or 0.0, period, damping), "C8.7.1.2.1.8"
    steps.append(Step("d asked", asked, "m", by, "displacement asked for at that period"))
    return CheckResult("non-linear", asked, ultimate, "m", "C8.7.1.2.1.8", unmoved)


CODES = {
    "NTC2018": Code(check, "C7.2.3", ("SLD", "SLV", "SLC"), ("SLV", "SLC"), storeys=True, parts_vibrate="anywhere", left_open=left_open)
}
