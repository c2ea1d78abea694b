# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``masonry-cd assess``: the runs of a scene's assumptions are made, by the engine of studies, and what they say is written."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from masonry_cd import __version__
from masonry_cd.analysis.assessment.assessment import FILE, GLOBAL, Assessment, Member
from masonry_cd.analysis.assessment.verdict import lines_of, warnings_of
from masonry_cd.analysis.run_row import RunRow
from masonry_cd.app.doubts import doubts
from masonry_cd.app.result import Result, Say
from masonry_cd.foundation.json_files import write_json
from masonry_cd.studies.assess.plan import AssessPlan
from masonry_cd.studies.assess.task import assess_task, limit_task
from masonry_cd.studies.study.checks import check_first
from masonry_cd.studies.study.plan import StudyPlan
from masonry_cd.studies.study.study_case import RunActions, StudyOptions, make_runs


def assess(plan: AssessPlan, folder: Path, options: StudyOptions, say: Say) -> Result[Assessment | None]:
    """Make the runs of an assessment that are missing, and write what they say.

    Raises:
        InputError: a scene that cannot be run, the folder of another one.
    """
    function, check = (assess_task, check_first) if plan.shakes else (limit_task, check_statics)

    def write(folder: Path, _: StudyPlan, rows: Mapping[str, RunRow]) -> None:
        write_json(folder / FILE, assessment_of(plan, rows).as_dict())

    made = make_runs(plan, folder, options, say, RunActions(write, function, lambda made: (*plan.doubtful, *check(made))))
    return made.ended_early() if made.stopped else report(folder)


def report(folder: Path) -> Result[Assessment | None]:
    """Write again what follows from the runs in a folder.

    Raises:
        InputError: the folder holds no assessment.
    """
    from reports.assess.outputs import FILES, text_table, write_assessment

    found = write_assessment(folder)
    table = [text_table(found), ""] if found.base.row.done else []
    return Result(found, [*table, *lines_of(found)], warnings_of(found), [folder / name for name in FILES if (folder / name).exists()])


def cost_in_words(plan: AssessPlan) -> str:
    """How many runs there are, and how long they take in terms of the base case."""
    once = {run.name: run.weight for run in plan.runs}
    work = sum(once.values()) / plan.runs[0].weight
    sampled = len({run.name for part, run in zip(plan.parts, plan.runs, strict=True) if part.kind == GLOBAL})
    all_vary = f", {sampled} of them with {len(plan.unknown)} properties varied at once" if sampled else ""
    return f"{plan.maker.study.title}: {len(once)} runs{all_vary}, which cost about as much as {work:.0f} of the base case"


def assessment_of(plan: AssessPlan, rows: Mapping[str, RunRow]) -> Assessment:
    """Return the assessment by the runs that have ended."""
    members = []
    for part, run in zip(plan.parts, plan.runs, strict=True):
        row = rows.get(run.name, RunRow())
        of = (run.name, part.member) if row.status else ("", 0)
        members.append(Member(part.kind, part.values(), row, *of, part.at))
    left, study = tuple((one.name, one.why) for one in plan.left_out), plan.maker.study
    single, sampled = (tuple(one for one in members if (one.kind == GLOBAL) == at_once) for at_once in (False, True))
    known, unknowns = tuple(one.known for one in plan.known), tuple(one.unknown for one in plan.unknown)
    return Assessment(study.title, study.scene_name, known, left, single, __version__, unknowns, sampled)


def check_statics(plan: StudyPlan) -> list[str]:
    """Check that there is something for limit analysis to multiply.

    Returns:
        values that are likely in another unit.

    Raises:
        InputError: anything wrong with the structure, the loads or [limit].
    """
    from masonry_cd.app.limit_structure import limit_structure
    from masonry_cd.limit.vehicle import somewhere

    scene = plan.maker.study.scene
    structure = limit_structure(somewhere(scene))
    with scene.locating():
        structure.loads()
    return doubts(scene, structure.assembly, structure.joints)
