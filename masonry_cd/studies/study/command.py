# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``masonry-cd study``: the missing runs of a plan are made, their tables are written, and what follows from them."""

from __future__ import annotations

from pathlib import Path

from masonry_cd.analysis.fragility.folder import TABLE, read_facts
from masonry_cd.app.result import Result, Say
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.checks import check_first
from masonry_cd.studies.study.folder import StudyFolder
from masonry_cd.studies.study.limit_runs import LIMITS, limit_lines, write_limits
from masonry_cd.studies.study.plan import StudyPlan
from masonry_cd.studies.study.study_case import RunActions, StudyOptions, hazard_numbers, make_runs
from masonry_cd.studies.study.table import PARQUET, write_table

WAYS = {"run": RunActions(write_table, check=check_first, maps=True), "limit": RunActions(write_limits)}


def study(plan: StudyPlan, folder: Path, options: StudyOptions, say: Say) -> Result[None]:
    """Make the runs of a study that are missing in a folder, and write what they say.

    Raises:
        InputError: a bad study; the folder of another one; a scheduler that does not answer. Nothing is lost.
    """
    asks = plan.maker.study.tables.asks
    made = make_runs(plan, folder, options, say, WAYS[asks])
    tables = [folder / name for name in ((LIMITS,) if asks == "limit" else (TABLE, PARQUET))]
    lines, warnings = [made.line, f"results: {', '.join(map(str, tables))}"], made.warnings(tables[0])
    if made.stopped:
        return made.ended_early(lines, warnings)
    if asks == "limit":
        return Result(None, [*lines, *limit_lines(plan, made.rows)], warnings)
    found = report(plan, folder)
    lines += [] if plan.adaptive is None else [plan.adaptive.line]
    return Result(None, [*lines, *found.lines], [*warnings, *found.warnings])


def report(plan: StudyPlan, folder: Path) -> Result[None]:
    """Fit and draw again from the runs in a folder.

    Raises:
        InputError: no study is there, or something in it is broken.
    """
    from reports.study.outputs import PAGE, write_study

    if plan.maker.study.tables.asks == "limit":
        raise InputError("--report", "a study of limit analyses has limits.csv and no fits")
    here = StudyFolder(folder)
    here.describe(read_facts(folder).model_copy(update={"hazard": hazard_numbers(plan.maker.study)}))  # which is not part of the runs
    found = write_study(folder)
    return Result(None, [found.verdict.line, *found.lines, f"page: {folder / PAGE}"], found.warnings)
