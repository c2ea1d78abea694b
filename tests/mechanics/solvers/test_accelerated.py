# SPDX-License-Identifier: GPL-3.0-or-later
"""Accelerated sweeps: their answers, what they gain, and their bits."""

from __future__ import annotations

import numpy as np
import pytest
import scenes

from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options, nlgs

solve = SOLVERS["accelerated"]
GRAINS = scenes.packing(5, mu=0.3, speed=0.02)


@pytest.mark.parametrize("mu", [0.0, 0.3, 0.6, 0.8])
@pytest.mark.parametrize(("speed", "tolerance", "share"), [(0.0, 1e-4, 0.4), (0.05, 1e-3, 0.8), (0.5, 1e-3, 0.8)])
def test_packed_spheres_in_fewer_sweeps(mu: float, speed: float, tolerance: float, share: float) -> None:
    """Spheres that lie, that slide past each other and that are struck take a share of the sweeps that they take without."""
    problem, options = scenes.packing(5, mu=mu, speed=speed), Options(tolerance, 1500)
    fast, slow = (SOLVERS[name](problem, options, None) for name in ("accelerated", "nlgs"))
    assert natural_map_error(problem, fast.impulse) <= tolerance
    assert fast.iterations <= share * slow.iterations


@pytest.mark.parametrize("problem", [scenes.tower(5), scenes.wall(3, 4), scenes.tower(3).to_local()], ids=["tower", "wall", "local"])
def test_converges_on_blocks(problem: FrictionProblem) -> None:
    """Low structures are solved to 1e-10, over bodies and in the impulses alone."""
    solution = solve(problem, Options(tolerance=1e-10), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-10
    if solution.velocity is not None:
        np.testing.assert_allclose(solution.velocity, problem.body_velocity(solution.impulse), atol=1e-12)


def test_a_tower_takes_a_third_of_the_sweeps() -> None:
    """The error propagates by a joint a sweep, and what is extrapolated goes farther."""
    fast, slow = (SOLVERS[name](scenes.tower(5), Options(tolerance=1e-6), None).iterations for name in ("accelerated", "nlgs"))
    assert fast < slow / 3.0


def test_threads_and_seeds_change_no_bit() -> None:
    """Sums are taken in a fixed order, and so are the joints."""
    one, two, other = (
        solve(GRAINS, Options(tolerance=1e-6, max_iterations=205, threads=threads, seed=seed), None)
        for threads, seed in ((1, 0), (2, 0), (1, 7))
    )
    for again in (two, other):
        np.testing.assert_array_equal(one.impulse, again.impulse)
        np.testing.assert_array_equal(one.velocity, again.velocity)
        assert one.iterations == again.iterations


@pytest.mark.parametrize("problem", [GRAINS, GRAINS.to_local()], ids=["bodies", "local"])
def test_the_best_measured_is_returned(problem: FrictionProblem) -> None:
    """A longer search never ends worse than a shorter one, though the error goes up and down on the way."""
    errors = [
        natural_map_error(problem, solve(problem, Options(tolerance=1e-300, max_iterations=limit), None).impulse)
        for limit in range(10, 400, 10)
    ]
    assert errors == sorted(errors, reverse=True)
    assert len(set(errors)) < len(errors)  # it did go up


def test_warm_start_needs_no_sweep() -> None:
    """A solution is recognised before the first sweep."""
    first = solve(GRAINS, Options(tolerance=1e-4), None)
    assert solve(GRAINS, Options(tolerance=1.001e-4), Solution(first.impulse, None, 0)).iterations == 0


def test_limit_is_said() -> None:
    """A tall tower is not done after 15 sweeps, and the reason says so."""
    solution = solve(scenes.tower(50), Options(max_iterations=15), None)
    assert solution.iterations == 15
    assert "limit reached" in solution.reason


def test_restarts_keep_it_from_running_away(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where contacts slip the extrapolation overshoots: without restarts the error grows."""
    problem, options = scenes.packing(5, mu=0.8, speed=0.05), Options(tolerance=1e-4, max_iterations=600)
    assert natural_map_error(problem, solve(problem, options, None).impulse) < 1e-3
    monkeypatch.setattr(nlgs, "EVERY", 600)  # the error is measured once, at the end
    assert natural_map_error(problem, solve(problem, options, None).impulse) > 1e-2
