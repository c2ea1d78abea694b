# SPDX-License-Identifier: GPL-3.0-or-later
"""Equivalent bodies of few unknowns: the same friction problem, whatever the blocks, and the same impulses by every solver."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numba
import numpy as np
import pytest

from masonry_cd.mechanics.friction.condensation import condense
from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options, admm
from masonry_cd.mechanics.solvers.admm_workspace import AdmmSettings
from masonry_cd.mechanics.solvers.condensed import in_condensed_unknowns

NODES, HEAVY = 12, 1e4


def column(m: int, n: int, seed: int = 0, apart: float = 0.3) -> FrictionProblem:
    """A column of six bodies with n unknowns on a support, pressed together: three contacts a joint, the second of which repeats the first,
    and whose third has rows ``apart`` from the first's. Masses differ by up to HEAVY in one body."""
    random, bodies, joints = np.random.default_rng(seed), 6, 6
    square = np.linalg.qr(random.normal(size=(bodies, n, n)))[0]
    inverse = np.einsum("bik,bk,bjk->bij", square, HEAVY ** -random.uniform(0.0, 1.0, size=(bodies, n)), square)
    first = random.normal(size=(joints, 1, 2, m, n))
    jacobian = np.concatenate([first, first, first + apart * random.normal(size=first.shape)], axis=1).reshape(3 * joints, 2, m, n)
    pairs = np.repeat([[b, b - 1] for b in range(joints)], 3, axis=0)
    jacobian[pairs < 0] = 0.0
    v_free = random.normal(size=(bodies, n))
    problem = FrictionProblem(
        inverse, v_free, pairs, Geometry.by_rows(jacobian), random.normal(size=(len(pairs), m)), np.full(len(pairs), 0.6), np.zeros((0, m))
    )
    return replace(problem, offset=problem.offset - [[3.0] + [0.0] * (m - 1)])


