"""auto: solves what one method alone does not, remembers what was cheap, and says what it did."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import scenes
from models import stepper, wall
from scenes import thrown

from benchmarks import ours
from benchmarks.scenes import arch
from masonry_cd.mechanics.friction.problem import Problem, Solution, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options, admm, auto, newton

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


def stuck(problem: Problem, options: Options, start: Solution) -> Solution:
    """A method that makes no headway in all iterations that it is given."""
    return replace(start, iterations=options.max_iterations)


def ends(problem: Problem, options: Options, start: Solution) -> Solution:
    """A method that solves any problem in three iterations, and in none where there is nothing to do."""
    found = SOLVERS["interior"](problem, replace(options, max_iterations=None), start)
    return replace(found, iterations=min(found.iterations, 3))


def instead(monkeypatch: pytest.MonkeyPatch, **methods: Any) -> None:
    """Have auto call others in the place of ``admm`` or ``newton``: what these themselves come to may hang on rounding."""
    kept = zip(auto.NAMES, auto.METHODS, strict=True)
    monkeypatch.setattr(auto, "METHODS", tuple(SimpleNamespace(solve=methods[name]) if name in methods else own for name, own in kept))


def test_learns_which_method_to_begin_with(monkeypatch: pytest.MonkeyPatch) -> None:
    """After a step that ADMM could not finish, the next one begins with Newton; what is solved at the start teaches nothing."""
    instead(monkeypatch, admm=stuck, newton=ends)
    problem = thrown(1.0)
    first = solve(problem, Options(tolerance=1e-9), None)
    assert first.reason == "admm + newton: converged"
    nearby = replace(problem, v_free=1.001 * problem.v_free)
    second = solve(nearby, Options(tolerance=1e-9), Solution(first.impulse, None, 0, memory=first.memory))
    assert second.reason == "newton: converged"
    again = solve(nearby, Options(tolerance=1e-9), Solution(second.impulse, None, 0, memory=second.memory))
    assert again.iterations == 0
    assert auto.Experience.recall(again).cost == auto.Experience.recall(second).cost


def chosen(costs_by_step: dict[int, list[float]], steps: int, costs: auto.Costs = (1.0, 1.0, 40.0, 20.0)) -> np.ndarray:
    """Which method each step begins with. In a row of steps, the k-th with a method costs the k-th of its numbers, or else the last."""
    known, out, row = auto.Experience(costs=costs), [], 0
    for _ in range(steps):
        method = known.first()
        row = row + 1 if out and out[-1] == method else 0
        own, step = costs_by_step[method], [0.0, 0.0]
        step[method] = own[min(row, len(own) - 1)]
        known.learn(method, step, sum(step))
        out.append(method)
    return np.array(out)


def test_the_more_expensive_method_is_tried_ever_more_seldom() -> None:
    """In steps 4, 16, 64, 256, counted from 0; each trial shows again that it costs more, and lasts for one step."""
    tried = np.flatnonzero(chosen({auto.ADMM: [200.0], auto.NEWTON: [300.0]}, 1000) == auto.NEWTON)
    np.testing.assert_array_equal(tried, [4, 16, 64, 256])


def test_a_trial_that_costs_less_changes_the_method_until_it_costs_more() -> None:
    """From the first trial on, Newton begins, and ADMM again once a step with Newton costs more than the last one with ADMM."""
    methods = chosen({auto.ADMM: [200.0], auto.NEWTON: [100.0] * 3 + [250.0]}, 12)
    np.testing.assert_array_equal(methods, [auto.ADMM] * 4 + [auto.NEWTON] * 4 + [auto.ADMM] * 4)


def test_no_trial_where_a_single_iteration_is_more_expensive() -> None:
    """What cannot win is not tried."""
    costs = {auto.ADMM: [200.0], auto.NEWTON: [1000.0]}
    assert (chosen(costs, 1000, (5.0, 500.0, 40.0, 20.0)) == auto.ADMM).all()
    assert not (chosen(costs, 1000, (5.0, 150.0, 40.0, 20.0)) == auto.ADMM).all()


def test_a_method_that_helps_shows_what_it_costs() -> None:
    """What Newton took to finish a step is a first guess of what it costs in its own turn; a step without iterations shows nothing."""
    known = auto.Experience()
    known.learn(auto.ADMM, [200.0, 100.0], 300.0)
    assert (known.cost, known.first()) == ([300.0, 100.0], auto.NEWTON)
    known.learn(auto.NEWTON, [0.0, 0.0], 0.0)
    assert known.cost == [300.0, 100.0]


def test_a_step_may_cost_some_times_the_usual() -> None:
    """The first step starts cold and does not count; a single step that costs far more hardly moves what is usual."""
    known = auto.Experience()
    known.learn(auto.ADMM, [9e6, 0.0], 9e6)
    assert known.allowance() == np.inf
    for _ in range(50):
        known.learn(auto.ADMM, [1e5, 0.0], 1e5)
    assert known.allowance() == pytest.approx(auto.PATIENCE * 1e5)
    known.learn(auto.ADMM, [9e6, 0.0], 9e6)
    assert known.allowance() < 1.2 * auto.PATIENCE * 1e5
    known.usual = 1.0
    assert known.allowance() == auto.CHEAP


def test_an_accepted_error_ends_a_step_that_has_cost_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where ADMM stalls, the step ends with what it has found if that will do, and goes on to other methods if not."""
    problem, glance = thrown(0.3), Options(tolerance=1e-10, accept=1e-1)
    first = solve(problem, glance, None)
    memory = first.memory | {
        "auto_tally": replace(auto.Experience.recall(first), usual=1.0, cost=[1.0, 2.0], stalls=True).beside({})["auto_tally"]
    }
    start, nearby = Solution(first.impulse, None, 0, memory=memory), replace(problem, v_free=1.3 * problem.v_free)
    monkeypatch.setattr(auto, "CHEAP", 0.0)
    monkeypatch.setattr(auto, "WORTH", 1.0)
    left = solve(nearby, glance, start)
    assert left.reason.startswith("admm: missed")
    assert left.error is not None and 1e-10 < left.error <= 1e-1
    exact = solve(nearby, Options(tolerance=1e-10), start)
    assert exact.reason.startswith("admm + interior") and exact.error is not None and exact.error <= 1e-10


