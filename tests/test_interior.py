"""Interior point: near a solution from nothing, in a number of steps that hardly depends on the problem."""

from __future__ import annotations

import pytest
import scenes
from test_extreme_problems import thrown

from masonry_cd.friction import natural_map_error
from masonry_cd.solvers import SOLVERS, Options

solve = SOLVERS["interior"]


@pytest.mark.parametrize("courses", [5, 20, 80])
def test_few_steps_at_any_height(courses: int) -> None:
    """A wall from rest takes less than 20 factorisations."""
    problem = scenes.wall(3, courses)
    solution = solve(problem, Options(tolerance=1e-8), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-8
    assert solution.iterations < 20


@pytest.mark.parametrize("speed", [0.01, 0.1, 1.0])
def test_newton_finishes_from_there(speed: float) -> None:
    """Where contacts slide and lift off it comes near enough for Newton."""
    problem = thrown(speed)
    near = solve(problem, Options(tolerance=1e-10), None)
    solution = SOLVERS["newton"](problem, Options(tolerance=1e-10), near)
    assert natural_map_error(problem, solution.impulse) <= 1e-10


def test_impulses_spread_evenly() -> None:
    """Of all impulses that carry a box on four corners it finds the symmetric ones, whatever the order of the contacts."""
    problem = scenes.tower(1)
    solution = solve(problem, Options(tolerance=1e-10), None)
    normal = solution.impulse[:, 0]
    assert normal == pytest.approx(normal.mean(), rel=1e-6)
