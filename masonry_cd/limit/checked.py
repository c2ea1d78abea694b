# SPDX-License-Identifier: GPL-3.0-or-later
"""Mechanisms with their code check: those of the whole and of its parts in one table, and the verdict of the governing one.

Each is checked at the level of its own constraint lines. "satisfied" follows only where the search for the least mechanism of its part is
sure. Stones of one course that slide by themselves, as on top of a wall, are no mechanism of the wall: they end the table, and decide where
nothing else fails.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.code_check.check import check_at
from masonry_cd.analysis.code_check.ground import Ground
from masonry_cd.analysis.code_check.level import HeldLevel, foundation_of, level_of
from masonry_cd.analysis.code_check.verdicts import (
    LINEAR,
    NON_LINEAR,
    WORST_FIRST,
    CheckResult,
    CheckVerdict,
    held_words,
    how_grave,
    verdict_of,
)
from masonry_cd.analysis.limit.found import FoundMechanism
from masonry_cd.analysis.limit.macro import ElementAnalysis
from masonry_cd.foundation.quantities import length

if TYPE_CHECKING:
    from masonry_cd.analysis.code_check.steps import CodeCheck
    from masonry_cd.analysis.code_check.table import CheckTable
    from masonry_cd.mechanics.model.blocks import Assembly

AXES = {"x": (1.0, 0.0), "-x": (-1.0, 0.0), "y": (0.0, 1.0), "-y": (0.0, -1.0)}


@dataclass(frozen=True, eq=False)
class Checked:
    """A mechanism of a part, and its check where one is required."""

    part: ElementAnalysis
    one: FoundMechanism
    level: HeldLevel | None
    check: CodeCheck | None
    no_displacement: str = ""  # why there is no check by displacements, where one is requested

    @cached_property
    def row(self) -> dict[str, Any]:
        """The mechanism as limit.json and the tables have it; demands and ratios are None without a check."""
        one, made, element, decides = self.one, self.one.oscillator, self.part.element, self.decides
        made_of = {} if self.check is None else {each.check: each for each in self.check.verdicts}
        first, other = made_of.get(LINEAR), made_of.get(NON_LINEAR)
        return {
            "element": element.name,
            "kind": element.kind,
            "push": way_words(self.part.direction),
            "mechanism": one.name,
            "found": one.source,  # how
            "height": self.height,  # of the line at which it is held, above the foundation [m]
            "moving_blocks": one.moving,
            "alpha0": made.alpha,
            "fraction": made.fraction,  # e* as taken
            "acceleration": self.acceleration if first is None else first.capacity,  # a0*, over the confidence factor in a check [m/s2]
            "demand": None if first is None else first.demand,  # [m/s2]; None where displacements alone are checked
            "ratio": None if decides is None else decides.ratio,  # capacity over demand of the check that decides
            "state": "" if decides is None else decides.state,
            "doubt": made.doubt,  # why e* = 1 is taken, if it is
            "undecided": "" if decides is None else decides.because,  # why the state is doubtful; empty where it is not
            "check": "" if decides is None else decides.check,  # linear or non-linear: the one that decides
            "last": None if other is None else made.last,  # d0*, where the factor vanishes [m]
            "last_by": "" if other is None else made.by,  # how d0* was found
            "displacement": None if other is None else other.capacity,  # borne, the share of d0* of the limit state [m]
            "displacement_demand": None if other is None else other.demand,  # [m]
            "displacement_ratio": None if other is None else other.ratio,
            "no_displacement": self.no_displacement,
        }

    @property
    def acceleration(self) -> float:
        """a0* [m/s2], over the confidence factor in a check."""
        steps = () if self.check is None else self.check.steps
        return next((step.value for step in steps if step.symbol == "a0*"), self.one.oscillator.acceleration())

    @property
    def height(self) -> float:
        """The height at which it is held above the foundation, or without a check its z [m]."""
        return self.one.height if self.level is None else self.level.height

    @property
    def doubt(self) -> str:
        """The reason why "satisfied" does not follow; empty where it may."""
        return (self.level.doubt if self.level is not None else "") or self.part.doubt

    @property
    def decides(self) -> CheckResult | None:
        """The gravest of its checks; None without one, as where displacements alone are checked and none is known."""
        return None if self.check is None else min(self.check.verdicts, key=how_grave, default=None)

    @property
    def severity(self) -> tuple[int, float]:
        """The key that orders the table: how grave the check that decides is, or a0* [m/s2] without one."""
        return (len(WORST_FIRST), self.acceleration) if self.decides is None else how_grave(self.decides)

    @property
    def label(self) -> str:
        """The part, its push and the mechanism."""
        return f"{self.part.element.name}, push {way_words(self.part.direction)}: {self.one.name}"

    @property
    def words(self) -> str:
        """The mechanism as a line."""
        row, made = self.row, self.one.oscillator
        of = f"{row['element']}, push {row['push']}"
        a0 = f"alpha0 {made.alpha:.4g}, e* {made.fraction:.3g}, a0* {row['acceleration']:.4g} m/s2{held_words(self.height)}"
        if self.decides is None:
            return f"{of}: {a0}: {self.one.name}"
        asked, by = [] if row["demand"] is None else [f"{row['demand']:.4g} required"], ""
        if row["displacement"] is not None:
            asked.append(f"{length(row['displacement'])} of d0* {length(made.last)}, {length(row['displacement_demand'])} required")
            by = f" ({self.decides.check})"
        return f"{of}: {self.decides.state}{by}, ratio {self.decides.ratio:.3g}: {a0}, {'; '.join(asked)}: {self.one.name}"

    def verdict(self) -> CheckVerdict:
        """The verdict that this mechanism gives."""
        assert self.check is not None
        return verdict_of(self.check.verdicts, self.row, self.part.numbers)


def checked(parts: Sequence[ElementAnalysis], table: CheckTable | None, ground: Ground | None, assembly: Assembly) -> list[Checked]:
    """All mechanisms of parts, the governing one first, and without a check by the least a0*.

    Args:
        parts: what was found.
        table: the check, None without one.
        ground: whose motion is required; None without a check.
        assembly: the blocks, from the lowest of which heights count where the table says nothing else.

    Raises:
        InputError: a foundation above the blocks.
    """
    if table is None or ground is None:
        made = [Checked(part, one, None, None) for part in parts for one in part.mechanisms]
    else:
        foot = foundation_of(table, assembly)
        made = [row for part in parts for row in _unread_alike(list(_by_code(part, table, ground, foot)))]
    return in_order(made)


def in_order(rows: Sequence[Checked]) -> list[Checked]:
    """Mechanisms in the order of the table."""
    return sorted(rows, key=lambda each: (each.one.stones, each.severity, each.part.element.name, way_words(each.part.direction)))


def _by_code(part: ElementAnalysis, table: CheckTable, ground: Ground, foot: float) -> Iterator[Checked]:
    """All mechanisms of a part with their checks, on a ground; heights count from a z [m]."""
    for one in part.mechanisms:
        level = level_of(table, one.height, foot)
        check = check_at(table, level, one.oscillator, ground, part.doubt)
        known = not table.checks_displacements or any(each.check == NON_LINEAR for each in check.verdicts)
        yield Checked(part, one, level, check, "" if known else check.unread or _no_displacement(one))


def _unread_alike(rows: list[Checked]) -> list[Checked]:
    """The mechanisms of a part: where the spectrum ends before the period of the one that is followed, it does not answer the others."""
    why = next((row.check.unread for row in rows if row.check is not None and row.check.unread), "")
    if not why:
        return rows
    return [replace(row, check=row.check.without_displacements(why)) if row.check and row.one.mechanism is None else row for row in rows]


def _no_displacement(one: FoundMechanism) -> str:
    """Why a mechanism has no check by displacements."""
    if one.mechanism is None:
        return "another mechanism of this part and push has a smaller a0* and is held as high: that one is followed"
    return one.oscillator.doubt or one.oscillator.end


def least_of(rows: Sequence[Checked]) -> list[Checked]:
    """The governing mechanism of each part and push."""
    first: dict[tuple[str, str], Checked] = {}
    for each in rows:
        first.setdefault((each.part.element.name, way_words(each.part.direction)), each)
    return list(first.values())


def gravest(rows: Sequence[Checked]) -> Checked | None:
    """The mechanism that decides: of the worst state the least ratio, stones that slide only where all others are in a better one.

    None without a check.
    """
    made = [each for each in rows if each.decides is not None]
    return min(made, key=lambda each: (each.severity[0], each.one.stones, each.severity[1]), default=None)


def weakest_of(rows: Sequence[Checked]) -> Checked | None:
    """The mechanism that meets the least share of its demand, whatever its state; stones that slide only where there is nothing else.

    None without a check. Its acceleration just borne, its return period and its class of risk are those of the structure: the mechanism
    that decides may bear more, where its check is not decided and others are satisfied.
    """
    made = [each for each in rows if each.decides is not None]
    return min(made, key=lambda each: (each.one.stones, each.severity[1]), default=None)


def looked_at(each: Checked, rows: Sequence[Checked]) -> list[Checked]:
    """The mechanisms of the part of one that were looked at, itself first."""
    return [each, *(other for other in rows if other.part is each.part and other is not each)]


def way_words(direction: np.ndarray) -> str:
    """A level direction as a user writes it: "-x", or its components."""
    for name, (x, y) in AXES.items():
        if abs(direction[0] - x) + abs(direction[1] - y) < 1e-9:
            return name
    return f"[{direction[0]:.3g}, {direction[1]:.3g}]"
