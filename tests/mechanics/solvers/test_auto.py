# SPDX-License-Identifier: GPL-3.0-or-later
"""auto: solves what one method alone does not, learns what ADMM is good for, and says what it did."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scenes
from models import stepper, wall
from scenes import thrown

from masonry_cd.mechanics.friction.problem import Problem, Solution, natural_map_error
from masonry_cd.mechanics.friction.solver_state import Learnt, SolverState
from masonry_cd.mechanics.solvers import SOLVERS, Options, auto, interior, newton

solve = SOLVERS["auto"]


def test_says_what_it_did() -> None:
    """The reason names the methods in turn."""
    assert solve(scenes.wall(3, 4), Options(), None).reason == "admm: converged"


def test_limit_bounds_all_methods_together() -> None:
    """max_iterations counts the iterations of every method."""
    solution = solve(thrown(0.3), Options(tolerance=1e-14, max_iterations=7), None)
    assert solution.iterations == 7
    assert "missed" in solution.reason


def stuck(problem: Problem, options: Options, start: Solution) -> Solution:
    """A method that makes no headway in all iterations that it is given."""
    return replace(start, iterations=options.max_iterations)


def ends(problem: Problem, options: Options, start: Solution) -> Solution:
    """A method that solves any problem in three iterations, and in none where there is nothing to do."""
    found = SOLVERS["interior"](problem, replace(options, max_iterations=None), start)
    return replace(found, iterations=min(found.iterations, 3))


def instead(monkeypatch: pytest.MonkeyPatch, **methods: Any) -> list[tuple[str, int, np.ndarray]]:
    """Have auto call others in the place of its methods, whose own end may hang on rounding: name, limit and first impulses of each."""
    asked: list[tuple[str, int, np.ndarray]] = []

    def noted(name: str, own: Any) -> SimpleNamespace:
        def solved(problem: Problem, options: Options, start: Solution) -> Solution:
            asked.append((name, options.max_iterations or 0, start.impulse.copy()))
            return methods.get(name, own.solve)(problem, options, start)

        return SimpleNamespace(solve=solved)

    monkeypatch.setattr(auto, "METHODS", {name: noted(name, own) for name, own in auto.METHODS.items()})
    return asked


def test_begins_cheaply_and_ends_with_what_solves_nearly_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """In space ADMM, proximal points by Newton from the best so far, and interior points from the impulses of the last step."""
    asked = instead(monkeypatch, admm=stuck, newton=stuck, interior=ends)
    problem = thrown(0.3)
    begin = Solution(0.5 * SOLVERS["interior"](problem, Options(tolerance=1e-6), None).impulse, None, 0)
    assert solve(problem, Options(tolerance=1e-9), begin).reason == "admm + newton + interior: converged"
    assert [name for name, *_ in asked] == ["admm", "newton", "interior"]
    np.testing.assert_array_equal(asked[-1][2], begin.impulse)


@pytest.mark.parametrize(("friction", "second"), [(0.6, "pivoting"), (1.2, "newton")])
def test_in_a_plane_pivoting_goes_on_where_friction_is_not_rough(monkeypatch: pytest.MonkeyPatch, friction: float, second: str) -> None:
    """With much friction there are several solutions, and it may end in one that moves."""
    machine = stepper(wall(3, 3), 2, solver="auto", planar=True)
    problem = machine.friction_problem().problem
    asked = instead(monkeypatch, admm=stuck, newton=ends, pivoting=ends)
    solve(replace(problem, mu=np.full(problem.contacts, friction)), Options(tolerance=1e-9), None)
    assert [name for name, *_ in asked] == ["admm", second]


def test_admm_has_fewer_iterations_where_it_does_not_end_the_step(monkeypatch: pytest.MonkeyPatch) -> None:
    """And more where it does; at least as many as the others took factorisations, at most MOST."""
    problem, options = thrown(0.3), Options(tolerance=1e-9)
    zero = np.zeros((problem.contacts, 3))
    asked = instead(monkeypatch, admm=stuck, newton=ends)
    state, given = SolverState(), []
    for _ in range(6):
        asked.clear()
        state = solve(problem, options, Solution(zero, None, 0, memory=state)).memory
        given.append(asked[0][1])
    assert given == [auto.MOST, 250, 62, 15, 3, 3]
    instead(monkeypatch, admm=ends)
    assert solve(problem, options, Solution(zero, None, 0, memory=state)).memory.learnt.budget == auto.FACTOR * 3
    many = SolverState(learnt=Learnt(budget=auto.MOST))
    assert solve(problem, options, Solution(zero, None, 0, memory=many)).memory.learnt.budget == auto.MOST


def test_admm_has_all_its_iterations_after_a_step_that_nothing_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Or else one hard step would leave all later ones to the others, which solve them at many times the cost or not at all."""
    problem, options = thrown(0.3), Options(tolerance=1e-300)
    asked = instead(monkeypatch, admm=stuck, newton=stuck, interior=stuck)
    few = Solution(np.zeros((problem.contacts, 3)), None, 1, memory=SolverState(learnt=Learnt(budget=15)))
    found = solve(problem, options, few)
    assert [name for name, *_ in asked] == ["admm", "newton", "interior"]
    assert "missed" in found.reason and found.memory.learnt.budget == auto.MOST


