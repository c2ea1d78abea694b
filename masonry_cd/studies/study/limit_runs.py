# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analyses instead of runs: a study with ``asks = "limit"`` has a table of factors and verdicts over what varies.

limits.csv has a row for each: what varied, whether the structure stands, the associated factor, the least found with its starts, their
agreement and spread, and of a code check the one verdict with demand, capacity and ratio.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from masonry_cd.app.scene import Scene
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.studies.study.plan import StudyPlan
from masonry_cd.studies.study.table import Rows

LIMITS = "limits.csv"
COLUMNS = (
    "stands", "associated", "least", "starts", "agreeing", "spread", "a0", "demand", "ratio", "verdict", "mechanism", "decides",
)  # fmt: skip
SHOWN = ("associated", "least", "ratio", "verdict")  # of the table that the command prints


def limit_row(scene: Scene) -> dict[str, Any]:
    """The limit analysis of a scene as a row, and of its macro-elements where it names some.

    Raises:
        InputError: a limit analysis without an answer.
    """
    from masonry_cd.limit.case import WantedMechanisms, limit_case

    case = limit_case(scene, wanted=WantedMechanisms(jobs=1))
    whole, verdict = case.whole, case.verdict
    found: dict[str, Any] = dict.fromkeys(COLUMNS)
    if whole is not None:
        analysis, least = whole.analysis, whole.analysis.least
        found |= {"stands": analysis.stands, "starts": analysis.starts}
        if analysis.stands and not analysis.bears_nothing:
            found["associated"] = analysis.associated.factor
        if least is not None:
            found |= {"least": least.optimum.factor, "agreeing": least.agreeing, "spread": least.spread}
        found["mechanism"] = f"{int(whole.collapse.mechanism.moving.sum())} blocks move"
    if verdict is not None:
        found |= {
            "a0": verdict.capacity,
            "demand": verdict.demand,
            "ratio": verdict.ratio,
            "verdict": verdict.state,
            "decides": verdict.reason,
        }
    return found


def write_limits(folder: Path, plan: StudyPlan, rows: Rows) -> None:
    """Write limits.csv, of the analyses that have ended."""
    varied, cells = plan.maker.space.varied.columns, []
    for run in plan.ordered():
        if run.name in rows:
            row, values = rows[run.name], run.asked.values
            made = row.limit or {}
            cells.append([run.name, *map(values.get, varied), row.status, *map(made.get, COLUMNS), row.reason])
    write_csv(folder / LIMITS, ("run", *varied, "status", *COLUMNS, "reason"), (map(_text, line) for line in cells))


def limit_lines(plan: StudyPlan, rows: Rows) -> list[str]:
    """The table as text, a line for each analysis that is done."""
    out = []
    for run in plan.ordered():
        made = rows[run.name].limit if run.name in rows else None
        if made:
            of = ", ".join(f"{key} = {_text(value)}" for key, value in run.asked.values.items()) or "the scene as it is"
            out.append(f"{of}: " + ", ".join(f"{key} {_text(made[key])}" for key in SHOWN if made[key] is not None))
    return out


def _text(value: object) -> str:
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
