# SPDX-License-Identifier: GPL-3.0-or-later
"""What the ties of a run had to bear, in a file and in pictures: ties.csv, and lines for the page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.ties import histories
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.io.results import Results

CSV = "ties.csv"
COLUMNS = (
    "tie", "block_a", "block_b", "bars", "length", "area", "yield_force", "tension_start", "tension_max", "tension_max_time",
    "stress_max", "tension_end", "yielded", "yield_time",
)  # fmt: skip


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
        write_csv(folder / CSV, COLUMNS, map(_cells, rows), digits=10)
    return rows


def _cells(row: dict[str, Any]) -> list[object]:
    named = row | {"tie": row["name"], "block_a": row["blocks"][0], "block_b": row["blocks"][1]}
    return [named[column] for column in COLUMNS]
