# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of an assessment, as a worker makes it: the steps of a scene that is shaken, and the load factor of one with a table [limit]."""

from __future__ import annotations

import time
from dataclasses import replace

from masonry_cd.analysis.assessment.assessment import UNSETTLED
from masonry_cd.analysis.run_row import DONE, FAILED, RunRow
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.task import Outcome, Task, run_task

SETTLE = "run.settle:"  # in the reason of a run whose joints do not come to rest under the weight


def assess_task(task: Task) -> Outcome:
    """The steps, and the load factor where the scene asks for one."""
    outcome = replace(_stepped(task), joints=None)
    row = outcome.row
    if not row.done or not task.tables.get("limit"):
        return outcome
    factor, reason, seconds = _statics(task)
    numbers = {**row.numbers, "load_factor": factor}
    row = replace(row, numbers=numbers, limit_reason=reason, limit_seconds=seconds, seconds=row.seconds + seconds)
    return replace(outcome, row=row)


def _stepped(task: Task) -> Outcome:
    """The steps; of joints that do not settle under the weight without it having settled, and the row says so."""
    outcome = run_task(task)
    if SETTLE not in outcome.row.reason:
        return outcome
    tables = {**task.tables, "run": {**task.tables["run"], "settle": False}}
    again = run_task(replace(task, tables=tables))
    return replace(again, row=replace(again.row, remark=UNSETTLED))


def limit_task(task: Task) -> Outcome:
    """The load factor alone."""
    factor, reason, seconds = _statics(task)
    status = FAILED if factor is None else DONE
    return Outcome(task.name, RunRow(status, reason, seconds, numbers={"load_factor": factor}, limit_seconds=seconds))


def _statics(task: Task) -> tuple[float | None, str, float]:
    """The load factor of a scene, or why there is none, and the seconds that it took."""
    from masonry_cd.limit.case import limit_case
    from masonry_cd.studies.study.checks import scene_of_run

    begin = time.perf_counter()
    factor, reason = None, ""
    try:
        whole = limit_case(scene_of_run(dict(task.tables))).whole
        assert whole is not None  # there is a load to multiply: the plan has been checked
        analysis = whole.analysis
        if not analysis.stands:
            factor, reason = 0.0, "it does not stand under its dead loads"
        elif analysis.problem.moves_support:
            reason = "supports that move have no load factor"
        else:
            factor = 0.0 if analysis.bears_nothing else analysis.governing.factor
    except InputError as error:
        reason = str(error)
    return factor, reason, time.perf_counter() - begin
