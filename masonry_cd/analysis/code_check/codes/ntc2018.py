# SPDX-License-Identifier: GPL-3.0-or-later
"""NTC 2018 with Circolare 7 of 21 January 2019, C8.7.1.2.1: local mechanisms of existing masonry by accelerations and displacements."""

from __future__ import annotations

import math

import numpy as np

from loads.signal.spectra.shape import damping_factor
from masonry_cd.analysis.code_check.code import Code
from masonry_cd.analysis.code_check.floors import ROWS as FLOOR_ROWS
from masonry_cd.analysis.code_check.floors import Floor
from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.steps import (
    BUILDING,
    CodeCheck,
    CodeQuantity,
    Working,
    capacity_rows,
    linear,
    no_end,
    no_ordinate,
    put_capacity,
)
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import LINEAR, NON_LINEAR, CheckResult
from masonry_cd.analysis.limit.oscillator import Oscillator

EDITION = "NTC 2018 with Circolare 7/2019"
LC1 = 1.35  # FC of the lowest level of knowledge
LIMITS = {"SLV": (0.4, 1.68, "[C8.7.1.10]", 0.08), "SLC": (0.6, 1.56, "[C8.7.1.11]", 0.10)}  # of d0, factor and clause of T, damping
FREE = 0.05  # damping of a part that is free to vibrate
AT_SLD, AT_SLV, BY_DISPLACEMENTS = "C8.7.1.2.1.5", "C8.7.1.2.1.7", "C8.7.1.2.1.8"


def _rows(state: str) -> dict[str, CodeQuantity]:
    """The quantities of the check by displacements at a limit state."""
    share, factor, clause, _ = LIMITS[state]
    return {
        f"d{state}": CodeQuantity("m", "C8.7.1.2.1.6", "displacement borne", f"{share:g} d0*"),
        f"alpha(d{state})": CodeQuantity("", "[C8.7.1.3]", "load factor left at that displacement, by the capacity curve"),
        f"a(d{state})": CodeQuantity("m/s2", "[C8.7.1.3]", "capacity at that displacement", f"alpha(d{state}) g / (e* CF)"),
        f"T{state}": CodeQuantity("s", clause, "equivalent period", f"{factor:g} pi sqrt(d{state} / a(d{state}))"),
    }


TABLE = (
    capacity_rows("[C8.7.1.1]", "[C8.7.1.5]", "C8.7.1.2.1.3", "[C8.7.1.3]", "[C8.7.1.4]")
    | FLOOR_ROWS
    | _rows("SLV")
    | _rows("SLC")
    | {
        "T0": CodeQuantity("s", "[C8.7.1.9]", "period of a part that is free to vibrate"),
        "Se(T0)": CodeQuantity("m/s2", "[C8.7.1.9]", "asked of a part that is free to vibrate"),
        "q": CodeQuantity("", AT_SLV, "behaviour factor"),
        "a asked": CodeQuantity("m/s2", AT_SLV, "acceleration required"),
        "a0* / a": CodeQuantity("", BY_DISPLACEMENTS, "from 1 on the mechanism does not start, which is enough"),
        "xi": CodeQuantity("", BY_DISPLACEMENTS, "equivalent damping of the mechanism"),
        "d asked": CodeQuantity("m", BY_DISPLACEMENTS, "displacement required at that period"),
    }
)


