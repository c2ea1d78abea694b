# SPDX-License-Identifier: GPL-3.0-or-later
"""One friction problem from a file, solved and judged: what ``masonry-cd solve`` does."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from masonry_cd.app.result import Result
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.problem_files import read_problem
from masonry_cd.mechanics.friction.problem import LocalProblem, Problem, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options
from masonry_cd.mechanics.solvers.by_name import require_solver, solver_named


def solve(
    path: Path | str, solver: str = "auto", tolerance: float = 1e-8, max_iterations: int | None = None, seed: int = 0,
    output: Path | str | None = None,
) -> Result[dict[str, Any]]:  # fmt: skip
    """Solve the problem in a file.

    Args:
        path: .npz or FCLIB HDF5.
        solver: ours, or one that a package adds, by its name.
        tolerance: natural map error, scaled.
        max_iterations: None: the solver's own limit.
        seed: of random sweep orders.
        output: an .npz for the impulses ``r`` and relative velocities ``u`` (of elastic contacts with C r), (C, 3) each as (n, t1, t2);
            (C, 2) for planar problems.

    Returns:
        error (scaled natural map error), error_unscaled, iterations, seconds (of the solve alone), converged, contacts, solver, reason.

    Raises:
        InputError: see :func:`read_problem`; an unknown solver, an impossible tolerance, an output that is no .npz.
    """
    require_solver(solver, "solver")
    method = solver_named(solver)
    if not 0.0 < tolerance < 1.0:
        raise InputError("tolerance", f"should be between 0 and 1, got {tolerance:g}")
    if output is not None and Path(output).suffix != ".npz":
        raise InputError(output, "give another file for the solution, SOLUTION.npz")
    problem = read_problem(path)
    if output is not None:
        Path(output).parent.mkdir(parents=True, exist_ok=True)
    options = Options(tolerance=tolerance, max_iterations=max_iterations, seed=seed)
    load_kernels(solver, problem)
    begin = time.perf_counter()
    solution = method(problem, options, None)
    seconds = time.perf_counter() - begin
    error = natural_map_error(problem, solution.impulse)
    if output is not None:
        with replacing(Path(output)) as part, part.open("wb") as file:
            np.savez(file, r=solution.impulse, u=problem.apply(solution.impulse))
    found = {
        "solver": solver,
        "contacts": problem.contacts,
        "error": error,
        "error_unscaled": natural_map_error(problem, solution.impulse, scaled=False),
        "iterations": solution.iterations,
        "seconds": seconds,
        "converged": bool(error <= tolerance),
        "reason": solution.reason,
    }
    lines = [
        f"{Path(path).name}: {problem.contacts} contacts, {solution.reason}",
        f"error {error:.3e} (unscaled {found['error_unscaled']:.3e}), {solution.iterations} iterations",
        f"{seconds:.3g} s",
    ]
    missed = [] if found["converged"] else [f"the solver missed the tolerance {tolerance:g}; the error is {error:.1e}"]
    return Result(found, lines, missed, [] if output is None else [Path(output)])


def load_kernels(solver: str, problem: Problem) -> None:
    """Let the kernels of a solver be compiled, or loaded, before time is taken; those of all for auto, which turns to any of them."""
    if isinstance(problem, LocalProblem):  # any method serves, and factorising a large one takes long
        m = problem.dimension
        problem = LocalProblem(sparse.identity(m, format="csr"), -np.ones((1, m)), np.ones(1))
    for name in SOLVERS if solver == "auto" else (solver,):
        solver_named(name)(problem, Options(tolerance=1e-300, max_iterations=1), None)
