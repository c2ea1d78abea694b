# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic contacts in the friction problem: closed forms, the rigid limit, every solver against the others, stiff, soft and mixed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes

from masonry_cd.mechanics.dynamics.impacts import solve_apart
from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options

STEP = 1e-3
FALL = scenes.GRAVITY * STEP  # speed that gravity gives in a step [m/s]


def particle(m: int, slide: float, mass: float = 2.0, compliance: tuple[float, float] = (0.5, 1.5), mu: float = 0.6) -> FrictionProblem:
    """One block on one spring below its centre: W = I / mass, C = diag(normal, tangential), and it comes sliding."""
    n = 2 * m if m == 3 else 3
    jacobian, v_free = np.zeros((1, 2, m, n)), np.zeros((1, n))
    jacobian[0, 0, :, :m] = np.roll(np.eye(m), -1, axis=1)  # the last coordinate is up
    v_free[0, m - 1], v_free[0, 0] = -FALL, slide
    spring = np.array([[compliance[0], *(m - 1) * [compliance[1]]]])
    return FrictionProblem(
        np.eye(n)[None] / mass, v_free, np.array([[0, -1]]), Geometry.by_rows(jacobian), np.zeros((1, m)), np.array([mu]), spring
    )


@pytest.mark.parametrize("m", [2, 3])
@pytest.mark.parametrize("name", ["admm", "auto", "newton", "nlgs"])
def test_particle_on_a_spring_sticks_and_slips(name: str, m: int) -> None:
    """p_n = g h / (1/M + C_n); p_t = -slide / (1/M + C_t) until it reaches mu p_n."""
    normal, bound = FALL / (0.5 + 0.5), 0.6 * FALL / (0.5 + 0.5)
    for share in (0.99, 1.01):
        problem = particle(m, slide=share * bound * (0.5 + 1.5))
        impulse = SOLVERS[name](problem, Options(tolerance=1e-13), None).impulse[0]
        assert impulse[0] == pytest.approx(normal, rel=1e-10)
        assert impulse[1] == pytest.approx(-min(share, 1.0) * bound, rel=1e-10)
        w = problem.apply(impulse[None])[0]
        assert w[1] == pytest.approx(max(share - 1.0, 0.0) * 2.0 * bound, abs=1e-12)


@pytest.mark.parametrize("name", ["admm", "auto", "interior", "newton", "nlgs"])
def test_chain_of_blocks_and_springs(name: str) -> None:
    """A tower that settles onto its elastic joints: the joint forces solve a tridiagonal system."""
    count, softness = 6, 0.3
    problem = scenes.softened(scenes.tower(count), softness, every=1)
    mass = 1.0 / problem.inverse_mass[:, 0, 0]
    relative = np.eye(count) - np.eye(count, k=-1)  # of each block to the one below
    joint = relative / mass @ relative.T + np.diag(problem.compliance[::4, 0] / 4.0)
    force = np.linalg.solve(joint, relative @ np.full(count, FALL))
    impulse = SOLVERS[name](problem, Options(tolerance=1e-12), None).impulse
    np.testing.assert_allclose(impulse[:, 0], np.repeat(force / 4.0, 4), rtol=1e-8)


def test_stiff_limit_is_rigid() -> None:
    """The velocities tend to those of rigid contacts in proportion to the compliance."""
    rigid = scenes.wall(3, 4, mu=2.0)
    rigid = replace(rigid, v_free=rigid.v_free + 0.005 * np.random.default_rng(1).normal(size=rigid.v_free.shape))
    expected = SOLVERS["auto"](rigid, Options(tolerance=1e-13), None).velocity
    misses = []
    for softness in (1e-2, 1e-3, 1e-4):
        solution = SOLVERS["auto"](scenes.softened(rigid, softness, every=1), Options(tolerance=1e-11), None)
        assert solution.velocity is not None
        misses.append(np.abs(solution.velocity - expected).max())
    assert misses[1] < 0.2 * misses[0]
    assert misses[2] < 0.15 * misses[1]
    assert misses[2] < 5e-3 * np.abs(rigid.v_free).max()


def mixed() -> FrictionProblem:
    """A small wall in motion: elastic joints that slip, stick and open, and rough rigid ones that do not slip, so that v is unique."""
    problem = scenes.softened(scenes.wall(2, 3), 0.5, every=2, by_joint=True)
    v_free = problem.v_free + 0.01 * np.random.default_rng(0).normal(size=problem.v_free.shape)
    return replace(problem, v_free=v_free, mu=np.where(problem.compliance[:, 0] > 0.0, 0.4, 3.0))


