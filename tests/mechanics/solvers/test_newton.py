# SPDX-License-Identifier: GPL-3.0-or-later
"""Newton: a few steps from a rough solution to machine precision, and honest failure."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scenes
from scenes import thrown

from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, natural_map_error
from masonry_cd.mechanics.friction.solver_state import SolverState
from masonry_cd.mechanics.solvers import SOLVERS, Options

solve = SOLVERS["newton"]


@pytest.mark.parametrize("local", [True, False])
@pytest.mark.parametrize("speed", [0.0, 0.05])
def test_finishes_what_others_began(local: bool, speed: float) -> None:
    """From a natural map error of 1e-4 at most 30 steps lead to 1e-9, at rest and with sliding contacts."""
    bodies = thrown(speed)
    problem: FrictionProblem | LocalProblem = bodies.to_local() if local else bodies
    rough = replace(SOLVERS["admm"](bodies, Options(tolerance=1e-4), None), velocity=None, memory=SolverState())
    begin = natural_map_error(problem, rough.impulse)
    fine = solve(problem, Options(tolerance=1e-9), rough)
    assert begin > 1e-9
    assert natural_map_error(problem, fine.impulse) <= 1e-9
    assert fine.iterations <= 30


def test_convergence_is_faster_than_linear() -> None:
    """Once the contacts have found their states, one step gains more than two digits, and four reach rounding."""
    standing = scenes.tower(10)
    problem = replace(standing, v_free=standing.v_free + np.array([0.05, 0.0, 0.0, 0.0, 0.0, 0.0]))  # thrown sideways: it slides
    start = SOLVERS["admm"](problem, Options(tolerance=1e-7), None)
    errors = []
    for steps in range(1, 5):
        errors.append(natural_map_error(problem, solve(problem, Options(tolerance=1e-15, max_iterations=steps), start).impulse))
    assert min(after / before for before, after in pairwise(errors)) < 1e-2
    assert errors[-1] < 1e-13


def test_never_worse_than_its_start() -> None:
    """From impulses far off, the best iterate is kept and a failure is said."""
    problem = thrown(0.3)
    start = SOLVERS["nlgs"](problem, Options(max_iterations=2), None)
    begin = natural_map_error(problem, start.impulse)
    solution = solve(problem, Options(tolerance=1e-12, max_iterations=3), start)
    error = natural_map_error(problem, solution.impulse)
    assert error <= begin * (1 + 1e-9)
    assert ("stopped" in solution.reason) == (error > 1e-12)


def test_velocity_belongs_to_the_impulses() -> None:
    """The velocities returned obey the equation of motion with the impulses returned."""
    problem = thrown(0.05)
    solution = solve(problem, Options(), None)
    assert solution.velocity is not None
    np.testing.assert_allclose(solution.velocity, problem.body_velocity(solution.impulse), atol=1e-12)
