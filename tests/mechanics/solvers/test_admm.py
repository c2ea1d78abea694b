# SPDX-License-Identifier: GPL-3.0-or-later
"""ADMM: converges where Gauss-Seidel does not, and reuses its factors from step to step."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
import scenes

from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import Solution, natural_map_error
from masonry_cd.mechanics.friction.solver_state import Learnt, SolverState
from masonry_cd.mechanics.linalg import ordering
from masonry_cd.mechanics.solvers import SOLVERS, Options
from masonry_cd.mechanics.solvers.admm import PROBE, learn, next_k

solve = SOLVERS["admm"]


def test_iterations_hardly_grow_with_height() -> None:
    """From rest, a wall of 100 courses takes less than twice the iterations of one of 10."""
    low, high = scenes.wall(3, 10), scenes.wall(3, 100)
    few, many = solve(low, Options(), None), solve(high, Options(), None)
    assert natural_map_error(low, few.impulse) <= 1e-8
    assert natural_map_error(high, many.impulse) <= 1e-8
    assert many.iterations < 2 * few.iterations


def test_velocity_belongs_to_the_impulses() -> None:
    """The velocities returned obey the equation of motion with the impulses returned."""
    problem = scenes.wall(3, 4)
    solution = solve(problem, Options(), None)
    assert solution.velocity is not None
    np.testing.assert_allclose(solution.velocity, problem.body_velocity(solution.impulse), atol=1e-12)


@pytest.mark.parametrize("softness", [0.0, 0.3])
def test_says_the_error_of_what_it_returns(softness: float) -> None:
    """Converged, cut short, or from a solution: the error measured on the way is that of the impulses returned."""
    problem = scenes.softened(scenes.wall(6, 20), softness)
    solution = None
    for options in (Options(tolerance=1e-6, max_iterations=5), Options(tolerance=1e-6), Options(tolerance=1e-5)):
        solution = solve(problem, options, solution)
        assert solution.error == pytest.approx(natural_map_error(problem, solution.impulse), rel=1e-6)


def test_the_impulses_of_a_short_run_carry_the_velocities_found() -> None:
    """After a few iterations the answer obeys the equation of motion, and its error is far below that of its part in the cones."""
    problem = scenes.wall(6, 20)
    solution = solve(problem, Options(tolerance=1e-12, max_iterations=5), None)
    p, cut = solution.impulse, solution.impulse.copy()
    cut[:, 0] = np.maximum(p[:, 0], 0.0)
    cut[:, 1:] *= np.minimum(1.0, problem.mu * cut[:, 0] / np.maximum(np.linalg.norm(p[:, 1:], axis=1), 1e-300))[:, None]
    assert not np.array_equal(cut, p)
    assert natural_map_error(problem, p) < 0.5 * natural_map_error(problem, cut)


def test_starts_from_the_velocities_given() -> None:
    """The solution's own velocities with impulses that miss a part take fewer iterations than the velocities of what is left."""
    problem = scenes.wall(6, 20)
    known = solve(problem, Options(), None)
    lost = known.impulse * (np.arange(problem.contacts) % 10 != 0)[:, None]
    with_velocity = solve(problem, Options(), Solution(lost, known.velocity, 0, memory=known.memory))
    without = solve(problem, Options(), Solution(lost, None, 0, memory=known.memory))
    assert with_velocity.iterations < without.iterations


def test_weight_arrives_at_the_ground() -> None:
    """The normal impulses on the ground carry the whole weight over the step."""
    problem = scenes.wall(4, 5)
    solution = solve(problem, Options(tolerance=1e-12), None)
    ground = problem.bodies[:, 1] < 0
    momentum = np.sum(problem.v_free[:, 2] / problem.inverse_mass[:, 2, 2])
    assert solution.impulse[ground, 0].sum() == pytest.approx(-momentum, rel=1e-9)


def test_memory_saves_the_factorisation() -> None:
    """A second step from the first one's solution stops at once; its memory passes through a checkpoint."""
    problem = scenes.wall(3, 4)
    first = solve(problem, Options(), None)
    again = solve(problem, Options(), Solution(first.impulse, None, 0, memory=first.memory))
    assert again.iterations == 0
    arrays = again.memory.arrays()
    assert all(isinstance(array, np.ndarray) for array in arrays.values())
    restored = SolverState.read(arrays)
    assert restored.learnt == again.memory.learnt
    nearby = replace(problem, v_free=1.001 * problem.v_free)
    one, other = (solve(nearby, Options(), Solution(first.impulse, None, 0, memory=deepcopy(state))) for state in (again.memory, restored))
    np.testing.assert_array_equal(one.impulse, other.impulse)


