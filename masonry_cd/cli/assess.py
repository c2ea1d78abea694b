# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd assess``: what the answer of a scene rests on."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result, said
from masonry_cd.cli.printing import warn
from masonry_cd.cli.shared import Changes, Force, Output, Planned, Quiet, Retry, SceneFile, Trust


def assess(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    all_pairs: Annotated[
        bool, typer.Option("--all-pairs", help="Also vary every pair of assumptions together, at two levels each.")
    ] = False,
    at_once: Annotated[
        bool, typer.Option("--global", help="Also vary all properties of the structure together, and find the share of each in the answer.")
    ] = False,
    workers: Annotated[int | None, typer.Option(metavar="N", min=1, help="Processes on this machine.", show_default="all cores")] = None,
    retry: Retry = False,
    plan: Planned = False,
    report: Annotated[bool, typer.Option("--report", help="Write the results again from the runs in DIR, without new runs.")] = False,
    force: Force = False,
    quiet: Quiet = False,
    trust: Trust = False,
) -> Result[Any]:
    """Vary each assumption of a scene on its own, and rank them by their effect on the answer.

    The assumptions are the stiffness of the joints, friction, the size of the blocks, their bond, damping, the points of elastic joints,
    the time step and the tolerance. A small ensemble of the scene itself shows the effect of chance. With a table [limit] the load factor
    is one of the answers. The table [assess] sets other ranges.

    With --global further runs vary all properties of the structure together. A surrogate fitted to them gives Sobol indices: the share of
    the variance of each answer that a property explains alone, and with the others. A poor surrogate gives none.

    DIR gets assess.png, a tornado chart, the page assess.html, assess.csv and assess.json. Repeating the command continues where
    the last one ended.

    \b
    Examples:
      masonry-cd assess examples/arch.toml -o out/arch_assess
      masonry-cd assess church.toml -o out/church_assess --workers 2
      masonry-cd assess church.toml -o out/church_assess --all-pairs
      masonry-cd assess church.toml -o out/church_assess --global --plan
    """
    from masonry_cd.app.scene import read_scene
    from masonry_cd.foundation.errors import InputError
    from masonry_cd.studies.assess import command
    from masonry_cd.studies.assess.plan import AssessPlan
    from masonry_cd.studies.study.study_case import StudyOptions

    if report:
        found = command.report(output)
    else:
        made = AssessPlan(read_scene(scene, set_ or ()), all_pairs, at_once)
        if plan:
            return Result(None, [command.cost_in_words(made)])
        options = StudyOptions(made.where(workers), retry, force, quiet=quiet, warn=warn)
        found = command.assess(made, output, options, said(not quiet))
    if found.value is not None and not found.value.base.row.done:
        raise InputError("", found.lines[0])
    return found
