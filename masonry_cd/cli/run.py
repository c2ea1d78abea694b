# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd run``: a scene is computed and its results are written."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from masonry_cd.app.folders import RUN, free_folder
from masonry_cd.app.progress import Interrupted
from masonry_cd.cli.shared import Changes, Force, Output, Quiet, SceneFile, Trust, errors_reported, exclude

if TYPE_CHECKING:
    from masonry_cd.app.case import Case


def run(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    force: Force = False,
    resume: Annotated[bool, typer.Option("--resume", help="Resume a run that was stopped, from its last checkpoint.")] = False,
    dump_problem: Annotated[
        list[str] | None, typer.Option("--dump-problem", metavar="STEP", help="Write the friction problem of this step; 1 or 1,2,9.")
    ] = None,
    explain: Annotated[bool, typer.Option("--explain", help="Say what was left out for this scene, and why.")] = False,
    quiet: Quiet = False,
    trust: Trust = False,
) -> None:
    """Compute a scene and write its results.

    DIR gets result.h5, joints.csv, summary.json, and the pictures that the scene asks for. The whole scene is checked first; bad input
    is reported in one line, with exit code 2, and nothing is written. Ctrl-C, SIGTERM, SIGHUP and SIGQUIT end a run after its current step:
    the results stay readable up to there, and --resume goes on to the same numbers as an unbroken run, as it does after a kill. Problems
    are written to problem_STEP.npz, or where impacts are solved apart to problem_STEP_forces.npz and problem_STEP_impacts.npz, for
    masonry-cd solve and accuracy.

    \b
    Examples:
      masonry-cd run aqueduct.toml -o out/aqueduct
      masonry-cd run aqueduct.toml -o out/aqueduct --resume
      masonry-cd run aqueduct.toml -o out/strong --set loads[0].amplitude=0.4 --set run.duration=5
      masonry-cd run aqueduct.toml -o out/aqueduct --force --set run.solver=nlgs --set run.tolerance=1e-6
    """
    with errors_reported():
        exclude(("--resume", resume), ("--force", force))
        exclude(("--quiet", quiet), ("--explain", explain))
        free_folder(output, RUN, force or resume)
        from masonry_cd.app.scene import read_scene
        from masonry_cd.io import checkpoint

        if resume:
            checkpoint.require(output / checkpoint.NAME)

        asked = read_scene(scene, set_ or ())
        from masonry_cd.app.case import prepare  # numba and the kernels come with it, after the cheap checks
        from masonry_cd.app.dump import parse_steps
        from masonry_cd.app.run_case import run_case

        steps = parse_steps(dump_problem or ())

        prepared = prepare(asked)
        if not quiet:
            _announce(prepared)
        go_on = f"masonry-cd: go on with: {_resuming(scene, output, set_ or ())}"
        try:
            summary = run_case(prepared, output, quiet, resume, steps)
        except Interrupted:
            typer.echo(go_on, err=True)
            raise
        with suppress(OSError) if summary["signal"] else nullcontext():  # the terminal may be what ended the run
            _tell_end(summary, output, quiet, explain)
            if summary["signal"]:
                typer.echo(go_on, err=True)
    if summary["stopped"]:
        raise typer.Exit(128 + summary["signal"] if summary["signal"] else 1)


def _tell_end(summary: dict[str, Any], output: Path, quiet: bool, explain: bool) -> None:
    """What a run has come to."""
    from masonry_cd.app.run_case import file_names
    from masonry_cd.app.summary import closing_lines

    if not quiet:
        typer.echo("\n".join(closing_lines(summary)))
        if explain:
            typer.echo("\n".join(["left out, and why:", *(f"- {line}" for line in summary["explanation"])]))
        written = (name for name in (*file_names(), *summary["dumped"]) if (output / name).exists())
        typer.echo(f"results: {', '.join(str(output / name) for name in written)}")
    for line in summary["warnings"]:
        typer.echo(f"masonry-cd: warning: {line}", err=True)


def _resuming(scene: Path, output: Path, changes: Sequence[str]) -> str:
    """The command that resumes a run."""
    from masonry_cd.foundation.trust import trusted

    trust = ["--trust"] if trusted() else []
    set_ = [word for change in changes for word in ("--set", change)]
    return shlex.join(["masonry-cd", "run", str(scene), "-o", str(output), "--resume", *set_, *trust])


def _announce(prepared: Case) -> None:
    """What is about to be computed."""
    from masonry_cd.app.time_step_summary import announced

    settings = prepared.scene.run
    joints = f"{prepared.assembly.count} blocks, {prepared.joints.count} joints"
    typer.echo(f"{prepared.scene.title}: {joints}, {announced(settings)}, solver {settings.solver}")
    for line in (*prepared.notes, *prepared.loading.lines, *(f"warning: {line}" for line in prepared.warnings)):
        typer.echo(line)
