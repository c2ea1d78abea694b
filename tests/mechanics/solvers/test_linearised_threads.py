# SPDX-License-Identifier: GPL-3.0-or-later
"""The methods that linearise the law, by teams of threads: the same bits for any number, with one subtree and with several."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes

from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem, natural_map_error
from masonry_cd.mechanics.friction.solver_state import SolverState
from masonry_cd.mechanics.linalg import ordering
from masonry_cd.mechanics.solvers import SOLVERS, Options
from masonry_cd.mechanics.solvers.linearised import MethodSettings
from masonry_cd.mechanics.solvers.linearised_bodies import interior_by_team, newton_by_team, over_bodies, path_by_team
from masonry_cd.mechanics.solvers.recall import recall
from masonry_cd.mechanics.solvers.shares import CHUNK

METHODS = {"newton": newton_by_team, "interior": interior_by_team, "path": path_by_team}
LIMIT = {"newton": 60, "interior": 15, "path": 15}  # iterations that lead from nothing into the thick of it


def sliding_wall(elastic: bool = False) -> FrictionProblem:
    """A wall in space, whose blocks are thrown along it, with every second contact on a spring or none."""
    problem = scenes.wall(5, 8)
    random = np.random.default_rng(3)
    problem = replace(problem, v_free=problem.v_free + random.normal(0.0, 0.05, problem.v_free.shape))
    return scenes.softened(problem, 0.1) if elastic else problem


def answer(problem: FrictionProblem, method: str, limit: int, threads: int) -> tuple[np.ndarray, np.ndarray, tuple[float, ...]]:
    """Impulses (C, 3) and velocities (B, 6) after a number of iterations from nothing, and what the method returns."""
    impulse, velocity = np.zeros((problem.contacts, 3)), np.empty(problem.v_free.shape)
    settings = MethodSettings(1.0, 1e-12, limit)
    return impulse, velocity, over_bodies(METHODS[method], problem.arrays(), recall(problem, None), settings, impulse, velocity, threads)


@pytest.mark.parametrize("blocks", [10, ordering.SUBTREE])
@pytest.mark.parametrize("elastic", [False, True])
@pytest.mark.parametrize("method", METHODS)
def test_threads_change_no_bit(method: str, elastic: bool, blocks: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """One, two and three threads give the same bits, from subtrees of a given number of blocks."""
    monkeypatch.setattr(ordering, "SUBTREE", blocks)
    problem = sliding_wall(elastic)
    assert problem.contacts > 4 * CHUNK
    assert (len(recall(problem, None).factors.pattern.symbolic.level) > 2) == (blocks == 10)
    impulse, velocity, found = answer(problem, method, LIMIT[method], 1)
    assert impulse.any()
    for threads in (2, 3):
        p, v, other = answer(problem, method, LIMIT[method], threads)
        np.testing.assert_array_equal(p, impulse)
        np.testing.assert_array_equal(v, velocity)
        np.testing.assert_array_equal(other, found)


@pytest.mark.parametrize("solver", ["newton", "interior"])
def test_solvers_take_the_threads_of_the_options(solver: str) -> None:
    """They end with the same bits below the tolerance."""
    problem = scenes.thrown(0.05)
    start = replace(SOLVERS["admm"](problem, Options(tolerance=1e-4), None), memory=SolverState())
    one, two = (SOLVERS[solver](problem, Options(tolerance=1e-8, threads=threads), start) for threads in (1, 2))
    np.testing.assert_array_equal(one.impulse, two.impulse)
    assert natural_map_error(problem, one.impulse) <= 1e-8
    assert one.iterations == two.iterations > 0


@pytest.mark.parametrize("elastic", [False, True])
def test_rigid_blocks_have_the_matrix_of_any_others(elastic: bool) -> None:
    """Assembled by cross products and from the rows of H it differs by rounding: so do the impulses after a few iterations."""
    problem = sliding_wall(elastic)
    by_rows = replace(problem, geometry=Geometry.by_rows(problem.jacobian))
    one, other = (answer(each, "interior", 4, 1)[0] for each in (problem, by_rows))
    np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-9 * np.abs(other).max())
    assert (one != other).any()
