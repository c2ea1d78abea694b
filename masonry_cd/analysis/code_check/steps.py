# SPDX-License-Identifier: GPL-3.0-or-later
"""A check as values, one after the other, each with symbol, unit, clause and its formula with the numbers put in; and what they amount to.

A code has one table of its quantities. ``Working.put`` notes a value and returns it, so that the line shows what the check continues with:

    a0* = alpha0 g / (e* CF) = 0.15 x 9.81 / (1 x 1.35) = 1.09 m/s2
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from loads.signal.spectra.shape import CodeQuantity
from loads.signal.spectra.table import beyond
from masonry_cd.analysis.code_check.borne import Borne
from masonry_cd.analysis.code_check.level import HeldLevel
from masonry_cd.analysis.code_check.verdicts import LINEAR, CheckResult
from masonry_cd.analysis.hazard.risk import Risk
from masonry_cd.analysis.limit.oscillator import Oscillator

GROUND, MECHANISM, BUILDING = "motion of the ground", "mechanism", "building"  # parts of a check other than linear and non-linear
IN_FULL = 1e4  # from which on a number is written without a power of ten
PRODUCT = re.compile(r"(?<=[\w)]) (?=[\w(])")  # a space between two factors


@dataclass(frozen=True)
class Step:
    """A value of a check."""

    symbol: str
    value: float
    unit: str
    clause: str
    meaning: str
    formula: str = ""  # in symbols of earlier steps; empty of a value that is given, or read from a curve
    part: str = ""  # of the check: motion of the ground, mechanism, building, linear or non-linear


class Working:
    """The values of a check in the order in which they are found."""

    def __init__(self, *tables: Mapping[str, CodeQuantity]) -> None:
        self.rows = {symbol: row for table in tables for symbol, row in table.items()}
        self.steps: list[Step] = []
        self.known: dict[str, float] = {}  # the last value of each symbol
        self.part = GROUND

    def put(self, symbol: str, value: float, formula: str | None = None, meaning: str = "", like: str = "") -> float:
        """Note a value, and return it.

        Args:
            symbol: a row of the tables.
            value: in the unit of that row.
            formula: in place of that of the row, where it depends on the case.
            meaning: in place of that of the row.
            like: the row of a symbol that has none of its own, as Se(T) of Se(TSLV).
        """
        row = self.rows[like or symbol]
        self.known[symbol] = value
        text = row.formula if formula is None else formula
        self.steps.append(Step(symbol, value, row.unit, row.clause, meaning or row.meaning, text, self.part))
        return value


def with_numbers(steps: Sequence[Step]) -> list[str]:
    """The formula of each step with the values of those before it put in, a line each; empty of a step without a formula."""
    out, known = [], dict[str, float]()
    for step in steps:
        line = ""
        if step.formula:
            numbers = PRODUCT.sub(" x ", _put_in(step.formula, known))
            line = f"{step.symbol} = {step.formula} = {numbers} = {shown(step.value)} {step.unit}".rstrip()
        out.append(line)
        known[step.symbol] = step.value
    return out


def _put_in(formula: str, known: Mapping[str, float]) -> str:
    """A formula with the values of its symbols in their place; the longer of two symbols that begin alike is the one."""
    names = "|".join(re.escape(name) for name in sorted(known, key=len, reverse=True))
    return re.sub(rf"(?<![\w/])(?:{names})(?![\w*])", lambda found: shown(known[found[0]]), formula) if known else formula


def shown(value: float) -> str:
    """Four digits, or all before the point."""
    return f"{value:.0f}" if abs(value) >= IN_FULL else f"{value:.4g}"


@dataclass(frozen=True)
class CodeCheck:
    """A code check."""

    code: str
    edition: str
    limit_state: str
    ground: str
    steps: tuple[Step, ...]
    verdicts: tuple[CheckResult, ...]
    notes: tuple[str, ...] = ()
    left_open: tuple[str, ...] = ()  # by the clauses: which reading is taken, and what was not looked at
    level: HeldLevel | None = None  # at which the mechanism is held, where that is known
    unread: str = ""  # why the spectrum does not answer the check by displacements
    borne: tuple[Borne, ...] = ()  # the acceleration of the ground that each check just meets, where it was looked for
    risk: Risk | None = None  # by the Italian guideline, where the hazard of the site is known

    def without_displacements(self, why: str) -> CodeCheck:
        """The check where the spectrum does not answer the one by displacements: that by accelerations alone does not decide against it."""
        return replace(self, unread=why, verdicts=tuple(replace(one, unread=why) for one in self.verdicts))

    @property
    def worked(self) -> dict[str, list[str]]:
        """The formulas with their numbers, a line each, by the parts of the check."""
        out: dict[str, list[str]] = {}
        for step, line in zip(self.steps, with_numbers(self.steps), strict=True):
            if line:
                out.setdefault(step.part, []).append(line)
        return out

    def numbers(self) -> dict[str, Any]:
        """The contents of check.json."""
        out = asdict(self) | {"worked": self.worked}
        out["verdicts"] = [one.numbers() for one in self.verdicts]
        out["borne"] = [one.numbers() for one in self.borne]
        out["risk"] = None if self.risk is None else self.risk.numbers()
        out["steps"] = [asdict(step) | {"line": line} for step, line in zip(self.steps, with_numbers(self.steps), strict=True)]
        return out

    def lines(self, of: Sequence[str] = ()) -> list[str]:
        """The lines of the check; its verdict is not among them, ``of`` say which mechanism it is of."""
        state = f", {self.limit_state}" if self.limit_state else ""
        head = f"{self.edition}{state}; {self.ground}"
        said = [*(one.words for one in self.verdicts), *(one.words for one in self.borne), *self.notes]
        said += [] if self.risk is None else self.risk.lines
        said += [f"no check by displacements: {self.unread}"] if self.unread else []
        said += [f"left open: {one}" for one in self.left_open]
        return [head, *of, *said]


def no_end(oscillator: Oscillator) -> str:
    """The line on why there is no check by displacements."""
    if oscillator.doubt:
        return f"no check by displacements: {oscillator.doubt}"
    return f"no non-linear check: {oscillator.end}"


def no_ordinate(symbol: str, period: float, longest: float) -> str:
    """The words on a period [s] beyond the last one of the spectrum, at which a check by displacements reads it."""
    return f"{symbol} = {beyond(period, longest)}"


def capacity_rows(factor: str, fraction: str, confidence: str, acceleration: str, displacement: str) -> dict[str, CodeQuantity]:
    """The quantities that all codes share, from the load factor to a0* and d0*, with the clauses by which a code gives each."""
    return {
        "g": CodeQuantity("m/s2", "run.gravity", "acceleration of gravity, one in all formulas"),
        "alpha0": CodeQuantity("", factor, "load factor at which the mechanism starts, from the limit analysis"),
        "sum P": CodeQuantity("N", fraction, "weight that moves: blocks, and masses that the push moves with them"),
        "sum P d": CodeQuantity("N", fraction, "of weights times virtual displacements along the push, over that of the control point"),
        "sum P d^2": CodeQuantity("N", fraction, "of weights times their squares"),
        "e*": CodeQuantity("", fraction, "share of the mass that takes part", "(sum P d)^2 / (sum P sum P d^2)"),
        "M*": CodeQuantity("kg", fraction, "participating mass", "e* sum P / g"),
        "CF": CodeQuantity("", confidence, "confidence factor"),
        "a0*": CodeQuantity("m/s2", acceleration, "acceleration that starts it", "alpha0 g / (e* CF)"),
        "dC0": CodeQuantity("m", displacement, "displacement of the control point at which the factor vanishes"),
        "d0*": CodeQuantity("m", displacement, "of the oscillator at which the factor vanishes", "dC0 sum P d^2 / sum P d"),
    }


def put_capacity(made: Working, oscillator: Oscillator, confidence: float) -> float:
    """Note these quantities of an oscillator, and return a0* [m/s2]."""
    made.part = MECHANISM
    made.put("g", oscillator.gravity)
    made.put("alpha0", oscillator.alpha)
    made.put("sum P", oscillator.weight)
    if oscillator.doubt:
        made.put("e*", oscillator.fraction, "", f"taken as one: {oscillator.doubt}")
    else:
        made.put("sum P d", oscillator.first)
        made.put("sum P d^2", oscillator.second)
        made.put("e*", oscillator.fraction)
    made.put("M*", oscillator.mass)
    made.put("CF", confidence)
    starts = made.put("a0*", oscillator.acceleration() / confidence)
    if oscillator.falls:
        made.put("dC0", float(oscillator.displacement[-1]))
        made.put("d0*", oscillator.last)
    return starts


def linear(oscillator: Oscillator, demand: float, capacity: float, clause: str, q: float, period: float = 0.0) -> CheckResult:
    """The check by accelerations [m/s2], of a demand that is read from a spectrum at a period [s] and divided by q."""
    taken = oscillator.by_formula if oscillator.doubt else 1.0
    return CheckResult(LINEAR, demand, capacity, "m/s2", clause, fraction=taken, period=period, q=q)
