"""A check as values, one after the other: each with its symbol, unit and clause; and what they amount to."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

from masonry_cd.analysis.limit.oscillator import Oscillator
from masonry_cd.foundation.quantities import counted

HOLDS = 1e-9  # share by which a demand may exceed a capacity and be met
MARGIN = 0.05  # share of a capacity that is kept: held pushes have moved structures up to so far below the least factor that a search found
NO_SEARCH = "the least factor without dilation is not known"


@dataclass(frozen=True)
class Step:
    """A value of a check."""

    symbol: str
    value: float
    unit: str
    clause: str
    meaning: str


@dataclass(frozen=True)
class Looked:
    """A mechanism that was looked at, and the acceleration at which it starts."""

    found: str  # how
    moving_blocks: int
    alpha0: float
    fraction: float  # e* as taken
    acceleration: float  # a0*, over the confidence factor [m/s2]
    doubt: str  # why e* = 1 is taken, if it is


@dataclass(frozen=True)
class Basis:
    """What a check rests on: the search for the least factor without dilation, and the mechanisms it looked at."""

    search: str = ""  # starts, agreement and spread, in words
    doubt: str = NO_SEARCH  # why "satisfied" does not follow, in words; empty where it may
    looked: tuple[Looked, ...] = ()  # the one that is checked first


@dataclass(frozen=True)
class Verdict:
    """A demand and a capacity.

    That a mechanism starts under the demand shows that the structure does not meet it, however that mechanism was found. That those which
    were found do not start shows it of the others only where the search is sure, and with a margin.
    """

    check: str  # linear or non-linear
    demand: float
    capacity: float
    unit: str
    clause: str
    unmoved: float = 0.0  # a0* over the acceleration under which the mechanism starts at all, where that decides as well
    doubt: str = NO_SEARCH  # why "satisfied" does not follow, in words; empty where it may

    @property
    def state(self) -> str:
        """satisfied, NOT satisfied or not decided."""
        if not self._met(1.0 + HOLDS):
            return "NOT satisfied"
        return "not decided" if self.doubt or not self._met(1.0 - MARGIN) else "satisfied"

    @property
    def passed(self) -> bool | None:
        """Whether the capacity is enough; None where that is not decided."""
        return {"satisfied": True, "NOT satisfied": False}.get(self.state)

    @property
    def ratio(self) -> float:
        """Capacity over demand."""
        return self.capacity / self.demand

    @property
    def words(self) -> str:
        """The verdict in a line."""
        sides = f"{self.capacity:.4g} {self.unit} borne, {self.demand:.4g} {self.unit} asked for, ratio {self.ratio:.3g}"
        end = "; the mechanism does not start" if self.unmoved >= 1.0 and self.demand > self.capacity else ""
        if self.state == "not decided":
            end += f"; {self.doubt or f'less than the margin of {100.0 * MARGIN:g} % is left'}"
        return f"{self.check} check {self.state}: {sides}{end} ({self.clause})"

    def _met(self, share: float) -> bool:
        """Whether this share of the capacity is enough, or of what it takes to start the mechanism."""
        return max(self.ratio, self.unmoved) * share >= 1.0


@dataclass(frozen=True)
class CodeCheck:
    """A check by a code."""

    code: str
    edition: str
    limit_state: str
    ground: str
    steps: tuple[Step, ...]
    verdicts: tuple[Verdict, ...]
    notes: tuple[str, ...] = ()
    basis: Basis = Basis()

    def resting_on(self, basis: Basis) -> CodeCheck:
        """The check with verdicts that follow from no more than a basis."""
        return replace(self, verdicts=tuple(replace(one, doubt=basis.doubt) for one in self.verdicts), basis=basis)

    def numbers(self) -> dict[str, Any]:
        """What check.json holds."""
        out = asdict(self)
        out["verdicts"] = [
            asdict(one) | {"state": one.state, "passed": one.passed, "ratio": one.ratio, "words": one.words} for one in self.verdicts
        ]
        return out

    def lines(self) -> list[str]:
        """The check in words."""
        state = f", {self.limit_state}" if self.limit_state else ""
        return [f"{self.edition}{state}; {self.ground}", *self._of(), *(one.words for one in self.verdicts), *self.notes]

    def _of(self) -> list[str]:
        """Which mechanism is checked, a line where it is known."""
        if not self.basis.looked:
            return []
        least = self.basis.looked[0]
        counts = counted(least.moving_blocks, "moving block")
        taken = f"; e* = 1 is taken, the safe side: {least.doubt}" if least.doubt else ""
        many = counted(len(self.basis.looked), "mechanism")
        return [f"checked: the least a0* of {many} looked at, {least.found}, {counts}, alpha0 {least.alpha0:.4g}{taken}"]


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
        Step("sum P", oscillator.weight, "N", at.fraction, "weight of the blocks that move"),
        Step("M*", oscillator.mass, "kg", at.fraction, f"participating mass, {all_of_it or '(sum P d)^2 / (g sum P d^2)'}"),
        Step("e*", oscillator.fraction, "", at.fraction, f"its share, {all_of_it or 'g M* / sum P'}"),
        Step("CF", confidence, "", at.confidence, "confidence factor"),
        Step("a0*", oscillator.acceleration() / confidence, "m/s2", at.acceleration, "acceleration that starts it, alpha0 g / (e* CF)"),
    ]
    if oscillator.falls:
        made.append(Step("d0*", oscillator.last, "m", at.displacement, "displacement of the oscillator at which the factor vanishes"))
    return made
