# SPDX-License-Identifier: GPL-3.0-or-later
"""Contacts by frames and arms have the operators of their rows of H."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scenes

from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.problem import FrictionProblem, natural_map_error


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


def test_rows_in_a_plane_turn_about_its_normal() -> None:
    """d_i and a . d_i, with a = e x r, on the first body, the opposite on the second."""
    problem = scenes.in_plane(scenes.thrown(0.3))
    axes, arm = problem.geometry.frame, problem.geometry.arm
    for side, sign in enumerate((1.0, -1.0)):
        on = problem.bodies[:, side] >= 0
        moment = np.einsum("ck,cik->ci", arm[:, side], axes)[:, :, None]
        np.testing.assert_allclose(problem.jacobian[on, side], sign * np.concatenate([axes, moment], axis=2)[on], rtol=1e-14)
        assert not problem.jacobian[~on, side].any()


def in_plane_on_one_block(problem: FrictionProblem) -> FrictionProblem:
    """A planar problem with a contact between two places of one block."""
    return on_one_block(scenes.in_plane(problem))


CHANGES = {
    "centred": lambda problem: problem,
    "coupled": scenes.off_centre,
    "on one block": on_one_block,
    "in a plane": in_plane_on_one_block,
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_arms_act_as_their_rows_do(change) -> None:
    """H v, H^T p and, by way of the error, the scales d."""
    problem = change(scenes.thrown(0.3))
    by_rows, random = replace(problem, geometry=Geometry.by_rows(problem.jacobian)), np.random.default_rng(1)
    v, p = random.normal(size=problem.v_free.shape), random.normal(size=problem.offset.shape)
    h = problem.jacobian_matrix()
    np.testing.assert_allclose(problem.relative_velocity(v) - problem.offset, (h @ v.ravel()).reshape(p.shape), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(by_rows.relative_velocity(v), problem.relative_velocity(v), rtol=0.0, atol=1e-12)
    speed = by_rows.body_velocity(p)
    np.testing.assert_allclose(problem.body_velocity(p), speed, rtol=0.0, atol=1e-12 * np.abs(speed).max())
    assert natural_map_error(problem, p) == pytest.approx(natural_map_error(by_rows, p), rel=1e-11)
