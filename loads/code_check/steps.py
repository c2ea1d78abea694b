"""A check as values, one after the other: each with its symbol, unit and clause; and what they amount to."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from masonry_cd.limit.oscillator import Oscillator

HOLDS = 1e-9  # share by which a demand may exceed a capacity and be met


@dataclass(frozen=True)
class Step:
    """A value of a check."""

    symbol: str
    value: float
    unit: str
    clause: str
    meaning: str


@dataclass(frozen=True)
class Verdict:
    """A demand and a capacity."""

    check: str  # linear or non-linear
    demand: float
    capacity: float
    unit: str
    clause: str
    rigid: bool = False  # whether it holds since the mechanism does not start at all

    @property
    def passed(self) -> bool:
        """Whether the capacity is enough."""
        return self.rigid or self.demand <= self.capacity * (1.0 + HOLDS)

    @property
    def ratio(self) -> float:
        """Capacity over demand."""
        return self.capacity / self.demand

    @property
    def words(self) -> str:
        """The verdict in a line."""
        sides = f"{self.capacity:.4g} {self.unit} borne, {self.demand:.4g} {self.unit} asked for, ratio {self.ratio:.3g}"
        end = "; the mechanism does not start" if self.rigid and self.demand > self.capacity else ""
        return f"{self.check} check {'satisfied' if self.passed else 'NOT satisfied'}: {sides}{end} ({self.clause})"


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

    def numbers(self) -> dict[str, Any]:
        """What check.json holds."""
        out = asdict(self)
        out["verdicts"] = [asdict(one) | {"passed": one.passed, "ratio": one.ratio, "words": one.words} for one in self.verdicts]
        return out

    def lines(self) -> list[str]:
        """The check in words."""
        state = f", {self.limit_state}" if self.limit_state else ""
        return [f"{self.edition}{state}; {self.ground}", *(one.words for one in self.verdicts), *self.notes]


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
    return f"no non-linear check: the capacity curve ends before the load factor vanishes: {oscillator.end}"


def capacity(oscillator: Oscillator, confidence: float, at: Clauses) -> list[Step]:
    """The steps that all codes share: from the load factor to a0* and d0*."""
    made = [
        Step("alpha0", oscillator.alpha, "", at.factor, "load factor at which the mechanism starts, from the limit analysis"),
        Step("sum P", oscillator.weight, "N", at.fraction, "weight of the blocks that move"),
        Step("M*", oscillator.mass, "kg", at.fraction, "participating mass, (sum P d)^2 / (g sum P d^2)"),
        Step("e*", oscillator.fraction, "", at.fraction, "its share, g M* / sum P"),
        Step("CF", confidence, "", at.confidence, "confidence factor"),
        Step("a0*", oscillator.acceleration() / confidence, "m/s2", at.acceleration, "acceleration that starts it, alpha0 g / (e* CF)"),
    ]
    if oscillator.falls:
        made.append(Step("d0*", oscillator.last, "m", at.displacement, "displacement of the oscillator at which the factor vanishes"))
    return made
