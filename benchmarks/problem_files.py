# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction problems against Siconos: the part ``files`` of ``peers.py``, see there."""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy import sparse

from benchmarks.ours import stepper
from benchmarks.scenes import scene
from benchmarks.sitting import environment, head, sitting
from masonry_cd.mechanics.friction.problem import LocalProblem, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options

HERE = Path(__file__).parent
HEAD = head("problem", "contacts", "tolerance", "program", "solver", "seconds", "iterations", "error", "unscaled")


def load(name: str) -> LocalProblem:
    """A friction problem in the impulses: from an .npz file, or of a step of a scene, ``SCENE@STEP``.

    Raises:
        ValueError: neither.
    """
    if "@" in name:
        word, step = name.rsplit("@", 1)
        return of_step(word, int(step))
    if not name.endswith(".npz"):
        raise ValueError(f"{name}: give an .npz file or SCENE@STEP")
    with np.load(name) as file:
        q = file["q"].reshape(-1, 3)
        w = sparse.csr_matrix((file["W_data"], file["W_indices"], file["W_indptr"]), shape=(q.size, q.size))
        return LocalProblem(w, q, file["mu"].ravel())


def of_step(name: str, step: int) -> LocalProblem:
    """The friction problem of a step of a scene, counted from 1, in all three dimensions; the steps before are solved to 1e-8."""
    machine = stepper(scene(name), step, planar=False)
    for _ in range(step - 1):
        machine.step()
    return machine.friction_problem().problem.to_local()


def save(problem: LocalProblem, path: Path) -> None:
    """Write a problem for Siconos."""
    w = problem.w
    np.savez(path, W_data=w.data, W_indices=w.indices, W_indptr=w.indptr, q=problem.q.ravel(), mu=problem.mu)


def _line(name: str, problem: LocalProblem, tolerance: float, who: str, seconds: float, iterations: int, impulse: np.ndarray) -> str:
    errors = f"{natural_map_error(problem, impulse):.1e} | {natural_map_error(problem, impulse, scaled=False):.1e}"
    return f"| {name} | {problem.contacts} | {tolerance:g} | {who} | {seconds:.3g} | {iterations} | {errors} |"


def _ours(name: str, problem: LocalProblem, solver: str, tolerance: float) -> str:
    """Solve thrice with one of our solvers, after a start that has the kernels compiled; the median time."""
    who = f"ours | {solver}"
    try:
        SOLVERS[solver](problem, Options(tolerance=tolerance, max_iterations=1), None)
    except KeyError:
        raise ValueError(f'no solver "{solver}"; this version has {", ".join(SOLVERS)}') from None
    except NotImplementedError:
        return f"| {name} | {problem.contacts} | {tolerance:g} | {who} | not for problems in the impulses | | | |"
    seconds = []
    for _ in range(3):
        begin = time.perf_counter()
        solution = SOLVERS[solver](problem, Options(tolerance=tolerance), None)
        seconds.append(time.perf_counter() - begin)
    return _line(name, problem, tolerance, who, float(np.median(seconds)), solution.iterations, solution.impulse)


def _siconos(name: str, problem: LocalProblem, solver: str, tolerance: float, given: argparse.Namespace, folder: Path) -> str:
    """Solve with Siconos in its own Python, within a time box."""
    who, answer = f"Siconos | {solver}", folder / "solution.npz"
    answer.unlink(missing_ok=True)
    command = [given.siconos_python, str(HERE / "siconos_solve.py"), str(folder / "problem.npz"), str(answer), "--solver", solver]
    try:
        done = subprocess.run(
            [*command, "--tolerance", str(tolerance)],
            env=environment(1), capture_output=True, text=True, check=False, timeout=given.seconds,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return f"| {name} | {problem.contacts} | {tolerance:g} | {who} | over {given.seconds:g} | | | |"
    if done.returncode:
        raise RuntimeError(f"Siconos: {(done.stderr.strip() or 'failed without a word').splitlines()[-1]}")
    with np.load(answer) as file:
        return _line(name, problem, tolerance, who, float(file["seconds"]), int(file["iterations"]), file["r"])


def files_command(given: argparse.Namespace) -> None:
    """Print the table of friction problems."""
    print(sitting(), HEAD, sep="\n\n", flush=True)
    for file in given.files:
        problem, name = load(file), Path(file).stem if file.endswith(".npz") else file
        with tempfile.TemporaryDirectory() as made:
            folder = Path(made)
            save(problem, folder / "problem.npz")
            for tolerance in given.tolerances:
                if given.siconos_python:
                    for solver in given.siconos_solvers:
                        print(_siconos(name, problem, solver, tolerance, given, folder), flush=True)
                for solver in given.solvers:
                    print(_ours(name, problem, solver, tolerance), flush=True)
