# SPDX-License-Identifier: GPL-3.0-or-later
"""The local Coulomb step against its own law, and Gauss-Seidel sweeps."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import scenes
from cones import project
from scipy import sparse

from masonry_cd.mechanics.friction.problem import LocalProblem, Solution, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options
from masonry_cd.mechanics.solvers.nlgs_kernels import colour_joints

solve = SOLVERS["nlgs"]


def local_step(w: np.ndarray, q: np.ndarray, mu: float) -> np.ndarray:
    """The answer of one sweep to one contact with u = W p + q: that of the local step."""
    problem = LocalProblem(sparse.csr_matrix(w), q[None], np.array([mu]))
    return solve(problem, Options(tolerance=1e-300, max_iterations=1), None).impulse[0]


def law_residual(w: np.ndarray, q: np.ndarray, mu: float, p: np.ndarray) -> float:
    """The natural map error of a single contact, by its definition."""
    u, root = w @ p + q, np.sqrt(np.trace(w) / len(q))
    r, x = p * root, p * root - u / root
    x[0] -= mu * np.linalg.norm(u[1:]) / root
    return float(np.linalg.norm(r - project(x, mu)) / np.linalg.norm(q / root))


@pytest.mark.parametrize("m", [2, 3])
@pytest.mark.parametrize("mu", [0.0, 1e-12, 1e-3, 0.3, 0.7, 1.0, 3.0, 10.0])
def test_local_step_is_exact(m: int, mu: float) -> None:
    """Random contacts of any size and conditioning are answered to rounding: separated, stuck and slipping ones."""
    rng = np.random.default_rng(int(1000 * mu) + m)
    for trial in range(300):
        root = rng.normal(size=(m, m)) + (3.0 if trial % 3 else 0.3) * np.eye(m)
        w = root @ root.T * 10.0 ** rng.uniform(-12, 12)
        q = rng.normal(size=m) * 10.0 ** rng.uniform(-8, 8)
        q[0] = -abs(q[0]) if trial % 4 else q[0]
        p = local_step(w, q, mu)
        assert np.isfinite(p).all()
        assert law_residual(w, q, mu, p) < 1e-14 * np.linalg.cond(w) + 1e-13, (w, q, p)


def test_sliding_block_has_the_closed_form() -> None:
    """One contact with W = I: impulse mu q_n against the sliding, and the rest of the velocity stays."""
    p = local_step(np.eye(3), np.array([-1.0, 3.0, 4.0]), 0.5)
    np.testing.assert_allclose(p, [1.0, -0.3, -0.4], atol=1e-15)


def test_nothing_becomes_nan() -> None:
    """Free velocities of zero, W of the size of the smallest and largest floats, and a flat W give finite impulses in the cone."""
    cases = [
        (np.eye(3), np.zeros(3)),
        (1e-150 * np.eye(3), np.array([-1e-150, 1.0, 1.0])),
        (1e150 * np.eye(3), np.array([-1e150, 1.0, 1.0])),
        (np.diag([1.0, 1e-30, 1.0]), np.array([-1.0, 1.0, 0.0])),
        (np.ones((3, 3)), np.array([-1.0, 1.0, -2.0])),
    ]
    for w, q in cases:
        for mu in (0.0, 0.5, 10.0):
            p = local_step(w, q, mu)
            assert np.isfinite(p).all()
            assert p[0] >= 0.0
            assert np.linalg.norm(p[1:]) <= mu * p[0] * (1 + 1e-12)


def test_converges_on_bodies_and_on_the_local_form() -> None:
    """A short tower is solved to 1e-10 in both forms, with the same velocities."""
    problem = scenes.tower(3)
    bodies = solve(problem, Options(tolerance=1e-10), None)
    local = solve(problem.to_local(), Options(tolerance=1e-10), None)
    assert natural_map_error(problem, bodies.impulse) <= 1e-10
    assert natural_map_error(problem, local.impulse) <= 1e-10
    assert bodies.velocity is not None
    np.testing.assert_allclose(bodies.velocity, 0.0, atol=1e-10)


def test_seed_decides_the_bits() -> None:
    """Equal seeds give equal bits; another seed gives other impulses, as rigid hyperstatic forces are not unique."""
    problem = scenes.wall(3, 4)
    one, again, other = (solve(problem, Options(max_iterations=50, seed=seed), None).impulse for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, again)
    assert not np.array_equal(one, other)


def test_forces_of_a_hyperstatic_scene_vary_over_seeds_but_not_what_they_do() -> None:
    """Converged impulses of a wall at rest differ from seed to seed; the velocities that they leave do not."""
    problem = scenes.wall(3, 4)
    found = [solve(problem, Options(tolerance=1e-10, max_iterations=20_000, seed=seed), None) for seed in range(3)]
    assert max(solution.error for solution in found) <= 1e-10
    one, *others = (solution.impulse for solution in found)
    assert min(np.abs(other - one).max() for other in others) > 1e-3 * np.abs(one).max()
    for solution in found:
        np.testing.assert_allclose(solution.velocity, 0.0, atol=1e-8)


def test_warm_start_needs_no_sweep() -> None:
    """A solution is recognised before the first sweep."""
    problem = scenes.tower(3)
    first = solve(problem, Options(), None)
    assert solve(problem, Options(), Solution(first.impulse, None, 0)).iterations == 0


def test_limit_is_said() -> None:
    """A tall tower is not done after 100 sweeps, and the reason says so."""
    solution = solve(scenes.tower(50), Options(max_iterations=100), None)
    assert solution.iterations == 100
    assert "limit reached" in solution.reason


@pytest.mark.slow(reason="threads spin while they wait for one another")
def test_threads_change_no_bit() -> None:
    """Sweeps on one thread and on two give the same bits, and they converge."""
    problem = scenes.wall(6, 4)
    one, two = (solve(problem, Options(max_iterations=200, threads=threads), None) for threads in (1, 2))
    np.testing.assert_array_equal(one.impulse, two.impulse)
    assert natural_map_error(problem, one.impulse) < 1e-2


def test_colours_share_no_block() -> None:
    """Joints of a colour touch no moving block twice, and every joint has a colour."""
    problem = scenes.wall(6, 4)
    bodies = len(problem.v_free)
    index = np.where(problem.bodies < 0, bodies, problem.bodies)
    start, order, ends = colour_joints(index, bodies)
    assert sorted(order) == list(range(len(start) - 1))
    for low, high in pairwise(ends):
        touched = index[start[order[low:high]]].ravel()
        moving = touched[touched < bodies]
        assert len(set(moving)) == len(moving)
