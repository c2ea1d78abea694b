# SPDX-License-Identifier: GPL-3.0-or-later
"""The first elastic period along a motion, and what a rigid run leaves out by it."""

import numpy as np
import pytest
from models import box, tower, wall

from masonry_cd.analysis.modal.elastic_joints import joint_modes, period_along
from masonry_cd.analysis.modal.elastic_period import DAMPING, YOUNG, elastic_period
from masonry_cd.analysis.modal.left_out import left_out_lines
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_stiffness import joint_stiffness

E, G, DT = 2.4e9, 0.8e9, 1e-3


def parts(blocks):
    assembly = Assembly.from_blocks(blocks, 0.6)
    return assembly, find_joints(assembly)


def sine(period, cycles, direction):
    """Velocities (N + 1, 3) of a base whose acceleration is a sine of 1 m/s2 [m/s]."""
    time = np.arange(0.0, cycles * period, DT)
    return np.outer((1.0 - np.cos(2.0 * np.pi * time / period)) * period / (2.0 * np.pi), direction)


@pytest.mark.parametrize("blocks", [tower(8), wall(4, 6)], ids=["tower", "wall"])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_period_is_that_of_the_first_mode_along_the_axis(blocks, axis):
    assembly, joints = parts(blocks)
    stiffness = joint_stiffness(assembly, joints, np.full(assembly.count, E), np.full(assembly.count, G))
    modes = joint_modes(blocks, np.full(assembly.count, E), 0.5, 6 * len(blocks))
    first = np.flatnonzero(np.asarray(modes["participation"])[:, axis] > 0.3)[0]
    assert period_along(assembly, joints, stiffness, np.eye(3)[axis]) == pytest.approx(1.0 / modes["frequencies"][first], rel=0.02)


def test_a_block_without_a_joint_does_not_count():
    assembly, joints = parts([*tower(4), box("aloof", (5.0, 5.0, 5.0), (5.5, 5.5, 5.5))])
    stiffness = joint_stiffness(assembly, joints, np.full(assembly.count, E), np.full(assembly.count, G))
    alone, own = parts(tower(4))
    of_tower = joint_stiffness(alone, own, np.full(alone.count, E), np.full(alone.count, G))
    along = np.array([1.0, 0.0, 0.0])
    assert period_along(assembly, joints, stiffness, along) == pytest.approx(period_along(alone, own, of_tower, along))


def test_a_long_sine_at_the_period_is_amplified_by_half_the_inverse_of_the_damping():
    assembly, joints = parts(tower(20))
    at_rest = elastic_period(assembly, joints, sine(0.1, 3, [1.0, 0.0, 0.0]), DT, (E, G))
    cycles = 40
    found = elastic_period(assembly, joints, sine(at_rest.elastic_period, cycles, [1.0, 0.0, 0.0]), DT, (E, G))
    assert found.elastic_period == at_rest.elastic_period
    assert found.amplification == pytest.approx((1.0 - np.exp(-2.0 * np.pi * DAMPING * cycles)) / (2.0 * DAMPING), rel=0.02)


def test_of_two_directions_that_which_is_amplified_more_is_reported():
    assembly, joints = parts(wall(4, 6))
    across = elastic_period(assembly, joints, sine(1.0, 2, [0.0, 1.0, 0.0]), DT, None)
    assert across.elastic_basis.young == YOUNG and not across.elastic_basis.named
    period = across.elastic_period
    both = sine(period, 20, [0.0, 1.0, 0.0]) + 1.3 * sine(2.0 * period, 10, [1.0, 0.0, 0.0])
    found = elastic_period(assembly, joints, both, DT, None)
    assert abs(found.elastic_basis.direction[1]) > 0.99
    assert found.elastic_period == pytest.approx(period, rel=1e-3)
    along = elastic_period(assembly, joints, sine(1.0, 2, [1.0, 0.0, 0.0]), DT, None)
    assert along.elastic_period < 0.5 * period, "a wall is stiffer in its plane"


def test_the_line_says_on_what_it_rests():
    basis = {"young": 1.5e9, "named": False, "direction": [1.0, 0.0, 0.0]}
    (said,) = left_out_lines(Summary(elastic_period=0.234, amplification=2.61, elastic_basis=basis))
    assert said.startswith("left out by rigid joints: masonry of E = 1.5 GPa (assumed: the scene names none) sways")
    assert "period of about 0.23 s along x, at which the motion of the base is amplified 2.6 times (S_a at 5 % over PGA)" in said
    assert said.endswith('material.masonry = "..." includes it')
    assert left_out_lines(Summary()) == []
