# SPDX-License-Identifier: GPL-3.0-or-later
"""Assessments made by hand: what each assumption does is known, so that what is said of it is known, too."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.assessment.assessment import BASE, ENSEMBLE, FILE, LEVEL, PAIR, Assessment, Known, Member, as_facts

KNOWN = (
    Known("joint stiffness", "rigid", ("E 3.3 GPa", "E 700 MPa")),
    Known("friction", "0.5", ("0.4", "0.6")),
    Known("damping", "none", ("0 %", "5 %"), reference="0 %"),
    Known("time step", "4 ms", ("2 ms",), numerical=True),
    Known("tolerance", "1e-05", ("1e-06",), numerical=True),
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


def row_of(millimetres: float, **more: Any) -> dict[str, Any]:
    """The row of a run, all of whose answers follow from one."""
    grade = 2 if millimetres < 150.0 else 4
    return {
        "status": "done", "reason": "", "run": f"{millimetres:g}",
        "displacement_max": 1e-3 * millimetres, "max_opening": 5e-4 * millimetres, "residual_opening": 1e-4 * millimetres,
        "grade_number": grade, "grade": f"D{grade}", "collapsed_blocks": 0, "load_factor": None,
        "steps": 100, "steps_missed": 0, "error_max": 1e-6, "provisional": None, "seconds": 1.5,
    } | more  # fmt: skip


def made(
    levels: Mapping[tuple[str, str], float | dict[str, Any]] | None = None,
    chance: float = CHANCE,
    pairs: Mapping[tuple[str, ...], float] | None = None,
) -> Assessment:
    """An assessment; a level may have a row of its own in the place of a displacement."""
    spread = chance * np.array([0.0, 1.0, -1.0, 1.2, -0.8, 0.4, -1.4, 0.6])
    members = [Member(BASE if k == 0 else ENSEMBLE, {}, row_of(100.0 + float(by), member=k)) for k, by in enumerate(spread)]
    for (name, level), value in (LEVELS | dict(levels or {})).items():
        members.append(Member(LEVEL, {name: level}, value if isinstance(value, dict) else row_of(value)))
    for (first, one, second, other), value in dict(pairs or {}).items():
        members.append(Member(PAIR, {first: one, second: other}, row_of(value)))
    return Assessment("Made", "made.toml", KNOWN, (("bond", "no key for its bond"),), tuple(members), "1.2.3")


def written(folder: Path, found: Assessment) -> Path:
    """The folder with an assessment in it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / FILE).write_text(json.dumps(as_facts(found)), encoding="utf-8")
    return folder
