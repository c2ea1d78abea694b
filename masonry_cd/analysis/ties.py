# SPDX-License-Identifier: GPL-3.0-or-later
"""Tensions of the ties of a run. Bars of one name are one tie, whose tension is their sum."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from masonry_cd.io.results import Results
from masonry_cd.io.summary_tables import TieTension
from masonry_cd.io.tie_bars import TieBar
from masonry_cd.mechanics.model.fill import BARS

AT_LIMIT = 1.0 - 1e-9  # share of its yield force from which on a bar counts as yielding


@dataclass(frozen=True, eq=False)
class TieHistory:
    """A tie over the N steps of a run."""

    name: str
    label: str  # its name, or those of its blocks
    bars: tuple[TieBar, ...]
    blocks: tuple[str, str]  # that its strongest bar holds
    time: np.ndarray  # (N,) [s]
    tension: np.ndarray  # (N, bars) [N]

    @cached_property
    def total(self) -> np.ndarray:
        """(N,) [N]."""
        return np.asarray(self.tension.sum(axis=1))

    @property
    def area(self) -> float:
        """Area of its section [m2]."""
        return float(sum(bar.section for bar in self.bars))

    @property
    def yielding(self) -> np.ndarray:
        """(N,) whether a bar of it yields."""
        return np.asarray((self.tension >= AT_LIMIT * np.array([bar.limit for bar in self.bars])).any(axis=1))

    def at(self, time: float) -> float:
        """Tension in the last step up to a time [N]; before the first step that of the first."""
        return float(self.total[max(0, int(np.searchsorted(self.time, time * (1.0 + 1e-12), side="right")) - 1)])

    def row(self) -> TieTension:
        """Its row of ties.csv and of the summary."""
        worst, yields = int(np.argmax(self.total)), np.flatnonzero(self.yielding)
        limit = float(sum(bar.limit for bar in self.bars))
        ends = max(self.bars, key=lambda bar: bar.section).points
        return TieTension(
            name=self.label,
            blocks=self.blocks,
            bars=len(self.bars),
            length=float(np.sqrt(((ends[1] - ends[0]) ** 2).sum())),
            area=self.area,
            yield_force=limit if np.isfinite(limit) else None,
            tension_start=float(self.total[0]),
            tension_max=float(self.total[worst]),
            tension_max_time=float(self.time[worst]),
            stress_max=float(self.total[worst]) / self.area,
            tension_end=float(self.total[-1]),
            yielded=bool(len(yields)),
            yield_time=float(self.time[yields[0]]) if len(yields) else None,
        )


def histories(results: Results) -> list[TieHistory]:
    """The ties of a run, in the order in which they were given, without the bars by which fill resists; none before its first step."""
    tension, time = results.per_step("ties/tension"), results.per_step("step_time")
    bars = results.ties
    if not bars or not len(tension):
        return []
    names = [bar.name or f"\0{i}" for i, bar in enumerate(bars)]
    found = []
    for name in dict.fromkeys(name for name in names if not name.startswith(BARS)):
        mine = [i for i, other in enumerate(names) if other == name]
        strongest = max(mine, key=lambda i: bars[i].section)
        first, second = (results.blocks[b].name for b in bars[strongest].blocks)
        label = bars[mine[0]].name or f"{first} to {second}"
        count = min(len(tension), len(time))
        found.append(
            TieHistory(bars[mine[0]].name, label, tuple(bars[i] for i in mine), (first, second), time[:count], tension[:count][:, mine])
        )
    return found
