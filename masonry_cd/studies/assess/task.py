# SPDX-License-Identifier: GPL-3.0-or-later
"""A run of an assessment, as a worker makes it: the steps of a scene that is shaken, and the load factor of one with a table [limit]."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

from masonry_cd.analysis.assessment.assessment import UNSETTLED
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.task import Outcome, Task, run_task

SETTLE = "run.settle:"  # in the reason of a run whose joints do not come to rest under the weight


def assess_task(task: Task) -> Outcome:
    """The steps, and the load factor where the scene asks for one."""
    outcome = replace(_stepped(task), joints=None)
    if outcome.row["status"] != "done" or not task.tables.get("limit"):
        return outcome
    found = _statics(task)
    return replace(outcome, row={**outcome.row, **found, "seconds": outcome.row["seconds"] + found["limit_seconds"]})


def _stepped(task: Task) -> Outcome:
    """The steps; of joints that do not settle under the weight without it having settled, and the row says so."""
    outcome = run_task(task)
    if SETTLE not in outcome.row["reason"]:
        return outcome
    tables = {**task.tables, "run": {**task.tables["run"], "settle": False}}
    again = run_task(replace(task, tables=tables))
    return replace(again, row={**again.row, "remark": UNSETTLED})


def limit_task(task: Task) -> Outcome:
    """The load factor alone."""
    found = _statics(task)
    status = "done" if found["load_factor"] is not None else "failed"
    return Outcome(
        task.name, {"status": status, "reason": found.pop("limit_reason"), "seconds": found["limit_seconds"], "worker": "", **found}
    )


def _statics(task: Task) -> dict[str, Any]:
    """The load factor of a scene, or why there is none."""
    from masonry_cd.app.limit_case import case_of
    from masonry_cd.studies.study.checks import scene_of_run

    begin = time.perf_counter()
    factor, reason = None, ""
    try:
        analysis = case_of(scene_of_run(dict(task.tables))).analysis
        if not analysis.stands:
            factor = 0.0
            reason = "it does not stand under its dead loads"
        elif analysis.problem.moves_support:
            reason = "supports that move have no load factor"
        else:
            factor = 0.0 if analysis.bears_nothing else analysis.governing.factor
    except InputError as error:
        reason = str(error)
    return {"load_factor": factor, "limit_reason": reason, "limit_seconds": time.perf_counter() - begin}
