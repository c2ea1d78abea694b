# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd study``: many runs of one scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from masonry_cd.app.result import Result, said
from masonry_cd.cli.printing import warn
from masonry_cd.cli.shared import Force, Output, Planned, Quiet, Retry, Scheduler, Slurm, Trust, Workers, exclude


def study(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="Study file (TOML).", show_default=False)],
    output: Output,
    workers: Workers = None,
    scheduler: Scheduler = None,
    slurm: Slurm = None,
    print_job: Annotated[bool, typer.Option("--print-job", help="Print the job that --slurm would submit, without a run.")] = False,
    retry: Retry = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Require that DIR holds a study; without the option a new one starts there.")
    ] = False,
    plan: Planned = False,
    report: Annotated[bool, typer.Option("--report", help="Repeat fits and pictures from the runs in DIR, without new runs.")] = False,
    force: Force = False,
    quiet: Quiet = False,
    trust: Trust = False,
) -> Result[None]:
    """Run one scene many times: over records, intensities, materials and seeds, on all cores or on a cluster.

    DIR gets runs.csv and runs.parquet, one row per run, and the results from them: fragilities with their bands, pictures, and the page
    study.html. Repeating the command continues the study without repeating finished runs; more records or levels in STUDY add only their
    own runs. With asks = "limit" each scene also gets a limit analysis, and DIR gets limits.csv with factors and verdicts over the varied
    keys. Ctrl-C ends a study without losing a finished run.

    \b
    Examples:
      masonry-cd study examples/study_arch.toml -o out/study
      masonry-cd study study.toml -o out/study --workers 8
      masonry-cd study study.toml -o out/study --scheduler tcp://node1:8786
      masonry-cd study study.toml -o out/study --slurm slurm.toml
    """
    from masonry_cd.foundation.errors import InputError
    from masonry_cd.studies.study import command
    from masonry_cd.studies.study.clusters import job_script
    from masonry_cd.studies.study.study_case import StudyOptions, plan_of

    exclude(("--report", report), ("--force", force))
    made = plan_of(study)
    if print_job:
        if slurm is None:
            raise InputError("--print-job", "shows a Slurm job; add --slurm CONFIG")
        return Result(None, job_script(slurm).splitlines())
    if plan:
        return Result(None, [made.line])
    if report:
        return command.report(made, output)
    options = StudyOptions(made.where(workers, scheduler, slurm), retry, force, resume, quiet, warn)
    return command.study(made, output, options, said(not quiet))
