"""What the ties of a run had to bear: ties.csv, the summary's share, and lines in pictures.

Bars of one name are one tie, whose tension is their sum.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.io.results import Results
from masonry_cd.io.tie_bars import TieBar

CSV = "ties.csv"
AT_LIMIT = 1.0 - 1e-9  # share of its yield force from which on a bar counts as yielding
COLUMNS = (
    "tie", "block_a", "block_b", "bars", "length", "area", "yield_force", "tension_start", "tension_max", "tension_max_time",
    "stress_max", "tension_end", "yielded", "yield_time",
)  # fmt: skip


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
        """Of its section [m2]."""
        return float(sum(bar.section for bar in self.bars))

    @property
    def yielding(self) -> np.ndarray:
        """(N,) whether a bar of it yields."""
        return np.asarray((self.tension >= AT_LIMIT * np.array([bar.limit for bar in self.bars])).any(axis=1))

    def at(self, time: float) -> float:
        """Tension in the last step up to a time [N]; before the first step that of the first."""
        return float(self.total[max(0, int(np.searchsorted(self.time, time * (1.0 + 1e-12), side="right")) - 1)])

    def row(self) -> dict[str, Any]:
        """Its row of ties.csv and of the summary."""
        worst, yields = int(np.argmax(self.total)), np.flatnonzero(self.yielding)
        limit = float(sum(bar.limit for bar in self.bars))
        ends = max(self.bars, key=lambda bar: bar.section).points
        return {
            "name": self.label,
            "blocks": list(self.blocks),
            "bars": len(self.bars),
            "length": float(np.sqrt(((ends[1] - ends[0]) ** 2).sum())),
            "area": self.area,
            "yield_force": limit if np.isfinite(limit) else None,
            "tension_start": float(self.total[0]),
            "tension_max": float(self.total[worst]),
            "tension_max_time": float(self.time[worst]),
            "stress_max": float(self.total[worst]) / self.area,
            "tension_end": float(self.total[-1]),
            "yielded": bool(len(yields)),
            "yield_time": float(self.time[yields[0]]) if len(yields) else None,
        }


def histories(results: Results) -> list[TieHistory]:
    """The ties of a run, in the order in which they were given; none before its first step."""
    tension, time = results.per_step("ties/tension"), results.per_step("step_time")
    bars = results.ties
    if not bars or not len(tension):
        return []
    names = [bar.name or f"\0{i}" for i, bar in enumerate(bars)]
    found = []
    for name in dict.fromkeys(names):
        mine = [i for i, other in enumerate(names) if other == name]
        strongest = max(mine, key=lambda i: bars[i].section)
        first, second = (results.blocks[b].name for b in bars[strongest].blocks)
        label = bars[mine[0]].name or f"{first} to {second}"
        count = min(len(tension), len(time))
        found.append(
            TieHistory(bars[mine[0]].name, label, tuple(bars[i] for i in mine), (first, second), time[:count], tension[:count][:, mine])
        )
    return found


def tie_lines(results: Results, origin: np.ndarray) -> dict[str, np.ndarray]:
    """For the page: ends of a line for each tie (2 T, 3) as built, from an origin (3,) [m], and the block that holds each (2 T,)."""
    strongest = [max(tie.bars, key=lambda bar: bar.section) for tie in histories(results)]
    if not strongest:
        return {}
    points = np.concatenate([bar.points for bar in strongest]) - origin
    return {"tie_point": points.astype(np.float32), "tie_block": np.array([bar.blocks for bar in strongest], np.uint32).ravel()}


def tie_tensions(results: Results, times: np.ndarray) -> dict[str, np.ndarray]:
    """For the page: the tension of each tie at some times (F,) [s], (T, F) [N]."""
    ties = histories(results)
    return {"tie_tension": np.array([[tie.at(float(time)) for time in times] for tie in ties], np.float32)} if ties else {}


def write_ties(results: Results, folder: Path) -> list[dict[str, Any]]:
    """Write ties.csv, and return its rows; nothing is written without ties."""
    rows = [tie.row() for tie in histories(results)]
    if rows:
        write_csv(folder / CSV, COLUMNS, map(_cells, rows))
    return rows


def _cells(row: dict[str, Any]) -> Sequence[object]:
    first, second = row["blocks"]
    named = row | {"tie": row["name"], "block_a": first, "block_b": second, "yielded": str(row["yielded"]).lower()}
    return [
        "" if named[column] is None else f"{named[column]:.10g}" if isinstance(named[column], float) else named[column]
        for column in COLUMNS
    ]
