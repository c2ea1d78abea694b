# SPDX-License-Identifier: GPL-3.0-or-later
"""Walls on elastic joints under a mass that rocks about their corner, too heavy for the stones there, which must not be shot out."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from models import box, ground, stepper, still

from masonry_cd.app.run_report import RunReport
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.joint_laws import JointLaw

SIDE, UNIT, COURSE, COURSES, TOP = 1.2, 0.3, 0.15, 3, 4.0  # [m]; stones are as wide as long
STEP, STEPS = 5e-3, 240
LONG_WALL, SHORT_WALL = np.linspace(0.0, SIDE, 5), np.array([UNIT, 1.5 * UNIT, 2.5 * UNIT, SIDE - UNIT])  # where stones end


def laden_ring() -> list[Block]:
    """A square ring of courses, whose corners belong to the walls along x and along y in turn, and a block of 460 t on them."""
    blocks = [ground(20.0)]
    for course in range(COURSES):
        along_x, along_y = (LONG_WALL, SHORT_WALL) if course % 2 == 0 else (SHORT_WALL, LONG_WALL)
        for side in (0.0, SIDE - UNIT):
            for low, high in pairwise(along_x):
                blocks.append(stone(course, (low, side), (high, side + UNIT)))
            for low, high in pairwise(along_y):
                blocks.append(stone(course, (side, low), (side + UNIT, high)))
    top = COURSES * COURSE
    return [*blocks, replace(box("top", (0.0, 0.0, top), (SIDE, SIDE, top + TOP)), density=8e4)]


def stone(course: int, low: tuple[float, float], high: tuple[float, float]) -> Block:
    """A stone between two corners (2,) seen from above."""
    return box(f"{course}: {low}", (*low, course * COURSE), (*high, (course + 1) * COURSE))


def rocking() -> Stepper:
    """The ring on elastic joints, settled, on a ground that shakes along both axes."""
    time, velocity = STEP * np.arange(STEPS + 1), still(STEPS)
    velocity[:, 0, 0] = 1.2 * np.sin(2.0 * np.pi * 0.8 * time)
    velocity[:, 0, 1] = 0.96 * np.sin(2.0 * np.pi * 0.7 * time)
    law = {"default": JointLaw(normal_stiffness=1e10)}
    out = stepper(laden_ring(), STEPS, dt=STEP, joints=law, tolerance=1e-4, solver="auto", support_velocity=velocity)
    settle(out)
    return out


def test_a_run_names_the_joint_that_is_shortened_most():
    report, moving = RunReport(), rocking()
    for _ in range(60):
        step = moving.step()
        report.look(step, moving)
        report.add(step, 1e-4, moving.energy)
    share = 100.0 * report.shortening_max / moving.width
    assert 1.0 < share < 10.0
    assert report.shortening_where.startswith(f"{share:.2g} % of the smallest width, between ")
    assert report.penetration_where == ""


def test_stones_at_the_toe_of_what_rocks_gain_no_energy():
    """The load on the last corner takes the stones there some centimetres into each other, at an angle.

    When the normals between them changed from step to step, and springs were born with the overlap that they found, 0.2 MJ came from
    nowhere in a single step, half as much as the base had put in, and stones were shot out.
    """
    moving, lost, fastest, squeezed = rocking(), [], 0.0, 0.0
    for _ in range(STEPS):
        shortening = moving.step().shortening
        velocity = moving.state.velocity[1:, :3] - moving.state.velocity[0, :3]
        fastest = max(fastest, np.linalg.norm(velocity, axis=1).max())
        lost.append(sum(moving.energy[name] for name in ("friction", "impact", "damping")))
        squeezed = max(squeezed, shortening.depth)
    assert squeezed > 0.015
    assert np.diff(lost).min() > -1e-3 * moving.energy["base_work"]
    assert moving.energy["damping"] > 0.0
    assert abs(moving.energy["balance"]) < 1e-4 * moving.energy["base_work"]
    assert fastest < 4.0
