# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``masonry-cd assess``: the runs of a scene's assumptions are made, by the engine of studies, and what they say is written."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from masonry_cd import __version__
from masonry_cd.analysis.assessment.assessment import FILE, Assessment, Known, Member, as_facts
from masonry_cd.app.doubts import doubts
from masonry_cd.app.scene import Scene
from masonry_cd.app.summary import write_json
from masonry_cd.studies.assess.assumptions import NUMERICAL, Level
from masonry_cd.studies.assess.plan import AssessPlan
from masonry_cd.studies.assess.task import assess_task, limit_task
from masonry_cd.studies.study.checks import check_first
from masonry_cd.studies.study.plan import Maker, Plan, Planned
from masonry_cd.studies.study.study_case import Options, Rows, Ways, study_case

Say = Callable[[str], None]


def assess_case(plan: AssessPlan, folder: Path, options: Options, say: Say) -> dict[str, Any]:
    """Make the runs of an assessment that are missing, and write assess.json.

    Returns:
        as :func:`masonry_cd.studies.study.study_case.study_case`.

    Raises:
        InputError: a scene that cannot be run, the folder of another one.
        Interrupted: by a signal; finished runs are kept.
    """
    function, check = (assess_task, check_first) if plan.shakes else (limit_task, check_statics)
    ways = Ways(function, partial(_write, plan), lambda made: (*plan.doubtful, *check(made)), maps=False)
    return study_case(plan, folder, options, say, ways)


def cost_in_words(plan: AssessPlan) -> str:
    """How many runs there are, and how long they take in terms of the base case."""
    once = {run.name: run.weight for run in plan.runs}
    work = sum(once.values()) / plan.runs[0].weight
    return f"{plan.maker.study.title}: {len(once)} runs, which cost about as much as {work:.0f} of the base case"


def _write(plan: AssessPlan, folder: Path, runs: Sequence[Planned], maker: Maker, rows: Rows) -> None:
    """Write assess.json of the runs that have ended."""
    del runs, maker
    known = [
        Known(
            one.name,
            one.base,
            _names(one.levels),
            one.reference,
            one.name in NUMERICAL,
            _names(level for level in one.levels if level.coarser),
        )
        for one in plan.known
    ]
    members = []
    for part, run in zip(plan.parts, plan.runs, strict=True):
        row = {key: value for key, value in rows.get(run.name, {}).items() if key not in ("parts", "values", "motion", "level")}
        members.append(Member(part.kind, part.values(), row | ({"run": run.name, "member": part.member} if row else {})))
    left = tuple((one.name, one.why) for one in plan.left_out)
    study = plan.maker.study
    found = Assessment(study.title, study.scene_name, tuple(known), left, tuple(members), __version__)
    write_json(as_facts(found), folder / FILE)


def _names(levels: Iterable[Level]) -> tuple[str, ...]:
    return tuple(level.name for level in levels)


def check_statics(plan: Plan) -> list[str]:
    """Check that there is something for limit analysis to multiply.

    Returns:
        values that are likely in another unit.

    Raises:
        InputError: anything wrong with the structure, the loads or [limit].
    """
    from masonry_cd.app.limit_structure import limit_structure
    from masonry_cd.app.limit_vehicle import somewhere

    scene: Scene = plan.maker.study.scene
    structure = limit_structure(somewhere(scene))
    with scene.locating():
        structure.loads()
    return doubts(scene, structure.assembly, structure.joints)
