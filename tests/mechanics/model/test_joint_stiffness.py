# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffness of joints by the masonry around them, against what straight and running bond ask for."""

from dataclasses import replace

import numpy as np
import pytest
from models import box, wall

from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_stiffness import joint_stiffness

E, G = 2.4e9, 0.8e9


def stiffness(blocks):
    """The joints of blocks, their middles (J, 3), and both stiffnesses (J,)."""
    assembly = Assembly.from_blocks(blocks, 0.6)
    joints = find_joints(assembly)
    young, shear = np.full(assembly.count, E), np.full(assembly.count, G)
    return joints, *joint_stiffness(assembly, joints, young, shear)


def test_in_a_column_the_moduli_over_the_length_and_supports_count_nothing():
    blocks = [box("base", (-1, -1, -1), (1, 1, 0), fixed=True)]
    blocks += [box(f"b{k}", (-0.3, -0.2, 0.5 * k), (0.3, 0.2, 0.5 * (k + 1))) for k in range(4)]
    joints, normal, tangential = stiffness(blocks)
    length = np.where(joints.centres()[:, 2] == 0.0, 0.25, 0.5)
    assert normal == pytest.approx(E / length)
    assert tangential == pytest.approx(G / length)


@pytest.mark.parametrize(("length", "height"), [(1.0, 0.5), (0.5, 0.5), (0.75, 0.25)])
@pytest.mark.parametrize("running", [False, True])
def test_a_bond_shears_as_the_continuum(length, height, running):
    """1 / P + 1 / Q = 1 / G, with what holds blocks against turning beside the head joints in running bond."""
    joints, normal, tangential = stiffness(wall(6, 6, length, height, 0.4, running))
    middle = joints.centres()
    inside = (np.abs(middle[:, 0] - 3.0 * length) < 1.6 * length) & (middle[:, 2] > 1.6 * height) & (middle[:, 2] < 4.4 * height)
    bed = inside & (np.abs(joints.normal[:, 2]) > 0.9)
    assert bed.sum() >= 6
    assert normal[bed] == pytest.approx(E / height)
    factor = tangential[bed] * height / G
    beside = E * length**2 / (4.0 * height**2) / G if running else 0.0
    assert 1.0 / factor + 1.0 / (factor + beside) == pytest.approx(1.0)


def test_the_stiffness_turns_with_the_wall():
    turn = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    blocks = wall(4, 4)
    turned = [replace(block, vertices=block.vertices @ turn.T) for block in blocks]
    here, there = stiffness(blocks), stiffness(turned)
    order = [np.lexsort(np.round(middle, 6).T) for middle in (here[0].centres() @ turn.T, there[0].centres())]
    for a, b in zip(here[1:], there[1:], strict=True):
        assert a[order[0]] == pytest.approx(b[order[1]])
