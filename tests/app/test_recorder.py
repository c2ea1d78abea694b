# SPDX-License-Identifier: GPL-3.0-or-later
"""Which support displacements are relative to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from models import box, gravity

from masonry_cd.app.recorder import staying_support
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block

STEPS = 100
BLOCKS = [
    box("stone", (0, 0, 0), (6, 1, 1)),
    box("sinks", (0, 0, -1), (1, 1, 0), fixed=True),
    box("stays", (2, 0, -1), (3, 1, 0), fixed=True),
    box("stays as well", (4, 0, -1), (5, 1, 0), fixed=True),
]


def support_where(velocity: np.ndarray, support_of: list[int], blocks: list[Block] = BLOCKS) -> int:
    assembly = replace(Assembly.from_blocks(blocks, 0.6), support_of=np.array(support_of))
    return staying_support(Stepper(assembly, velocity, gravity(STEPS), Run(dt=1e-3, duration=STEPS * 1e-3)), find_joints(assembly))


def test_it_is_the_first_of_those_that_the_loads_move_least():
    velocity = np.zeros((STEPS + 1, 2, 3))
    velocity[:, :, 0] = 0.1 * np.sin(np.linspace(0, 6, STEPS + 1))[:, None]  # all shake
    assert support_where(velocity, [-1, 0, 1, 1]) == 1
    velocity[20:40, 0, 2] = -0.2  # and one settles
    assert support_where(velocity, [-1, 0, 1, 1]) == 2


def test_one_that_goes_and_comes_back_has_not_stayed():
    velocity = np.zeros((STEPS + 1, 2, 3))
    velocity[:, 0, 0] = np.sin(2 * np.pi * np.linspace(0, 1, STEPS + 1))
    velocity[:, 1, 2] = -1e-3
    assert support_where(velocity, [-1, 0, 1, 1]) == 2


def test_a_ground_on_which_nothing_stands_is_none():
    """Both abutments sink alike, and the ground between them stays."""
    velocity = np.zeros((STEPS + 1, 2, 3))
    velocity[:, 0, 2] = -1e-3
    blocks = [*BLOCKS[:3], box("ground", (-1, -1, -2), (7, 2, -1.5), fixed=True)]
    assert support_where(velocity, [-1, 0, 0, 1], blocks) == 1
    assert support_where(velocity, [-1, 0, 1, 1], blocks) == 2
