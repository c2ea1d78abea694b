"""The commands on numerics: one friction problem from a file, and error against run time. They are part of :mod:`masonry_cd.cli`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from masonry_cd.cli_shared import Changes, Force, Output, Quiet, free_folder, told


def solve(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Friction problem: FCLIB HDF5 or .npz.", show_default=False)],
    solver: Annotated[str, typer.Option(metavar="NAME", help="auto, nlgs, admm, newton or interior.")] = "auto",
    tolerance: Annotated[float, typer.Option(metavar="T", help="Natural map error to reach (scaled).")] = 1e-8,
    max_iterations: Annotated[int | None, typer.Option(metavar="N", min=1, help="The solver's own limit by default.")] = None,
    seed: Annotated[int, typer.Option(metavar="N", min=0, help="Of random sweep orders.")] = 0,
    json_: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="SOLUTION.npz", help="Save impulses r, velocities u.")] = None,
) -> None:
    """Solve one friction problem from a file and print how exactly.

    The errors are measured outside the solver; a tolerance that was missed is told.

    \b
    Examples:
      masonry-cd solve KaplasTower-i1061-4.npz
      masonry-cd solve problem.hdf5 --solver admm --tolerance 1e-10 --json -o solution.npz
    """
    with told():
        from masonry_cd.problem_files import solve_file

        found = solve_file(file, solver, tolerance, max_iterations, seed, output)
        if json_:
            typer.echo(json.dumps(found))
        else:
            typer.echo(f"{file.name}: {found['contacts']} contacts, {found['reason']}")
            typer.echo(f"error {found['error']:.3e} (unscaled {found['error_unscaled']:.3e}), {found['iterations']} iterations")
            typer.echo(f"{found['seconds']:.3g} s")
        if not found["converged"]:
            typer.echo(f"masonry-cd: warning: the tolerance {tolerance:g} was missed, the error is {found['error']:.1e}", err=True)


def accuracy(
    source: Annotated[Path, typer.Argument(metavar="SCENE|FILE", help="Scene (TOML), or friction problem.", show_default=False)],
    output: Output,
    set_: Changes = None,
    solvers: Annotated[str | None, typer.Option(metavar="NAMES", help="auto,nlgs,...", show_default="all; of a scene its own")] = None,
    tolerances: Annotated[str | None, typer.Option(metavar="T1,T2,...", help="To reach in each step.", show_default="a range")] = None,
    dts: Annotated[str | None, typer.Option(metavar="DT1,DT2,...", help="Time steps [s].", show_default="x 2, 1, 1/2")] = None,
    repeats: Annotated[int | None, typer.Option(metavar="N", min=1, help="For median times.", show_default="5; of a scene 1")] = None,
    duration: Annotated[float | None, typer.Option(metavar="SECONDS", help="Of a scene, to shorten it.", show_default="its own")] = None,
    seeds: Annotated[int | None, typer.Option(metavar="N", min=2, help="Run a scene with N sweep orders too.")] = None,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Measure error against run time: of the solvers on a friction problem, or of a whole scene over time step and tolerance.

    DIR gets accuracy.csv, accuracy.md and accuracy.png, a work-precision diagram; with --seeds also seeds.csv. Errors of a problem are
    natural map errors, measured outside the solvers. Runs of a scene are compared with a run at half the smallest time step and the
    tightest tolerance: displacements and joint openings, in the root mean square over blocks or joints, the largest over time, relative to
    that of this finest run. What missed its tolerance is marked.

    \b
    Examples:
      masonry-cd accuracy problem.npz -o out/solvers --solvers nlgs,admm,auto --tolerances 1e-4,1e-8,1e-12
      masonry-cd accuracy arch.toml -o out/accuracy --dts 4e-3,2e-3,1e-3 --tolerances 1e-3,1e-6
      masonry-cd accuracy arch.toml -o out/accuracy --duration 1.5 --seeds 8
    """
    with told():
        from reports.accuracy_case import OUTPUTS, accuracy_case

        free_folder(output, OUTPUTS, force)
        asked = {"solvers": solvers, "tolerances": tolerances, "dts": dts, "repeats": repeats, "duration": duration, "seeds": seeds}
        found = accuracy_case(source, asked, set_ or (), output, lambda line: None if quiet else typer.echo(line, err=True))
        if not quiet:
            typer.echo("\n".join(found["lines"]))
            typer.echo(f"written: {', '.join(map(str, found['written']))}")
        for line in found["warnings"]:
            typer.echo(f"masonry-cd: warning: {line}", err=True)
