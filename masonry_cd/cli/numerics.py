"""The commands that check: modal companions, one friction problem from a file, error against run time. Part of :mod:`masonry_cd.cli`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.cli.shared import Changes, Force, Output, Quiet, SceneFile, free_folder, told


def modal(
    scene: SceneFile,
    output: Output,
    set_: Changes = None,
    young: Annotated[
        list[str] | None,
        typer.Option(metavar="E", help="Modulus [Pa]: 3e9, or by group of blocks: pier=4e9, default=2e9."),
    ] = None,
    poisson: Annotated[float, typer.Option(metavar="NU", help="Poisson's ratio.")] = 0.2,
    method: Annotated[str, typer.Option(metavar="NAME", help="continuum, joints or both.")] = "both",
    modes: Annotated[int, typer.Option(metavar="N", help="Modes to compute.")] = 6,
    mesh_size: Annotated[float | None, typer.Option(metavar="H", help="Of the tetrahedra [m].", show_default="thickness")] = None,
    restraint: Annotated[list[str] | None, typer.Option(metavar="GROUP=DIRECTIONS", help="What supports hold: pier1=z.")] = None,
    reference: Annotated[Path | None, typer.Option(metavar="CSV", help="Measured modes to compare with.")] = None,
    fit: Annotated[bool, typer.Option("--fit", help="Fit E to the first measured frequency.")] = False,
    pictures: Annotated[int, typer.Option(metavar="N", help="Modes to draw.")] = 6,
    nscd: Annotated[bool, typer.Option("--nscd", help="Frequencies of the run itself, on the scene's elastic joints, instead.")] = False,
    sweep: Annotated[str | None, typer.Option(metavar="x|y|z", help="With --nscd: amplitudes over the frequency of the base.")] = None,
    velocity: Annotated[float | None, typer.Option(metavar="C", help="Of the sweep [m/s].", show_default="1/1000 g")] = None,
    force: Force = False,
) -> None:
    """Check modal frequencies: the bonded elastic continuum, and rigid blocks on elastic joints, on the blocks of a scene.

    Rigid blocks with unilateral contacts have no elastic frequency; these two companions stand in for the structure before it cracks.
    A run on elastic joints has its own: with --nscd it swings freely, or is swept with v(t) = C sin(2 pi f t), beside its linear modes.

    \b
    Examples:
      masonry-cd modal aqueduct.toml -o out/modal --young 3e9
      masonry-cd modal church.toml -o out/modal --reference measured.csv --fit
      masonry-cd modal mortar.toml -o out/modal --nscd --sweep x
    """
    with told():
        if nscd or sweep:
            _vibration(scene, output, {"modes": modes, "sweep": sweep, "velocity": velocity}, set_ or (), force)
            return
        from masonry_cd.app.modal_case import OUTPUTS, by_group, modal_case

        free_folder(output, OUTPUTS, force)
        asked = {
            "young": by_group(young, "young") if young else None, "poisson": poisson, "method": method, "modes": modes,
            "mesh_size": mesh_size, "restraint": by_group(restraint, "restraint") if restraint else {}, "reference": reference,
            "fit": fit, "pictures": pictures,
        }  # fmt: skip
        found = modal_case(scene, asked, output, set_ or ())
        typer.echo("\n".join(found["lines"]))
        for line in found["warnings"]:
            typer.echo(f"masonry-cd: warning: {line}", err=True)
        typer.echo(f"written: {', '.join(map(str, found['written']))}")


def _vibration(scene: Path, output: Path, asked: dict[str, Any], changes: Sequence[str], force: bool) -> None:
    """The run's own frequencies."""
    from masonry_cd.studies.vibration import OUTPUTS, vibration_case

    free_folder(output, OUTPUTS, force)
    found = vibration_case(scene, asked, output, changes)
    typer.echo("\n".join(found["lines"]))
    typer.echo(f"written: {', '.join(found['written'])}")


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
        from masonry_cd.app.solve_file import solve_file

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
        from masonry_cd.studies.accuracy_case import OUTPUTS, accuracy_case

        free_folder(output, OUTPUTS, force)
        asked = {"solvers": solvers, "tolerances": tolerances, "dts": dts, "repeats": repeats, "duration": duration, "seeds": seeds}
        found = accuracy_case(source, asked, set_ or (), output, lambda line: None if quiet else typer.echo(line, err=True))
        if not quiet:
            typer.echo("\n".join(found["lines"]))
            typer.echo(f"written: {', '.join(map(str, found['written']))}")
        for line in found["warnings"]:
            typer.echo(f"masonry-cd: warning: {line}", err=True)
