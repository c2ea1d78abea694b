"""Contacts of a joint share its twist: frames and arms give H back, and where they cannot each contact keeps its rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scenes

from masonry_cd.mechanics.friction.joint_twists import frames_of, size_of_twist
from masonry_cd.mechanics.friction.problem import FrictionProblem
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.solvers.contact_partition import ContactPartition, partition_contacts


def partition(problem: FrictionProblem) -> ContactPartition:
    """The contacts of a problem by subtree and joint."""
    given = problem.arrays()
    pattern = Pattern.of(len(problem.v_free), given.bodies[:, 0], given.bodies[:, 1])
    found = pattern.locate(given.bodies, given.bodies)
    assert found is not None
    index, block, _ = found
    return partition_contacts(given, index, block, pattern.symbolic, size_of_twist(given.jacobian, given.bodies))


def test_frames_and_arms_give_the_rows_of_contacts_back() -> None:
    """Joints of a wall have several contacts; d_i and (r + a) x d_i are their rows on both bodies."""
    problem = scenes.thrown(0.3)
    made = partition(problem)
    joints = made.joints
    assert len(joints.s) == 6
    assert len(made.place) <= problem.contacts // 3
    of_contact = np.repeat(np.arange(len(made.place)), np.diff(joints.start))
    frames = joints.frame[of_contact, :9].reshape(-1, 3, 3)
    arm = np.einsum("ci,cik->ck", joints.arm, frames)
    for side, sign in enumerate((1.0, -1.0)):
        on = problem.bodies[made.contact, side] >= 0
        reach = (joints.frame[of_contact, 9 + 3 * side : 12 + 3 * side] + arm)[on]
        rows = sign * np.concatenate([frames[on], np.cross(reach[:, None], frames[on])], axis=2)
        np.testing.assert_allclose(rows, problem.jacobian[made.contact[on], side], atol=1e-12)


def test_contacts_whose_rows_are_not_of_rigid_bodies_keep_them() -> None:
    """A row that no frame has leaves all contacts joints of their own."""
    problem = scenes.thrown(0.3)
    jacobian = problem.jacobian.copy()
    jacobian[5, 0, 1, 4] += 1e-3
    odd = replace(problem, jacobian=jacobian)
    made = partition(odd)
    assert len(made.joints.s) == 3
    np.testing.assert_array_equal(made.joints.rows, jacobian[made.contact])
    assert frames_of(jacobian, problem.bodies).shape == (0, 15)


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
