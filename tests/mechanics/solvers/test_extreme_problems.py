# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiff and extreme friction problems: each reaches its tolerance, or says by how much it missed. Impulses are finite in any case."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scenes
from scipy import sparse

from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, natural_map_error
from masonry_cd.mechanics.solvers import SOLVERS, Options

TOLERANCE = 1e-8


def column(count: int, **kwargs: object) -> FrictionProblem:
    """A column of boxes from rest."""
    return scenes.tower(count, **kwargs)  # type: ignore[arg-type]


def heavy_on_light(ratio: float) -> FrictionProblem:
    """Ten boxes, the top one heavier by the ratio."""
    density = np.full(10, 2000.0)
    density[-1] *= ratio
    return column(10, density=density)


def light_on_heavy(ratio: float) -> FrictionProblem:
    """Ten boxes, the lowest one heavier by the ratio."""
    density = np.full(10, 2000.0)
    density[0] *= ratio
    return column(10, density=density)


def scaled(length: float) -> FrictionProblem:
    """A wall whose blocks have edges of about the given length [m]."""
    low, high = [], []
    for course in range(6):
        edges = np.arange(5.0) if course % 2 == 0 else np.array([0.0, 0.5, 1.5, 2.5, 3.5, 4.0])
        for a, b in pairwise(edges):
            low.append([a, 0.0, 0.5 * course])
            high.append([b, 0.5, 0.5 * course + 0.5])
    return scenes.boxes(length * np.array(low), length * np.array(high))


def many_points(points: int) -> FrictionProblem:
    """Two boxes with many contact points per joint, all but four of them redundant."""
    problem = column(2)
    rng = np.random.default_rng(3)
    weights = rng.dirichlet(np.ones(4), points)  # new points inside the corners: rows of H are linear in the point
    rows, bodies = [], []
    for joint in range(2):
        corners = problem.jacobian[4 * joint : 4 * joint + 4]
        rows.append(np.einsum("pc,csij->psij", weights, corners))
        bodies.append(np.repeat(problem.bodies[4 * joint : 4 * joint + 1], points, axis=0))
    return replace(
        problem,
        geometry=Geometry.by_rows(np.concatenate([problem.jacobian, *rows])),
        bodies=np.concatenate([problem.bodies, *bodies]),
        offset=np.zeros((8 + 2 * points, 3)),
        mu=np.full(8 + 2 * points, 0.6),
        compliance=np.zeros((8 + 2 * points, 3)),
    )


def duplicated() -> FrictionProblem:
    """Every contact of a wall three times."""
    problem = scenes.wall(3, 3)
    return problem.subset(np.repeat(np.arange(problem.contacts), 3))


SOLVABLE: dict[str, Callable[[], FrictionProblem]] = {
    "heavy on light 1e4": lambda: heavy_on_light(1e4),
    "light on heavy 1e8": lambda: light_on_heavy(1e8),
    "no friction": lambda: column(10, mu=0.0),
    "mu 1e-6": lambda: scenes.wall(4, 5, mu=1e-6),
    "mu 2": lambda: scenes.wall(4, 5, mu=2.0),
    "mu 10": lambda: scenes.wall(4, 5, mu=10.0),
    "50 points per joint": lambda: many_points(50),
    "duplicate contacts": duplicated,
    "one contact": lambda: one_contact(),
    "column of 500": lambda: column(500),
    "lengths of 1e-3 m": lambda: scaled(1e-3),
    "lengths of 1e3 m": lambda: scaled(1e3),
    "thrown at 1 mm/s": lambda: scenes.thrown(1e-3),
    "thrown at 0.1 m/s": lambda: scenes.thrown(0.1),
    "thrown at 10 m/s": lambda: scenes.thrown(10.0),
}


def one_contact() -> FrictionProblem:
    """A box that lands on one corner."""
    return column(1).subset(np.array([0]))


def local(w: np.ndarray | sparse.sparray, q: np.ndarray, mu: np.ndarray) -> LocalProblem:
    """A problem in the impulses alone."""
    return LocalProblem(sparse.csr_matrix(w), q.reshape(len(mu), -1), mu)


def low_rank(contacts: int, rank: int, mu: float) -> LocalProblem:
    """W of a low rank, with free velocities from its range."""
    h = np.random.default_rng(7).normal(size=(3 * contacts, rank))
    return local(h @ h.T, h @ np.random.default_rng(8).normal(size=rank), np.full(contacts, mu))


def slippery_and_rough() -> LocalProblem:
    """A wall thrown at 1 cm/s, whose contacts have mu 0 or mu 10 at random."""
    problem = scenes.thrown(0.01)
    return replace(problem, mu=np.random.default_rng(9).choice([0.0, 10.0], problem.contacts)).to_local()


