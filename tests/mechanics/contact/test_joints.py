# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint measures against slips and hinges made by hand."""

import numpy as np
import pytest
from models import box, ground, tower, turned, wall

from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import JointPeaks, measure_joints
from masonry_cd.mechanics.model.state import State


def test_the_joints_of_a_wall_are_its_bed_and_head_joints():
    assembly = Assembly.from_blocks(wall(4, 4, length=0.4, height=0.2, width=0.3), 0.6)
    joints = find_joints(assembly)
    bed = np.abs(joints.normal[:, 2]) > 0.5
    assert joints.count == (4 + 3 * 8) + (2 * 3 + 2 * 4)
    assert joints.area[bed].sum() == pytest.approx(4 * 4 * 0.4 * 0.3)  # four bed joints over the whole length
    assert joints.area[~bed] == pytest.approx(0.2 * 0.3)
    toward = assembly.centre[joints.block_b] - assembly.centre[joints.block_a]
    assert (np.einsum("ji,ji->j", toward, joints.normal) > 0).all()


def test_nothing_is_open_at_rest():
    assembly = Assembly.from_blocks(wall(3, 3), 0.6)
    joints = find_joints(assembly)
    measures = measure_joints(joints, assembly, State.at_rest(assembly))
    assert max(measures.opening.max(), measures.sliding.max(), measures.rotation.max()) < 1e-14
    assert measures.contact_area == pytest.approx(joints.area)


def test_a_known_slip_comes_back():
    assembly = Assembly.from_blocks(tower(2, side=0.5), 0.6)
    joints, state = find_joints(assembly), State.at_rest(assembly)
    state.position[2] += [0.03, -0.04, 0.0]
    measures = measure_joints(joints, assembly, state)
    assert measures.sliding == pytest.approx([0.0, 0.05], abs=1e-14)
    assert measures.opening == pytest.approx([0.0, 0.0], abs=1e-14)
    assert measures.contact_area == pytest.approx([0.25, 0.47 * 0.46])


@pytest.mark.parametrize("angle", [1e-5, 1e-3, 0.3])
def test_a_known_hinge_comes_back(angle):
    assembly = Assembly.from_blocks(tower(2, side=0.5, height=0.25), 0.6)
    joints = find_joints(assembly)
    measures = measure_joints(joints, assembly, turned(assembly, 2, (0.0, 1.0, 0.0), angle, (0.25, 0.0, 0.25)))
    assert measures.rotation == pytest.approx([0.0, angle], rel=1e-9)
    assert measures.opening == pytest.approx([0.0, 0.5 * np.sin(angle)], rel=1e-9)
    assert measures.sliding[1] < 1e-3 * angle * 0.5
    open_from = min(0.5, 1e-4 / np.sin(angle))  # distance from the hinge to where the joint is 0.1 mm open
    assert measures.contact_area[1] == pytest.approx(open_from * 0.5, rel=1e-9)


def test_the_measures_do_not_change_when_everything_moves_together():
    assembly = Assembly.from_blocks(tower(2), 0.6)
    joints = find_joints(assembly)
    state = turned(assembly, 2, (0.0, 1.0, 0.0), 0.1, (0.25, 0.0, 0.25))
    before = measure_joints(joints, assembly, state)
    w, z = np.cos(0.4), np.sin(0.4)  # about z through the origin
    c, s = np.cos(0.8), np.sin(0.8)
    state.position = state.position @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + [3.0, -1.0, 2.0]
    a, b, p, q = state.orientation.T
    state.orientation = np.stack([w * a - z * q, w * b - z * p, w * p + z * b, w * q + z * a], axis=1)
    after = measure_joints(joints, assembly, state)
    for name in ("opening", "sliding", "rotation", "contact_area"):
        assert getattr(after, name) == pytest.approx(getattr(before, name), abs=1e-12)


def test_peaks_remember_the_worst_and_the_first_opening():
    assembly = Assembly.from_blocks([ground(), box("b", (0, 0, 0), (1, 1, 1))], 0.6)
    joints = find_joints(assembly)
    peaks = JointPeaks(joints)
    for time, lift in ((1.0, 0.0), (2.0, 5e-4), (3.0, 2e-3), (4.0, 0.0)):
        state = State.at_rest(assembly)
        state.position[1, 2] += lift
        peaks.update(measure_joints(joints, assembly, state), time)
    assert peaks.opening == pytest.approx([2e-3])
    assert peaks.first_opening_time.tolist() == [2.0]
    assert peaks.contact_area_loss == pytest.approx([1.0])