def check(table: CheckTable, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """Check a mechanism."""
    made, verdicts, notes, unread = Working(ground.rows, TABLE), list[CheckResult](), list[str](), ""
    starts = put_capacity(made, oscillator, table.confidence_factor)
    ground.put(made)
    asked, formula = _asked_at_once(table, ground, made)
    if table.limit_state != "SLC":
        verdicts.append(_linear(table, oscillator, made, (asked, formula), starts))
    if table.checks_displacements and oscillator.falls:
        made.part = NON_LINEAR
        unmoved = made.put("a0* / a", starts / asked, f"a0* / {formula}")
        found = _non_linear(table, oscillator, ground, made, unmoved)
        verdicts += [found] if isinstance(found, CheckResult) else []
        unread = found if isinstance(found, str) else ""
    elif table.checks_displacements:
        notes.append(no_end(oscillator))
    facts = (table.limit_state, ground.words, tuple(made.steps), tuple(verdicts), tuple(notes))
    return CodeCheck("NTC2018", EDITION, *facts, left_open=left_open(table)).without_displacements(unread)


def left_open(table: CheckTable) -> tuple[str, ...]:
    """Points that the clauses leave to the engineer, and what was taken."""
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


def _asked_at_once(table: CheckTable, ground: Ground, made: Working) -> tuple[float, str]:
    """The acceleration that is asked of a mechanism which must not start [m/s2], and its formula."""
    free = table.element_period
    if not table.height:
        if free is None:
            return ground.peak, "ag S"
        made.part = LINEAR
        made.put("T0", free)
        return made.put("Se(T0)", ground.acceleration(free), ground.formula(free, "T0", False)), "Se(T0)"
    floor = Floor.of(table, ground)
    made.part = BUILDING
    made.put("z", table.height)
    made.put("H", table.building_height or 0.0)
    made.put("T1", floor.period)
    made.put("xi1", floor.damping)
    made.put("eta1", damping_factor(floor.damping))
    there = ground.formula(floor.period, "T1", True).replace("eta", "eta1")
    made.put("Se(T1, xi1)", ground.acceleration(floor.period, floor.damping), there)
    if table.participation is None:
        made.put("n", table.storeys or 1)
    made.put("gamma1", table.gamma, "3 n / (2 n + 1)" if table.participation is None else "")
    made.put("psi1(z)", table.share)
    made.put("aZ", floor.peak)
    if free is None:
        return max(floor.peak, ground.peak), "max(aZ, ag S)"
    made.part = LINEAR
    made.put("T0", free)
    made.put("xi", FREE, meaning="damping of the part")
    return max(floor.put(made, free, FREE, "T0"), ground.peak), "max(SeZ(T0), ag S)"


def _linear(table: CheckTable, oscillator: Oscillator, made: Working, asked: tuple[float, str], starts: float) -> CheckResult:
    """The check by accelerations; at SLV they are divided by q."""
    made.part = LINEAR
    (demand, formula), free = asked, table.element_period or 0.0
    if table.limit_state == "SLD":
        return linear(oscillator, made.put("a asked", demand, formula), starts, AT_SLD, 1.0, free)
    q = made.put("q", table.behaviour_factor)
    return linear(oscillator, made.put("a asked", demand / q, f"{formula} / q"), starts, AT_SLV, q, free)


def _non_linear(table: CheckTable, oscillator: Oscillator, ground: Ground, made: Working, unmoved: float) -> CheckResult | str:
    """The check by displacements, at SLV or SLC; or why the spectrum does not answer it."""
    state = table.limit_state
    share, factor, _, damping = LIMITS[state]
    borne, of = f"d{state}", f"T{state}"
    ultimate = made.put(borne, share * oscillator.last)
    made.put(f"alpha({borne})", oscillator.load_factor(ultimate))
    there = made.put(f"a({borne})", oscillator.acceleration(ultimate) / table.confidence_factor)
    period = made.put(of, factor * math.pi * math.sqrt(ultimate / there))
    made.put("xi", damping)
    if period > ground.longest:
        return no_ordinate(of, period, ground.longest)
    if table.height:
        asked, formula = Floor.of(table, ground).displaced(made, period, damping, of)
    else:
        asked, formula = ground.displaced(made, (table.element_period or 0.0, period), damping, of)
    made.put("d asked", asked, formula)
    return CheckResult(NON_LINEAR, asked, ultimate, "m", BY_DISPLACEMENTS, unmoved, period=period, damping=damping)


def raised(table: CheckTable, ground: Ground, periods: np.ndarray, damping: float) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration [m/s2] and displacement [m] required at the height of a table, (n,) each."""
    floor = Floor.of(table, ground)
    found, displaced = floor.spectrum_at(periods, damping)
    return np.maximum(found, ground.peak), displaced


CODES = {
    "NTC2018": Code(
        check, "C7.2.3", ("SLD", "SLV", "SLC"), ("SLV", "SLC"), storeys=True, parts_vibrate="anywhere", left_open=left_open, raised=raised
    )
}