@pytest.mark.parametrize("apart", [0.3, 1e-6])
@pytest.mark.parametrize(("m", "n"), [(2, 10), (2, 24), (3, 36), (3, 6)])
def test_the_problem_of_equivalent_bodies_is_the_same(m: int, n: int, apart: float) -> None:
    """W and q to rounding, where rows nearly repeat too; as many unknowns as independent rows, in steps of four."""
    problem = column(m, n, apart=apart)
    random = np.random.default_rng(1)
    impulse = random.normal(size=(problem.contacts, m))
    moved = problem.body_velocity(impulse)
    found = condense(problem, moved)
    small, local, other = found.problem, problem.to_local(), found.problem.to_local()
    np.testing.assert_allclose(other.w.toarray(), local.w.toarray(), rtol=0.0, atol=1e-14 * np.abs(local.w.toarray()).max())
    np.testing.assert_allclose(other.q, local.q, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(small.relative_velocity(found.velocity), problem.relative_velocity(moved), rtol=0.0, atol=1e-12 / apart)
    for scaled in (True, False):
        assert natural_map_error(small, impulse, scaled) == pytest.approx(natural_map_error(problem, impulse, scaled), rel=1e-12)
    ranks = [min(2 * m * (2 if b < 5 else 1), n) for b in range(6)]  # two joints with two contacts that differ; one on the last
    assert found.kept.sum() == sum(ranks)
    assert small.width is not None
    assert small.width.tolist() == [-(-rank // 4) * 4 for rank in ranks]
    for b, width in enumerate(small.width):
        assert not small.jacobian[small.bodies == b][..., width:].any()


@pytest.mark.parametrize("felt", [1, 10, 13])
@pytest.mark.parametrize(("m", "n"), [(2, 24), (3, 36), (2, 16)])
def test_bodies_have_as_many_unknowns_as_their_own_mesh(m: int, n: int, felt: int) -> None:
    """The largest mesh leaves room in others: rows of every second body are zero beyond those that it has, whatever M^-1 holds there."""
    problem = column(m, n)
    jacobian = problem.jacobian.copy()
    for side in range(2):
        jacobian[problem.bodies[:, side] % 2 == 1, side, :, felt:] = 0.0
    problem = replace(problem, geometry=Geometry.by_rows(jacobian))
    moved = problem.body_velocity(np.random.default_rng(2).normal(size=(problem.contacts, m)))
    found = condense(problem, moved)
    local, other = problem.to_local(), found.problem.to_local()
    np.testing.assert_allclose(other.w.toarray(), local.w.toarray(), rtol=0.0, atol=1e-14 * np.abs(local.w.toarray()).max())
    np.testing.assert_allclose(other.q, local.q, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(found.problem.relative_velocity(found.velocity), problem.relative_velocity(moved), rtol=0.0, atol=1e-11)
    assert found.problem.width is not None
    assert found.problem.width[1] == -(-min(4 * m, felt) // 4) * 4


@pytest.mark.parametrize("softness", [0.0, 1e-3])
@pytest.mark.parametrize("name", ["newton", "admm", "auto", "interior", "nlgs", "accelerated"])
@pytest.mark.parametrize(("m", "n"), [(2, 16), (3, 24)])
def test_every_solver_solves_it(name: str, m: int, n: int, softness: float) -> None:
    """A solution of the equivalent problem solves the one it stands for, springs or not; and the other in as many unknowns as it has."""
    problem = column(m, n)
    problem = replace(problem, compliance=np.full((problem.contacts, m), softness) if softness else problem.compliance)
    options = Options(tolerance=1e-9, max_iterations=20_000)
    for solve in (in_condensed_unknowns(SOLVERS[name]), SOLVERS[name]):
        found = solve(problem, options, None)
        assert natural_map_error(problem, found.impulse) < 2e-9, found.reason


def test_it_is_solved_by_the_kernels_of_other_problems() -> None:
    """Its arrays are of their kind; of any other one, each solver would be compiled once more."""
    problem = column(2, 24)
    assert numba.typeof(condense(problem).problem.arrays()) == numba.typeof(problem.arrays())


def test_factors_in_other_unknowns_are_rebuilt(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where other rows add unknowns, the factors of the step before are out of date; where the same do, they serve again."""
    fresh, run = [], admm.run_by_team

    def watched(kernel: Any, threads: int, *arguments: Any) -> Any:
        fresh.append(next(each.fresh for each in arguments if isinstance(each, AdmmSettings)))
        return run(kernel, threads, *arguments)

    monkeypatch.setattr(admm, "run_by_team", watched)
    solve, problem, options = in_condensed_unknowns(SOLVERS["admm"]), column(2, 24), Options(tolerance=1e-9)
    first = solve(problem, options, None)
    kept = first.memory.kept
    assert kept is not None and kept.dtype == np.bool_
    memory = replace(first.memory, learnt=replace(first.memory.learnt, stale=False))  # as far as their own step knows, they are good
    again = solve(problem, options, Solution(0.9 * first.impulse, None, 0, memory=memory))
    np.testing.assert_array_equal(again.memory.kept, kept)
    assert fresh == [True, False]
    order = np.r_[2, 1, 0, 3 : problem.contacts]
    turned = problem.subset(order)
    other = solve(turned, options, Solution(0.9 * first.impulse[order], None, 0, memory=memory))
    assert not np.array_equal(other.memory.kept, kept)
    assert natural_map_error(turned, other.impulse) < 1e-9
    assert fresh[-1]


def test_rigid_blocks_are_left_as_they_are() -> None:
    """Those of uniform strain too: contacts feel all of their unknowns."""
    seen = []
    solve = in_condensed_unknowns(lambda problem, options, start: seen.append(problem) or Solution(np.zeros((0, 2)), None, 0))  # type: ignore[arg-type, func-returns-value]
    for m, n in ((2, 3), (2, 6), (3, 6), (3, 12)):
        problem = column(m, n)
        solve(problem, Options(), None)
        assert seen[-1] is problem