def test_experience_survives_in_the_memory_of_a_solution() -> None:
    """All of it, beside what the methods keep."""
    known = auto.Experience([3.0, 4.0], 5, 6, (7.0, 8.0, 9.0, 10.0), True, 11.0, True, True, 12.0)
    memory = known.beside({"other": np.ones(1)})
    assert auto.Experience.recall(Solution(np.zeros((1, 3)), None, 0, memory=memory)) == known
    assert "other" in memory


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


def test_what_goes_on_moving_is_not_solved_deeper_in_vain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each step begins close to its solution, and no deeper one does for the next: one in LOOK is solved so, until it moves no more."""
    asked: list[float] = []

    def noted(method: Any) -> Any:
        solved_by = method.solve

        def solved(given: Problem, options: Options, start: Solution | None = None) -> Solution:
            asked.append(options.tolerance)
            return solved_by(given, options, start)

        return solved

    for method in (admm, newton):
        monkeypatch.setattr(method, "solve", noted(method))
    problem, options = thrown(0.1), Options(tolerance=1e-3)
    last = solve(problem, options, None)
    for k in range(3 * auto.LOOK):
        last = solve(replace(problem, v_free=(1.0 + 0.05 * (k % 2)) * problem.v_free), options, last)
    deeper = [tolerance < options.tolerance for tolerance in asked]
    assert 3 <= sum(deeper) <= 5
    for _ in range(auto.LOOK + 1):
        last = solve(problem, options, last)
    assert last.iterations == 0


def test_the_error_that_it_reports_is_that_of_the_measure() -> None:
    """The measure of ``friction`` is asked on the way; the step need not ask it again."""
    problem = thrown(0.1)
    first = solve(problem, Options(), None)
    again = solve(problem, Options(), Solution(first.impulse, None, 0, memory=first.memory))
    for solution in (first, again):
        assert solution.error == natural_map_error(problem, solution.impulse)
    np.testing.assert_allclose(again.velocity, first.velocity, atol=1e-12)


def test_newton_helps_grains_out_of_a_circle(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rough spheres that move: what sweeps alone take up to 4,000 to get below 1e-4 for, or do not, takes less with Newton after 1,000."""
    rough = ((5, 0.55, 0.03), (4, 0.55, 0.07), (4, 0.65, 0.2), (4, 0.7, 0.1))
    problems = [scenes.packing(cells, mu=mu, speed=speed) for cells, mu, speed in rough]
    options = Options(tolerance=1e-4, accept=1e-3)
    helped = [solve(problem, options, None) for problem in problems]
    monkeypatch.setattr(auto, "NEWTON_LIMIT", 0)
    alone = [solve(problem, options, None) for problem in problems]
    solved, solved_alone = (
        sum(natural_map_error(problem, each.impulse) <= options.tolerance for problem, each in zip(problems, done, strict=True))
        for done in (helped, alone)
    )
    assert solved > solved_alone
    assert sum(each.iterations for each in helped) < 0.6 * sum(each.iterations for each in alone)