def with_still_contacts() -> LocalProblem:
    """A wall, and contacts between supports: no impulse moves them, and their rows of W are zero."""
    problem = scenes.thrown(0.01).to_local()
    q = np.concatenate([problem.q, [[0.1, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.1, 0.0]]])
    return local(sparse.block_diag([problem.w, np.zeros((9, 9))]), q, np.append(problem.mu, [0.5, 0.5, 0.0]))


def frictionless_rows() -> LocalProblem:
    """Normal rows only: the tangential ones of W are zero, and so is mu."""
    h = np.zeros((90, 20))
    h[::3] = np.random.default_rng(10).normal(size=(30, 20))
    return local(h @ h.T, h @ np.random.default_rng(11).normal(size=20), np.zeros(30))


LOCAL: dict[str, Callable[[], LocalProblem]] = {
    "in the impulses, thrown at 0.1 m/s": lambda: scenes.thrown(0.1).to_local(),
    "thrown, every contact three times": lambda: (
        scenes.thrown(0.01).subset(np.repeat(np.arange(scenes.thrown(0.01).contacts), 3)).to_local()
    ),
    "mu 0 and mu 10": slippery_and_rough,
    "in the impulses, heavy on light 1e4": lambda: heavy_on_light(1e4).to_local(),
    "rows of zeros": with_still_contacts,
    "normal rows only": frictionless_rows,
    "dense, of low rank": lambda: low_rank(60, 40, 0.5),
    "in units a million times larger": lambda: replace(scenes.thrown(0.1).to_local(), w=1e6 * scenes.thrown(0.1).to_local().w),
}


def test_supports_that_close_on_each_other_are_reported() -> None:
    """No impulse can hold them apart: the others are solved, and the error is reported."""
    problem = with_still_contacts()
    problem.q[-3:, 0] = -0.1
    solution = SOLVERS["auto"](problem, Options(tolerance=TOLERANCE, max_iterations=400), None)
    assert np.isfinite(solution.impulse).all()
    assert "missed" in solution.reason
    assert natural_map_error(problem, solution.impulse) > 1e-2


@pytest.mark.parametrize("name", [*SOLVABLE, *LOCAL])
def test_auto_reaches_its_tolerance(name: str) -> None:
    """Whatever the problem, auto solves it to 1e-8 by the measure that no solver has a say in; also W alone, singular or badly scaled."""
    problem = (SOLVABLE | LOCAL)[name]()
    solution = SOLVERS["auto"](problem, Options(tolerance=TOLERANCE), None)
    assert natural_map_error(problem, solution.impulse) <= TOLERANCE, solution.reason


def test_beyond_double_precision_is_said() -> None:
    """A top block 1e8 times heavier presses with impulses of which a 1e-16th already moves a light block: close, and honest about it."""
    problem = heavy_on_light(1e8)
    solution = SOLVERS["auto"](problem, Options(tolerance=TOLERANCE), None)
    error = natural_map_error(problem, solution.impulse)
    assert error <= 1e-4
    assert ("missed" in solution.reason) == (error > TOLERANCE)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", ["heavy on light 1e4", "mu 10", "duplicate contacts", "thrown at 10 m/s"])
def test_what_a_solver_says_is_true(solver: str, name: str) -> None:
    """A solver stopped early returns finite impulses, and claims convergence only where there is."""
    problem = SOLVABLE[name]()
    solution = SOLVERS[solver](problem, Options(tolerance=TOLERANCE, max_iterations=30), None)
    assert np.isfinite(solution.impulse).all()
    assert ("converged" in solution.reason) == (natural_map_error(problem, solution.impulse) <= TOLERANCE)


@pytest.mark.parametrize("solver", SOLVERS)
def test_no_contact(solver: str) -> None:
    """Nothing to solve: no impulse, and the free velocity."""
    problem = scenes.apart()
    solution = SOLVERS[solver](problem, Options(), None)
    assert solution.impulse.shape == (0, 3)
    assert solution.velocity is not None
    np.testing.assert_array_equal(solution.velocity, problem.v_free)


@pytest.mark.parametrize("solver", SOLVERS)
def test_closing_supports_are_reported(solver: str) -> None:
    """A box between two supports that close on it has no solution: finite impulses, a reason that says it, a large error."""
    bottom = column(1)
    rows = bottom.jacobian.copy()
    rows[:, 0, 0] *= -1.0  # the same corners pressed from above; where along the height does not matter for the normal rows
    problem = replace(
        bottom,
        geometry=Geometry.by_rows(np.concatenate([bottom.jacobian, rows])),
        bodies=np.tile(bottom.bodies, (2, 1)),
        offset=np.tile([-0.5, 0.0, 0.0], (8, 1)),
        mu=np.tile(bottom.mu, 2),
    )
    solution = SOLVERS[solver](problem, Options(max_iterations=300), None)
    assert np.isfinite(solution.impulse).all()
    assert natural_map_error(problem, solution.impulse) > 1e-3
    assert "converged" not in solution.reason
