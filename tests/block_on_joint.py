# SPDX-License-Identifier: GPL-3.0-or-later
"""A block on one elastic joint, whose swings have closed forms."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from models import GRAVITY, box, ground, stepper

from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.state import State

STIFFNESS, SIDES, HEIGHT = 1e8, (0.5, 0.3), 0.4  # normal [N/m3], of the block's base and its height [m]
AREA, MASS = 0.15, 2000.0 * 0.15 * 0.4
SAG = MASS * GRAVITY / (STIFFNESS * AREA)  # under its weight [m]


def block(height: float = HEIGHT, above: float = 0.0) -> list[Block]:
    """A block on the ground, or above it."""
    x, y = 0.5 * SIDES[0], 0.5 * SIDES[1]
    return [ground(2.0), box("b", (-x, -y, above), (x, y, above + height))]


def on_joint(
    dt: float, steps: int, joints: Mapping[str, JointLaw], kick: Mapping[int, float], above: float = -SAG, **settings: object
) -> Stepper:
    """A block in equilibrium on its joint, or above it, with velocities to begin with; ``settings`` are keys of the table [run]."""
    start = State.at_rest(Assembly.from_blocks(block(), 0.6))
    start.position[1, 2] += above
    for column, speed in kick.items():
        start.velocity[1, column] = speed
    return stepper(block(), steps, dt=dt, joints=joints, start=start, **settings)


def history(machine: Stepper, steps: int, column: int) -> np.ndarray:
    """Velocity of the block after each step."""
    out = np.empty(steps)
    for k in range(steps):
        machine.step()
        out[k] = machine.state.velocity[1, column]
    return out
