# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd calibrate``: which values of a model explain what was observed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result, said
from masonry_cd.cli.printing import warn
from masonry_cd.cli.shared import Force, Output, Planned, Quiet, Retry, Scheduler, Slurm, Trust, Workers


def calibrate(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="Study file with [[observations]] (TOML).", show_default=False)],
    output: Output,
    workers: Workers = None,
    scheduler: Scheduler = None,
    slurm: Slurm = None,
    retry: Retry = False,
    plan: Planned = False,
    force: Force = False,
    quiet: Quiet = False,
    trust: Trust = False,
) -> Result[Any]:
    """Find the values of a model that explain the observations of a building: frequencies, mode shapes, cracks, drifts, fallen blocks.

    STUDY is a study file with design = "calibrate": [vary] has the prior distributions, [[observations]] the observations with their
    errors. Samples are drawn round by round where the previous ones were likely, and weighted. DIR gets ranges, correlations and
    predictions in calibrate.json, the page calibrate.html, and posterior.parquet, which [vary] of another study reads by from. With too
    few effective samples there is no answer, and the exit code is 1. Repeating the command continues where the last one ended.

    \b
    Examples:
      masonry-cd calibrate tower.toml -o out/tower
      masonry-cd calibrate tower.toml -o out/tower --workers 2
    """
    from masonry_cd.studies.calibrate import command
    from masonry_cd.studies.calibrate.plan import Calibration
    from masonry_cd.studies.study.study_case import StudyOptions
    from masonry_cd.studies.study.study_file import read_study

    made = Calibration.of(read_study(study))
    where = command.Sampling(made).plan.where(workers, scheduler, slurm)
    if plan:
        return Result(None, [made.line])
    return command.calibrate(made, output, StudyOptions(where, retry, force, quiet=quiet, warn=warn), said(not quiet))
