# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd study``: many runs of one scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.progress import Interrupted
from masonry_cd.cli.shared import Force, Output, Quiet, Trust, errors_reported, exclude, same_command, warn
from masonry_cd.foundation.errors import InputError

REASONS = 5  # named at the end; the others are counted


def study(
    study: Annotated[Path, typer.Argument(metavar="STUDY", help="Study file (TOML).", show_default=False)],
    output: Output,
    workers: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Processes of this machine.", show_default="run.workers, or all cores")
    ] = None,
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Of a dask scheduler that runs: tcp://host:8786.")] = None,
    slurm: Annotated[Path | None, typer.Option(metavar="CONFIG", help="Workers as jobs of Slurm, by this file (TOML).")] = None,
    retry: Annotated[bool, typer.Option("--retry", help="Make runs again that failed or ran out of time.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Refuse a DIR that holds no study; else it goes on without it as well.")] = False,
    plan: Annotated[bool, typer.Option("--plan", help="Check the study, print how many runs it has, and make none.")] = False,
    report: Annotated[bool, typer.Option("--report", help="Fit and draw again from the runs in DIR; make none.")] = False,
    force: Force = False,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Make many runs of one scene: over records, intensities, materials, and seeds, on all cores or on a cluster.

    DIR gets runs.csv and runs.parquet, one row per run, and what follows from them: fragilities with their bands, pictures, and the page
    study.html. The same command again goes on where the last one ended, and makes no finished run again; more records or levels in STUDY
    make only their own runs. With asks = "limit" each scene gets a limit analysis, and DIR limits.csv, factors and verdicts over what
    varies. Ctrl-C ends a study without losing a finished run.

    \b
    Examples:
      masonry-cd study examples/study_arch.toml -o out/study
      masonry-cd study study.toml -o out/study --workers 8
      masonry-cd study study.toml -o out/study --scheduler tcp://node1:8786
      masonry-cd study study.toml -o out/study --slurm slurm.toml
    """
    with errors_reported():
        from masonry_cd.studies.study.clusters import Where
        from masonry_cd.studies.study.study_case import Options, plan_of, study_case

        exclude(("--scheduler", scheduler), ("--slurm", slurm))
        exclude(("--workers", workers), ("--scheduler or --slurm", scheduler or slurm))
        exclude(("--report", report), ("--force", force))
        made = plan_of(study)
        if plan:
            asked = made.maker.study
            typer.echo(
                f"{asked.title}: {len(made.runs)} runs{', and those that follow' if made.adapts else ''}, design {asked.tables.design}"
            )
            return
        run = made.maker.study.tables.run
        limits = made.maker.study.tables.asks == "limit"
        if report and limits:
            raise InputError("--report", "a study of limit analyses has limits.csv and no fits")
        if report:
            _write_report(output, quiet)
            return
        where = Where(scheduler, slurm, workers or run.workers, run.memory, run.timeout + run.grace)
        options = Options(where, retry, force, resume, quiet, warn)
        go_on = same_command()
        try:
            found = study_case(made, output, options, lambda line: None if quiet else typer.echo(line, err=True))
        except Interrupted:
            typer.echo(go_on, err=True)
            raise
        tell_end(found, output, quiet)
        if not found["stopped"] and not limits:
            _write_report(output, quiet)
    if found["stopped"]:
        typer.echo(f"masonry-cd: error: {found['stopped']}; finished runs are kept\n{go_on}", err=True)
        raise typer.Exit(1)


def tell_end(found: dict[str, Any], output: Path, quiet: bool) -> None:
    """What the study has come to."""
    no_data = found["failed"] + found["timeout"]
    if not quiet:
        typer.echo(f"{found['done']} of {found['runs']} runs done, {found['failed']} failed, {found['timeout']} ran out of time")
        if found.get("limits"):
            typer.echo("\n".join([*found["limits"], f"results: {output / 'limits.csv'}"]))
        else:
            typer.echo(f"results: {output / 'runs.csv'}, {output / 'runs.parquet'}")
    often = sorted(found["reasons"].items(), key=lambda item: -item[1])
    warn(f"{count} of {no_data} runs without data: {reason}" for reason, count in often[:REASONS])
    if others := often[REASONS:]:
        total = sum(count for _, count in others)
        warn([f"{total} of {no_data} runs without data, for {len(others)} other reasons: see {output / 'runs.csv'}"])


def _write_report(output: Path, quiet: bool) -> None:
    """Write what follows from the runs, and tell it."""
    from masonry_cd.analysis.verdict import Verdict
    from reports.study.outputs import write_study

    summary = write_study(output)
    if not quiet:
        typer.echo("\n".join([Verdict(**summary["verdict"]).line, *summary["lines"], f"page: {output / 'study.html'}"]))
    warn(summary["warnings"])
