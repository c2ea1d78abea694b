# SPDX-License-Identifier: GPL-3.0-or-later
"""Mechanisms with their check by a code: those of the whole and of its parts in one table, and the verdict of the gravest.

Each is checked at the level of its own lowest line. What counts as "satisfied" follows only where the search for the least mechanism of its
part is sure. Stones of one course that slide by themselves, as on top of a wall, are no mechanism of the wall: they end the table, and
decide where nothing else fails.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.analysis.code_check.check import check_at
from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.level import Level, foundation_of, level_of
from masonry_cd.analysis.code_check.verdicts import (
    NON_LINEAR,
    Basis,
    CheckResult,
    MechanismRow,
    SearchNumbers,
    Verdict,
    held_words,
    how_grave,
    verdict_of,
)
from masonry_cd.analysis.limit.candidates import ASSOCIATED
from masonry_cd.analysis.limit.macro import ElementAnalysis, PartMechanism
from masonry_cd.foundation.quantities import length

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.steps import CodeCheck
    from masonry_cd.analysis.code_check.table import CheckTable
    from masonry_cd.mechanics.model.blocks import Assembly

AXES = {"x": (1.0, 0.0), "-x": (-1.0, 0.0), "y": (0.0, 1.0), "-y": (0.0, -1.0)}
TIES_ASK = (
    "ties make a mechanism start later and stiffer: by displacements, and under the spectrum of a floor, its shorter period may be asked "
    "for more than without them"
)


@dataclass(frozen=True, eq=False)
class PartLooked:
    """A part under a push, and why no demand counts as met by it after its search; empty where one may."""

    part: ElementAnalysis
    doubt: str
    numbers: SearchNumbers  # of the search
    search: str = ""  # what it came to, in words

    @classmethod
    def of(cls, part: ElementAnalysis, doubt: str) -> PartLooked:
        """A part with the numbers of the search within it."""
        least, upper = part.least, [one.oscillator.alpha for one in part.mechanisms if one.source.startswith(ASSOCIATED)]
        top = min(upper, default=None)
        if least is None:
            return cls(part, doubt, SearchNumbers(top, None, 0, 0, 0, None))
        return cls(part, doubt, SearchNumbers(top, least.optimum.factor, least.starts, len(least.found), least.agreeing, least.spread))


@dataclass(frozen=True, eq=False)
class Checked:
    """A mechanism of a part, and its check where one is asked for."""

    looked: PartLooked
    one: PartMechanism
    level: Level | None
    check: CodeCheck | None
    no_displacement: str = ""

    @cached_property
    def row(self) -> MechanismRow:
        """The mechanism as the tables have it."""
        one, made = self.one, self.one.oscillator
        names = one.element.name, one.element.kind, way_words(one.direction), one.name, one.source
        if self.check is None or self.level is None:
            return MechanismRow(
                *names, self.height, one.moving, made.alpha, made.fraction, made.acceleration(), None, None, "", made.doubt, ""
            )
        linear, decides = self.check.verdicts[0], self.decides
        other = next((each for each in self.check.verdicts if each.check == NON_LINEAR), None)
        sides: tuple[float | None, float | None, float | None, float | None] = (None, None, None, None)
        if other is not None:
            sides = (made.last, other.capacity, other.demand, other.ratio)
        numbers = (linear.capacity, linear.demand, decides.ratio)
        return MechanismRow(
            *names, self.height, one.moving, made.alpha, made.fraction, *numbers, decides.state, made.doubt, decides.because, decides.check,
            *sides, self.no_displacement,
        )  # fmt: skip

    @property
    def height(self) -> float:
        """Of the line at which it is held, above the foundation, or without a check above the lowest block [m]."""
        return self.one.height if self.level is None else self.level.height

    @property
    def doubt(self) -> str:
        """Why "satisfied" does not follow, in words; empty where it may."""
        return (self.level.doubt if self.level is not None else "") or self.looked.doubt

    @property
    def decides(self) -> CheckResult:
        """The gravest of its checks."""
        assert self.check is not None
        return min(self.check.verdicts, key=how_grave)

    @property
    def severity(self) -> tuple[int, float]:
        """By which the table is in order: how grave the check that decides is, or a0* [m/s2] without one."""
        return (0, self.one.oscillator.acceleration()) if self.check is None else how_grave(self.decides)

    @property
    def words(self) -> str:
        """The mechanism in a line."""
        row = self.row
        a0 = f"alpha0 {row.alpha0:.4g}, e* {row.fraction:.3g}, a0* {row.acceleration:.4g} m/s2{held_words(row.height)}"
        if row.ratio is None:
            return f"{row.element}, push {row.push}: {a0}: {row.mechanism}"
        asked = f"{row.demand:.4g} asked for"
        if row.displacement is not None and row.displacement_demand is not None:
            asked += f"; {length(row.displacement)} of d0* {length(row.last or 0.0)}, {length(row.displacement_demand)} asked for"
        by = f" ({row.check})" if row.displacement is not None else ""
        return f"{row.element}, push {row.push}: {row.state}{by}, ratio {row.ratio:.3g}: {a0}, {asked}: {row.mechanism}"

    def verdict(self) -> Verdict:
        """The verdict that this mechanism gives."""
        assert self.check is not None
        return verdict_of(self.check.verdicts, self.row, self.looked.numbers)


def checked(parts: Sequence[PartLooked], table: CheckTable | None, ground: Ground | None, assembly: Assembly) -> list[Checked]:
    """All mechanisms of parts, the gravest first, and without a check by the least a0*.

    Args:
        parts: what was found.
        table: the check, None without one.
        ground: whose motion is asked for; None without a check.
        assembly: the blocks, from the lowest of which heights count where the table says nothing else.

    Raises:
        InputError: a foundation above the blocks.
    """
    if table is None or ground is None:
        made = [Checked(looked, one, None, None) for looked in parts for one in looked.part.mechanisms]
    else:
        made = list(_by_code(parts, table, ground, foundation_of(table, assembly)))
    return in_order(made)


def in_order(rows: Sequence[Checked]) -> list[Checked]:
    """Mechanisms in the order of the table."""
    return sorted(rows, key=lambda each: (each.one.stones, each.severity, each.row.element, each.row.push))


def _by_code(parts: Sequence[PartLooked], table: CheckTable, ground: Ground, foot: float) -> Iterator[Checked]:
    """All mechanisms of parts with their checks, on a ground; heights count from a z [m]."""
    for looked in parts:
        for one in looked.part.mechanisms:
            level = level_of(table, one.height, foot)
            check = check_at(table, level, one.oscillator, ground, Basis(doubt=looked.doubt))
            yield Checked(looked, one, level, check, _no_displacement(one) if table.by_displacements and len(check.verdicts) == 1 else "")


def _no_displacement(one: PartMechanism) -> str:
    """Why a mechanism has no check by displacements."""
    if one.found is None:
        return "another mechanism of this part and push has a smaller a0* and is held as high: that one is followed"
    return one.oscillator.doubt or one.oscillator.end


def least_of(rows: Sequence[Checked]) -> list[Checked]:
    """The gravest mechanism of each part and push."""
    first: dict[tuple[str, str], Checked] = {}
    for each in rows:
        first.setdefault((each.row.element, each.row.push), each)
    return list(first.values())


def gravest(rows: Sequence[Checked]) -> Checked | None:
    """The mechanism that decides: of the worst state the least ratio, stones that slide only where all others are in a better one.

    None without a check.
    """
    made = [each for each in rows if each.check is not None]
    return min(made, key=lambda each: (each.severity[0], each.one.stones, each.severity[1]), default=None)


def in_full(each: Checked, rows: Sequence[Checked], tied: bool) -> CodeCheck:
    """The check of a mechanism with what it rests on: the search, and all mechanisms of its part that were looked at, itself first.

    Where the structure is ``tied``, it says that ties may ask for more.
    """
    assert each.check is not None
    others = [other.row for other in rows if other.looked is each.looked and other is not each]
    basis = Basis(each.looked.search, each.doubt, (each.row, *others), each.looked.numbers)
    asks = tied and (len(each.check.verdicts) > 1 or (each.level is not None and bool(each.level.counted)))
    return replace(each.check, basis=basis, notes=(*each.check.notes, *([TIES_ASK] if asks else [])))


def way_words(direction: np.ndarray) -> str:
    """A level direction as a user writes it: "-x", or its components."""
    for name, (x, y) in AXES.items():
        if abs(direction[0] - x) + abs(direction[1] - y) < 1e-9:
            return name
    return f"[{direction[0]:.3g}, {direction[1]:.3g}]"
