# SPDX-License-Identifier: GPL-3.0-or-later
"""Solvers by name, ours or of an installed package, and solvers that Python gives.

What a solver from elsewhere returns is judged outside it: its impulses have to be C finite vectors of m numbers, and their error is
measured by :func:`masonry_cd.mechanics.friction.problem.natural_map_error`, whatever error it reports. It gets copies of what it starts
from, so that it may write into them, and no problem without contacts.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.foundation import plugins
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.signatures import require_call
from masonry_cd.mechanics.solvers import SOLVERS, Options, Solver

if TYPE_CHECKING:
    from masonry_cd.mechanics.friction.problem import Problem, Solution

GROUP = "solvers"  # of entry points
OWN = "python"  # as run.solver, of a function that Python gives


def is_solver(name: str) -> bool:
    """True where a solver has this name; none is imported, and packages are asked only for a name that is not built in."""
    return name in SOLVERS or name in plugins.names(GROUP)


def every_solver() -> Iterator[str]:
    """Names of ours, then of those that packages add."""
    yield from SOLVERS
    yield from plugins.names(GROUP)


def require_solver(name: str, where: object) -> None:
    """Check that there is a solver of a name.

    Raises:
        InputError: there is none.
    """
    if not is_solver(name):
        raise InputError(where, f'no solver "{name}"{suggest(name, every_solver())}; known are {", ".join(every_solver())}')


def solver_named(name: str) -> Solver:
    """A solver.

    Raises:
        InputError: a package that cannot be used.
        KeyError: no such solver.
    """
    return SOLVERS[name] if name in SOLVERS else judged(plugins.load(GROUP, name), f'solver "{name}"')


def step_solver(given: str | Solver) -> Solver:
    """A solver as the steps of a run call it: by its name, or one that Python gives."""
    from masonry_cd.mechanics.solvers.condensed import in_condensed_unknowns  # of the kernels, which a scene is checked without

    return in_condensed_unknowns(solver_named(given) if isinstance(given, str) else judged(given, "solver"))


def judged(solver: Solver, where: str) -> Solver:
    """A solver from elsewhere, whose answers are checked and measured.

    Args:
        solver: ``f(problem, options, start)``.
        where: for messages.

    Raises:
        InputError: it cannot be called so; in a step, an answer that is none.
    """
    require_call(solver, plugins.CALLED[GROUP]["solve"], where, "solve")

    def solve(problem: Problem, options: Options, start: Solution | None = None) -> Solution:
        from masonry_cd.mechanics.friction.problem import Solution, natural_map_error

        shape = problem.contacts, problem.dimension
        if not problem.contacts:
            return Solution(np.zeros(shape), None, 0)
        if start is not None:
            velocity = None if start.velocity is None else start.velocity.copy()
            start = replace(start, impulse=start.impulse.copy(), velocity=velocity)
        found = solver(problem, options, start)
        if not isinstance(found, Solution):
            raise InputError(where, f"returns a {type(found).__name__}, not a Solution(impulse, None, iterations)")
        if isinstance(found.iterations, bool) or not isinstance(found.iterations, int | np.integer) or found.iterations < 0:
            raise InputError(where, f"returns {found.iterations!r} iterations, a whole number is needed")
        impulse = np.asarray(found.impulse)
        if impulse.shape != shape or impulse.dtype.kind not in "fiu" or not np.isfinite(impulse).all():
            raise InputError(where, f"returns impulses {impulse.shape} of {impulse.dtype}, and {shape} finite numbers are needed")
        impulse = np.array(impulse, dtype=np.float64, order="C")
        return replace(found, impulse=impulse, velocity=None, iterations=int(found.iterations), error=natural_map_error(problem, impulse))

    return solve
