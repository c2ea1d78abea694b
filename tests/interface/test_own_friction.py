# SPDX-License-Identifier: GPL-3.0-or-later
"""Own laws of friction: static and kinetic, by slip rate and by the direction of the joint, against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import masonry_cd as mc

G = 9.81
STATIC, KINETIC, RATE = 0.6, 0.3, 0.1  # coefficients, and the speed over which the one falls to the other [m/s]


def cube(steps: int, duration: float, **run: Any) -> dict[str, Any]:
    """A cube of 0.4 m and 128 kg on a wide support."""
    blocks = [mc.box((-4, -1, -0.4), (4, 1, 0)), mc.box((-0.2, -0.2, 0), (0.2, 0.2, 0.4))]
    return {
        "structure": {"blocks": blocks, "fixed": "b0"},
        "material": {"density": 2000.0, "friction": STATIC},
        "run": {"dt": duration / steps, "duration": duration, "until_still": False, **run},
    }


def weakening(contacts: Any) -> np.ndarray:
    """The coefficient falls from the static to the kinetic one as faces slide."""
    return KINETIC + (STATIC - KINETIC) * np.exp(-contacts.speed / RATE)


def speed_by_rate(steps: int) -> float:
    """The speed at 0.15 s of the cube thrown at 1 m/s [m/s]."""
    sim = mc.Simulation(cube(steps, 0.15), velocities={"b1": (1.0, 0.0, 0.0)}, friction=weakening)
    sim.run()
    return float(sim.state.velocity[1, 0])


def test_a_block_thrown_is_braked_by_the_law_of_its_slip_rate() -> None:
    """dv/dt = -g mu(v), to first order in the step."""
    v, h = 1.0, 1e-5
    for _ in range(15000):  # midpoint rule
        half = v - 0.5 * h * G * (KINETIC + (STATIC - KINETIC) * math.exp(-v / RATE))
        v -= h * G * (KINETIC + (STATIC - KINETIC) * math.exp(-half / RATE))
    coarse, fine = (abs(speed_by_rate(steps) - v) for steps in (150, 300))
    assert fine < 1e-4 and coarse / fine == pytest.approx(2.0, rel=0.2)


@pytest.mark.parametrize("planar", [True, False])
def test_a_block_that_is_pulled_harder_and_harder_sticks_to_the_static_and_slides_by_the_kinetic_coefficient(planar: bool) -> None:
    mass, rate, duration = 128.0, 2000.0, 0.6  # force over time [N/s]
    start = STATIC * mass * G / rate

    def law(contacts: Any) -> np.ndarray:
        return np.where(contacts.speed > 1e-6, KINETIC, STATIC)

    def pull(time: float) -> tuple[float, float, float]:
        return rate * time, 0.0, 0.0

    sim = mc.Simulation(cube(1200, duration, planar=planar), forces={"b1": pull}, friction=law)
    sim.run(until=start - 2e-3)
    assert abs(sim.state.velocity[1, 0]) < 1e-9
    sim.run()
    slid = 0.5 * rate * (duration**2 - start**2) / mass - KINETIC * G * (duration - start)
    assert sim.state.velocity[1, 0] == pytest.approx(slid, rel=5e-3)


def test_bed_and_head_joints_have_coefficients_of_their_own() -> None:
    """A cube between two cheeks that press it is pulled up: the head joints alone hold it."""
    press, head = 4000.0, 0.5
    blocks = [
        mc.box((-1, -1, -0.4), (1, 1, 0)),
        mc.box((-0.2, -0.2, 0), (0.2, 0.2, 0.4)),
        mc.box((-0.6, -0.2, 0), (-0.2, 0.2, 0.4)),
        mc.box((0.2, -0.2, 0), (0.6, 0.2, 0.4)),
    ]
    scene = {
        "structure": {"blocks": blocks, "fixed": "b0"},
        "material": {"density": 2000.0, "friction": 0.1},
        "run": {"dt": 1e-3, "duration": 0.1, "until_still": False},
    }

    def law(contacts: Any) -> np.ndarray:
        return np.where(np.abs(contacts.normal[:, 2]) > 0.5, 0.0, head)

    def lifted_by(share: float) -> float:
        up = share * (2.0 * head * press + 128.0 * G)
        down = 1e5  # so that the cheeks do not go with the cube
        forces = {"b1": lambda time: (0.0, 0.0, up), "b2": lambda time: (press, 0.0, -down), "b3": lambda time: (-press, 0.0, -down)}
        sim = mc.Simulation(scene, forces=forces, friction=law)
        sim.run()
        return float(sim.state.position[1, 2] - 0.2)

    assert abs(lifted_by(0.98)) < 1e-6 and lifted_by(1.05) > 1e-3


def test_the_coefficients_of_the_scene_given_back_are_the_scene_and_contacts_bear_the_weight() -> None:
    seen = []

    def law(contacts: Any) -> np.ndarray:
        seen.append(contacts)
        return contacts.friction

    own, plain = mc.Simulation(cube(20, 0.02), friction=law), mc.Simulation(cube(20, 0.02))
    own.run()
    plain.run()
    assert (own.state.position == plain.state.position).all() and (own.state.velocity == plain.state.velocity).all()
    last = seen[-1]
    assert last.force.sum() == pytest.approx(128.0 * G, rel=1e-6) and np.allclose(np.abs(last.normal[:, 2]), 1.0)
    assert last.time == pytest.approx(0.019) and last.step == pytest.approx(1e-3)


@pytest.mark.parametrize("given", [[0.5], -1.0, math.nan])
def test_other_than_a_coefficient_for_each_contact_is_refused(given: Any) -> None:
    sim = mc.Simulation(cube(20, 0.02), friction=lambda contacts: np.full(len(contacts.friction), given) if np.isscalar(given) else given)
    with pytest.raises(mc.InputError) as refused:
        sim.step()
    assert refused.value.place == "friction"


def test_joints_with_cohesion_are_refused() -> None:
    scene = cube(20, 0.02)
    scene["material"]["joints"] = {"cohesion": 1e5, "normal_stiffness": 1e10, "tangential_stiffness": 1e10}
    with pytest.raises(mc.InputError) as refused:
        mc.Simulation(scene, friction=weakening)
    assert refused.value.place == "friction"
