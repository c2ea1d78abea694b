# SPDX-License-Identifier: GPL-3.0-or-later
"""NTC 2008 with Circolare 617 of 2 February 2009, appendix C8A.4: the older wording of the Italian check of local mechanisms."""

from __future__ import annotations

import math

import numpy as np

from loads.signal.spectra.shape import USUAL_DAMPING
from masonry_cd.analysis.code_check.code import Code
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

EDITION = "NTC 2008 with Circolare 617/2009"
CLAUSE = "C8A.4"
ULTIMATE, SECANT = 0.4, 0.4  # du* over d0*, ds* over du*
TABLE = capacity_rows(*5 * (CLAUSE,)) | {
    "z": CodeQuantity("m", CLAUSE, "height at which the mechanism is held, above the foundation"),
    "H": CodeQuantity("m", CLAUSE, "height of the building"),
    "T1": CodeQuantity("s", CLAUSE, "period of the building"),
    "psi(Z)": CodeQuantity("", CLAUSE, "mode at the height of the mechanism", "z / H"),
    "n": CodeQuantity("", CLAUSE, "storeys"),
    "gamma": CodeQuantity("", CLAUSE, "participation of the mode"),
    "Se psi gamma": CodeQuantity("m/s2", CLAUSE, "acceleration at that height", "Se(T1) psi(Z) gamma"),
    "q": CodeQuantity("", CLAUSE, "behaviour factor"),
    "a asked": CodeQuantity("m/s2", CLAUSE, "acceleration required"),
    "du*": CodeQuantity("m", CLAUSE, "displacement borne", f"{ULTIMATE:g} d0*"),
    "ds*": CodeQuantity("m", CLAUSE, "at which the period is read", f"{SECANT:g} du*"),
    "alpha(ds*)": CodeQuantity("", CLAUSE, "load factor left there, by the capacity curve"),
    "as*": CodeQuantity("m/s2", CLAUSE, "capacity there", "alpha(ds*) g / (e* CF)"),
    "Ts": CodeQuantity("s", CLAUSE, "secant period", "2 pi sqrt(ds* / as*)"),
    "SDe(T)": CodeQuantity("m", CLAUSE, "displacement of the elastic spectrum"),
    "Ts/T1": CodeQuantity("", CLAUSE, "of both periods", "Ts / T1"),
    "d raised": CodeQuantity(
        "m", CLAUSE, "displacement at that height", "SDe(T1) psi(Z) gamma (Ts/T1)^2 / sqrt((1 - Ts/T1)^2 + 0.02 Ts/T1)"
    ),
    "d asked": CodeQuantity("m", CLAUSE, "displacement required"),
}  # fmt: skip


def check(table: CheckTable, oscillator: Oscillator, ground: Ground) -> CodeCheck:
    """Check a mechanism at SLD by accelerations, at SLV by accelerations over q and by displacements."""
    made, notes, unread = Working(ground.rows, TABLE), list[str](), ""
    starts = put_capacity(made, oscillator, table.confidence_factor)
    ground.put(made)
    asked, formula = _asked(table, ground, made)
    made.part = LINEAR
    q = 1.0 if table.limit_state == "SLD" else made.put("q", table.behaviour_factor)
    asked = made.put("a asked", asked / q, formula if table.limit_state == "SLD" else f"{formula} / q")
    verdicts = [linear(oscillator, asked, starts, CLAUSE, q)]
    if table.checks_displacements and oscillator.falls:
        found = _non_linear(table, oscillator, ground, made)
        verdicts += [found] if isinstance(found, CheckResult) else []
        unread = found if isinstance(found, str) else ""
    elif table.checks_displacements:
        notes.append(no_end(oscillator))
    facts = (table.limit_state, ground.words, tuple(made.steps), tuple(verdicts), tuple(notes))
    return CodeCheck("NTC2008", EDITION, *facts).without_displacements(unread)


def _asked(table: CheckTable, ground: Ground, made: Working) -> tuple[float, str]:
    """The acceleration required, before q: that of the ground, above it also Se(T1) psi(Z) gamma [m/s2]; and its formula."""
    if not table.height:
        return ground.peak, "ag S"
    assert table.building_period is not None and table.building_height is not None
    made.part = BUILDING
    made.put("z", table.height)
    made.put("H", table.building_height)
    first = made.put("T1", table.building_period)
    there = made.put("Se(T1)", ground.acceleration(first), ground.formula(first, "T1", False), like="Se(T)")
    share = made.put("psi(Z)", table.share)
    if table.participation is None:
        made.put("n", table.storeys or 1)
    gamma = made.put("gamma", table.gamma, "3 n / (2 n + 1)" if table.participation is None else "")
    return max(made.put("Se psi gamma", there * share * gamma), ground.peak), "max(Se psi gamma, ag S)"


def _non_linear(table: CheckTable, oscillator: Oscillator, ground: Ground, made: Working) -> CheckResult | str:
    """The check by displacements: by the secant period at ds* = 0.4 du*, du* = 0.4 d0*; or why the spectrum does not answer it."""
    made.part = NON_LINEAR
    ultimate = made.put("du*", ULTIMATE * oscillator.last)
    secant = made.put("ds*", SECANT * ultimate)
    made.put("alpha(ds*)", oscillator.load_factor(secant))
    there = made.put("as*", oscillator.acceleration(secant) / table.confidence_factor)
    period = made.put("Ts", 2.0 * math.pi * math.sqrt(secant / there))
    if period > ground.longest:
        return no_ordinate("Ts", period, ground.longest)
    asked, formula = _displaced(ground, made, period, "Ts"), "SDe(Ts)"
    if table.height:
        first = table.building_period or 0.0
        ratio = made.put("Ts/T1", period / first)
        raised = _displaced(ground, made, first, "T1") * table.share * table.gamma * resonance(ratio)
        asked = max(asked, made.put("d raised", raised))
        formula = "max(SDe(Ts), d raised)"
    return CheckResult(NON_LINEAR, made.put("d asked", asked, formula), ultimate, "m", CLAUSE, period=period)


def resonance(ratio: float) -> float:
    """(Ts/T1)^2 / sqrt((1 - Ts/T1)^2 + 0.02 Ts/T1) of a ratio of periods."""
    return ratio**2 / math.sqrt((1.0 - ratio) ** 2 + 0.02 * ratio)


def raised(table: CheckTable, ground: Ground, periods: np.ndarray, damping: float) -> tuple[np.ndarray, np.ndarray]:
    """Acceleration [m/s2] and displacement [m] required at the height of a table, (n,) each."""
    first, share = table.building_period or 1.0, table.share * table.gamma
    grown = np.array([resonance(ratio) for ratio in (periods / first).tolist()])
    there = max(ground.acceleration(first) * share, ground.peak)
    further = np.maximum(ground.furthest(first, first, damping) * share * grown, ground.spectrum_at(periods, damping)[1])
    return np.full(len(periods), there), further


def _displaced(ground: Ground, made: Working, period: float, of: str) -> float:
    """SDe at a period whose symbol is ``of`` [m], noted."""
    asked, formula = ground.displaced(made, (period, period), USUAL_DAMPING, of)
    return made.put(f"SDe({of})", asked, formula, like="SDe(T)")


CODES = {"NTC2008": Code(check, CLAUSE, ("SLD", "SLV"), ("SLV",), storeys=True, raised=raised)}
