# SPDX-License-Identifier: GPL-3.0-or-later
"""Pivoting: follows the piecewise linear path of structures in a plane that slide as a whole to the solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from models import advance
from places import EXAMPLES

from benchmarks.ours import stepper, stepper_of_file
from benchmarks.scenes import wall
from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options

solve = SOLVERS["pivoting"]
BLOCK = np.diag([1.0 / 2000.0, 1.0 / 2000.0, 1.0 / 300.0])  # M^-1 of a block [1/kg, 1/(kg m2)]


def thrown(mu: float, seed: int, softness: float = 0.0) -> FrictionProblem:
    """A wall in a plane whose blocks are thrown apart at random, as on springs of a compliance relative to that of the blocks."""
    problem, random = stepper(wall(5, 6), 1).friction_problem().problem, np.random.default_rng(seed)
    v_free = problem.v_free + 0.02 * random.normal(size=problem.v_free.shape)
    v_free[:, :2] += 0.05 * np.linspace(0.0, 1.0, len(v_free))[:, None] * random.normal(size=2)
    made = replace(problem, v_free=v_free, mu=np.full(problem.contacts, mu))
    return replace(made, compliance=np.tile(softness * made.delassus_diagonal().trace(axis1=1, axis2=2)[:, None], 2)) if softness else made


def sliding_block(compliance: float = 0.0) -> FrictionProblem:
    """A block of unit height and width two on a plane, which it meets at v = (3, -0.1) m/s at its two lower corners."""
    corners = np.array([[-1.0, -0.5], [1.0, -0.5]])
    jacobian = np.zeros((2, 2, 2, 3))
    for c, (x, z) in enumerate(corners):  # rows normal and tangent, columns x, z and the rotation
        jacobian[c, 0] = [[0.0, 1.0, x], [1.0, 0.0, -z]]
    v_free, mu, own = np.array([[3.0, -0.1, 0.0]]), np.full(2, 0.5), np.full((2, 2), compliance)
    return FrictionProblem(BLOCK[None], v_free, np.array([[0, -1]] * 2), Geometry.by_rows(jacobian), np.zeros((2, 2)), mu, own)


@pytest.mark.parametrize("softness", [0.0, 0.1])
@pytest.mark.parametrize("mu", [0.0, 0.8, 1.5, 2.5])
def test_solves_nearly_all_that_is_thrown_apart(mu: float, softness: float) -> None:
    """At most one of eight walls is left, rigid or on springs, without friction or with much."""
    problems = [thrown(mu, seed, softness) for seed in range(8)]
    errors = [natural_map_error(problem, solve(problem, Options(tolerance=1e-8), None).impulse) for problem in problems]
    assert sum(error <= 1e-8 for error in errors) >= 7, errors


def test_a_block_slides_as_by_hand() -> None:
    """It stops sinking and loses mu times that much speed; the corner in front carries more, by the moment of friction about its middle."""
    solution = solve(sliding_block(), Options(tolerance=1e-12), None)
    assert solution.velocity is not None
    normal, mass, lever, half = 2000.0 * 0.1, 2000.0, 0.5, 1.0
    assert solution.velocity[0] == pytest.approx([3.0 - 0.5 * normal / mass, 0.0, 0.0], abs=1e-10)
    moment = 0.5 * normal * lever
    assert solution.impulse[:, 0] == pytest.approx([0.5 * (normal - moment / half), 0.5 * (normal + moment / half)])
    assert solution.impulse[:, 1] == pytest.approx(-0.5 * solution.impulse[:, 0])


def test_springs_of_the_contacts_are_their_own() -> None:
    """An elastic contact gives way by its compliance times its impulse, and is what other methods find too."""
    problem = sliding_block(1e-4)
    solution = solve(problem, Options(tolerance=1e-12), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-12
    expected = SOLVERS["nlgs"](problem, Options(tolerance=1e-13), None)
    np.testing.assert_allclose(solution.impulse, expected.impulse, rtol=1e-9)


def test_solves_an_aqueduct_that_slides_as_a_whole() -> None:
    """The first step of the demo, at 0.24 g, from nothing and from impulses that are all wrong; the same bits again."""
    problem = stepper_of_file(EXAMPLES / "aqueduct_sinusoidal.toml").friction_problem().problem
    options = Options(tolerance=1e-8, max_iterations=1000)
    solution = solve(problem, options, None)
    assert natural_map_error(problem, solution.impulse) <= 1e-8, solution.reason
    np.testing.assert_array_equal(solve(problem, options, None).impulse, solution.impulse)
    wrong = Solution(2.0 * solution.impulse[::-1], None, 0)
    again = solve(problem, options, wrong)
    assert natural_map_error(problem, again.impulse) <= 1e-8, again.reason


def test_a_wall_that_friction_holds_does_not_move() -> None:
    """With friction of 10 a step has several solutions. At 1 g the wall goes with its base: none that moves is taken for it."""
    machine = stepper(replace(wall(6, 6), friction=10.0, amplitude=9.81 / (4.0 * np.pi), frequency=2.0), 500)
    advance(machine, 500)
    moved = machine.state.position - machine.assembly.centre
    assert np.abs(moved - moved[np.argmax(machine.assembly.fixed)]).max() < 1e-9


def test_limits_are_kept() -> None:
    """Factorisations end at a limit, with the best answer."""
    problem = thrown(1.5, 1)
    whole = solve(problem, Options(tolerance=1e-8), None)
    assert whole.iterations > 4
    few = solve(problem, Options(tolerance=1e-8, max_iterations=3), None)
    assert few.iterations == 3
    assert "stopped" in few.reason
    begin = natural_map_error(problem, np.zeros_like(whole.impulse))
    assert natural_map_error(problem, few.impulse) <= begin


@pytest.mark.parametrize("problem", [scenes.wall(3, 3), sliding_block().to_local()])
def test_other_problems_are_left_to_the_interior_point_method(problem: FrictionProblem) -> None:
    solution = solve(problem, Options(tolerance=1e-8), None)
    assert solution.reason == "interior: converged"
    assert natural_map_error(problem, solution.impulse) <= 1e-8
