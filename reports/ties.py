# SPDX-License-Identifier: GPL-3.0-or-later
"""The ties of a run: ties.csv, lines with their tension in a picture, and lines for the page."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from masonry_cd.analysis.deformed import Pose, Solids
from masonry_cd.analysis.ties import histories
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.quantities import force
from masonry_cd.io.results import Results
from masonry_cd.io.summary_tables import TieTension
from reports.drawing.parts import Ties

CSV = "ties.csv"
COLUMNS = ("tie", "block_a", "block_b", *tuple(TieTension.model_fields)[2:])


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


def write_ties(results: Results, folder: Path) -> None:
    """Write ties.csv; nothing without ties."""
    rows = [tie.row() for tie in histories(results)]
    if rows:
        cells = ([row.name, *row.blocks, *(getattr(row, name) for name in COLUMNS[3:])] for row in rows)
        write_csv(folder / CSV, COLUMNS, cells, digits=10)


def ties_at(results: Results, solids: Solids, pose: Pose, factor: float) -> Ties:
    """The ties at a frame; displacements are drawn amplified by a factor."""
    ends, texts, tension = [], [], []
    for tie in histories(results):
        blocks = np.array([bar.blocks for bar in tie.bars])
        moved = [pose.moved(solids, np.array([bar.points[k] for bar in tie.bars]), blocks[:, k], factor) for k in range(2)]
        weight = np.array([bar.section for bar in tie.bars]) / tie.area
        ends.append([weight @ points for points in moved])
        now = tie.at(pose.time)
        yielded = tie.yielding[: max(1, int(np.searchsorted(tie.time, pose.time * (1.0 + 1e-12), side="right")))].any()
        tension.append(now)
        texts.append(("slack" if now == 0.0 else force(now)) + (", has yielded" if yielded else ""))
    return Ties(np.array(ends, dtype=float).reshape(-1, 2, 3), tuple(texts), np.array(tension))
