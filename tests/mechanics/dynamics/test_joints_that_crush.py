# SPDX-License-Identifier: GPL-3.0-or-later
"""Joints that crush: the moment of a wall that rocks under its load in closed form, energy over cycles, what a crushed joint remembers."""

import numpy as np
import pytest
from models import GRAVITY, advance, box, gravity, ground, stepper

from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.state import rotation_matrices

DEPTH, WIDTH, HEIGHT, STIFFNESS = 0.5, 1.0, 0.5, 1e9  # [m], [N/m3]
WEIGHT = 2000.0 * DEPTH * WIDTH * HEIGHT * GRAVITY  # [N]


def pushed(load: float, share: float, history: list[float], steps: int, planar: bool = True, damping: float = 0.5) -> Stepper:
    """A block on its bed, whose weight is a share ``load`` of what crushes the bed all over.

    Its centre is pushed by a ``share`` of what the closed form of the moment, N b/2 (1 - N/(f b t)), bears, times a history.
    """
    strength = WEIGHT / (load * DEPTH * WIDTH)
    pull, time = gravity(steps), np.linspace(0.0, 1.0, steps + 1)
    pull[:, 0] = share * GRAVITY * DEPTH / HEIGHT * (1.0 - load) * np.interp(time, np.linspace(0.0, 1.0, len(history)), history)
    law = {"default": JointLaw(normal_stiffness=STIFFNESS, compressive_strength=strength, damping=damping, damping_frequency=20.0)}
    blocks = [ground(), box("b", (-DEPTH / 2, -WIDTH / 2, 0.0), (DEPTH / 2, WIDTH / 2, HEIGHT))]
    out = stepper(blocks, steps, dt=2e-3, friction=2.0, joints=law, acceleration=pull, planar=planar, solver="auto", tolerance=1e-8)
    settle(out)
    return out


def turn(machine: Stepper) -> float:
    """How far the block has turned [rad]."""
    return float(2.0 * np.arctan2(machine.state.orientation[1, 2], machine.state.orientation[1, 0]))


@pytest.mark.parametrize("load", [0.05, 0.2, 0.5])
def test_a_rocking_wall_bears_the_moment_of_the_closed_form(load):
    turned = []
    for share in (0.97, 1.02):
        machine = pushed(load, share, [0.0, 1.0, 1.0, 1.0], 600)
        advance(machine, 600)
        turned.append(abs(turn(machine)))
    assert turned[0] < 2e-2 < 0.1 < turned[1]


def test_pressure_ends_at_the_strength_and_energy_is_booked_over_cycles():
    load, steps = 0.3, 800
    machine, crushed, most = pushed(load, 0.9, [0.0, 1.0, -1.0, 1.0, 0.0], steps), [0.0], 0.0
    for _ in range(steps):
        machine.step()
        crushed.append(machine.energy["crushing"])
        made, p = machine.last, machine.solution.impulse[:, 0]
        most = max(most, float((p / (2e-3 * made.springs.area)).max()) * load * DEPTH * WIDTH / WEIGHT)
    assert 0.99 < most < 1.005
    assert np.diff(crushed).min() >= 0.0
    assert crushed[-1] > 1e-3
    assert abs(machine.energy["balance"]) < 1e-9 * WEIGHT * HEIGHT
    assert machine.energy["damping"] > 0.0
    assert np.count_nonzero(machine.detector.snapshot()["crushed"] > 0.0) >= 2  # at either edge


def test_a_joint_in_space_crushes_as_in_its_plane_and_resumes_to_the_same_bits():
    history, steps = [0.0, 0.9, 0.9, 0.0], 300
    plane, first, second = (pushed(0.3, 1.0, history, steps, planar) for planar in (True, False, False))
    for _ in range(150):
        plane.step()
        first.step()
    second.restore({name: array.copy() for name, array in first.snapshot().items()})
    for machine in (plane, first, second):
        advance(machine, 150)
    assert first.energy == second.energy
    assert first.state.position.tobytes() == second.state.position.tobytes()
    assert first.energy["crushing"] == pytest.approx(plane.energy["crushing"], rel=1e-2)
    assert first.energy["crushing"] > 0.0


def test_what_was_crushed_stays_so_when_the_joint_comes_off_and_closes_again():
    machine = pushed(0.3, 0.9, [0.0, 1.0, 0.0], 200)
    advance(machine, 200)
    detector, state, still = machine.detector, machine.state, np.zeros((2, 6))
    before = detector.most_crushed()[0]
    for lift in (0.0, 0.01, 0.01, 0.0):
        raised = state.copy()
        raised.position[1, 2] += lift
        found = detector.detect(raised.position, rotation_matrices(raised.orientation), still, 2e-3, 0.0, np.zeros(3))
        assert (len(found.gap) > 0) == (lift == 0.0)
    assert before > 1e-6
    assert detector.most_crushed()[0] == before
