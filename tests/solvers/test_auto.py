"""auto: solves what one method alone does not, remembers what was cheap, and says what it did."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from models import stepper, wall
from scenes import thrown

from benchmarks import ours
from benchmarks.scenes import arch
from masonry_cd.friction.problem import Solution, natural_map_error
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


def chosen(costs_by_step: dict[int, list[float]], steps: int, costs: auto.Costs = (1.0, 1.0, 40.0, 20.0)) -> np.ndarray:
    """Which method each step begins with. In a row of steps, the k-th with a method costs the k-th of its numbers, or else the last."""
    tally, out, row = auto.Tally.recall(None), [], 0
    for _ in range(steps):
        method = auto._prefer(tally, costs)
        row = row + 1 if out and out[-1] == method else 0
        own, spent = costs_by_step[method], [0.0, 0.0]
        spent[method] = own[min(row, len(own) - 1)]
        auto._learn(tally, method, spent)
        out.append(method)
    return np.array(out)


@pytest.mark.parametrize(("dearer", "apart"), [(1.2, 120), (3.5, 350), (8.0, 800)])
def test_the_other_method_is_tried_the_more_seldom_the_dearer_it_was(dearer: float, apart: int) -> None:
    """The first trial is early; a step that is no cheaper than the one before ends it. The next ones are the farther apart the dearer it
    was, so that their share of all costs is the same."""
    tried = np.flatnonzero(chosen({auto.ADMM: [200.0], auto.NEWTON: [200.0 * dearer]}, 1000) == auto.NEWTON)
    starts = tried[np.diff(tried, prepend=-2) > 1]
    assert starts[0] == auto.EARLY - 1
    assert (np.diff(starts) >= apart).all()
    assert len(starts) == 1 + (1000 - auto.EARLY) // (apart + 1)
    assert len(tried) == len(starts) * (2 if dearer <= auto.HOPELESS else 1)


def test_a_method_that_warms_up_is_given_the_steps_that_it_needs() -> None:
    """Dearer in its first two steps and cheaper from then on: a trial of one step would never find out."""
    methods = chosen({auto.ADMM: [200.0], auto.NEWTON: [500.0, 300.0, 100.0]}, 50)
    np.testing.assert_array_equal(methods[auto.EARLY - 1 :], auto.NEWTON)


def test_no_trial_where_a_single_iteration_is_dearer() -> None:
    """What cannot win is not tried."""
    costs = {auto.ADMM: [200.0], auto.NEWTON: [1000.0]}
    assert (chosen(costs, 1000, (5.0, 500.0, 40.0, 20.0)) == auto.ADMM).all()
    assert not (chosen(costs, 1000, (5.0, 150.0, 40.0, 20.0)) == auto.ADMM).all()


def test_small_arches_are_stepped_with_newton() -> None:
    """ADMM takes more than ten iterations a step, Newton one or two, and a call of ADMM costs as much as some of its iterations."""
    machine = ours.stepper(arch(27), 40)
    reports = [machine.step() for _ in range(40)]
    assert max(r.error for r in reports) <= 1e-8
    assert sum(r.reason == "newton: converged" for r in reports[10:]) >= 28
    assert np.median([r.iterations for r in reports[10:]]) <= 2


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


def test_sweeps_lead_on_in_packed_grains(monkeypatch: pytest.MonkeyPatch) -> None:
    """Packed spheres that slide past each other fill the factors: sweeps are cheap there, and reach the tolerance."""
    problem = scenes.packing(4, mu=0.8, speed=0.05)
    solution = solve(problem, Options(tolerance=1e-8), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-8
    assert "nlgs" in solution.reason
    monkeypatch.setattr(auto, "SWEEPS", (10**9, 0))
    monkeypatch.setattr(auto, "LONG", 0)
    assert "nlgs" not in solve(problem, Options(tolerance=1e-8), None).reason


def test_sweeps_come_where_they_are_cheap() -> None:
    """After the interior point method's first start; before it where that is too dear, and in place of Newton if that is dearer still."""
    problem = scenes.wall(3, 4)
    sweep = auto.SWEEP * auto.entries(problem)
    usual, sweeps = [auto.ADMM, auto.NEWTON], [auto.NLGS, auto.NEWTON]
    start, last = [auto.INTERIOR], [auto.INTERIOR, auto.NEWTON]
    for newton, methods in (
        (1.0, usual + last),
        (100.0 * sweep, usual + start + sweeps + last),
        (auto.BUDGET, [auto.ADMM] + sweeps + last),
    ):
        turns = auto._turns(problem, auto.ADMM, (1.0, newton), cold=False, slides=False)
        assert [method for method, _ in turns] == methods
