# SPDX-License-Identifier: GPL-3.0-or-later
"""Dashpots of elastic joints: closed forms of a block on one joint, the energy that they take, and what they leave alone."""

from __future__ import annotations

import numpy as np
import pytest
from block_on_joint import AREA, MASS, STIFFNESS, history, on_joint
from models import GRAVITY, advance, gravity, stepper, tower

from masonry_cd.mechanics.model.joint_laws import JointLaw

TANGENTIAL = 4e7  # [N/m3]
OMEGA = np.sqrt(STIFFNESS * AREA / MASS)  # of the swing up and down [rad/s]
ON = {"solver": "auto", "duration": 10.0}  # keys of [run]


def law(share: float, omega: float) -> dict[str, JointLaw]:
    """An elastic joint with a dashpot that is a share of critical at a circular frequency."""
    damped = {"damping": share, "damping_frequency": omega / (2.0 * np.pi)} if share else {}
    return {"default": JointLaw(normal_stiffness=STIFFNESS, tangential_stiffness=TANGENTIAL, theta=0.5, **damped)}


def swing(time: np.ndarray, speed: float, share: float, omega: float) -> np.ndarray:
    """Velocity of a damped swing that begins with a speed in its middle."""
    rate, damped = share * omega, omega * np.sqrt(1.0 - share**2)
    return speed * np.exp(-rate * time) * (np.cos(damped * time) - rate / damped * np.sin(damped * time))


def spin() -> float:
    """Circular frequency of the turning about the vertical axis, on the tangential springs [rad/s]."""
    return float(np.sqrt(TANGENTIAL * AREA / MASS))  # second moment of the area over that of the mass: both go by a^2 + b^2


@pytest.mark.parametrize(("column", "omega"), [(2, OMEGA), (5, spin())])
@pytest.mark.parametrize("share", [0.05, 0.5])
def test_a_swing_fades_as_its_share_of_critical_says_to_second_order(column, omega, share):
    errors = []
    for dt in (1e-3, 5e-4, 2.5e-4):
        steps = round(0.04 / dt)
        got = history(on_joint(dt, steps, law(share, omega), {column: 1e-3}, **ON), steps, column)
        exact = swing(dt * np.arange(1, steps + 1), 1e-3, share, omega)
        errors.append(float(np.abs(got - exact).max()) / 1e-3)
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2.0, 2.0], abs=0.25)
    assert errors[-1] < 0.01


def test_the_dashpot_takes_all_of_a_swing_and_the_balance_closes():
    """The residual of the solver, 1e-12 of g h times the weight's impulse in each of 400 steps, is a fifth of the bound on the balance."""
    machine = on_joint(5e-4, 400, law(0.2, OMEGA), {2: 1e-2}, tolerance=1e-12, **ON)
    history(machine, 400, 2)
    kick = 0.5 * MASS * 1e-4
    assert machine.energy["damping"] == pytest.approx(kick, rel=1e-6)
    assert abs(machine.energy["balance"]) < 1e-9 * kick


def rebound(share: float) -> float:
    """Share of its speed that a body keeps on landing on spring and dashpot (Schwager & Poeschel, Granular Matter 9, 2007)."""
    free = share / np.sqrt(1.0 - share**2)
    return float(np.exp(-free * (np.pi - np.arctan2(2.0 * share * np.sqrt(1.0 - share**2), 1.0 - 2.0 * share**2))))


@pytest.mark.parametrize("share", [0.05, 0.2])
def test_a_block_that_lands_comes_back_as_spring_and_dashpot_let_it(share):
    dt, speed = 2e-5, 5.0
    machine = on_joint(dt, 1000, law(share, OMEGA), {2: -speed}, above=1e-5, **ON)
    velocity = history(machine, 1000, 2)
    assert velocity[500:].max() == pytest.approx(speed * rebound(share), rel=0.02)
    assert abs(machine.energy["balance"]) < 1e-9 * 0.5 * MASS * speed**2


def test_friction_bounds_spring_and_dashpot_together():
    """A block that slides comes to rest as Coulomb's law has it: the joint holds v^2 / (2 mu g) against it, whatever its dashpot."""
    speed, mu = 0.5, 0.6
    machine = on_joint(1e-3, 300, law(1.0, OMEGA), {0: speed}, **ON)
    history(machine, 300, 0)
    slid = speed**2 / (2.0 * mu * GRAVITY)
    assert machine.state.position[1, 0] == pytest.approx(slid, rel=0.03)
    assert machine.energy["friction"] == pytest.approx(0.5 * MASS * speed**2, rel=0.03)
    assert abs(machine.energy["balance"]) < 1e-9 * 0.5 * MASS * speed**2


def test_what_rests_rests_and_stiffness_limits_no_step():
    """Dashpots carry nothing at rest: a tower settled on joints of any stiffness and damping stays where it is."""
    from masonry_cd.mechanics.dynamics.equilibrium import settle

    for stiffness in (1e8, 1e14):
        joints = {"default": JointLaw(normal_stiffness=stiffness, damping=0.1, damping_frequency=5.0)}
        machine = stepper(tower(6), 200, dt=1e-2, joints=joints, solver="auto", acceleration=gravity(200))
        settle(machine)
        before = machine.state.position.copy()
        advance(machine, 200)
        assert np.abs(machine.state.position - before).max() < 1e-9


def test_a_dashpot_of_no_share_changes_no_bit():
    one, other = (on_joint(1e-3, 50, joints, {2: 1e-3, 0: 0.01}, **ON) for joints in (law(0.0, OMEGA), law(1e-300, OMEGA)))
    assert np.array_equal(history(one, 50, 2), history(other, 50, 2))
