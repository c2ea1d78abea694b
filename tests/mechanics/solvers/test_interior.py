# SPDX-License-Identifier: GPL-3.0-or-later
"""Interior point and proximal points: solve what slides or rocks as a whole, in a number of steps that hardly depends on the problem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes
from places import EXAMPLES
from scenes import thrown
from scipy import sparse

from masonry_cd.app.case import prepare
from masonry_cd.app.scene import read_scene
from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.friction.coulomb_law import SLIP, STICK
from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, Solution, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options
from masonry_cd.mechanics.solvers.central_path import Iterate, Linearisation, allows_step, change_contact, contact_step, linearise_contact
from masonry_cd.mechanics.solvers.interior import TURN
from masonry_cd.mechanics.solvers.newton_kernels import first_status_change

solve = SOLVERS["interior"]


def seldom(*values: int) -> list:
    """Values of a parameter that only the long tests take."""
    return [pytest.param(value, marks=pytest.mark.validation) for value in values]


@pytest.mark.parametrize("m", [2, 3])
def test_the_products_of_a_contact_are_linearised(m: int) -> None:
    """A change of impulse and sliding speed, and of w by the springs and by z, changes the products as wanted; the gains are those of z."""
    random, k = np.random.default_rng(5), m + 1
    for _ in range(200):
        mu, gamma = random.uniform(0.05, 2.0), 10.0 ** random.uniform(-8, 2)
        p, w = (
            np.r_[10.0 ** random.uniform(-8, 2), random.normal(size=m - 1)],
            np.r_[10.0 ** random.uniform(-8, 2), random.normal(size=m - 1)],
        )
        p[1:] *= random.uniform() * mu * p[0] / np.linalg.norm(p[1:])  # inside the cones
        w[1:] *= random.uniform() * gamma / np.linalg.norm(w[1:])
        soft, z, wanted = 10.0 ** random.uniform(-12, 0, m), 1e-3 * gamma * random.normal(size=m), random.normal(size=k)
        here = Iterate(w[None], p[None], np.array([gamma]), np.empty((0, 0)))
        pivot, gain, unused = np.empty((1, k)), np.empty((1, m, m)), np.empty((1, m))
        linear = Linearisation(here, unused, wanted[None], pivot, gain, soft[None], unused, unused)
        assert linearise_contact.py_func(w, p, gamma, mu, soft, pivot[0], gain[0], (0,) * m)
        way = Iterate(z[None].copy(), np.empty((1, m)), np.empty(1), np.empty((0, 0)))
        change_contact.py_func(linear, mu, 0, way, m)
        dw, dp, dgamma = way.w[0].copy(), way.p[0].copy(), way.gamma[0]
        assert dw == pytest.approx(z + soft * dp)
        way.w[:] = 0.0
        change_contact.py_func(linear, mu, 0, way, m)
        scale = np.abs(way.p).max() + np.abs(gain[0] * z).max()
        assert way.p[0] - gain[0] @ z == pytest.approx(dp, abs=1e-12 * scale)
        terms = [np.r_[w[0] * dp[0], p[0] * dw[0]], np.r_[gamma * mu * dp[0], mu * p[0] * dgamma, w[1:] * dp[1:], p[1:] * dw[1:]]]
        terms += [np.r_[gamma * dp[i], p[i] * dgamma, mu * p[0] * dw[i], mu * dp[0] * w[i]] for i in range(1, m)]
        for found, asked in zip(terms, wanted, strict=True):
            assert found.sum() == pytest.approx(asked, abs=1e-12 * max(np.abs(found).sum(), 1.0))


@entry()
def stepped(w, p, gamma, dw, dp, dgamma, mu, share, size_m):
    """The longest step of a contact, and whether it allows a share of that, of 1e3 at most."""
    longest = contact_step(w, p, gamma, dw, dp, dgamma, mu, len(size_m))
    return longest, allows_step(w, p, gamma, dw, dp, dgamma, mu, share * min(longest, 1e3), len(size_m))


@pytest.mark.parametrize("m", [2, 3])
def test_a_contact_allows_what_is_shorter_than_its_longest_step(m: int) -> None:
    """A step that stays inside both cones by a hair is allowed, one that leaves one of them by a hair is not."""
    random = np.random.default_rng(7)
    for _ in range(200):
        mu, gamma = random.uniform(0.05, 2.0), random.uniform(0.1, 2.0)
        w, p = np.r_[1.0, 0.3 * gamma * random.normal(size=m - 1)], np.r_[1.0, 0.3 * mu * random.normal(size=m - 1)]
        if np.linalg.norm(w[1:]) >= gamma or np.linalg.norm(p[1:]) >= mu:
            continue
        dw, dp, dgamma = random.normal(size=m), random.normal(size=m), random.normal()
        assert stepped(w, p, gamma, dw, dp, dgamma, mu, 1.0 - 1e-9, (0,) * m)[1]
        longest, allowed = stepped(w, p, gamma, dw, dp, dgamma, mu, 1.0 + 1e-9, (0,) * m)
        assert longest > 1e3 or not allowed


@pytest.mark.parametrize("courses", [5, 20, 80])
def test_few_steps_at_any_height(courses: int) -> None:
    """A wall from rest takes less than 20 factorisations."""
    problem = scenes.wall(3, courses)
    solution = solve(problem, Options(tolerance=1e-8), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-8
    assert solution.iterations < 20


@pytest.mark.parametrize("speed", [0.01, 0.1, 1.0])
def test_solves_what_slides_and_lifts_off(speed: float) -> None:
    """A wall whose ground jerks away, from nothing and from impulses that are all wrong."""
    problem = thrown(speed)
    solution = solve(problem, Options(tolerance=1e-9), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-9
    elsewhere = Solution(2.0 * solution.impulse[::-1], None, 0)
    again = solve(problem, Options(tolerance=1e-9), elsewhere)
    assert natural_map_error(problem, again.impulse) <= 1e-9


def nudged(problem: FrictionProblem, nudge: int) -> FrictionProblem:
    """A problem with free velocities 1e-12 m/s off, as another processor rounds: which way a path goes at its folds may hang on that."""
    return replace(problem, v_free=problem.v_free + 1e-12 * np.random.default_rng(nudge).normal(size=problem.v_free.shape))


@pytest.mark.parametrize("nudge", [0, *seldom(1, 3, 4)])
@pytest.mark.parametrize("uneven", [0.0, 3.0])
def test_solves_local_problems_that_slide(uneven: float, nudge: int) -> None:
    """In the impulses alone, also where contacts are written in units that differ by six powers of ten: the error does not change."""
    problem = nudged(thrown(0.1), nudge).to_local()
    unit = 10.0 ** np.random.default_rng(4).uniform(-uneven, uneven, problem.contacts)
    scale = sparse.diags(np.repeat(unit, 3))
    problem = LocalProblem((scale @ problem.w @ scale).tocsr(), problem.q * unit[:, None], problem.mu)
    solution = solve(problem, Options(tolerance=1e-8), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-8, solution.reason
    first = solve(problem, Options(tolerance=1e-8, max_iterations=2 * TURN), None)
    assert natural_map_error(problem, first.impulse) <= 1e-2  # the first start comes to 3e-4 to 2e-3, which hangs on rounding


def test_solves_an_aqueduct_that_slides_as_a_whole() -> None:
    """The first step of the demo, at 0.24 g: neither ADMM nor Newton comes near."""
    case = prepare(read_scene(EXAMPLES / "aqueduct_sinusoidal.toml"))
    loading = case.loading
    problem = Stepper(case.assembly, loading.support_velocity, loading.acceleration, case.scene.run).friction_problem().problem
    for other in ("admm", "newton"):
        assert natural_map_error(problem, SOLVERS[other](problem, Options(max_iterations=300), None).impulse) > 1e-5
    solution = solve(problem, Options(tolerance=1e-8), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-8
    np.testing.assert_array_equal(solve(problem, Options(tolerance=1e-8), None).impulse, solution.impulse)


def rough(columns: int, courses: int, mu: float, seed: int) -> FrictionProblem:
    """A wall of rough blocks that are thrown apart at random: contacts that slide push others open or shut."""
    problem, random = scenes.wall(columns, courses, mu=mu), np.random.default_rng(seed)
    v_free = problem.v_free.copy()
    v_free[:, :2] += 0.05 * np.linspace(0.0, 1.0, len(v_free))[:, None] * random.normal(size=2)
    return replace(problem, v_free=v_free + 0.02 * random.normal(size=v_free.shape))


@pytest.mark.parametrize("nudge", [1, *seldom(2, 3)])
@pytest.mark.parametrize(("columns", "courses", "mu", "seed"), [(5, 6, 0.8, 7), (5, 6, 1.5, 3), (5, 6, 2.5, 0), (5, 6, 2.5, 2)])
def test_path_leads_around_turning_points(columns: int, courses: int, mu: float, seed: int, nudge: int) -> None:
    """Where the damped path and proximal points after it stall, the path by its length goes on, however it is rounded."""
    problem = nudged(rough(columns, courses, mu, seed), nudge)
    stalled = solve(problem, Options(tolerance=1e-8, max_iterations=2 * TURN), None)
    assert natural_map_error(problem, stalled.impulse) > 1e-6
    solution = solve(problem, Options(tolerance=1e-8), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-8


@pytest.mark.parametrize("count", [4, *seldom(10)])
@pytest.mark.parametrize("mu", [0.8, 1.5, 2.5])
def test_solves_nearly_all_that_is_thrown_apart(mu: float, count: int) -> None:
    """Not a problem or two that luck has picked: of four or ten in a row at most one is left."""
    problems = [nudged(rough(5, 6, mu, seed), seed) for seed in range(count)]
    errors = [natural_map_error(problem, solve(problem, Options(tolerance=1e-8), None).impulse) for problem in problems]
    assert sum(error <= 1e-8 for error in errors) >= count - 1


@pytest.mark.parametrize("side", [1.0 - 1e-14, 1.0 + 1e-14])
@pytest.mark.parametrize(("status", "outward"), [(SLIP, 1.0), (STICK, -1.0)])
def test_contact_keeps_the_status_that_it_moves_into(side: float, status: int, outward: float) -> None:
    """Rounding leaves a contact on either side of the cone where it changed: on its way into its new status it does not change back."""
    mu, x = np.array([0.5]), np.array([[2.0, side, 0.0]])
    dx = np.array([[0.1, 0.1 + outward, 0.0]])
    step, _, _ = first_status_change(mu, np.array([status]), x, dx, 0, 1, (0, 0, 0))
    assert step > 1.0


def test_limit_bounds_both_methods_together() -> None:
    """max_iterations counts the factorisations of the interior point method and of proximal points."""
    solution = solve(thrown(0.3), Options(tolerance=1e-300, max_iterations=70), None)
    assert solution.iterations == 70
    assert "stopped" in solution.reason


def test_impulses_spread_evenly() -> None:
    """It finds the symmetric ones of all impulses that carry a box on four corners, whatever the order of the contacts."""
    problem = scenes.tower(1)
    solution = solve(problem, Options(tolerance=1e-10), None)
    normal = solution.impulse[:, 0]
    assert normal == pytest.approx(normal.mean(), rel=1e-6)


def test_an_error_that_a_scene_accepts_does_not_end_it() -> None:
    """It goes on to the tolerance."""
    problem = thrown(0.3)
    exact = solve(problem, Options(tolerance=1e-10, accept=0.9), None)
    assert natural_map_error(problem, exact.impulse) <= 1e-10
