# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve: the impulses of a step, impacts apart from forces (``impacts.py``), island by island (``islands.py``)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.dynamics.error_scale import find_overload, on_scale
from masonry_cd.mechanics.dynamics.impacts import error_of, open_among, open_contacts, solve_apart
from masonry_cd.mechanics.dynamics.islands import FORCES, Islands
from masonry_cd.mechanics.dynamics.joint_history import pretensioned
from masonry_cd.mechanics.dynamics.step_problem import Solved, StepProblem
from masonry_cd.mechanics.dynamics.system import System
from masonry_cd.mechanics.friction.problem import FrictionProblem
from masonry_cd.mechanics.solvers import Options

Watch = Callable[[int, str, FrictionProblem], None]  # the step, and a problem solved in it by name: "" where it is the only one


def solve(system: System, made: StepProblem, islands: Islands, number: int, watch: Watch | None = None) -> Solved:
    """Find the impulses of step ``number``, counted from 1. Bonded contacts are solved in impulses whose cones begin at zero."""
    if made.springs is None or not made.springs.bond.any():
        return _solve_cones(system, made, islands, number, watch)
    bond = made.springs.bond
    start = replace(made.start, impulse=_shifted(made.start.impulse, bond))
    solved = _solve_cones(system, made._replace(problem=pretensioned(made.problem, bond), start=start), islands, number, watch)
    blow = None if solved.blow is None else _shifted(solved.blow, -bond)
    return solved._replace(solution=replace(solved.solution, impulse=_shifted(solved.solution.impulse, -bond)), blow=blow)


def _shifted(impulse: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Impulses (C, m) with other ones (C,) added on the normals."""
    out = impulse.copy()
    out[:, 0] += normal
    return out


def _solve_cones(system: System, made: StepProblem, islands: Islands, number: int, watch: Watch | None) -> Solved:
    """Find the impulses of contacts whose cones begin at zero, impacts apart from forces."""
    s, problem, start, linked = system.settings, made.solved, made.start, made.predicted.linked
    options = Options(s.tolerance, s.max_iterations, s.seed + number - 1, system.threads_for(problem.contacts), s.accepted)
    impact = _impact(system, made)
    if linked is not None:  # whose unknowns change from step to step
        start = replace(start, velocity=None)
    overload = None if start.velocity is None else find_overload(system, start.velocity, made.predicted)
    islands.link(problem, start.impulse, s.tolerance)
    solve_part = on_scale(overload, options, islands.solve)
    if impact is None:
        solution = solve_part(problem, start, FORCES)
        if watch is not None:
            watch(number, "", problem)
        return Solved(solution, error_of(problem, solution))
    is_open, struck = impact
    both = solve_apart(problem, is_open, ~struck, made.rows.gap, system.constants.step, start, solve_part)
    if watch is not None:
        watch(number, "forces", both.forces)
        watch(number, "impacts", both.impacts)
    carried = both.carried_impulse if linked is None else linked.impulse(linked.velocity(both.carried_impulse))
    return Solved(both.solution, both.error, carried, both.blow)


def _impact(system: System, made: StepProblem) -> tuple[np.ndarray, np.ndarray] | None:
    """The open and the struck contacts, see :func:`masonry_cd.mechanics.dynamics.impacts.open_contacts`; None: no impact.

    Elastic and bonded contacts are never hit: their law spans the whole step.
    """
    rows, h, pull = made.rows, system.constants.step, made.predicted.pull
    if made.springs is not None and made.springs.whole.any():
        return open_among(np.flatnonzero(~made.springs.whole), made.problem, rows.gap, rows.pair, h, pull)
    return open_contacts(made.problem, rows.gap, rows.pair, h, pull)
