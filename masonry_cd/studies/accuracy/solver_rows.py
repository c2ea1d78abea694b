# SPDX-License-Identifier: GPL-3.0-or-later
r"""Error against run time of the friction solvers on one problem.

Every solver is given every tolerance from a cold start. Its error is the natural map error
(:mod:`masonry_cd.mechanics.friction.problem`), scaled and unscaled, computed from the impulses outside the solver; its time the median of
repeats, kernels compiled before. A solver that misses a tolerance would go through the same iterations for a tighter one, so tighter ones
are left out.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass

from masonry_cd.app.commands.solve import load_kernels
from masonry_cd.app.result import Say
from masonry_cd.mechanics.friction.problem import LocalProblem, Problem, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options, pivoting
from masonry_cd.mechanics.solvers.by_name import solver_named
from masonry_cd.studies.accuracy.picture import Measurement, PanelSheet, Point, TimePanel

TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
REPEATS = 5
LONG = 5.0  # [s] a solve that takes longer is not repeated
NEEDS = {"interior": "a problem over bodies", "pivoting": "a problem over bodies in a plane"}


@dataclass(frozen=True)
class SolverRow:
    """One solver at one tolerance."""

    solver: str
    tolerance: float
    error: float  # natural map error, scaled
    error_unscaled: float
    iterations: int
    seconds: float  # median
    repeats: int
    reached: bool


def measured(problem: Problem, title: str, rows: Sequence[SolverRow], every: bool) -> Measurement:
    """Return the measurement of the solvers; where ``every`` solver is requested, those that do not apply are named as well."""
    names = list(dict.fromkeys(row.solver for row in rows))
    by_name = {name: [row for row in rows if row.solver == name] for name in names}
    lines = [f"{title}: {problem.contacts} contacts, errors by the natural map, median times"]
    lines += [_best(name, own[-1]) for name, own in by_name.items()]
    lines += [f"{name}: left out, it needs {what}" for name, what in NEEDS.items() if every and name not in names]
    drawn = [(name, [Point(row.seconds, row.error, not row.reached) for row in own]) for name, own in by_name.items()]
    heading = f"Error against run time: {title}"
    facts = "each point a tolerance, from loose to tight along the line; hollow: tolerance missed"
    panel = TimePanel("natural map error (scaled)", drawn, levels=sorted({row.tolerance for row in rows}))
    cells = [vars(row) for row in rows]
    return Measurement(heading, cells, cells, lines, [], PanelSheet(heading, facts, "time of one solve, median [s]", [panel]))


def solver_rows(problem: Problem, solvers: Sequence[str], tolerances: Sequence[float], repeats: int, say: Say) -> list[SolverRow]:
    """Measure solvers on a problem, see the head of this file.

    Args:
        problem: over bodies or in the impulses.
        solvers: their names.
        tolerances: from loose to tight.
        repeats: solves per row, but for those longer than LONG.
        say: called with a line before each solver.
    """
    rows: list[SolverRow] = []
    for name in solvers:
        say(f"{name}: {problem.contacts} contacts")
        load_kernels(name, problem)
        for tolerance in tolerances:
            rows.append(_solver_row(problem, name, tolerance, repeats))
            if not rows[-1].reached:
                break
    return rows


def _solver_row(problem: Problem, name: str, tolerance: float, repeats: int) -> SolverRow:
    """One solver at one tolerance."""
    method, seconds = solver_named(name), list[float]()
    while len(seconds) < repeats and sum(seconds) < LONG:
        begin = time.perf_counter()
        solution = method(problem, Options(tolerance=tolerance), None)
        seconds.append(time.perf_counter() - begin)
    error = natural_map_error(problem, solution.impulse)
    unscaled = natural_map_error(problem, solution.impulse, scaled=False)
    median = statistics.median(seconds)
    return SolverRow(name, tolerance, error, unscaled, solution.iterations, median, len(seconds), bool(error <= tolerance))


def solvers_for(problem: Problem, asked: Sequence[str] | None) -> tuple[str, ...]:
    """The solvers to measure: those requested, or all that solve such a problem themselves."""
    if asked is not None:
        return tuple(asked)
    solves = {"interior": not isinstance(problem, LocalProblem), "pivoting": pivoting.applies(problem)}
    return tuple(name for name in SOLVERS if solves.get(name, True))


def _best(name: str, last: SolverRow) -> str:
    """Describe the best result of one solver."""
    cost = f"{1e3 * last.seconds:.3g} ms, {last.iterations} iterations"
    if last.reached:
        return f"{name}: reached all, the tightest, {last.tolerance:g}, with an error of {last.error:.1e} in {cost}"
    return f"{name}: missed {last.tolerance:g} with an error of {last.error:.1e} in {cost}; tighter ones would end there too"
