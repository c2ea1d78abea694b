# SPDX-License-Identifier: GPL-3.0-or-later
"""Times and errors of the friction solvers, as Markdown tables: python -m benchmarks.solvers [--collected FOLDER] [--large] [--threads N]

Every error is the scaled natural map error, measured outside the solver; every time the median of several solves of the same problem,
kernels compiled before.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import scenes

from masonry_cd.io.problem_files import read_problem
from masonry_cd.mechanics.friction.problem import Problem, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options

COLLECTED = Path(__file__).parents[1].parent / "shared" / "friction_problems"
REPEATS = 5


def measure(
    problem: Problem, solver: str, tolerance: float, limit: int | None = None, repeats: int = REPEATS, threads: int = 1
) -> tuple[float, int, float]:
    """Error, iterations and median seconds of a cold start."""
    options = Options(tolerance=tolerance, max_iterations=limit, threads=threads)
    SOLVERS[solver](problem, Options(tolerance=1e-300, max_iterations=1), None)
    seconds = []
    for _ in range(repeats):
        begin = time.perf_counter()
        solution = SOLVERS[solver](problem, options, None)
        seconds.append(time.perf_counter() - begin)
    return natural_map_error(problem, solution.impulse), solution.iterations, statistics.median(seconds)


def collected(folder: Path) -> None:
    """The problems of the FCLIB collection."""
    print("\n| problem | contacts | solver | iterations | error | time [ms] |\n|---|---|---|---|---|---|")
    for path in sorted(folder.glob("*.npz")):
        problem = read_problem(path)
        for solver, limit in (("nlgs", 3000), ("admm", None), ("newton", None), ("auto", None)):
            error, iterations, seconds = measure(problem, solver, 1e-10, limit)
            print(f"| {path.stem} | {problem.contacts} | {solver} | {iterations} | {error:.1e} | {seconds * 1e3:.1f} |", flush=True)


def walls(sizes: list[tuple[int, int]], threads: int) -> None:
    """One step from rest of a wall in running bond, solved to 1e-8 from a cold start."""
    print("\n| wall | blocks | contacts | iterations | error | time [s] | per contact [us] |\n|---|---|---|---|---|---|---|")
    for columns, courses in sizes:
        problem = scenes.wall(columns, courses)
        error, iterations, seconds = measure(problem, "auto", 1e-8, repeats=3, threads=threads)
        cells = (f"{columns} x {courses}", len(problem.v_free), problem.contacts, iterations, f"{error:.1e}", f"{seconds:.3f}")
        print("|", " | ".join(map(str, cells)), f"| {seconds / problem.contacts * 1e6:.2f} |", flush=True)


def sweeps() -> None:
    """Cost of a Gauss-Seidel sweep on one thread and on two, preparation taken off."""
    print("\n| scene | contacts | ns per contact and sweep | on two threads |\n|---|---|---|---|")
    for name, problem in (("tower of 50", scenes.tower(50)), ("wall 10 x 10", scenes.wall(10, 10)), ("wall 40 x 25", scenes.wall(40, 25))):
        cells = []
        for threads in (1, 2):
            prepared, swept = (measure(problem, "nlgs", 1e-300, limit, threads=threads)[2] for limit in (0, 300))
            cells.append(f"{(swept - prepared) / 300 / problem.contacts * 1e9:.0f}")
        print(f"| {name} | {problem.contacts} | {' | '.join(cells)} |", flush=True)


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--collected", type=Path, default=COLLECTED, help="folder of .npz problems")
    parser.add_argument("--large", action="store_true", help="walls of up to 50,000 blocks, minutes to build")
    parser.add_argument("--threads", type=int, default=1, help="of each solve of a wall")
    arguments = parser.parse_args()
    sweeps()
    walls([(50, 10), (50, 20), (50, 50), (50, 100)], arguments.threads)
    if arguments.large:
        walls([(10, 100), (200, 100), (500, 100)], arguments.threads)
    if arguments.collected.is_dir():
        collected(arguments.collected)
    else:
        print(f"\nno collected problems in {arguments.collected}")


if __name__ == "__main__":
    main()