def test_newton_has_the_pattern_of_the_grains_in_touch() -> None:
    """Grains change their neighbours: pairs that touched in the last step leave the pattern, or it would fill up."""
    problem, options = scenes.packing(4, mu=0.7, speed=0.1), Options(tolerance=1e-4, accept=1e-3)
    first = solve(problem, options, None)
    fewer = problem.subset(np.arange(problem.contacts) % 10 > 0)
    begin = Solution(np.zeros((fewer.contacts, 3)), None, 0, memory=first.memory)
    second = solve(fewer, options, begin)
    assert "newton" in first.reason
    assert "newton" in second.reason
    assert len(second.memory["admm_pairs"]) < len(first.memory["admm_pairs"])


@pytest.mark.parametrize(("steps", "asked"), [(auto.LOOK, True), (auto.LOOK + 1, False)])
def test_newton_that_stalled_on_grains_is_asked_now_and_then(steps: int, asked: bool) -> None:
    """After a step that Newton did not end it has a turn in every LOOK-th step only."""
    problem, known = scenes.packing(4, mu=0.7, speed=0.1), auto.Experience(steps=steps, stalls=True)
    start = Solution(np.zeros((problem.contacts, 3)), None, 0, memory=known.beside({}))
    assert ("newton" in solve(problem, Options(tolerance=1e-4, accept=1e-3), start).reason) == asked


def test_packed_grains_begin_with_sweeps() -> None:
    """Packed spheres touch in points: sweeps come first, and what they leave goes to the methods that factorise, unless it is accepted."""
    problem = scenes.packing(4, mu=0.3, speed=0.0)
    solved = solve(problem, Options(tolerance=1e-4), None)
    assert solved.reason == "accelerated: converged"
    assert natural_map_error(problem, solved.impulse) == solved.error <= 1e-4
    hard = solve(problem, Options(tolerance=1e-300, max_iterations=auto.GRAIN_TURNS * auto.GRAIN_TURN + 5), None)
    assert hard.reason.startswith(auto.GRAIN_TURNS * "accelerated + " + "admm: missed")
    left = solve(problem, Options(tolerance=1e-300, accept=1e-4), None)
    assert left.iterations == auto.GRAIN_TURNS * auto.GRAIN_TURN
    assert 0.0 < left.error <= 1e-4


def test_a_turn_of_sweeps_may_do() -> None:
    """Where the error is accepted and the steps before took little, sweeps end with what any step may cost."""
    problem = scenes.packing(4, mu=0.3, speed=0.05)
    easy = solve(problem, Options(tolerance=1e-3), solve(problem, Options(tolerance=1e-1), None))
    solution = solve(problem, Options(tolerance=1e-300, accept=1e-2), Solution(np.zeros_like(easy.impulse), None, 0, memory=easy.memory))
    assert solution.iterations == int(auto.CHEAP / auto.sweep(problem)) < auto.GRAIN_TURNS * auto.GRAIN_TURN
    assert solution.reason.startswith(" + ".join(auto.GRAIN_TURNS * ["accelerated"]) + ": missed")


def test_what_touches_in_points() -> None:
    """Many spheres do; few spheres, blocks on faces, scenes in a plane, and problems that name no blocks go by other rules."""
    grains = scenes.packing(4, mu=0.3, speed=0.05)
    assert auto.touch_in_points(grains)
    for other in (scenes.packing(2, mu=0.3, speed=0.05), scenes.wall(12, 10), grains.to_local()):
        assert not auto.touch_in_points(other)


def test_limits_follow_costs() -> None:
    """A problem that is solved once may cost more than a step."""
    problem, costs = scenes.wall(3, 4), (1.0, 1e4, 0.0, 0.0)
    step, once = (dict(auto.turns(problem, costs, cold))[auto.INTERIOR] for cold in (False, True))
    assert step < once


def test_newton_is_not_asked_after_a_step_that_it_did_not_end() -> None:
    """Every eighth step is begun as if nothing were known."""
    costs, newton = (1.0, 3.0, 0.0, 0.0), (auto.NEWTON, auto.NEWTON_LIMIT)
    glance = (auto.ADMM, int(3 * auto.GLANCE))
    known = auto.Experience(steps=5)
    assert auto.openings(auto.ADMM, costs, known) == [glance, newton]
    assert auto.openings(auto.NEWTON, costs, known) == [newton, glance]
    known.stalls = True
    assert auto.openings(auto.NEWTON, costs, known) == [glance]
    known.steps = auto.LOOK
    assert auto.openings(auto.NEWTON, costs, known) == [newton, glance]


