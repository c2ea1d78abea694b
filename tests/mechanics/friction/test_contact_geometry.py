# SPDX-License-Identifier: GPL-3.0-or-later
"""Contacts by frames and arms have the operators of their rows of H."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes

from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem, natural_map_error


def coupled(problem: FrictionProblem) -> FrictionProblem:
    """The problem of blocks whose coordinates are not those of their centres of mass."""
    shift = np.eye(6)
    shift[:3, 3:] = [[0.0, 0.2, -0.3], [-0.2, 0.0, 0.1], [0.3, -0.1, 0.0]]
    return replace(problem, inverse_mass=shift @ problem.inverse_mass @ shift.T)


def on_one_block(problem: FrictionProblem) -> FrictionProblem:
    """The problem with a contact between two places of one block."""
    bodies = problem.bodies.copy()
    bodies[5] = max(bodies[5])
    return replace(problem, bodies=bodies)


def test_rows_are_those_of_frame_and_arms() -> None:
    """d_i and r x d_i on the first body, the opposite on the second, and nothing on supports."""
    problem = scenes.thrown(0.3)
    axes, arm = problem.geometry.frame, problem.geometry.arm
    for side, sign in enumerate((1.0, -1.0)):
        on = problem.bodies[:, side] >= 0
        rows = sign * np.concatenate([axes, np.cross(arm[:, side, None], axes)], axis=2)
        np.testing.assert_array_equal(problem.jacobian[on, side], rows[on])
        assert not problem.jacobian[~on, side].any()
        assert not arm[~on, side].any()


@pytest.mark.parametrize("change", [lambda problem: problem, coupled, on_one_block], ids=["centred", "coupled", "on one block"])
def test_arms_act_as_their_rows_do(change) -> None:
    """H v, H^T p and, by way of the error, the scales d."""
    problem = change(scenes.thrown(0.3))
    by_rows, random = replace(problem, geometry=Geometry.by_rows(problem.jacobian)), np.random.default_rng(1)
    v, p = random.normal(size=problem.v_free.shape), random.normal(size=problem.offset.shape)
    h = problem.jacobian_matrix()
    np.testing.assert_allclose(problem.relative_velocity(v) - problem.offset, (h @ v.ravel()).reshape(-1, 3), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(by_rows.relative_velocity(v), problem.relative_velocity(v), rtol=0.0, atol=1e-12)
    speed = by_rows.body_velocity(p)
    np.testing.assert_allclose(problem.body_velocity(p), speed, rtol=0.0, atol=1e-12 * np.abs(speed).max())
    assert natural_map_error(problem, p) == pytest.approx(natural_map_error(by_rows, p), rel=1e-11)