@pytest.mark.parametrize("name", ["admm", "newton", "nlgs"])
@pytest.mark.parametrize("local", [False, True])
def test_solvers_agree_where_rigid_and_elastic_joints_mix(name: str, local: bool) -> None:
    """The velocities are those of ``auto`` to 1e-9 of the largest; so are the impulses of the elastic contacts."""
    problem = mixed()
    expected = SOLVERS["auto"](problem, Options(tolerance=1e-13), None)
    assert natural_map_error(problem, expected.impulse) < 1e-13
    options = Options(tolerance=1e-12, max_iterations=100_000)
    impulse = SOLVERS[name](problem.to_local() if local else problem, options, None).impulse
    velocity, other = problem.body_velocity(impulse), problem.body_velocity(expected.impulse)
    np.testing.assert_allclose(velocity, other, atol=1e-9 * np.abs(other).max())
    soft = problem.compliance[:, 0] > 0.0
    np.testing.assert_allclose(impulse[soft], expected.impulse[soft], atol=1e-9 * np.abs(expected.impulse).max())


@pytest.mark.parametrize("softness", [1e-3, 1.0, 1e3])
def test_hyperstatic_walls_are_easier_when_elastic(softness: float) -> None:
    """Where rigid contacts leave the forces open, springs settle them: few iterations of every method, from stiff to soft."""
    problem = scenes.softened(scenes.wall(8, 10), softness, every=1)
    for name, limit in (("admm", 70), ("newton", 25)):
        solution = SOLVERS[name](problem, Options(tolerance=1e-9, max_iterations=limit), None)
        assert natural_map_error(problem, solution.impulse) <= 1e-9, name
    if softness >= 1.0:
        assert SOLVERS["nlgs"](problem, Options(tolerance=1e-9), None).iterations <= 100


@pytest.mark.parametrize("softness", [1e-8, 1e-7, 1e-6, 1e-4, 1e-2, 1.0, 1e3])
@pytest.mark.parametrize("by_joint", [True, False])
@pytest.mark.parametrize("speed", [0.0, 0.05])
@pytest.mark.parametrize("size", [(5, 5), (8, 10)])
def test_auto_solves_every_mixture(softness: float, by_joint: bool, speed: float, size: tuple[int, int]) -> None:
    """Rigid and elastic contacts side by side or in one joint, at rest and sheared, from very stiff to very soft.

    Stiff springs settle what the rigid contacts leave open: the error shows it only as a share C / W of the impulses.
    """
    problem = scenes.softened(scenes.wall(*size), softness, every=2, by_joint=by_joint)
    v_free = problem.v_free.copy()
    v_free[:, 0] += speed * np.linspace(0.0, 1.0, len(v_free))
    problem = replace(problem, v_free=v_free)
    solution = SOLVERS["auto"](problem, Options(tolerance=1e-9, max_iterations=1500), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-9


def test_impacts_apart_leave_the_springs_their_law() -> None:
    """A block on a rigid contact is hit by another while springs hold it: rigid impulses add up, elastic ones obey their law as a whole."""
    problem = scenes.softened(scenes.tower(3), 0.4, every=2, by_joint=True)  # the joints 1 and 3 elastic, 2 rigid
    v_free = problem.v_free.copy()
    v_free[2, 2] -= 0.1
    problem = replace(problem, v_free=v_free)
    is_open = problem.bodies[:, 0] == 2
    gap = np.where(is_open, 1e-5, 0.0)

    def solve(part: FrictionProblem, start: Solution, kind: str) -> Solution:
        return SOLVERS["auto"](part, Options(tolerance=1e-12), start)

    found = solve_apart(
        problem, is_open, problem.compliance.any(axis=1), gap, STEP, Solution(np.zeros((problem.contacts, 3)), None, 0), solve
    )
    impulse, soft = found.solution.impulse, problem.compliance[:, 0] > 0.0
    w = problem.apply(impulse)
    assert found.error < 1e-12
    assert np.abs(w[soft] * impulse[soft]).max() < 1e-12
    assert w[soft, 0].min() > -1e-12
    assert impulse[~soft, 0].min() > 0.0
