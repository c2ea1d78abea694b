"""Newton: a few steps from a rough solution to machine precision, and honest failure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scenes
from scenes import thrown

from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, Solution, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options, newton
from masonry_cd.mechanics.solvers.admm import FIRST_STIFFNESS

solve = SOLVERS["newton"]
MOST = newton.stiffest(1e-7)


@pytest.mark.parametrize("local", [True, False])
@pytest.mark.parametrize("speed", [0.0, 0.05])
def test_finishes_what_others_began(local: bool, speed: float) -> None:
    """From a natural map error of 1e-4 at most 15 steps lead to 1e-9, at rest and with sliding contacts."""
    bodies = thrown(speed)
    problem: FrictionProblem | LocalProblem = bodies.to_local() if local else bodies
    rough = SOLVERS["admm"](problem, Options(tolerance=1e-4), None)
    begin = natural_map_error(problem, rough.impulse)
    fine = solve(problem, Options(tolerance=1e-9), rough)
    assert begin > 1e-9
    assert natural_map_error(problem, fine.impulse) <= 1e-9
    assert fine.iterations <= 15


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


def test_begins_stiffer_after_few_iterations() -> None:
    """After a few problems that hardly differ the next one takes less than half of the iterations; a failure forgets what was learnt."""
    problem, options = scenes.tower(40), Options(tolerance=1e-12)
    anew = last = solve(problem, options, SOLVERS["admm"](problem, Options(tolerance=1e-4), None))
    for step in range(1, 6):
        nearby = replace(problem, v_free=(1.0 + 1e-4 * step) * problem.v_free)
        begin = last.impulse
        anew, last = solve(nearby, options, Solution(begin, None, 0)), solve(nearby, options, Solution(begin, None, 0, memory=last.memory))
        assert max(natural_map_error(nearby, s.impulse) for s in (anew, last)) <= 1e-12
    assert 0 < 2 * last.iterations <= anew.iterations
    failed = solve(problem, Options(tolerance=1e-15, max_iterations=1), Solution(0.0 * begin, None, 0, memory=last.memory))
    assert "failed" in failed.reason
    assert solve(nearby, options, Solution(begin, None, 0, memory=failed.memory)).iterations == anew.iterations


@pytest.mark.parametrize(
    ("cost", "settled"),
    [
        (lambda k: 2, MOST),  # few anyway
        (lambda k: 20 if k < 1e6 else 3, MOST),  # softer takes more: through, up to the end
        (lambda k: 5 if k < 1e5 else 12, 1e5),  # stiffer takes more
    ],
)
def test_stiffness_goes_where_iterations_are_few(cost: Callable[[float], int], settled: float) -> None:
    """From the softest start, in a row of solves that take so many iterations from such a K, K is soon near where they are few."""
    k, before, seen = FIRST_STIFFNESS, np.inf, []
    for _ in range(40):
        k, before = newton.next_stiffness(k, 1e8, before, cost(k), True, MOST)
        seen.append(k)
    assert FIRST_STIFFNESS <= min(seen) <= max(seen) <= MOST
    if settled == MOST:
        assert set(seen[10:]) == {settled}
    else:
        assert np.mean([k < settled for k in seen]) > 0.5


def test_stiffness_is_forgotten_after_a_failure_and_follows_the_end_of_a_solve() -> None:
    """A solve that had to soften on its way lets the next one begin as soft; one that failed begins anew."""
    assert newton.next_stiffness(1e6, 1e4, 8.0, 8, True, MOST)[0] == 1e4
    assert newton.next_stiffness(1e6, 1e6, 8.0, 0, True, MOST) == (1e6, 8.0)  # nothing was done, nothing learnt
    assert newton.next_stiffness(1e6, 1e8, 8.0, 8, False, MOST) == (FIRST_STIFFNESS, np.inf)


def test_never_worse_than_its_start() -> None:
    """From impulses far off, the best iterate is kept and a failure is said."""
    problem = thrown(0.3)
    start = SOLVERS["nlgs"](problem, Options(max_iterations=2), None)
    begin = natural_map_error(problem, start.impulse)
    solution = solve(problem, Options(tolerance=1e-12, max_iterations=3), start)
    error = natural_map_error(problem, solution.impulse)
    assert error <= begin * (1 + 1e-9)
    assert ("failed" in solution.reason) == (error > 1e-12)


def test_velocity_belongs_to_the_impulses() -> None:
    """The velocities returned obey the equation of motion with the impulses returned."""
    problem = thrown(0.05)
    solution = solve(problem, Options(), None)
    assert solution.velocity is not None
    np.testing.assert_allclose(solution.velocity, problem.body_velocity(solution.impulse), atol=1e-12)