def test_knows_from_the_step_before_when_to_look_at_the_error() -> None:
    """Without the ratio of error and change that the last step ended with, a solve stops later, not knowing that it is there."""
    problem, options = scenes.wall(6, 20), Options()
    last = solve(problem, options, None)
    nearby, forgetful = replace(problem, v_free=1.0001 * problem.v_free), deepcopy(last.memory)
    forgetful = replace(forgetful, learnt=replace(forgetful.learnt, rate=1.0))
    known, unknown = (solve(nearby, options, Solution(last.impulse, None, 0, memory=m)) for m in (last.memory, forgetful))
    assert max(natural_map_error(nearby, s.impulse) for s in (known, unknown)) <= options.tolerance
    assert 0 < known.iterations < unknown.iterations


@pytest.mark.parametrize(("iterations", "wins"), [(79, True), (80, False)])
def test_a_neighbouring_k_is_kept_where_it_takes_fewer_iterations(iterations: int, wins: bool) -> None:
    """It is tried once in PROBE steps, below the best so far and then above it; where it does not win the next step factorises again."""
    learnt = Learnt(k=10.0, stale=False, steps=PROBE - 2, mean_iterations=100.0)
    assert next_k(learnt) == 10.0
    learnt = learn(learnt, 10.0, 10.0, 100, 1.0)
    k = next_k(learnt)
    assert k < 10.0
    learnt = learn(learnt, k, k, iterations, 1.0)
    assert learnt.k == (k if wins else 10.0)
    assert learnt.stale is not wins
    assert next_k(replace(learnt, steps=2 * PROBE - 1)) > learnt.k


def test_what_is_learnt_passes_through_a_checkpoint() -> None:
    """All of it, in its types, and what a solver from elsewhere keeps."""
    learnt = Learnt(k=30.0, stale=False, steps=7, mean_iterations=5.5, rate=2.0, budget=60)
    restored = SolverState.read(SolverState(learnt=learnt, own={"guess": np.arange(3.0)}).arrays())
    assert restored.learnt == learnt
    np.testing.assert_array_equal(restored.own["guess"], np.arange(3.0))
    assert SolverState.read(SolverState().arrays()).learnt == Learnt()


def test_memory_of_another_contact_graph_is_not_believed() -> None:
    """Starting from a solution of other contacts between the same bodies still converges."""
    problem = scenes.wall(3, 4)
    first = solve(problem, Options(), None)
    keep = np.arange(problem.contacts) % 7 != 0
    fewer = problem.subset(keep)
    second = solve(fewer, Options(), Solution(first.impulse[keep], None, 0, memory=first.memory))
    assert natural_map_error(fewer, second.impulse) <= 1e-8


def in_subtrees(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut the elimination trees of some hundred blocks into subtrees of several levels."""
    monkeypatch.setattr(ordering, "SUBTREE", 60)


def test_threads_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    """Subtrees are solved to the same bits by one, two and three threads, cold and from the memory of the step before."""
    in_subtrees(monkeypatch)
    problem = scenes.softened(scenes.wall(8, 10), 0.3)
    ends = []
    for threads in (1, 2, 3):
        options = Options(tolerance=1e-10, threads=threads)
        first = solve(problem, options, None)
        ends.append((first, solve(problem, options, Solution(0.5 * first.impulse, None, 0, memory=first.memory))))
    assert ends[0][0].memory.factors.pattern.symbolic.level[1] > 3
    assert len(ends[0][0].memory.factors.pattern.symbolic.level) > 3
    for ended in ends:
        for one, other in zip(ends[0], ended, strict=True):
            assert natural_map_error(problem, other.impulse) <= 1e-10
            np.testing.assert_array_equal(other.impulse, one.impulse)
            np.testing.assert_array_equal(other.velocity, one.velocity)


def test_subtrees_give_the_answer_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut into subtrees or not, a wall moves with the same velocities."""
    problem = scenes.wall(7, 9)
    whole = solve(problem, Options(tolerance=1e-12), None)
    in_subtrees(monkeypatch)
    parts = solve(problem, Options(tolerance=1e-12), None)
    assert len(parts.memory.factors.pattern.symbolic.subtree) > len(whole.memory.factors.pattern.symbolic.subtree) == 2
    np.testing.assert_allclose(parts.velocity, whole.velocity, atol=1e-11)


def test_the_order_of_the_two_blocks_of_a_contact_does_not_matter() -> None:
    """With the sides of every contact swapped, and rows of H as in problems from files, the problem is the same one."""
    problem = scenes.wall(3, 4)
    swapped = replace(problem, bodies=problem.bodies[:, ::-1].copy(), geometry=Geometry.by_rows(problem.jacobian[:, ::-1].copy()))
    one, other = (solve(each, Options(tolerance=1e-10), None) for each in (problem, swapped))
    assert other.iterations == one.iterations
    np.testing.assert_allclose(other.impulse, one.impulse, rtol=1e-9, atol=1e-9 * np.abs(one.impulse).max())


def test_same_inputs_same_bits() -> None:
    """Twice the same problem gives the same impulses to the last bit."""
    problem = scenes.wall(4, 4)
    np.testing.assert_array_equal(solve(problem, Options(), None).impulse, solve(problem, Options(), None).impulse)
