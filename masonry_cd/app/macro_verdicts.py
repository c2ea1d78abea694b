# SPDX-License-Identifier: GPL-3.0-or-later
"""What the mechanisms of macro-elements amount to: a row each, and the verdict of the least."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.code_check.level import level_of
from masonry_cd.analysis.code_check.verdicts import (
    MARGIN,
    NOT_DECIDED,
    WORST_FIRST,
    Basis,
    CheckResult,
    Judgement,
    Looked,
    SearchNumbers,
    held_words,
    sides_in_words,
    undecided_words,
    worst,
)
from masonry_cd.analysis.limit.candidates import ASSOCIATED
from masonry_cd.analysis.limit.macro import Effort, ElementAnalysis, PartMechanism
from masonry_cd.analysis.limit.search import AGREE
from masonry_cd.foundation.quantities import length

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.ground import Ground
    from masonry_cd.analysis.code_check.table import CheckTable

AXES = {"x": (1.0, 0.0), "-x": (-1.0, 0.0), "y": (0.0, 1.0), "-y": (0.0, -1.0)}


@dataclass(frozen=True)
class MacroRow:
    """A mechanism of a macro-element."""

    element: str
    kind: str
    push: str
    mechanism: str
    found: str  # how
    height: float  # of the line at which it is held, above the foundation [m]
    moving_blocks: int
    alpha0: float
    fraction: float  # e* as taken
    acceleration: float  # a0*, over the confidence factor where there is a check [m/s2]
    demand: float | None  # [m/s2]
    ratio: float | None  # capacity over demand of the check that decides
    state: str  # of it; empty without a check
    doubt: str  # why e* = 1 is taken, if it is
    undecided: str  # why "satisfied" does not follow, in words
    part: int  # which of the analyses of parts it is of
    number: int  # which of its mechanisms
    check: str = ""  # linear, by accelerations, or non-linear, by displacements: the one that decides
    last: float | None = None  # d0*, where the factor vanishes [m]; None where it is not known
    displacement: float | None = None  # borne, the share of d0* of the limit state [m]
    displacement_demand: float | None = None  # [m]
    displacement_ratio: float | None = None
    no_displacement: str = ""  # why there is no check by displacements, where one is asked for

    @property
    def words(self) -> str:
        """The row in a line."""
        a0 = f"alpha0 {self.alpha0:.4g}, e* {self.fraction:.3g}, a0* {self.acceleration:.4g} m/s2{held_words(self.height)}"
        if self.ratio is None:
            return f"{self.element}, push {self.push}: {a0}: {self.mechanism}"
        asked = f"{self.demand:.4g} asked for"
        if self.displacement is not None and self.displacement_demand is not None:
            asked += f"; {length(self.displacement)} of d0* {length(self.last or 0.0)}, {length(self.displacement_demand)} asked for"
        by = f" ({self.check})" if self.displacement is not None else ""
        return f"{self.element}, push {self.push}: {self.state}{by}, ratio {self.ratio:.3g}: {a0}, {asked}: {self.mechanism}"


def rows_of(
    parts: Sequence[ElementAnalysis], table: CheckTable | None, folder: Path, foundation: float, effort: Effort
) -> tuple[MacroRow, ...]:
    """All mechanisms, the least ratio first.

    Args:
        parts: what was found.
        table: the check, None without one.
        folder: from which the path of a record is read.
        foundation: its z [m].
        effort: of the search.

    Raises:
        InputError: a record that cannot be read.
    """
    from masonry_cd.analysis.code_check.ground import ground_of

    ground = None if table is None else ground_of(table, folder)
    rows = [
        _row(one, (k, number), part, table, ground, foundation, effort)
        for k, part in enumerate(parts)
        for number, one in enumerate(part.mechanisms)
    ]
    return tuple(sorted(rows, key=lambda row: (row.ratio if row.ratio is not None else row.acceleration, row.element, row.push)))


def _row(
    one: PartMechanism, place: tuple[int, int], part: ElementAnalysis, table: CheckTable | None, ground: Ground | None, foot: float,
    effort: Effort,
) -> MacroRow:  # fmt: skip
    """A mechanism, and its check where one is asked for."""
    made = one.oscillator
    names = (one.element.name, one.element.kind, way_words(one.direction), one.name, one.source)
    if table is None or ground is None:
        facts = (*names, max(one.height - foot, 0.0), one.moving)
        return MacroRow(*facts, made.alpha, made.fraction, made.acceleration(), None, None, "", made.doubt, "", *place)
    from masonry_cd.analysis.code_check.check import check_at

    level = level_of(table, one.height, foot)
    facts = (*names, level.height, one.moving)
    undecided = level.doubt or _undecided(part, effort)
    checked = check_at(table, level, made, ground, Basis(doubt=undecided))
    linear, decides = checked.verdicts[0], min(checked.verdicts, key=_gravity)
    by_displacements: tuple[Any, ...] = (None, None, None, None, _no_displacement(one) if table.by_displacements else "")
    if len(checked.verdicts) > 1:
        other = checked.verdicts[1]
        by_displacements = (made.last, other.capacity, other.demand, other.ratio, "")
    numbers = (linear.capacity, linear.demand, decides.ratio)
    doubts = (made.doubt, undecided)
    return MacroRow(*facts, made.alpha, made.fraction, *numbers, decides.state, *doubts, *place, decides.check, *by_displacements)


def _gravity(one: CheckResult) -> tuple[int, float]:
    """By which the gravest of the checks of a mechanism is found."""
    return WORST_FIRST.index(one.state), max(one.ratio, one.unmoved)


def _no_displacement(one: PartMechanism) -> str:
    """Why a mechanism has no check by displacements."""
    if one.found is None:
        return "another mechanism of this part and push has a smaller a0* and is held as high: that one is followed"
    return one.oscillator.doubt or one.oscillator.end


def _undecided(part: ElementAnalysis, effort: Effort) -> str:
    """Why the check of a part cannot say "satisfied", in words."""
    if part.remarks:
        return part.remarks[0]
    if part.least is None:
        if part.points > effort.most_points:
            size = f"a part of more than {effort.most_points:,} contact points"
            return f"the free least mechanism is not searched for in {size}: limit.starts = 2 does"
        return "no start of the search for the free least mechanism came to an end: raise limit.starts"
    if not part.least.agreed:
        return (
            f"{part.least.agreeing} of {part.least.starts} starts came to the least factor found, {AGREE} have to agree: raise limit.starts"
        )
    return ""


def judged(rows: Sequence[MacroRow], parts: Sequence[ElementAnalysis]) -> Judgement | None:
    """The verdict of the least mechanism; None of none."""
    return worst([_judgement(row, parts[row.part]) for row in rows])


def _judgement(row: MacroRow, part: ElementAnalysis) -> Judgement:
    """The verdict on one mechanism of a part."""
    assert row.ratio is not None and row.demand is not None
    by_displacements = row.check == "non-linear"
    capacity, demand, unit = (
        (row.displacement, row.displacement_demand, "m") if by_displacements else (row.acceleration, row.demand, "m/s2")
    )
    assert capacity is not None and demand is not None
    looked = Looked(row.found, row.moving_blocks, row.alpha0, row.fraction, row.acceleration, row.doubt, row.height)
    least, upper = part.least, [one.oscillator.alpha for one in part.mechanisms if one.source.startswith(ASSOCIATED)]
    numbers = None
    if least is not None:
        top = min(upper, default=math.inf)
        numbers = SearchNumbers(top, least.optimum.factor, least.starts, len(least.found), least.agreeing, least.spread)
    reason = f"{row.element}, push {row.push}, {row.mechanism}: {row.check} check, {sides_in_words(capacity, demand, unit)}"
    reason += f", alpha0 {row.alpha0:.4g}, e* {row.fraction:.3g}"
    reason += held_words(row.height)
    if row.state == NOT_DECIDED:
        reason += undecided_words(row.undecided)
    return Judgement(row.state, reason, row.check, demand, capacity, unit, row.ratio, MARGIN, looked, numbers)


def way_words(direction: np.ndarray) -> str:
    """A level direction as a user writes it: "-x", or its components."""
    for name, (x, y) in AXES.items():
        if abs(direction[0] - x) + abs(direction[1] - y) < 1e-9:
            return name
    return f"[{direction[0]:.3g}, {direction[1]:.3g}]"