def test_admm_goes_on_where_newton_stalls(monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton, cut short here, does not end the step; ADMM does, and in the next one, begun with a short turn, Newton is not asked."""
    monkeypatch.setattr(auto, "NEWTON_LIMIT", 1)
    problem = thrown(0.3)
    first = solve(problem, Options(tolerance=1e-5), None)
    assert first.reason == "admm + newton + admm: converged"
    nearby = replace(problem, v_free=1.1 * problem.v_free)
    monkeypatch.setattr(auto, "GLANCE", 1.0)
    second = solve(nearby, Options(tolerance=1e-5), Solution(first.impulse, None, 0, memory=first.memory))
    assert second.reason.endswith(": converged")
    begun = second.reason.partition(":")[0].split(" + ")[:2]
    assert begun[0] == "admm"
    assert begun[1:] in (["admm"], ["interior"])  # in the place of Newton


def test_newton_that_stalls_close_to_the_solution_is_not_asked_twice(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step that begins close to the solution, and which Newton, which makes no headway here, was to solve deeper, continues with ADMM."""
    problem = thrown(0.3)
    first = solve(problem, Options(tolerance=1e-9), None)
    memory = first.memory | replace(auto.Experience.recall(first), cost=[2.0, 1.0], stalls=False, steps=5).beside({})
    nearby = replace(problem, v_free=(1.0 + 1e-6) * problem.v_free)
    error = natural_map_error(nearby, first.impulse)

    instead(monkeypatch, newton=stuck)
    again = solve(nearby, Options(tolerance=0.5 * error), Solution(first.impulse, None, 0, memory=memory))
    assert again.reason.startswith("newton + admm")


@pytest.mark.parametrize(
    ("cost", "steps", "known", "on_trial"),
    [
        ([1e4, 1e5], 3, {}, None),
        ([1e4, 1e5], 4, {}, auto.NEWTON),
        ([1e5, 1e4], 4, {}, auto.ADMM),
        ([1e5, 1e4], 5, {"stalls": True}, None),  # begins with ADMM because Newton, the cheaper one, stalled
        ([1e4, 1e5], 4, {"stalls": True}, None),  # Newton's turn for a trial, but it is not asked
        ([1e4, 1e5], 4, {"slides": True}, None),  # begins with pivoting or interior points
    ],
)
def test_a_step_knows_whether_it_is_a_trial(
    monkeypatch: pytest.MonkeyPatch, cost: list[float], steps: int, known: dict[str, Any], on_trial: int | None
) -> None:
    """One is what begins with the method that costs more."""
    seen: list[int | None] = []
    monkeypatch.setattr(auto._Search, "solution", lambda search, _: seen.append(search.on_trial) or search.start)
    problem = thrown(0.3)
    start = Solution(np.zeros((problem.contacts, 3)), None, 0, memory=auto.Experience(cost, steps, **known).beside({}))
    solve(problem, Options(tolerance=1e-5), start)
    assert seen == [on_trial]


def test_a_trial_is_not_charged_to_its_step() -> None:
    """What the method on trial costs leaves the others what they are allowed."""
    search = auto._Search(thrown(0.3), Options(), None, allowance=1e3)
    search.costs, search.iterations[auto.NEWTON] = (1.0, 10.0, 0.0, 0.0), 50
    assert search.enough(auto.ADMM) == 500
    search.on_trial = auto.NEWTON
    assert search.enough(auto.ADMM) == 1000
    search.iterations[auto.ADMM] = 400
    assert search.enough(auto.ADMM) == 600


def test_newton_that_ends_a_step_does_not_stall_if_it_falls_short_of_what_is_deeper() -> None:
    """Close to the solution a step is solved deeper than asked; to get within the tolerance is enough there."""
    problem = thrown(0.3)
    first = solve(problem, Options(tolerance=1e-9), None)
    memory = first.memory | replace(auto.Experience.recall(first), cost=[2.0, 1.0], stalls=False).beside({})
    nearby = replace(problem, v_free=(1.0 + 1e-9) * problem.v_free)
    again = solve(nearby, Options(tolerance=1e-9), Solution(first.impulse, None, 0, memory=memory))
    assert again.error is not None and again.error <= 1e-9
    assert not auto.Experience.recall(again).stalls
