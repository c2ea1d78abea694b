# SPDX-License-Identifier: GPL-3.0-or-later
"""Bonds that soften: curves and energies in closed form, order in the time step, unloading, a beam that is peeled off, equal bits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from models import GRAVITY, advance, box, gravity, ground, material_of, stepper

import loads
from masonry_cd.foundation.arrays import Stored
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.state import rotation_matrices

K_N, K_T, TENSION, COHESION, G_1, G_2, MU = 1e10, 4e9, 1e5, 1.5e5, 20.0, 60.0, 0.6
LAW = {"normal_stiffness": K_N, "tangential_stiffness": K_T, "cohesion": COHESION, "tension": TENSION}
HEAVY = 1e12  # of the block, 0.1 m high, which so stays where it is while its base is led away [kg/m3]
BREAKS = {"linear": 4e-4, "exponential": 1.9e-3}  # opening at which no tension is left, or a ten-thousandth [m]


def led(
    path: Sequence[Sequence[float]], seconds: float, dt: float, softening: str = "linear", pressure: float = 0.0, theta: float = 0.6
) -> Stepper:
    """A heavy block on a joint of 1 m2, whose base goes from point to point of a path [m] in equal times, smoothly.

    ``pressure`` [Pa] is on the joint from the beginning.
    """
    steps, points = round(seconds / dt), np.vstack([np.zeros(3), path]).astype(float)
    x = np.linspace(0.0, len(path), steps + 1)
    leg = np.minimum(x.astype(int), len(path) - 1)
    y = x - leg
    place = points[leg] + (y * y * (3.0 - 2.0 * y))[:, None] * (points[leg + 1] - points[leg])
    velocity = np.zeros((steps + 1, 3))
    for k in range(steps):
        velocity[k + 1] = 2.0 * (place[k + 1] - place[k]) / dt - velocity[k]
    blocks = [ground(2.0), box("b", (-0.5, -0.5, 0.0), (0.5, 0.5, 0.1), density=HEAVY)]
    law = {"default": JointLaw(**LAW, fracture_energy=G_1, shear_fracture_energy=G_2, softening=softening, theta=theta)}
    pull = gravity(steps, (0.0, 0.0, -pressure / (0.1 * HEAVY)))
    start = Assembly.from_blocks(blocks, MU)
    state = replace(stepper(blocks, 1).state, position=start.centre - [[0.0, 0.0, 0.0], [0.0, 0.0, pressure / K_N]])
    return stepper(
        blocks, steps, dt=dt, duration=1.0, friction=MU, joints=law, start=state, acceleration=pull,
        support_velocity=velocity[:, None, :], tolerance=1e-12, planar=False,
    )  # fmt: skip


def step_in_tension(machine: Stepper) -> tuple[float, float]:
    """Make a step: the opening at the place of the midpoint rule of a spring with theta 0.6, and the tension [m, N]."""
    before = between(machine)
    machine.step()
    return 0.4 * before + 0.6 * between(machine), -machine.solution.impulse[:, 0].sum() / machine.settings.dt


def between(machine: Stepper) -> float:
    """The opening between two q_m, by which the spring goes: a tenth of a step after the end of the last [m]."""
    state = machine.state
    return float(np.diff(state.position[:, 2] + 0.1 * machine.settings.dt * state.velocity[:, 2])[0]) - 0.3


def traction(opening: np.ndarray, softening: str) -> np.ndarray:
    """Tension of the law over an opening that grows [Pa]."""
    first = TENSION / K_N
    if softening == "linear":
        return np.clip(TENSION * (2.0 * G_1 / TENSION - opening) / (2.0 * G_1 / TENSION - first), 0.0, K_N * opening)
    return np.minimum(K_N * opening, TENSION * np.exp(-np.maximum(0.0, opening - first) * TENSION / (G_1 - 0.5 * TENSION * first)))


@pytest.mark.parametrize("softening", ["linear", "exponential"])
def test_two_blocks_pulled_apart_follow_the_curve_and_take_its_energy(softening: str) -> None:
    machine = led([(0.0, 0.0, -1.05 * BREAKS[softening])], 0.25, 1e-3, softening)
    opening, force = np.array([step_in_tension(machine) for _ in range(250)]).T
    assert np.abs(force - traction(opening, softening)).max() < 0.03 * TENSION
    energy = machine.energy
    assert energy["bond"] == pytest.approx(G_1, rel=1e-3)
    assert energy["base_work"] == pytest.approx(G_1, rel=5e-3)
    assert abs(energy["balance"]) < 1e-9 * G_1


def test_the_work_of_a_pull_converges_with_the_step_by_more_than_the_first_order() -> None:
    errors = []
    for steps in (30, 120):
        machine = led([(0.0, 0.0, -4.5e-4)], 0.12, 0.12 / steps, theta=0.5)
        advance(machine, steps)
        errors.append(abs(machine.energy["base_work"] - G_1))
        assert machine.energy["bond"] == pytest.approx(G_1, rel=1e-9)  # however long the step
    assert errors[1] < errors[0] / 4.0**1.2
    assert errors[0] < 0.01 * G_1


def test_sheared_under_pressure_the_bond_takes_its_energy_and_friction_the_rest() -> None:
    way, pressure = 9e-4, 1e5
    machine = led([(-way, 0.0, 0.0)], 0.2, 1e-3, pressure=pressure)
    most = 0.0
    for _ in range(200):
        machine.step()
        most = max(most, abs(machine.solution.impulse[:, 1].sum()) / 1e-3)
    slid = way - MU * pressure / K_T  # what friction bears elastically comes first
    assert most == pytest.approx(COHESION + MU * pressure, rel=0.02)
    assert machine.energy["bond"] == pytest.approx(G_2, rel=1e-3)
    assert machine.energy["friction"] == pytest.approx(MU * pressure * slid, rel=3e-3)
    assert machine.energy["elastic"] == pytest.approx(0.5 * (MU * pressure) ** 2 / K_T + 0.5 * pressure**2 / K_N, rel=1e-3)


@pytest.mark.parametrize("along", [0.5, 2.0])
def test_a_mixed_opening_takes_the_energy_of_the_power_law(along: float) -> None:
    way = 1.5e-3
    machine = led([(-along * way, 0.0, -way)], 0.25, 1e-3)
    advance(machine, 250)
    shear = K_T * along**2 / (K_N + K_T * along**2)
    assert machine.energy["bond"] == pytest.approx(1.0 / ((1.0 - shear) / G_1 + shear / G_2), rel=1e-3)


def test_a_bond_unloads_to_the_origin_and_is_pressed_with_its_whole_stiffness() -> None:
    machine = led([(0.0, 0.0, -2e-4), (0.0, 0.0, 1e-5)], 0.4, 1e-3)
    advance(machine, 202)
    damage = float(machine.motion.bonds.damage[machine.last.bonds.held].min())
    bonded = traction(np.array([2e-4]), "linear")[0] / (K_N * 2e-4)
    assert 1.0 - damage == pytest.approx(bonded, rel=1e-3)
    taken = machine.energy["bond"]
    for _ in range(198):
        opening, force = step_in_tension(machine)
        stiffness = (1.0 - damage) * K_N if opening > 0.0 else K_N
        if abs(opening) > 2e-6:  # not while it closes
            assert force == pytest.approx(stiffness * opening, rel=1e-4, abs=2.0)
    assert opening == pytest.approx(-1e-5, rel=1e-2)
    assert machine.energy["bond"] == taken


def test_a_run_resumes_in_the_middle_of_softening_with_the_same_bits_and_refuses_bonds_that_no_run_leaves() -> None:
    path = [(-1e-4, 2e-5, -1e-4), (1e-4, 0.0, -1.5e-4)]
    first, second = (led(path, 0.2, 1e-3, "exponential", 2e4) for _ in range(2))
    advance(first, 90)
    stored = {name: array.copy() for name, array in first.snapshot().items()}
    second.check(Stored(stored))
    second.restore(stored)
    for machine in (first, second):
        advance(machine, 110)
    assert first.energy == second.energy
    assert first.energy["bond"] > 1.0
    assert first.state.position.tobytes() == second.state.position.tobytes()
    with pytest.raises(InputError, match="bonds/damage"):
        second.check(Stored(stored | {"bonds/damage": 1.0 + stored["bonds/damage"]}))


def test_the_share_of_a_joint_that_is_bonded_falls_with_the_energy_that_is_taken() -> None:
    machine = led([(0.0, 0.0, -2e-4)], 0.2, 1e-3)
    joints, of_pairs = find_joints(machine.assembly), np.zeros(1, dtype=int)
    assert machine.joint_bonds(of_pairs, joints) == pytest.approx([1.0])
    advance(machine, 200)
    assert machine.joint_bonds(of_pairs, joints) == pytest.approx([1.0 - machine.energy["bond"] / G_1], rel=1e-9)
    assert 0.2 < machine.energy["bond"] / G_1 < 0.8


def test_a_bond_that_is_cut_in_the_middle_of_softening_leaves_friction_and_its_energy_is_booked() -> None:
    pressure = 1e5
    machine = led([(-3e-4, 0.0, 0.0), (-4e-4, 0.0, 0.0)], 0.2, 1e-3, pressure=pressure)
    advance(machine, 120)
    before, bonded = machine.energy, float(machine.motion.bonds.damage.min())
    assert 0.5 < bonded < 1.0
    machine.cut_bonds(np.ones((2, 2), dtype=bool))
    advance(machine, 80)
    after = machine.energy
    assert abs(machine.solution.impulse[:, 1].sum()) / 1e-3 == pytest.approx(MU * pressure, rel=1e-3)
    assert after["bond"] == before["bond"]
    assert 0.0 < after["damping"] - before["damping"] < before["elastic"]
    assert abs(after["balance"]) < 1e-9 * G_2


# --- a beam peeled off its base: half of a double cantilever beam ------------------------------------------------------------

LONG, DEEP, TOUGH, ARM = 0.05, 0.1, 50.0, 2e11  # of a block [m], G_I [N/m], stiffness of the joints between the blocks [N/m3]
BENDING = ARM * LONG * DEEP * DEEP**3 / 12.0  # E I [N m2]


def peeled(points: int, count: int = 14, free: int = 6, lift: float = 1.2e-3, steps: int = 90) -> np.ndarray:
    """Lift the end of a row of blocks off its base, of which the first are not bonded to it: lift, force and turn of that end, (N, 3).

    By symmetry the bond is not sheared: it hardly resists.
    """
    blocks = [box("base", (-0.2, -DEEP, -0.5), (count * LONG + 0.2, DEEP, 0.0), fixed=True)]
    for i in range(count):
        block = box(f"b{i}", (i * LONG, -DEEP / 2, 0.0), ((i + 1) * LONG, DEEP / 2, DEEP))
        blocks.append(replace(block, group="free" if i < free else "arm"))
    strong = JointLaw(normal_stiffness=ARM, tangential_stiffness=10.0 * ARM, cohesion=1e9, tension=1e9, joint_points=3)
    bond = {"cohesion": 1e6, "tension": 1e6, "fracture_energy": TOUGH, "shear_fracture_energy": 1e6, "softening": "linear"}
    weak = JointLaw(normal_stiffness=5e10, tangential_stiffness=1e7, joint_points=points, **bond)
    laws = {"free-free": strong, "free-arm": strong, "arm-arm": strong, "arm-base": weak, "free-base": JointLaw(normal_stiffness=5e10)}
    assembly, dt = Assembly.from_blocks(blocks, material_of(0.6, laws)), 1e-3
    push = {"kind": "push", "control": "displacement", "direction": "z", "blocks": "b0", "point": [0.0, 0.0, DEEP / 2], "targets": [lift]}
    loading = loads.build([push | {"speed": 1.875 * lift / (steps * dt)}], dt, steps, (0.0, 0.0, 0.0), Path(), assembly)
    run = Run.model_validate({"dt": dt, "duration": steps * dt, "solver": "newton", "tolerance": 1e-8})
    machine, out = Stepper(assembly, loading.support_velocity, loading.acceleration, run, forces=loading.forces), []
    for _ in range(steps):
        machine.step()
        turn, driven = rotation_matrices(machine.state.orientation)[1], machine.driven()
        out.append((driven.displacement[0], driven.force[0], np.arctan2(turn[2, 0], turn[0, 0])))
    assert abs(machine.energy["balance"]) < 1e-6 * machine.energy["base_work"]
    return np.array(out)


def test_a_peeled_beam_follows_the_theory_of_beams_at_any_number_of_points() -> None:
    fine, coarse = peeled(9), peeled(5)
    for curve in (fine, coarse):
        lift, force, turn = curve[(curve[:, 0] > 7.5e-4) & (curve[:, 0] < 1.05e-3)].T
        assert np.abs(force * -turn / DEEP / TOUGH - 1.0).max() < 0.05  # J = P theta / b, of any law of the bond
        free = np.sqrt(2.0 * DEEP * TOUGH * BENDING) / force  # length at which G = P^2 a^2 / (2 b E I)
        assert np.abs(force * free**3 / (3.0 * BENDING) / lift - 1.0).max() < 0.06
    assert fine[:, 1].max() == pytest.approx(coarse[:, 1].max(), rel=0.01)
    assert np.abs(fine[:, 1] - coarse[:, 1]).max() < 0.04 * fine[:, 1].max()


# --- a stone that is cut beforehand ------------------------------------------------------------------------------------------

SPAN, HIGH, WIDE, STONE, STIFF = 2.0, 0.3, 0.3, 1e6, 1e11  # of a lintel [m], its tensile strength [Pa], stiffness of the cut [N/m3]


def broken_at(energy: float, points: int = 9, steps: int = 250, most: float = 1.75) -> float:
    """Weight at which a lintel that is cut at mid-span and bonded there falls, over that of the moment f_t b h^2 / 6."""
    half, end = SPAN / 2, SPAN / 2 + 0.1
    blocks = [
        box("pier 0", (-end, -WIDE / 2, -0.5), (-half, WIDE / 2, 0.0), fixed=True),
        box("pier 1", (half, -WIDE / 2, -0.5), (end, WIDE / 2, 0.0), fixed=True),
        replace(box("left", (-end, -WIDE / 2, 0.0), (0.0, WIDE / 2, HIGH)), group="left"),
        replace(box("right", (0.0, -WIDE / 2, 0.0), (end, WIDE / 2, HIGH)), group="right"),
    ]
    bond = {"cohesion": 5.0 * STONE, "tension": STONE, "fracture_energy": energy, "shear_fracture_energy": 1e5, "softening": "linear"}
    law = JointLaw(normal_stiffness=STIFF, joint_points=points, damping=0.1, damping_frequency=20.0, **bond)
    assembly = Assembly.from_blocks(blocks, material_of({"left-right": 0.6, "default": 0.0}, {"left-right": law}))
    moment = 2000.0 * GRAVITY * WIDE * HIGH * (half**2 - 0.1**2) / 2.0
    pull, dt = gravity(steps) * np.linspace(0.0, most, steps + 1)[:, None] * STONE * WIDE * HIGH**2 / 6.0 / moment, 3e-3
    run = Run.model_validate({"dt": dt, "duration": dt * steps, "tolerance": 1e-8, "solver": "newton"})
    machine = Stepper(assembly, np.zeros((steps + 1, 1, 3)), pull, run)
    for k in range(steps):
        machine.step()
        if machine.state.position[2, 2] - assembly.centre[2, 2] < -5e-4:
            return most * (k + 1) / steps
    return np.inf


def test_a_lintel_cut_at_mid_span_breaks_at_the_elastic_moment_and_bears_more_the_tougher_it_is() -> None:
    least = STONE**2 / (2.0 * STIFF)
    brittle, tough = broken_at(1.05 * least), broken_at(4.0 * least)
    assert 1.0 < brittle < 1.1
    assert 1.3 < tough < 3.0  # three times were all of the section at the strength
    assert broken_at(4.0 * least, points=15) == pytest.approx(tough, rel=0.03)
