# SPDX-License-Identifier: GPL-3.0-or-later
"""Which stiffness contacts and joints have: of their law, of the masonry as built, or, where blocks meet again, of two cubes."""

import numpy as np
import pytest
from models import tower

from masonry_cd.mechanics.contact.find_joints import find_joints, joint_parts
from masonry_cd.mechanics.dynamics.pair_stiffness import PairStiffness, most_stretched, softest_spring, stiffness_of_joints
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material

E, G = 3e9, 1e9
SIDE, HEIGHT = 0.5, 0.25


def assembly(joints=None, material=None):
    """Two blocks on the ground."""
    keys = {} if material is None else material.model_dump(exclude_unset=True)
    masonry = {"kind": "squared stone", "E": E, "G": G}
    return Assembly.from_blocks(tower(2, SIDE, HEIGHT), Material(friction=0.6, joints=joints or {}, masonry=masonry, **keys))


def test_joints_as_built_and_blocks_that_meet_anew():
    made = assembly()
    pairs = PairStiffness.of(made)
    lower, upper = (joint_parts(made)[joint] for joint in np.argsort(find_joints(made).centres()[:, 2]))
    found = pairs.of_contacts(np.array([lower, upper]), made.shapes.part_block[[lower, upper]])
    assert found == pytest.approx(np.array([[E, G], [E, G]]) / np.array([[0.5 * HEIGHT], [HEIGHT]]))
    ground, top = 0, 2  # which do not touch as built
    anew = pairs.of_contacts(np.array([[ground, top]]), np.array([[ground, top]]))
    assert anew == pytest.approx(np.array([[E, G]]) / (0.5 * np.cbrt(SIDE * SIDE * HEIGHT)))
    assert softest_spring(made.laws, pairs) == pytest.approx(E / HEIGHT)


def test_a_law_of_its_own_wins():
    made = assembly({"block-base": JointLaw(normal_stiffness=5e9, tangential_stiffness=2e9, cohesion=1e5)})
    normal, tangential = stiffness_of_joints(made, find_joints(made))
    assert sorted(normal) == pytest.approx([5e9, E / HEIGHT])
    assert sorted(tangential) == pytest.approx([2e9, G / HEIGHT])
    assert most_stretched(made.laws, PairStiffness.of(made)) == pytest.approx(1e5 / 0.6 / 5e9)


def test_joints_do_not_deform_for_blocks_that_deform_themselves():
    made = assembly(material=ElasticBlocks.model_validate({"deformable": "uniform", "young": 1e9}))
    assert not np.any(stiffness_of_joints(made, find_joints(made)))
    assert not PairStiffness.of(made).of_contacts(np.array([[0, 1]]), np.array([[0, 1]])).any()


def test_without_masonry_there_is_none():
    assert PairStiffness.of(Assembly.from_blocks(tower(2), 0.6)) is None
