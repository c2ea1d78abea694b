# SPDX-License-Identifier: GPL-3.0-or-later
"""Tolerances that no impulses meet: every solver ends, with the best that it has, and says by how much it missed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, Problem, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options

UNREACHABLE = 1e-300
LIMITS = (None, 1, 40)


def identity(m: int) -> LocalProblem:
    """One contact that presses and slides, W the identity."""
    return LocalProblem(sparse.identity(m, format="csr"), -np.ones((1, m)), np.ones(1))


def random_problem(seed: int, m: int) -> FrictionProblem:
    """Up to three bodies and five contacts, some of them twice, with any friction; in a plane or in space."""
    rng = np.random.default_rng([seed, m])
    bodies, contacts, n = int(rng.integers(1, 4)), int(rng.integers(1, 6)), 3 if m == 2 else 6
    root = rng.normal(size=(bodies, n, n)) + 2.0 * np.eye(n)
    pairs = np.column_stack([rng.integers(0, bodies, contacts), np.full(contacts, -1)])
    others = rng.integers(-1, bodies, contacts)
    pairs[:, 1] = np.where(others == pairs[:, 0], -1, others)
    jacobian = rng.normal(size=(contacts, 2, m, n))
    jacobian[contacts // 2 :] = jacobian[: contacts - contacts // 2]
    return FrictionProblem(
        root @ root.transpose(0, 2, 1), rng.normal(size=(bodies, n)), pairs, Geometry.by_rows(jacobian),
        rng.choice([0.0, -0.1], (contacts, m)),
        rng.choice([0.0, 0.3, 1.0, 2.5], contacts), np.zeros((0, m)),
    )  # fmt: skip


def problems(m: int) -> list[Problem]:
    """Problems given by bodies and by W alone; some without friction, some at a solution."""
    found = [random_problem(seed, m) for seed in range(4)]
    still = replace(found[0], v_free=np.zeros_like(found[0].v_free), offset=np.zeros_like(found[0].offset))
    return [identity(m), *found, still, *(problem.to_local() for problem in (*found, still))]


@pytest.mark.parametrize("m", [2, 3], ids=["plane", "space"])
@pytest.mark.parametrize("name", ["nlgs", "admm", "newton", "interior", "pivoting", "accelerated", "auto"])
def test_every_solver_ends_at_a_tolerance_that_no_impulses_meet(name: str, m: int) -> None:
    for problem in problems(m):
        for limit in LIMITS:
            solution = SOLVERS[name](problem, Options(UNREACHABLE, limit), None)
            assert np.isfinite(solution.impulse).all()
            error = natural_map_error(problem, solution.impulse)
            assert np.isfinite(error) and (error > UNREACHABLE or error == 0.0)
            assert ("converged" in solution.reason) == (error == 0.0), solution.reason
            assert limit is None or solution.iterations <= limit


@pytest.mark.parametrize("m", [2, 3], ids=["plane", "space"])
def test_one_contact_is_solved_to_rounding_though_the_tolerance_is_below(m: int) -> None:
    solution = SOLVERS["auto"](identity(m), Options(1e-16), None)
    assert natural_map_error(identity(m), solution.impulse) <= 1e-12
