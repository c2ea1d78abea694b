# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd accuracy``: error against run time."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result, said
from masonry_cd.cli.shared import Changes, Force, Output, Quiet, Trust
from masonry_cd.mechanics.solvers import SOLVERS


def accuracy(
    source: Annotated[Path, typer.Argument(metavar="SCENE|FILE", help="Scene (TOML), or friction problem.", show_default=False)],
    output: Output,
    set_: Changes = None,
    solvers: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES", help=f"Solvers to measure: {','.join(SOLVERS)}, or those of plug-ins.", show_default="all; of a scene its own"
        ),
    ] = None,
    tolerances: Annotated[str | None, typer.Option(metavar="T1,T2,...", help="Tolerances of each step.", show_default="a range")] = None,
    dts: Annotated[str | None, typer.Option(metavar="DT1,DT2,...", help="Time steps [s].", show_default="x 2, 1, 1/2")] = None,
    repeats: Annotated[
        int | None, typer.Option(metavar="N", min=1, help="Repetitions, for median times.", show_default="5; of a scene 1")
    ] = None,
    duration: Annotated[
        float | None, typer.Option(metavar="SECONDS", help="Duration of a scene, to shorten it.", show_default="its own")
    ] = None,
    ensemble: Annotated[int | None, typer.Option(metavar="N", min=1, help="Judge a scene by N runs of each setting.")] = None,
    workers: Annotated[int, typer.Option(metavar="N", min=1, help="Runs of an ensemble in parallel.")] = 1,
    force: Force = False,
    quiet: Quiet = False,
    trust: Trust = False,
) -> Result[Any]:
    """Measure error against run time: of the solvers on a friction problem, or of a whole scene over time step and tolerance.

    DIR gets accuracy.csv, accuracy.md and accuracy.png, a work-precision diagram. Errors of a problem are
    natural map errors, measured outside the solvers. Runs of a scene are compared with the finest run, at half the smallest time step and
    the tightest tolerance: displacements and joint openings as the root mean square over blocks or joints, the largest over time, relative
    to that of the finest run. Settings that missed their tolerance are marked.

    Under strong shaking single runs differ by chance. With --ensemble N each setting is run N times, with amplitudes that differ by 1e-9:
    medians and quartiles of openings, sliding, displacement and drift, whether they differ from those of the finest setting by more than
    chance, and which setting is good enough. Time steps are then the scene's own unless given; members.csv has every run. Finished
    runs are kept: after a kill the same command continues, and with a larger N it makes only the new runs.

    \b
    Examples:
      masonry-cd accuracy problem.npz -o out/solvers --solvers nlgs,admm,auto --tolerances 1e-4,1e-8,1e-12
      masonry-cd accuracy arch.toml -o out/accuracy --dts 4e-3,2e-3,1e-3 --tolerances 1e-3,1e-6
      masonry-cd accuracy demo.toml -o out/accuracy --ensemble 8 --workers 2 --tolerances 1e-3,1e-5
    """
    from masonry_cd.studies.accuracy import command

    asked = command.AccuracyRequest(solvers, tolerances, dts, repeats, duration, tuple(set_ or ()), ensemble, workers, force, quiet)
    return command.accuracy(source, output, asked, said(not quiet))
