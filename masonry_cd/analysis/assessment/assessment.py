# SPDX-License-Identifier: GPL-3.0-or-later
r"""The runs of an assessment, and how far each assumption moves each answer.

The bar of an assumption is the range of an answer over the base case and its levels. Members of the ensemble differ by nothing but
rounding, so their standard deviation s is what chance does to one run. k runs that differ by chance alone spread by less than

    q s,     q the 95 % quantile of the studentised range of k runs and n - 1 degrees of freedom

in 19 of 20 cases (Tukey's test): an assumption shows in an answer where its bar is longer than that, and than FELT of the base case.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.analysis.assessment.indices import Indices, Unknown, indices_of
from masonry_cd.analysis.outputs import ANSWER, numbers_in
from masonry_cd.analysis.run_row import RunRow, row_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_text

FILE = "assess.json"
BASE, ENSEMBLE, LEVEL, PAIR, GLOBAL = "base", "ensemble", "level", "pair", "global"
NOT_IN_ROW = ("kind", "values", "run", "member", "at")  # keys of a run in the file that are no part of its row
UNSETTLED = "weight at once"  # remark on a run whose joints would not settle under their weight before it
LEAST = 3  # members of an ensemble that is one
CONFIDENCE = 0.95  # of the test against chance
FELT = 0.05  # share of the base case below which a difference is none to an engineer
WHOLE = 1.0  # of grades and counts of blocks


class AssessedNumber(NamedTuple):
    """A number that a run answers with."""

    key: str  # column
    name: str
    unit: str  # in which it is shown
    factor: float  # into that unit
    whole: bool = False  # a grade or a count


ANSWERS = tuple(AssessedNumber(key, one.name, *one.shown, one.whole) for key, one in numbers_in(ANSWER).items())
DISPLACEMENT, GRADE, FACTOR = (
    next(one for one in ANSWERS if one.key == key) for key in ("displacement_max", "grade_number", "load_factor")
)


@dataclass(frozen=True)
class Member:
    """A run: its place in the assessment, and its row; an empty one where it is still to be made."""

    kind: str  # base | ensemble | level | pair | global
    values: Mapping[str, str]  # levels by assumption
    row: RunRow
    run: str = ""  # its name
    number: int = 0  # of a member of the ensemble
    at: tuple[float, ...] = ()  # point of the unit cube where all vary at once

    @property
    def missed(self) -> bool:
        """Return True if steps missed the tolerance."""
        return bool(self.row.number("steps_missed"))

    def of(self, answer: AssessedNumber) -> float:
        """An answer; nan where there is none."""
        value = self.row.number(answer.key) if self.row.done else None
        return float("nan") if value is None else float(value)

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        row = replace(self.row, parts={}).as_dict() | {"run": self.run, "member": self.number} if self.row.status else {}
        return {"kind": self.kind, "values": dict(self.values), **({"at": list(self.at)} if self.at else {}), **row}


@dataclass(frozen=True)
class KnownAssumption:
    """An assumption: what the scene says of it, and the names of its other levels."""

    name: str
    base: str
    levels: tuple[str, ...]
    reference: str = ""  # the level that others are compared with; empty: the base case
    numerical: bool = False
    coarser: tuple[str, ...] = ()  # levels, than the base case: no measure of its error


@dataclass(frozen=True)
class AssumptionEffect:
    """The effect of an assumption on an answer."""

    low: float
    high: float
    reference: float
    values: tuple[tuple[str, float], ...]  # of each level that is data
    shows: bool  # beyond chance, and enough to be felt

    @property
    def length(self) -> float:
        """Length of the bar; 0 without data."""
        return self.high - self.low if np.isfinite(self.high - self.low) else 0.0


@dataclass(frozen=True, eq=False)
class Assessment:
    """An assessment; its JSON file holds the fields."""

    title: str
    scene: str
    assumptions: tuple[KnownAssumption, ...]
    left_out: tuple[tuple[str, str], ...]  # names and why
    members: tuple[Member, ...]
    program: str = ""  # its version
    unknowns: tuple[Unknown, ...] = ()  # of runs in which they all vary at once
    sampled: tuple[Member, ...] = ()  # these runs

    @cached_property
    def indices(self) -> dict[AssessedNumber, Indices]:
        """Sobol indices of each answer, where all unknowns were varied at once; empty where they were not."""
        out, u = {}, np.array([one.at for one in self.sampled])
        for answer in self.answers if self.sampled else ():
            values = np.array([one.of(answer) for one in self.sampled])
            out[answer] = indices_of(self.unknowns, u, values, FELT * abs(self.base.of(answer)))
        return out

    @cached_property
    def base(self) -> Member:
        """The scene itself."""
        return next(one for one in self.members if one.kind == BASE)

    @cached_property
    def ensemble(self) -> list[Member]:
        """The base case and its neighbours."""
        return [one for one in self.members if one.kind in (BASE, ENSEMBLE)]

    @cached_property
    def answers(self) -> list[AssessedNumber]:
        """Those that the base case has, but for numbers of blocks where none falls in any run."""
        found = [one for one in ANSWERS if np.isfinite(self.base.of(one))]
        return [one for one in found if one.key != "collapsed_blocks" or any(member.of(one) > 0 for member in self.members)]

    def level(self, assumption: str, level: str) -> Member | None:
        """The run of a level by itself."""
        return next((one for one in self.members if one.kind == LEVEL and dict(one.values) == {assumption: level}), None)

    def chance(self, answer: AssessedNumber) -> tuple[float, float]:
        """The range of an answer over the ensemble."""
        values = self._of(self.ensemble, answer)
        return (float(values.min()), float(values.max())) if len(values) > 1 else (np.nan, np.nan)

    def range(self, answer: AssessedNumber, kinds: Sequence[str] = (BASE, ENSEMBLE, LEVEL, PAIR)) -> tuple[float, float]:
        """The range of an answer over all runs that are no coarser than the base case."""
        coarser = {(known.name, level) for known in self.assumptions for level in known.coarser}
        values = self._of([one for one in self.members if one.kind in kinds and coarser.isdisjoint(one.values.items())], answer)
        return (float(values.min()), float(values.max())) if len(values) else (np.nan, np.nan)

    def by_chance(self, answer: AssessedNumber, runs: int) -> float:
        """How far a given number of runs spread by chance alone, in 19 of 20 cases."""
        values = self._of(self.ensemble, answer)
        if len(values) < LEAST or runs < 2:
            return 0.0
        return _quantile(runs, len(values) - 1) * float(values.std(ddof=1))

    def bar(self, assumption: KnownAssumption, answer: AssessedNumber) -> AssumptionEffect:
        """Return the effect of an assumption on an answer."""
        reference = self.base if not assumption.reference else self.level(assumption.name, assumption.reference)
        at = np.nan if reference is None else reference.of(answer)
        excluded = (assumption.reference, *assumption.coarser)
        found = [(name, self.level(assumption.name, name)) for name in assumption.levels if name not in excluded]
        values = tuple((name, member.of(answer)) for name, member in found if member is not None and np.isfinite(member.of(answer)))
        every = np.array([at, *(value for _, value in values)])
        if not np.isfinite(at) or not values:
            return AssumptionEffect(np.nan, np.nan, at, values, False)
        bar = AssumptionEffect(float(every.min()), float(every.max()), at, values, False)
        felt = WHOLE if answer.whole else FELT * abs(at)
        shows = bar.length > self.by_chance(answer, len(every)) and bar.length >= felt and bar.length > 0.0
        return AssumptionEffect(bar.low, bar.high, at, values, shows)

    def bars(self) -> dict[str, dict[str, dict[str, Any]]]:
        """The bars by assumption, the weightiest first, and by answer, with what chance alone spans."""
        return {one.name: {answer.key: self._bar_as_dict(one, answer) for answer in self.answers} for one in self.ranked}

    def _bar_as_dict(self, one: KnownAssumption, answer: AssessedNumber) -> dict[str, Any]:
        bar = self.bar(one, answer)
        chance = self.by_chance(answer, 1 + len(bar.values))
        return {"low": bar.low, "high": bar.high, "reference": bar.reference, "by_chance": chance, "shows": bar.shows}

    def share(self, assumption: KnownAssumption, answer: AssessedNumber) -> float:
        """The length of a bar over the range of all single runs."""
        low, high = self.range(answer, (BASE, ENSEMBLE, LEVEL))
        return self.bar(assumption, answer).length / (high - low) if high > low else 0.0

    def weight(self, assumption: KnownAssumption) -> float:
        """Mean share over the answers of those bars that show: what assumptions are ranked by."""
        shares = [self.share(assumption, answer) * self.bar(assumption, answer).shows for answer in self.answers]
        return float(np.mean(shares)) if shares else 0.0

    @cached_property
    def ranked(self) -> list[KnownAssumption]:
        """The assumptions, the weightiest first."""
        every = {one: (self.weight(one), np.mean([self.share(one, a) for a in self.answers] or [0.0])) for one in self.assumptions}
        return sorted(every, key=lambda one: every[one], reverse=True)

    @cached_property
    def deciding(self) -> list[KnownAssumption]:
        """Assumptions whose bars show in some answer, the weightiest first."""
        return [one for one in self.ranked if self.weight(one) > 0.0]

    def is_tested(self, assumption: KnownAssumption) -> bool:
        """Return True if some level of an assumption is data."""
        return any(self.bar(assumption, answer).values for answer in self.answers)

    def interactions(self, answer: AssessedNumber) -> list[tuple[Member, float]]:
        """Return each pair with the distance of its answer from the sum of what its two levels do alone, the farthest first."""
        found = []
        for pair in (one for one in self.members if one.kind == PAIR):
            alone = [self.level(name, level) for name, level in pair.values.items()]
            single = sum((np.nan if one is None else one.of(answer)) - self.base.of(answer) for one in alone)
            beyond = pair.of(answer) - self.base.of(answer) - single
            if np.isfinite(beyond):
                found.append((pair, float(beyond)))
        return sorted(found, key=lambda one: -abs(one[1]))

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "title": self.title,
            "scene": self.scene,
            "program": self.program,
            "assumptions": [vars(one) for one in self.assumptions],
            "left_out": [{"assumption": name, "why": why} for name, why in self.left_out],
            "members": [one.as_dict() for one in self.members],
        } | (
            {"unknowns": [one._asdict() for one in self.unknowns], "sampled": [one.as_dict() for one in self.sampled]}
            if self.sampled
            else {}
        )

    @staticmethod
    def _of(members: Sequence[Member], answer: AssessedNumber) -> np.ndarray:
        values = np.array([one.of(answer) for one in members])
        return values[np.isfinite(values)]


def read_assessment(folder: Path) -> Assessment:
    """The assessment in a folder.

    Raises:
        InputError: there is none, or it cannot be read.
    """
    file = folder / FILE
    if not file.exists():
        raise InputError(folder, f"holds no {FILE}: no assessment was made there")
    try:
        facts = json.loads(read_text(file))
        known = tuple(
            KnownAssumption(**{**one, "levels": tuple(one["levels"]), "coarser": tuple(one.get("coarser", ()))})
            for one in facts["assumptions"]
        )
        members, sampled = (tuple(_member(one) for one in facts.get(key, ())) for key in ("members", "sampled"))
        unknowns = tuple(Unknown(one["name"], one["span"], tuple(one["choices"])) for one in facts.get("unknowns", ()))
        left = tuple((one["assumption"], one["why"]) for one in facts["left_out"])
        return Assessment(facts["title"], facts["scene"], known, left, members, facts.get("program", ""), unknowns, sampled)
    except (ValueError, KeyError, TypeError, OSError) as fault:
        raise InputError(file, f"is not an assessment: {fault}") from None


def _member(facts: Mapping[str, Any]) -> Member:
    """A run as the file has it."""
    more = (facts.get("run", ""), facts.get("member", 0), tuple(facts.get("at", ())))
    return Member(facts["kind"], facts["values"], row_of(dict(facts), NOT_IN_ROW), *more)


@lru_cache
def _quantile(runs: int, freedom: int) -> float:
    """Return a quantile of the studentised range."""
    from scipy.stats import studentized_range

    return float(studentized_range.ppf(CONFIDENCE, runs, freedom))
