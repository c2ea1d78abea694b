# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd run``: a scene is computed and its results are written."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result, silent
from masonry_cd.cli.shared import Changes, Force, Output, Quiet, SceneFile, Trust, exclude


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
) -> Result[Any]:
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
    exclude(("--resume", resume), ("--force", force))
    exclude(("--quiet", quiet), ("--explain", explain))
    from masonry_cd.app.scene import read_scene

    read = read_scene(scene, set_ or ())
    from masonry_cd.app.commands.run import RunRequest  # numba comes with it, which a scene that is refused does without
    from masonry_cd.app.commands.run import run as command

    asked = RunRequest(force, resume, dump_problem or (), explain, quiet)
    return command(read, output, asked, silent if quiet else typer.echo)
