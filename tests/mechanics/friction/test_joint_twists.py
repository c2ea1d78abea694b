# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of contacts between rigid blocks give their rows of H back."""

from __future__ import annotations

import numpy as np
import scenes

from masonry_cd.mechanics.friction.joint_twists import frames_of, size_of_twist


def test_each_contact_has_the_frame_of_its_rows() -> None:
    """d_i and r x d_i are its rows on both bodies, and r is zero on supports."""
    problem = scenes.thrown(0.3)
    frames = frames_of(problem.jacobian, problem.bodies)
    assert frames.shape == (problem.contacts, 15)
    axes = frames[:, :9].reshape(-1, 3, 3)
    for side, sign in enumerate((1.0, -1.0)):
        arm, on = frames[:, 9 + 3 * side : 12 + 3 * side], problem.bodies[:, side] >= 0
        rows = sign * np.concatenate([axes, np.cross(arm[:, None], axes)], axis=2)
        np.testing.assert_allclose(rows[on], problem.jacobian[on, side], atol=1e-12)
        assert not arm[~on].any()


def test_a_row_that_no_frame_has_leaves_all_contacts_without() -> None:
    """Their twists are then their velocities."""
    problem = scenes.thrown(0.3)
    jacobian = problem.jacobian.copy()
    assert len(size_of_twist(problem.frames, 3)) == 6
    jacobian[5, 0, 1, 4] += 1e-3
    frames = frames_of(jacobian, problem.bodies)
    assert frames.shape == (0, 15)
    assert len(size_of_twist(frames, 3)) == 3
