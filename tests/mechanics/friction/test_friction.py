# SPDX-License-Identifier: GPL-3.0-or-later
"""The friction problem and its error measures, against plain numpy formulas."""

from __future__ import annotations

import numpy as np
import pytest
import scenes
from cones import project
from scipy import sparse

from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, Solution, first_impulse, natural_map_error


def plain_error(problem: FrictionProblem | LocalProblem, impulse: np.ndarray, scaled: bool) -> float:
    """The natural map error contact by contact."""
    u, q = problem.apply(impulse), problem.free_relative_velocity()
    d = np.trace(problem.delassus_diagonal(), axis1=1, axis2=2) / problem.dimension
    root = np.sqrt(d) if scaled else np.ones_like(d)
    residual = []
    for c in range(problem.contacts):
        r, w = impulse[c] * root[c], u[c] / root[c]
        shifted = w.copy()
        shifted[0] += problem.mu[c] * np.linalg.norm(w[1:])
        residual.append(r - project(r - shifted, problem.mu[c]))
    return float(np.linalg.norm(residual) / np.linalg.norm(q / root[:, None]))


@pytest.mark.parametrize("scaled", [True, False])
@pytest.mark.parametrize("local", [True, False])
@pytest.mark.parametrize("softness", [0.0, 3.0])
def test_error_agrees_with_its_definition(softness: float, local: bool, scaled: bool) -> None:
    """The compiled measure equals the formula at random impulses inside and outside the cones, with every second contact elastic too."""
    problem = scenes.softened(scenes.wall(3, 4), softness)
    impulse = np.random.default_rng(1).normal(size=(problem.contacts, 3))
    checked = problem.to_local() if local else problem
    assert natural_map_error(checked, impulse, scaled) == pytest.approx(plain_error(problem, impulse, scaled), rel=1e-12)


def test_a_start_of_other_contacts_is_refused_before_kernels_read_it() -> None:
    problem = scenes.wall(3, 4)
    start = Solution(np.zeros((problem.contacts - 1, 3)), None, 0)
    with pytest.raises(ValueError, match="contacts"):
        first_impulse(problem, start)


def test_frictionless_contact_that_opens_has_no_error() -> None:
    """Without friction and without sliding: at the tip of the cone, not beyond it."""
    problem = LocalProblem(sparse.identity(3, format="csr"), np.array([[0.1, 0.0, 0.0]]), np.zeros(1))
    assert natural_map_error(problem, np.zeros((1, 3))) == 0.0


@pytest.mark.parametrize(("velocity", "solved"), [(0.1, True), (0.0, True), (-0.1, False)])
def test_contact_that_no_impulse_moves(velocity: float, solved: bool) -> None:
    """Its rows of W are zero: it is judged by its velocity, on the scale of the other contacts."""
    w = sparse.block_diag([np.eye(3), np.zeros((3, 3))], format="csr")
    problem = LocalProblem(w, np.array([[-1.0, 0.0, 0.0], [velocity, 0.0, 0.0]]), np.array([0.5, 0.5]))
    np.testing.assert_allclose(problem.scales(), 1.0)
    error = natural_map_error(problem, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    assert (error < 1e-15) == solved
    assert np.isfinite(error)


def test_error_has_no_unit() -> None:
    """Lengths in millimetres and masses in grams leave the scaled error as it is; the unscaled one changes."""
    problem = scenes.softened(scenes.wall(2, 3), 0.7)
    impulse = np.random.default_rng(2).normal(size=(problem.contacts, 3))
    length, mass = 1e3, 1e3
    turn = np.array([1.0] * 3 + [1.0 / length] * 3)  # angular velocity keeps its unit when lengths grow
    other = FrictionProblem(
        problem.inverse_mass / mass * np.outer(turn, turn),
        problem.v_free * length * turn,
        problem.bodies,
        Geometry.by_rows(problem.jacobian / turn),
        problem.offset * length,
        problem.mu,
        problem.compliance / mass,
    )
    scaled_impulse = impulse * mass * length
    assert natural_map_error(other, scaled_impulse) == pytest.approx(natural_map_error(problem, impulse), rel=1e-12)
    assert natural_map_error(other, scaled_impulse, False) != pytest.approx(natural_map_error(problem, impulse, False), rel=1e-2)


def test_local_and_body_form_agree() -> None:
    """w = (W + C) p + q with W + C assembled equals the matrix-free product, and the diagonal blocks agree."""
    problem = scenes.softened(scenes.wall(3, 3), 0.5)
    local = problem.to_local()
    impulse = np.random.default_rng(3).normal(size=(problem.contacts, 3))
    np.testing.assert_allclose(local.apply(impulse), problem.apply(impulse), atol=1e-12)
    np.testing.assert_allclose(local.delassus_diagonal(), problem.delassus_diagonal(), atol=1e-15)
