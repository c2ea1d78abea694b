# SPDX-License-Identifier: GPL-3.0-or-later
"""Ties while a structure settles: they pull with their first tension, and the run begins with it."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
from models import GRAVITY, gravity, material_of, still, tower

from loads.bars import Forces, PointLoad, Tie
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material

STEPS, STIFFNESS, TENSION = 40, 1e8, 2e4  # N/m3 of a joint, N
AREA, WEIGHT = 0.25, 2000.0 * 0.25 * 0.25 * GRAVITY  # of a block of a tower


def tied(tension: float, stiffness: float = STIFFNESS, young: float | None = None, from_start: bool = False) -> Stepper:
    """Two blocks on elastic joints, held down from the ground through their middle; a point load comes with the run."""
    joints = {"default": JointLaw(normal_stiffness=stiffness, tangential_stiffness=stiffness)}
    material = None if young is None else ElasticBlocks.model_validate({"deformable": "uniform", "young": young, "poisson": 0.0})
    assembly = Assembly.from_blocks(tower(2), material_of(0.6, joints, material))
    ends = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.5]]) - assembly.centre[[0, 2]]
    tie = Tie((0, 2), ends, 0.5, 1e-4, 4e7, tension, 0.0, from_start=from_start)
    late = PointLoad(2, np.zeros(3), np.array([0.0, 0.0, -1e4]), np.r_[np.zeros(2), np.ones(STEPS - 1)])
    run = Run.model_validate({"dt": 1e-3, "duration": 1e3, "solver": "auto", "tolerance": 1e-12})
    return Stepper(assembly, still(STEPS), gravity(STEPS), run, forces=Forces((late,), (tie,)))


@pytest.mark.parametrize("tension", [0.0, TENSION])
def test_joints_close_by_weight_and_tension_over_their_stiffness(tension: float) -> None:
    machine = tied(tension)
    assert settle(machine) > 0
    sunk = machine.assembly.centre[:, 2] - machine.state.position[:, 2]
    lower, upper = (2.0 * WEIGHT + tension) / (STIFFNESS * AREA), (WEIGHT + tension) / (STIFFNESS * AREA)
    np.testing.assert_allclose(sunk[1:], [lower, lower + upper], rtol=2e-5)


def test_blocks_that_deform_shorten_by_the_stress_of_both() -> None:
    machine = tied(TENSION, 1e12, 1e9)
    settle(machine)
    stress = (WEIGHT * np.array([1.5, 0.5]) + TENSION) / AREA
    np.testing.assert_allclose(machine.state.strain[1:, 2], -stress / 1e9, rtol=2e-4)


def test_the_run_begins_at_rest_with_the_first_tension() -> None:
    machine = tied(TENSION)
    settle(machine)
    at_rest = machine.state.position.copy()
    machine.step()
    assert machine.tensions == pytest.approx([TENSION], rel=1e-9)
    assert np.abs(machine.state.position - at_rest).max() < 1e-9
    other = tied(TENSION)
    other.restore(deepcopy(machine.snapshot()))
    for _ in range(STEPS - 1):  # with the load: the tie is as stiff as ever, and slackens
        machine.step()
        other.step()
    assert np.array_equal(machine.state.position, other.state.position)
    top = machine.state.position[2, 2] - at_rest[2, 2]
    assert machine.tensions == pytest.approx([TENSION + 4e7 * top], rel=0.05)
    assert top < -1e-4


def test_a_tie_that_is_there_from_the_start_shortens_with_the_joints() -> None:
    """Its tension is N = N_0 - k s of the sinking s = (3 W + 2 N) / K of the top."""
    machine = tied(TENSION, from_start=True)
    settle(machine)
    joint = STIFFNESS * AREA
    expected = (TENSION - 4e7 * 3.0 * WEIGHT / joint) / (1.0 + 4e7 * 2.0 / joint)
    sunk = machine.assembly.centre[2, 2] - machine.state.position[2, 2]
    assert sunk == pytest.approx((3.0 * WEIGHT + 2.0 * expected) / joint, rel=1e-4)
    at_rest = machine.state.position.copy()
    machine.step()
    assert machine.tensions == pytest.approx([expected], rel=1e-4)
    assert np.abs(machine.state.position - at_rest).max() < 1e-7


def test_what_stands_by_its_tie_alone_settles_with_it() -> None:
    """A block without friction under a pull to the side, on a tie that has no tension before."""
    assembly = Assembly.from_blocks(tower(1), Material(friction=0.0, joints={"default": JointLaw(normal_stiffness=STIFFNESS)}))
    ends = np.array([[-3.0, 0.0, 0.125], [0.0, 0.0, 0.125]]) - assembly.centre
    side = 0.3 * GRAVITY
    run = Run.model_validate({"dt": 1e-3, "duration": 1e3, "solver": "auto", "tolerance": 1e-12})
    forces = Forces((), (Tie((0, 1), ends, 3.0, 1e-4, 1e7, 0.0, 0.0, from_start=True),))
    machine = Stepper(assembly, still(STEPS), gravity(STEPS, (side, 0.0, -GRAVITY)), run, forces=forces)
    settle(machine)
    pull = float(assembly.mass[1]) * side
    assert machine.state.position[1, 0] - assembly.centre[1, 0] == pytest.approx(pull / 1e7, rel=1e-3)
    machine.step()
    assert machine.tensions == pytest.approx([pull], rel=1e-3)