def test_admm_has_at_least_as_many_iterations_as_the_others_took_factorisations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of which costs more than an iteration; what they took at most to no avail counts, too."""
    problem, options = thrown(0.3), Options(tolerance=1e-9)
    instead(monkeypatch, admm=stuck, newton=stuck, interior=ends)
    begin = Solution(np.zeros((problem.contacts, 3)), None, 1, memory=SolverState(learnt=Learnt(budget=15)))
    assert solve(problem, options, begin).memory.learnt.budget == newton.LIMIT + 3


def test_where_factorisations_take_long_newton_has_few_and_the_interior_point_method_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the way of the latter ends hardly any step; a problem that is solved once has all starts."""
    problem, options = thrown(0.3), Options(tolerance=1e-300, max_iterations=100_000)
    asked = instead(monkeypatch, admm=stuck, newton=stuck, interior=stuck)
    memory = SOLVERS["admm"](problem, Options(max_iterations=1), None).memory
    assert memory.factors is not None
    once = memory.factors.pattern.operations(problem.unknowns)
    zero = Solution(np.zeros((problem.contacts, 3)), None, 0, memory=memory)
    for begin, operations in ((zero, auto.LAST * once), (zero, 17.5 * once), (zero, 0.5 * once), (None, 0.5 * once)):
        monkeypatch.setattr(auto, "OPERATIONS", operations)
        asked.clear()
        solve(problem, options, begin)
        limits = {name: limit for name, limit, _ in asked if name in ("newton", "interior")}
        few = {"newton": 17} if operations > once else {}
        all_of = {"newton": newton.LIMIT, "interior": auto.LAST if begin else interior.MOST}
        assert limits == (all_of if begin is None or operations > 100.0 * once else few)


@pytest.mark.parametrize("solver", ["admm", "newton", "auto"])
def test_same_inputs_same_bits(solver: str) -> None:
    """Two steps in a row, done twice, agree to the last bit; no clock has a say."""
    problem, results = thrown(0.1), []
    for _ in range(2):
        first = SOLVERS[solver](problem, Options(), None)
        second = SOLVERS[solver](problem, Options(tolerance=1e-12), Solution(0.9 * first.impulse, None, 0, memory=first.memory))
        results.append(second.impulse)
    np.testing.assert_array_equal(*results)


def test_the_error_that_it_reports_is_that_of_the_measure() -> None:
    """The measure of ``friction`` is asked on the way; the step need not ask it again."""
    problem = thrown(0.1)
    first = solve(problem, Options(), None)
    again = solve(problem, Options(), Solution(first.impulse, None, 0, memory=first.memory))
    assert again.reason == "as in the last step: converged"
    for solution in (first, again):
        assert solution.error == pytest.approx(natural_map_error(problem, solution.impulse), rel=1e-6, abs=1e-15)
    np.testing.assert_allclose(again.velocity, first.velocity, atol=1e-12)


def test_after_a_step_that_moved_admm_measures_the_impulses_to_begin_with(monkeypatch: pytest.MonkeyPatch) -> None:
    """Once, and where they do again they stay as they are, with the memory."""
    problem = thrown(0.1)
    first = SOLVERS["admm"](problem, Options(tolerance=1e-9), None)
    monkeypatch.setattr(auto, "natural_map_error", None)  # nobody asks it
    again = solve(problem, Options(), Solution(first.impulse, None, 1, memory=first.memory))
    assert again.reason == "as in the last step: converged" and again.iterations == 0 and again.memory is first.memory
    np.testing.assert_array_equal(again.impulse, first.impulse)
    assert again.error == pytest.approx(natural_map_error(problem, first.impulse), rel=1e-6, abs=1e-15)
    on = solve(problem, Options(tolerance=1e-9), Solution(0.5 * first.impulse, None, 1, memory=first.memory))
    assert on.reason == "admm: converged" and natural_map_error(problem, on.impulse) <= 1e-9


def worst(name: str, problem: Problem, tolerance: float) -> float:
    """The error that a solver leaves."""
    return natural_map_error(problem, SOLVERS[name](problem, Options(tolerance=tolerance), None).impulse)


@pytest.mark.parametrize("local", [False, True])
def test_never_worse_than_its_members(local: bool) -> None:
    """A problem without a step before ends at the error of the best of them, or below the tolerance."""
    for speed in (0.3, 1.0):
        bodies = thrown(speed)
        problem: Problem = bodies.to_local() if local else bodies
        best = min(worst(name, problem, 1e-13) for name in ("admm", "newton", "interior"))
        assert worst("auto", problem, 1e-13) <= max(best, 1e-13)


def test_packed_grains_begin_with_sweeps() -> None:
    """Packed spheres touch in points: sweeps come first, and what they leave goes to the methods that factorise, unless it is accepted."""
    problem = scenes.packing(4, mu=0.3, speed=0.0)
    solved = solve(problem, Options(tolerance=1e-4), None)
    assert solved.reason == "accelerated: converged"
    assert natural_map_error(problem, solved.impulse) == pytest.approx(solved.error, rel=1e-9)
    assert solved.error <= 1e-4
    hard = solve(problem, Options(tolerance=1e-300, max_iterations=auto.SWEEPS + 5), None)
    assert hard.reason.startswith("accelerated + admm: missed")
    left = solve(problem, Options(tolerance=1e-300, accept=1e-4), None)
    assert left.iterations == auto.SWEEPS
    assert 0.0 < left.error <= 1e-4


def test_what_touches_in_points() -> None:
    """Many spheres do; few spheres, blocks on faces, scenes in a plane, and problems that name no blocks go by other rules."""
    grains = scenes.packing(4, mu=0.3, speed=0.05)
    assert auto.touch_in_points(grains)
    for other in (scenes.packing(2, mu=0.3, speed=0.05), scenes.wall(12, 10), grains.to_local()):
        assert not auto.touch_in_points(other)
