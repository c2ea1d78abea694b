# SPDX-License-Identifier: GPL-3.0-or-later
"""The ties of a limit analysis: what each pulls at collapse, for limit.json, ties.csv, lines and pictures. Bars of one name are one tie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from masonry_cd.analysis.limit.problem import Bars
from masonry_cd.foundation.quantities import force
from masonry_cd.mechanics.model.fill import BARS

CSV = "ties.csv"
COLUMNS = ("tie", "block_a", "block_b", "bars", "tension_n", "yield_force_n", "yields")
AT_LIMIT = 1.0 - 1e-6  # share of its yield force from which on a bar counts as yielding; cone programmes end at 1e-8
NOTHING = 1e-5  # share of the mean weight of a block below which a bar pulls nothing: cone programmes end at 1e-8 of all loads


@dataclass(frozen=True, eq=False)
class LimitTie:
    """A tie of n bars and what it pulls."""

    label: str  # its name, or those of its blocks
    names: tuple[str, str]  # of the blocks that its first bar holds
    blocks: np.ndarray  # (n, 2)
    points: np.ndarray  # (n, 2, 3) as built [m]
    tension: np.ndarray  # (n,) [N]
    strength: np.ndarray  # (n,) force at which a bar yields, inf where it never does [N]

    @property
    def total(self) -> float:
        """Tension of the tie [N]."""
        return float(self.tension.sum())

    @cached_property
    def yields(self) -> bool:
        """Return True if a bar of it yields."""
        return bool((self.tension >= AT_LIMIT * self.strength).any())

    @property
    def words(self) -> str:
        """Describe the tie at collapse."""
        return "slack" if self.total == 0.0 else force(self.total) + (", yields" if self.yields else "")

    def row(self) -> dict[str, Any]:
        """For limit.json and ties.csv."""
        limit = float(self.strength.sum())
        cells = (self.label, *self.names, len(self.tension), self.total, limit if np.isfinite(limit) else None, self.yields)
        return dict(zip(COLUMNS, cells, strict=True))


def limit_ties(names: Sequence[str], bars: Bars, pulls: np.ndarray, blocks: Sequence[str], weight: float) -> list[LimitTie]:
    """The ties by the names of their T bars, in the order in which they were given.

    Args:
        names: (T,) of the bars, empty where one was given none.
        bars: T.
        pulls: (T,) tension of the bars [N].
        blocks: names of all.
        weight: mean one of a block [N].
    """
    tension = np.where(pulls > NOTHING * weight, pulls, 0.0)
    whose = [name or f"\0{i}" for i, name in enumerate(names)]
    found = []
    for name in dict.fromkeys(whose):
        mine = np.array([i for i, other in enumerate(whose) if other == name])
        ends = blocks[bars.blocks[mine[0], 0]], blocks[bars.blocks[mine[0], 1]]
        label = names[mine[0]] or f"{ends[0]} to {ends[1]}"
        found.append(LimitTie(label, ends, bars.blocks[mine], bars.points[mine], tension[mine], bars.strength[mine]))
    return found


def tie_lines(ties: Sequence[LimitTie], most: int) -> list[str]:
    """Return a line on the pull of each tie; of more than ``most`` those that pull most."""
    first = sorted(ties, key=lambda tie: -tie.total)[:most]
    lines = [f"{_named(tie)}: {tie.words} at collapse" for tie in ties if tie in first]
    return [*lines, f"{len(ties) - most} more ties: see {CSV}"] if len(ties) > most else lines


def _named(tie: LimitTie) -> str:
    """A tie, or the fill that resists as one."""
    return tie.label if tie.label.startswith(BARS) else f'tie "{tie.label}"'
