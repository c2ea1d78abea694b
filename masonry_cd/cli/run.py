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
    explain: Annotated[bool, typer.Option("--explain", help="Explain which work this scene does not need, and why.")] = False,
    quiet: Quiet = False,
    trust: Trust = False,
) -> Result[Any]:
    """Run a scene and write its results.

    DIR gets result.h5, joints.csv, summary.json, and the pictures that the scene requests. The whole scene is checked first; bad input
    is reported in one line, with exit code 2, and nothing is written. Ctrl-C, SIGTERM, SIGHUP and SIGQUIT end a run after its current step.
    The results stay readable up to that step, and --resume, also after a kill, continues to the same numbers as an uninterrupted run.
    --dump-problem writes problem_STEP.npz for masonry-cd solve and accuracy, or problem_STEP_forces.npz and problem_STEP_impacts.npz where
    impacts are solved separately.

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
