# SPDX-License-Identifier: GPL-3.0-or-later
"""A problem given by W alone is to the solvers one over bodies: the same operator, the same error, whatever the rank of W."""

from __future__ import annotations

import numpy as np
import pytest
import scenes
from scipy import sparse

from masonry_cd.mechanics.friction.coupling import is_definite
from masonry_cd.mechanics.friction.law_terms import errors_by_group
from masonry_cd.mechanics.friction.problem import LocalProblem, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options

ITERATIVE = ("accelerated", "admm", "auto", "interior", "newton", "nlgs")


@pytest.mark.parametrize("local", [False, True], ids=["bodies", "W"])
@pytest.mark.parametrize("name", ITERATIVE)
def test_every_solver_returns_the_error_of_its_answer(name: str, local: bool) -> None:
    problem = scenes.tower(3).to_local() if local else scenes.tower(3)
    for options in (Options(tolerance=1e-9), Options(tolerance=1e-300, max_iterations=3)):
        solution = SOLVERS[name](problem, options, None)
        assert solution.error == pytest.approx(natural_map_error(problem, solution.impulse), rel=1e-6, abs=1e-14)


@pytest.mark.parametrize("name", ITERATIVE)
def test_what_the_solvers_find_moves_as_w_says(name: str) -> None:
    problem = scenes.tower(3).to_local()
    solution = SOLVERS[name](problem, Options(tolerance=1e-9), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-9
    if solution.velocity is not None:
        np.testing.assert_allclose(solution.velocity, problem.apply(solution.impulse), atol=1e-9)


@pytest.mark.parametrize("name", ["admm", "interior", "newton"])
def test_a_w_of_low_rank_without_symmetry_in_the_last_digits_is_solved(name: str) -> None:
    """Eight contacts that three numbers move, one of which no impulse moves, with the rounding of a published file."""
    rng = np.random.default_rng(3)
    h = rng.normal(size=(24, 3))
    h[6:9] = 0.0
    w = h @ h.T * (1.0 + 1e-14 * rng.normal(size=(24, 24)))
    problem = LocalProblem(sparse.csr_matrix(w), (h @ rng.normal(size=3)).reshape(8, 3), np.full(8, 0.5))
    solution = SOLVERS[name](problem, Options(tolerance=1e-8), None)
    assert natural_map_error(problem, solution.impulse) <= 1e-8, solution.reason


def test_errors_by_group_add_up_to_that_of_all() -> None:
    problem = scenes.wall(3, 3)
    impulse = np.random.default_rng(0).random((problem.contacts, 3))
    for each in (problem, problem.to_local()):
        residual, size = errors_by_group(each.arrays(), impulse, np.arange(each.contacts) % 3, 3)
        assert np.linalg.norm(residual) / np.linalg.norm(size) == pytest.approx(natural_map_error(problem, impulse), rel=1e-12)


@pytest.mark.parametrize(("least", "definite"), [(-1e-3, False), (1e-3, True)])
def test_definite_is_what_the_least_eigenvalue_says(least: float, definite: bool) -> None:
    values, vectors = np.array([least, *np.linspace(0.5, 2.0, 5)]), np.linalg.qr(np.random.default_rng(1).normal(size=(6, 6)))[0]
    problem = LocalProblem(sparse.csr_matrix(vectors @ np.diag(values) @ vectors.T), np.zeros((2, 3)), np.ones(2))
    assert is_definite(problem.w, 1e-6) == definite
