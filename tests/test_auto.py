"""auto: solves what one method alone does not, remembers what was cheap, and says what it did."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from models import stepper, wall
from test_extreme_problems import thrown

from masonry_cd.friction import Solution, natural_map_error
from masonry_cd.solvers import SOLVERS, Options, auto

solve = SOLVERS["auto"]


def test_says_what_it_did() -> None:
    """The reason names the methods in turn."""
    assert solve(scenes.wall(3, 4), Options(), None).reason == "admm: converged"


def test_newton_takes_over() -> None:
    """A wall whose ground jerks away is beyond a short run of ADMM; auto solves it."""
    problem = thrown(0.3)
    solution = solve(problem, Options(tolerance=1e-11), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-11
    assert "newton" in solution.reason


def test_limit_bounds_all_methods_together() -> None:
    """max_iterations counts the iterations of every method."""
    solution = solve(thrown(0.3), Options(tolerance=1e-14, max_iterations=7), None)
    assert solution.iterations == 7
    assert "missed" in solution.reason


def test_learns_which_method_to_begin_with() -> None:
    """After a step that ADMM could not finish, the next one begins with Newton; what is solved at the start teaches nothing."""
    problem = thrown(0.3)
    first = solve(problem, Options(tolerance=1e-10), None)
    assert first.reason.startswith("admm + newton")
    nearby = replace(problem, v_free=1.001 * problem.v_free)
    second = solve(nearby, Options(tolerance=1e-10), Solution(first.impulse, None, 0, memory=first.memory))
    assert second.reason.startswith("newton")
    again = solve(nearby, Options(tolerance=1e-10), Solution(second.impulse, None, 0, memory=second.memory))
    assert again.iterations == 0
    np.testing.assert_array_equal(again.memory["auto_tally"][:2], second.memory["auto_tally"][:2])


@pytest.mark.parametrize(("dearer", "steps"), [(1.2, 60), (8.0, 400), (np.nan, 50)])
def test_the_other_method_is_tried_the_more_seldom_the_dearer_it_was(dearer: float, steps: int) -> None:
    """Trials of a method that took so many times as much are that many times as far apart, so that their share of all costs is the same."""
    tally = auto._recall(None)
    tally[auto.ADMM], tally[auto.NEWTON] = 1.0, dearer
    chosen = [auto._prefer(tally) for _ in range(1000)]
    tried = np.flatnonzero(np.array(chosen) == auto.NEWTON)
    np.testing.assert_array_equal(np.diff(tried, prepend=-1), steps)
    assert len(tried) == 1000 // steps


@pytest.mark.parametrize("solver", ["admm", "newton", "auto"])
def test_same_inputs_same_bits(solver: str) -> None:
    """Two steps in a row, done twice, agree to the last bit; no clock has a say."""
    problem, results = thrown(0.1), []
    for _ in range(2):
        first = SOLVERS[solver](problem, Options(), None)
        second = SOLVERS[solver](problem, Options(tolerance=1e-12), Solution(0.9 * first.impulse, None, 0, memory=first.memory))
        results.append(second.impulse)
    np.testing.assert_array_equal(*results)


def test_at_rest_hardly_any_step_needs_an_iteration() -> None:
    """Close to rest a step is solved deeper than asked, and the impulses then do for hundreds of steps, within the tolerance."""
    machine = stepper(wall(4, 6), 200, solver="auto", tolerance=1e-8)
    reports = [machine.step() for _ in range(200)]
    assert sum(r.iterations > 0 for r in reports) <= 6
    assert max(r.error for r in reports) <= 1e-8
    assert np.abs(machine.state.position - machine.assembly.centre).max() < 1e-9


def test_the_error_that_it_reports_is_that_of_the_measure() -> None:
    """The measure of ``friction`` is asked on the way; the step need not ask it again."""
    problem = thrown(0.1)
    first = solve(problem, Options(), None)
    again = solve(problem, Options(), Solution(first.impulse, None, 0, memory=first.memory))
    for solution in (first, again):
        assert solution.error == natural_map_error(problem, solution.impulse)
    np.testing.assert_allclose(again.velocity, first.velocity, atol=1e-12)
