# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders of studies made by hand: a capacity and a demand that are known, so that what is fitted is known, too.

The structure is a column of three blocks. Its record m has the capacity theta exp(e_m + f) [m/s2], where e_m is its own, of a scatter
``between``, and f that of the run, by friction. Openings follow the ratio of the intensity to the capacity.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from made_run import at_rest, box, shifted, write_run

COLLAPSE = {"quantity": "collapsed_blocks", "above": 0}
CRACKED = {"quantity": "max_opening", "above": 1e-3}
COLUMN = [
    box("base", (-1.5, -0.5, -0.3), (1.5, 0.5, 0.0), "base", fixed=True),
    *(box(f"drum{k}", (-0.5, -0.5, k), (0.5, 0.5, k + 1)) for k in range(3)),
]
RESULTS = (
    "max_opening", "max_sliding", "displacement_max", "drift", "collapsed_blocks", "collapse_time", "grade", "grade_number", "steps",
    "steps_missed", "error_max",
)  # fmt: skip


@dataclass
class Made:
    """Contents of a made study."""

    design: str = "stripes"
    records: int = 12
    levels: Sequence[float] = (1.0, 2.0, 3.0, 4.0, 5.0)
    theta: float = 3.0  # median capacity [m/s2]
    between: float = 0.3  # scatter of the records
    by_friction: float = 0.0  # of the capacity, per standard deviation of friction
    seed: int = 1
    limit_states: Mapping[str, Any] = field(default_factory=lambda: {"cracked": CRACKED, "collapse": COLLAPSE})
    measure: str | None = "PGA"
    more: Mapping[str, Any] = field(default_factory=dict)  # to study.json


def rows_of(made: Made) -> list[dict[str, Any]]:
    """A row per run."""
    random = np.random.default_rng(made.seed)
    own = made.between * random.standard_normal(made.records)
    rows = []
    for m in range(made.records):
        levels = list(made.levels) if made.design != "cloud" else list(np.exp(random.normal(np.log(made.theta) - 0.6, 0.7, 3)))
        for level in levels:
            z = float(random.standard_normal())
            capacity = made.theta * np.exp(own[m] + made.by_friction * z)
            ratio = level / capacity
            collapsed = ratio >= 1.0
            opening = 4e-3 * ratio**2 * (100.0 if collapsed else 1.0)
            row = {
                "run": f"{len(rows):08x}", "motion": f"M{m:02d}", "level": "" if made.design == "cloud" else repr(float(level)),
                "seed": "0", "status": "done", "reason": "", "seconds": "1.5", "PGA": repr(float(level)),
                "material.friction": repr(0.6 * float(np.exp(0.15 * z))),
                "PGV": repr(float(0.1 * level * np.exp(0.3 * random.standard_normal()))), "max_opening": repr(float(opening)),
                "max_sliding": repr(float(0.5 * opening)), "displacement_max": repr(float(2 * opening)), "drift": repr(float(opening / 3)),
                "collapsed_blocks": str(int(collapsed)), "collapse_time": "4.2" if collapsed else "",
                "grade": "D4" if collapsed else "D1", "grade_number": "4" if collapsed else "1", "steps": "1000", "steps_missed": "0",
                "error_max": "1e-09",
            }  # fmt: skip
            rows.append(row)
            if made.design == "ida" and collapsed:
                break
    return rows


def write_study_folder(folder: Path, made: Made, rows: Sequence[Mapping[str, Any]] | None = None, joints: bool = False) -> Path:
    """Write study.json and runs.csv, and with ``joints`` also joints/ and reference/; return the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    found = list(rows_of(made) if rows is None else rows)
    asked = {
        "format": 1, "program": "0", "title": "Column", "design": made.design, "seed": made.seed, "scene": "column.toml",
        "measure": made.measure, "levels": list(made.levels) if made.design == "stripes" else None, "varied": ["material.friction"],
        "limit_states": made.limit_states, "keep": "none", "plan": "0", "runs": len(found),
    } | dict(made.more)  # fmt: skip
    (folder / "study.json").write_text(json.dumps(asked), encoding="utf-8")
    header = ["run", "motion", "level", "seed", "status", "reason", "seconds", *asked["varied"], "PGA", "PGV", *RESULTS]
    with (folder / "runs.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, header)
        writer.writeheader()
        writer.writerows(found)
    if joints:
        _write_joints(folder, found)
    return folder


def _write_joints(folder: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """The lowest joint opens as the run says, the others half as far each; where blocks fell the upmost one is lost."""
    (folder / "joints").mkdir(exist_ok=True)
    (folder / "reference").mkdir(exist_ok=True)
    rest = at_rest(COLUMN)
    write_run(folder / "reference" / "result.h5", COLUMN, [rest, shifted(rest, 3, (0.004, 0.0, 0.0))])
    for row in rows:
        if row["status"] == "done":
            opening = np.float32(float(row["max_opening"]) * 0.5 ** np.arange(3))
            lost = np.array([False, False, float(row["collapsed_blocks"]) > 0])
            np.savez(folder / "joints" / f"{row['run']}.npz", opening=opening, sliding=0.1 * opening, lost=lost, shape=7)
