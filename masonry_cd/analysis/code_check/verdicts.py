# SPDX-License-Identifier: GPL-3.0-or-later
"""The one verdict of a check, which every output has: its result, how sure that is, and what decides it, with its numbers.

The least of the checks that were made decides, and of the mechanisms looked at the one with the least capacity over its demand. The
Circolare lets the check by displacements stand in for that by accelerations (C8.7.1.2.1.7), but it is made of one mechanism only: of the
others the accelerations are all that is known.

Result and confidence are two things. One mechanism that starts under the demand is enough for "NOT satisfied", however it was found: that
is certain. "satisfied" says something of all mechanisms, and rests on a search. Everything else is doubtful, because of something.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from masonry_cd.analysis.limit.outcome import SearchNumbers
from masonry_cd.analysis.limit.solution import agreement

ON_THE_GROUND = 0.5  # height up to which the motion of the ground is that of a mechanism [m]
HOLDS = 1e-9  # share by which a demand may exceed a capacity and be met
MARGIN = 0.05  # share of a capacity that is kept: held pushes have moved structures up to so far below the least factor that a search found
NO_SEARCH = "the least factor without dilation is not known"
LITTLE = f"less than the margin of {100.0 * MARGIN:g} % is left"
NOT_SATISFIED, NOT_DECIDED, SATISFIED = "NOT satisfied", "not decided", "satisfied"
WORST_FIRST = (NOT_SATISFIED, NOT_DECIDED, SATISFIED)
PASSED = {SATISFIED: True, NOT_SATISFIED: False, NOT_DECIDED: None}
CERTAIN, BY_SEARCH, DOUBTFUL = "certain", "by search", "doubtful"
LINEAR, NON_LINEAR = "linear", "non-linear"  # checks: by accelerations, by displacements


@dataclass(frozen=True)
class CheckResult:
    """A demand and a capacity by one clause.

    That a mechanism starts under the demand shows that the structure does not meet it, however that mechanism was found. That those which
    were found do not start shows it of the others only where the search is sure, and with a margin.
    """

    check: str  # linear or non-linear
    demand: float
    capacity: float
    unit: str
    clause: str
    unmoved: float = 0.0  # a0* over the acceleration under which the mechanism starts at all, where that decides as well
    doubt: str = NO_SEARCH  # the reason why "satisfied" does not follow; empty where it may
    fraction: float = 1.0  # e* by its formula, where one was taken in its place on the safe side
    period: float = 0.0  # at which the demand is read from the spectrum [s]
    damping: float = 0.05  # of that spectrum
    q: float = 1.0  # by which its value is divided
    unread: str = ""  # why the check that may stand in for it could not be made, though the mechanism has one

    @property
    def state(self) -> str:
        """satisfied, NOT satisfied or not decided."""
        if self.met * (1.0 + HOLDS) < 1.0:
            return NOT_DECIDED if self.unread else NOT_SATISFIED
        return NOT_DECIDED if self.doubt or self.met * (1.0 - MARGIN) < 1.0 else SATISFIED

    @property
    def because(self) -> str:
        """Why the state is doubtful; empty where it is not."""
        if self.state == NOT_DECIDED:
            return self.doubt or LITTLE if self.met >= 1.0 else self.unread
        if self.state == NOT_SATISFIED and self.met >= self.fraction:
            return f"e* = 1 is used, on the safe side; with e* = {self.fraction:.3g} by its formula the demand is met"
        return ""

    @property
    def passed(self) -> bool | None:
        """True where the capacity is enough; None where that is not decided."""
        return PASSED[self.state]

    @property
    def ratio(self) -> float:
        """Capacity over demand."""
        return self.capacity / self.demand

    @property
    def met(self) -> float:
        """The share of the demand that is met, by the capacity or since the mechanism does not start."""
        return max(self.ratio, self.unmoved)

    @property
    def words(self) -> str:
        """The verdict in a line."""
        sides = sides_in_words(self.capacity, self.demand, self.unit)
        end = "; the mechanism does not start" if self.unmoved >= 1.0 and self.demand > self.capacity else ""
        if self.because:
            end += f"; {self.because}"
        return f"{self.check} check {self.state}: {sides}{end} ({self.clause})"

    def numbers(self) -> dict[str, Any]:
        """The numbers of it in check.json."""
        more = {"confidence": confidence(self.state, self.because), "because": self.because}
        return asdict(self) | {"state": self.state, "passed": self.passed, "ratio": self.ratio, "words": self.words} | more


@dataclass(frozen=True, eq=False)
class CheckSpectrum:
    """The spectrum that one check is read from, in its unit: accelerations [m/s2] or displacements [m]."""

    check: CheckResult
    period: np.ndarray  # (n,) [s]
    ground: np.ndarray  # (n,)
    raised: np.ndarray | None  # (n,) required at the height of the mechanism; None on the ground, and where a code has none

    @property
    def asked(self) -> np.ndarray:
        """(n,) of which the value at the period of the check is required, before it is divided by q."""
        return self.ground if self.raised is None else self.raised

    @property
    def largest(self) -> int:
        """The index of the largest value up to the period of the check: with a record, what is required by displacements."""
        return int(np.argmax(self.asked[self.period <= self.check.period]))


@dataclass(frozen=True)
class CheckVerdict:
    """The one verdict on a structure: a result, and how sure it is."""

    state: str  # the result: satisfied, NOT satisfied or not decided
    reason: str  # what decides it, with its numbers
    because: str = ""  # why it is doubtful; empty where it is not
    check: str = ""  # linear or non-linear: the check that decides; empty where none was needed
    demand: float | None = None
    capacity: float | None = None
    unit: str = ""
    ratio: float | None = None  # capacity over demand
    margin: float | None = None  # share of the capacity that is kept for "satisfied"
    mechanism: dict[str, Any] | None = None  # that decides, as limit.json has it
    search: SearchNumbers | None = None

    @property
    def confidence(self) -> str:
        """certain, by search or doubtful."""
        return confidence(self.state, self.because)

    @property
    def sure(self) -> str:
        """The confidence, with its reason."""
        return ": ".join(filter(None, [self.confidence, self.because]))

    @property
    def words(self) -> str:
        """The verdict in a line."""
        return f"verdict: {self.state}: {self.reason}; {self.sure}"

    def numbers(self) -> dict[str, Any]:
        """The numbers of it in limit.json."""
        return asdict(self) | {"confidence": self.confidence, "passed": PASSED[self.state], "words": self.words}


def confidence(state: str, because: str) -> str:
    """How sure a result is, with the reason why it is doubtful, if there is one."""
    if because or state == NOT_DECIDED:
        return DOUBTFUL
    return BY_SEARCH if state == SATISFIED else CERTAIN


def sides_in_words(capacity: float, demand: float, unit: str) -> str:
    """The phrase on what is borne, what is required, and their ratio."""
    return f"{capacity:.4g} {unit} borne, {demand:.4g} {unit} required, ratio {capacity / demand:.3g}"


def held_words(height: float) -> str:
    """How high a mechanism is held, as the end of a phrase; nothing of one on the ground."""
    return f", held {height:.4g} m up" if height > ON_THE_GROUND else ""


def refused(reason: str, search: SearchNumbers | None = None) -> CheckVerdict:
    """The verdict on a structure which needs no check to fail."""
    return CheckVerdict(NOT_SATISFIED, reason, search=search)


def how_grave(one: CheckResult) -> tuple[int, float]:
    """The order of checks, the governing one first: by their state, then by how far the demand is met."""
    return WORST_FIRST.index(one.state), one.met


def undecided(reason: str, search: SearchNumbers | None = None) -> CheckVerdict:
    """The verdict where there is no check."""
    return CheckVerdict(NOT_DECIDED, reason, margin=MARGIN, search=search)


def verdict_of(verdicts: Sequence[CheckResult], row: dict[str, Any] | None = None, found: SearchNumbers | None = None) -> CheckVerdict:
    """The verdict of the checks of a mechanism, that of the gravest.

    Args:
        verdicts: one or more.
        row: the mechanism, as limit.json has it.
        found: the search that it comes from.
    """
    least = min(verdicts, key=how_grave)
    reason = f"{least.check} check, {sides_in_words(least.capacity, least.demand, least.unit)}"
    if row is not None:
        of = f"alpha0 {row['alpha0']:.4g}, e* {row['fraction']:.3g}{held_words(row['height'])}"
        reason = f"{row['element']}, push {row['push']}, {row['mechanism']}: {reason}, {of}"
    better = [one for one in verdicts if one.state == SATISFIED and least.state != SATISFIED]
    alone = [f"the {better[0].check} check alone is satisfied"] if better else []
    because = "; ".join(filter(None, [least.because, *alone]))
    sides = (least.check, least.demand, least.capacity, least.unit, least.ratio)
    return CheckVerdict(least.state, f"{reason}{searched_words(found)}", because, *sides, MARGIN, row, found)


def searched_words(found: SearchNumbers | None) -> str:
    """The phrase on the starts of a search: their agreement and their spread."""
    if found is None or not found.starts:
        return ""
    spread = "" if found.spread is None else f", spread {100.0 * found.spread:.2g} %"
    return f"; {agreement(found.agreeing, found.starts)}{spread}"


def worst(found: Sequence[CheckVerdict]) -> CheckVerdict | None:
    """The least of some verdicts, by state and then by ratio; None of none."""
    order = [(WORST_FIRST.index(one.state), one.ratio if one.ratio is not None else 0.0) for one in found]
    return found[order.index(min(order))] if found else None
