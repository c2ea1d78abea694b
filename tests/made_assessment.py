# SPDX-License-Identifier: GPL-3.0-or-later
"""Assessments made by hand: what each assumption does is known, so that what is said of it is known, too."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.assessment.assessment import BASE, ENSEMBLE, FILE, LEVEL, PAIR, Assessment, KnownAssumption, Member
from masonry_cd.analysis.run_row import RunRow, row_of

KNOWN = (
    KnownAssumption("joint stiffness", "rigid", ("E 3.3 GPa", "E 700 MPa")),
    KnownAssumption("friction", "0.5", ("0.4", "0.6")),
    KnownAssumption("damping", "none", ("0 %", "5 %"), reference="0 %"),
    KnownAssumption("time step", "4 ms", ("2 ms",), numerical=True),
    KnownAssumption("tolerance", "1e-05", ("1e-06",), numerical=True),
)
LEVELS = {
    ("joint stiffness", "E 3.3 GPa"): 120.0,
    ("joint stiffness", "E 700 MPa"): 240.0,
    ("friction", "0.4"): 101.0,
    ("friction", "0.6"): 98.0,
    ("damping", "0 %"): 180.0,
    ("damping", "5 %"): 176.0,
    ("time step", "2 ms"): 103.0,
    ("tolerance", "1e-06"): 97.0,
}
"""Largest displacements [mm]; that of the base case is 100."""
CHANCE = 3.0  # standard deviation of the ensemble [mm]


def row(millimetres: float, **more: Any) -> RunRow:
    """The row of a run, all of whose answers follow from one; fields of the row or numbers may be others."""
    grade = 2 if millimetres < 150.0 else 4
    numbers = {
        "displacement_max": 1e-3 * millimetres, "max_opening": 5e-4 * millimetres, "residual_opening": 1e-4 * millimetres,
        "grade_number": grade, "grade": f"D{grade}", "collapsed_blocks": 0, "load_factor": None,
        "steps": 100, "steps_missed": 0, "error_max": 1e-6, "provisional": None,
    }  # fmt: skip
    return row_of({"status": "done", "reason": "", "seconds": 1.5} | numbers | more)


def made(
    levels: Mapping[tuple[str, str], float | RunRow] | None = None,
    chance: float = CHANCE,
    pairs: Mapping[tuple[str, ...], float] | None = None,
) -> Assessment:
    """An assessment; a level may have a row of its own in the place of a displacement."""
    spread = chance * np.array([0.0, 1.0, -1.0, 1.2, -0.8, 0.4, -1.4, 0.6])
    members = [Member(BASE if k == 0 else ENSEMBLE, {}, row(100.0 + float(by)), f"e{k}", k) for k, by in enumerate(spread)]
    for (name, level), value in (LEVELS | dict(levels or {})).items():
        members.append(Member(LEVEL, {name: level}, value if isinstance(value, RunRow) else row(value), f"{name} {level}"))
    for (first, one, second, other), value in dict(pairs or {}).items():
        members.append(Member(PAIR, {first: one, second: other}, row(value)))
    return Assessment("Made", "made.toml", KNOWN, (("bond", "no key for its bond"),), tuple(members), "1.2.3")


def written(folder: Path, found: Assessment) -> Path:
    """The folder with an assessment in it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / FILE).write_text(json.dumps(found.as_dict()), encoding="utf-8")
    return folder
