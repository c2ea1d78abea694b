# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd solve``: one friction problem from a file."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result
from masonry_cd.mechanics.solvers import SOLVERS
from masonry_cd.mechanics.solvers.options import LARGEST_SEED, MOST_ITERATIONS


def solve(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Friction problem: FCLIB HDF5 or .npz.", show_default=False)],
    solver: Annotated[str, typer.Option(metavar="NAME", help=f"One of {', '.join(SOLVERS)}, or a solver of a plug-in.")] = "auto",
    tolerance: Annotated[float, typer.Option(metavar="T", help="Natural map error to reach (scaled).")] = 1e-8,
    max_iterations: Annotated[
        int | None,
        typer.Option(metavar="N", min=1, max=MOST_ITERATIONS, help="Largest number of iterations; that of the solver by default."),
    ] = None,
    seed: Annotated[int, typer.Option(metavar="N", min=0, max=LARGEST_SEED, help="Seed of random sweep orders.")] = 0,
    json_: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="SOLUTION.npz", help="Save impulses r and velocities u.")] = None,
) -> Result[Any]:
    """Solve one friction problem from a file and print its errors.

    The errors are measured outside the solver; a missed tolerance is reported.

    \b
    Examples:
      masonry-cd solve KaplasTower-i1061-4.npz
      masonry-cd solve problem.hdf5 --solver admm --tolerance 1e-10 --json -o solution.npz
    """
    from masonry_cd.app.commands.solve import solve as command

    found = command(file, solver, tolerance, max_iterations, seed, output)
    return replace(found, lines=[json.dumps(found.value)], written=()) if json_ else found
