# SPDX-License-Identifier: GPL-3.0-or-later
"""A check as values, one after the other: each with its symbol, unit and clause; and what they amount to."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import Any

from masonry_cd.analysis.code_check.level import Level
from masonry_cd.analysis.code_check.verdicts import Basis, CheckResult, Judgement, judgement
from masonry_cd.analysis.limit.oscillator import Oscillator
from masonry_cd.foundation.quantities import counted


@dataclass(frozen=True)
class Step:
    """A value of a check."""

    symbol: str
    value: float
    unit: str
    clause: str
    meaning: str


@dataclass(frozen=True)
class CodeCheck:
    """A check by a code."""

    code: str
    edition: str
    limit_state: str
    ground: str
    steps: tuple[Step, ...]
    verdicts: tuple[CheckResult, ...]
    notes: tuple[str, ...] = ()
    basis: Basis = field(default_factory=Basis)
    left_open: tuple[str, ...] = ()  # by the clauses: which reading is taken, and what was not looked at
    level: Level | None = None  # at which the mechanism is held, where that is known

    def resting_on(self, basis: Basis) -> CodeCheck:
        """The check with verdicts that follow from no more than a basis."""
        return replace(self, verdicts=tuple(replace(one, doubt=basis.doubt) for one in self.verdicts), basis=basis)

    @property
    def judgement(self) -> Judgement:
        """The one verdict: that of the least check."""
        return judgement(self.verdicts, self.basis, self.notes)

    def numbers(self) -> dict[str, Any]:
        """What check.json holds."""
        out = asdict(self) | {"verdict": self.judgement.numbers()}
        out["verdicts"] = [
            asdict(one) | {"state": one.state, "passed": one.passed, "ratio": one.ratio, "words": one.words} for one in self.verdicts
        ]
        return out

    def lines(self) -> list[str]:
        """The check in words."""
        state = f", {self.limit_state}" if self.limit_state else ""
        head = f"{self.edition}{state}; {self.ground}"
        said = [*(one.words for one in self.verdicts), *self.notes, *(f"left open: {one}" for one in self.left_open)]
        return [head, *self._of(), *said, self.judgement.words]

    def _of(self) -> list[str]:
        """Which mechanism is checked and where it is held, where that is known."""
        if not self.basis.looked:
            return []
        least = self.basis.looked[0]
        counts = counted(least.moving_blocks, "moving block")
        taken = f"; e* = 1 is taken, the safe side: {least.doubt}" if least.doubt else ""
        many = counted(len(self.basis.looked), "mechanism")
        by = "ratio by accelerations" if any(one.height != least.height for one in self.basis.looked) else "a0*"
        held = [self.level.words] if self.level is not None else []
        return [f"checked: the least {by} of {many} looked at, {least.found}, {counts}, alpha0 {least.alpha0:.4g}{taken}", *held]


@dataclass(frozen=True)
class Clauses:
    """Where a code speaks of the oscillator."""

    factor: str
    fraction: str
    confidence: str
    acceleration: str
    displacement: str


def no_end(oscillator: Oscillator) -> str:
    """Why there is no check by displacements."""
    if oscillator.doubt:
        return f"no check by displacements: {oscillator.doubt}"
    return f"no non-linear check: {oscillator.end}"


def capacity(oscillator: Oscillator, confidence: float, at: Clauses) -> list[Step]:
    """The steps that all codes share: from the load factor to a0* and d0*."""
    all_of_it = f"taken as one: {oscillator.doubt}" if oscillator.doubt else ""
    made = [
        Step("alpha0", oscillator.alpha, "", at.factor, "load factor at which the mechanism starts, from the limit analysis"),
        Step("sum P", oscillator.weight, "N", at.fraction, "weight that moves: blocks, and masses that the push moves with them"),
        Step("M*", oscillator.mass, "kg", at.fraction, f"participating mass, {all_of_it or '(sum P d)^2 / (g sum P d^2)'}"),
        Step("e*", oscillator.fraction, "", at.fraction, f"its share, {all_of_it or 'g M* / sum P'}"),
        Step("CF", confidence, "", at.confidence, "confidence factor"),
        Step("a0*", oscillator.acceleration() / confidence, "m/s2", at.acceleration, "acceleration that starts it, alpha0 g / (e* CF)"),
    ]
    if oscillator.falls:
        made.append(Step("d0*", oscillator.last, "m", at.displacement, "displacement of the oscillator at which the factor vanishes"))
    return made
