# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks of one strain each, against closed forms: shortening, own frequencies, waves, shear, energy."""

from __future__ import annotations

import math
from copy import deepcopy

import numpy as np
import pytest
from models import BOX_FACES, GRAVITY, advance, box, gravity, ground, material_of, stepper, still, tower, turned, wall

from loads.bars import Forces, PointLoad
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.state import State, body_maps

YOUNG, DENSITY = 1e9, 2000.0
BOTH = pytest.mark.parametrize("planar", [True, False])
XX, YY, ZZ, YZ, XZ, XY = range(6)


def soft(**keys: object) -> ElasticBlocks:
    """Blocks of uniform strain, with keys of the table [material]."""
    return ElasticBlocks.model_validate({"deformable": "uniform", "young": YOUNG} | keys)


def strained(machine: Stepper, block: int) -> np.ndarray:
    """Strains of a block, (6,)."""
    return machine.state.strain[block]


def own_frequency(strain: int, dt: float, poisson: float, planar: bool = False) -> float:
    """Circular frequency at which a strain of a free box, 0.6 x 0.8 x 0.5 m, swings without damping, by its zeros [1/s]."""
    blocks = [box("base", (-1.0, -1.0, -3.0), (1.0, 1.0, -2.0), fixed=True), box("b", (-0.3, -0.4, 0.0), (0.3, 0.4, 0.5))]
    steps = 400
    material = soft(poisson=poisson, strain_theta=0.5)
    machine = stepper(
        blocks, steps, acceleration=np.zeros((steps + 1, 3)), material=material, dt=dt, planar=planar, duration=1.0, gravity=[0, 0, 0]
    )
    machine.state.strain[1, strain] = 1e-5
    seen = [1e-5]
    for _ in range(steps):
        machine.step()
        seen.append(machine.state.strain[1, strain])
    value, time = np.array(seen), dt * np.arange(steps + 1)
    k = np.flatnonzero(value[:-1] * value[1:] < 0.0)
    zeros = time[k] + dt * value[k] / (value[k] - value[k + 1])
    assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["elastic"] + 1e-9 * machine.energy["kinetic"]
    return float(np.pi / np.diff(zeros).mean())


@BOTH
@pytest.mark.parametrize(("poisson", "young"), [(0.0, YOUNG), (0.3, YOUNG), (0.3, 1e9), (0.3, 1e10), (0.3, 1e11), (0.3, 1e12)])
def test_a_column_shortens_as_its_weight_tells(planar: bool, poisson: float, young: float) -> None:
    """Four blocks on a smooth base: the mean stress of each is the weight above its middle; the sides widen by Poisson's ratio."""
    height, count, steps = 0.25, 4, 40
    machine = stepper(tower(count, height=height), steps, friction=0.0, material=soft(poisson=poisson), planar=planar, tolerance=1e-12)
    assert settle(machine) > 0
    assert machine.system.unknowns == (6 if planar else 12)
    strain = -DENSITY * GRAVITY * height * (count - 0.5 - np.arange(count)) / YOUNG
    shift = height * (np.cumsum(strain) - 0.5 * strain)  # of the middles
    for _ in range(steps + 1):
        np.testing.assert_allclose(machine.state.strain[1:, ZZ], strain, rtol=1e-7)
        np.testing.assert_allclose(machine.state.strain[1:, [XX, YY]], np.outer(-poisson * strain, [1, 1]), rtol=1e-7, atol=1e-14)
        np.testing.assert_allclose(machine.state.position[1:, 2] - machine.assembly.centre[1:, 2], shift, rtol=1e-7)
        if machine.steps < steps:
            machine.step()


@pytest.mark.parametrize(
    ("strain", "frequency"),
    [
        (ZZ, math.sqrt(12.0 * YOUNG / (DENSITY * 0.5**2))),
        (XX, math.sqrt(12.0 * YOUNG / (DENSITY * 0.6**2))),
        (XZ, math.sqrt(12.0 * 0.5 * YOUNG / DENSITY * (1 / 0.6**2 + 1 / 0.5**2))),
        (YZ, math.sqrt(12.0 * 0.5 * YOUNG / DENSITY * (1 / 0.8**2 + 1 / 0.5**2))),
        (XY, math.sqrt(12.0 * 0.5 * YOUNG / DENSITY * (1 / 0.6**2 + 1 / 0.8**2))),
    ],
)
def test_a_free_block_swings_at_its_own_frequency(strain: int, frequency: float) -> None:
    """Without Poisson's ratio each strain swings by itself, omega^2 = K / M; the midpoint rule lengthens the period by (omega h)^2 / 12."""
    dt = 2e-5
    found = own_frequency(strain, dt, 0.0)
    assert found == pytest.approx(frequency * (1.0 - (frequency * dt) ** 2 / 12.0), rel=1e-4)


def test_a_block_in_a_plane_swings_as_in_space_under_plane_stress() -> None:
    """With Poisson's ratio the slow swing of a slender direction is softer in plane stress than the bare stiffness C_zz of the solid."""
    steps, dt = 300, 1e-5
    blocks = [box("base", (-1.0, -1.0, -3.0), (1.0, 1.0, -2.0), fixed=True), box("b", (-0.01, -0.01, 0.0), (0.01, 0.01, 1.0))]
    swings = []
    for planar in (True, False):
        material = soft(poisson=0.3, strain_theta=0.5)
        machine = stepper(
            blocks, steps, acceleration=np.zeros((steps + 1, 3)), material=material, dt=dt, planar=planar, duration=1.0, gravity=[0, 0, 0]
        )
        machine.state.strain[1, :3] = [-0.3e-5, -0.3e-5, 1e-5]
        swings.append([float(strained(machine, 1)[ZZ]) for _ in range(steps) if machine.step()])
    omega = math.sqrt(12.0 * YOUNG / DENSITY)
    exact = 1e-5 * np.array([math.cos(omega * dt * (k + 1)) for k in range(steps)])  # E, not C_zz: the sides are free
    np.testing.assert_allclose(swings[0], exact, atol=1e-2 * 1e-5)
    np.testing.assert_allclose(swings[1], exact, atol=1e-2 * 1e-5)


def test_a_bar_that_hits_a_wall_rebounds_after_two_passages_of_the_wave() -> None:
    """40 blocks in a row, not glued, at 0.5 m/s: contact lasts 2 L / c, and nearly all of the motion comes back; energy closes."""
    count, length, speed = 40, 4.0, 0.5
    wave, size = math.sqrt(YOUNG / DENSITY), length / count
    dt = 0.5 * size / wave
    steps = round(3.0 * length / wave / dt)
    blocks = [ground(1.0), *(box(f"b{i}", (-0.1, -0.1, size * i), (0.1, 0.1, size * (i + 1))) for i in range(count))]
    none = np.zeros((steps + 1, 3))
    material = soft(poisson=0.0, strain_theta=0.5)
    machine = stepper(blocks, steps, friction=0.0, acceleration=none, material=material, dt=dt, duration=1.0, gravity=[0, 0, 0])
    first = np.zeros((count + 1, 6))
    first[1:, 2] = -speed
    machine.kick(first)
    pressed = np.zeros(steps)
    for k in range(steps):
        machine.step()
        assert machine.last is not None
        pressed[k] = machine.solution.impulse[(machine.last.rows.blocks == 0).any(axis=1), 0].sum()
    mass, kinetic = DENSITY * 0.04 * length, 0.5 * DENSITY * 0.04 * length * speed**2
    contact = dt * (1 + np.flatnonzero(pressed > 1e-3 * pressed.max())[-1])
    assert contact == pytest.approx(2.0 * length / wave, rel=0.02)
    assert pressed.sum() / (2.0 * mass * speed) == pytest.approx(1.0, abs=0.02)
    assert machine.state.velocity[1:, 2].mean() == pytest.approx(speed, rel=0.03)
    assert abs(machine.energy["balance"]) < 1e-10 * kinetic


@BOTH
def test_a_push_shears_a_block_by_its_mean_stress(planar: bool) -> None:
    """Under a body acceleration a along the base the mean shear stress of a block is rho a H / 2, and its shear strain that over G."""
    side, height, poisson, steps = 1.0, 0.25, 0.25, 60
    blocks = [ground(2.0), box("b", (-side / 2, -side / 2, 0.0), (side / 2, side / 2, height))]
    pull = gravity(steps, (2.0, 0.0, -GRAVITY))
    machine = stepper(
        blocks, steps, acceleration=pull, material=soft(poisson=poisson, strain_theta=1.0), planar=planar, dt=1e-3, tolerance=1e-12
    )
    advance(machine, steps)
    shear = DENSITY * 2.0 * height / 2.0 / (YOUNG / (2.0 * (1.0 + poisson)))
    assert abs(strained(machine, 1)[XZ]) == pytest.approx(shear, rel=1e-6)
    np.testing.assert_allclose(strained(machine, 1)[[YZ, XY]], 0.0, atol=1e-9 * shear)


@BOTH
def test_a_bond_under_pressure_has_the_same_stress_everywhere(planar: bool) -> None:
    """Patch test: whole and half units, whose faces do not match, under a rigid plate that is pressed down, on a smooth base."""
    steps, press, poisson = 120, 1e5, 0.25
    blocks = [*wall(2, 3), Block("plate", box("", (-0.1, -0.3, 0.6), (0.9, 0.3, 0.7)).vertices, BOX_FACES, 100.0, "plate")]
    forces = Forces((PointLoad(len(blocks) - 1, np.zeros(3), np.array([0.0, 0.0, -press]), np.ones(steps + 1)),), ())
    run = Run(dt=1e-3, duration=1.0, solver="newton", tolerance=1e-13, planar=planar, gravity=(0.0, 0.0, 0.0))
    material = soft(deformable={"block": "uniform"}, poisson=poisson, strain_theta=1.0, damping=0.5, damping_frequency=100.0)
    assembly = Assembly.from_blocks(blocks, material_of(0.0, None, material))
    machine = Stepper(assembly, still(steps), np.zeros((steps + 1, 3)), run, forces=forces)
    advance(machine, steps)
    strain = -press / (0.8 * 0.2) / YOUNG
    expected = strain * np.array([-poisson, -poisson, 1.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(machine.state.strain[1:-1], np.tile(expected, (len(blocks) - 2, 1)), atol=1e-9 * abs(strain))


def test_two_forces_that_pull_at_a_block_stretch_it() -> None:
    """F on either end of a free box, not along its axes only: the mean stress is force times place over the volume."""
    blocks = [box("base", (-1.0, -1.0, -3.0), (1.0, 1.0, -2.0), fixed=True), box("b", (-0.2, -0.3, -0.5), (0.2, 0.3, 0.5))]
    steps, force = 60, np.array([300.0, 0.0, 5e4])
    arm = 0.5 * force / force[2]  # along the force: the pair turns nothing
    always = np.ones(steps + 1)
    forces = Forces((PointLoad(1, arm, force, always), PointLoad(1, -arm, -force, always)), ())
    run = Run(dt=1e-3, duration=1.0, solver="nlgs", tolerance=1e-10, planar=False, gravity=(0.0, 0.0, 0.0))
    assembly = Assembly.from_blocks(blocks, material_of(0.5, None, soft(poisson=0.25, strain_theta=1.0)))
    machine = Stepper(assembly, still(steps), np.zeros((steps + 1, 3)), run, forces=forces)
    advance(machine, steps)
    stress = 2.0 * np.outer(force, arm) / (0.4 * 0.6 * 1.0)
    strain = 1.25 / YOUNG * stress - 0.25 / YOUNG * np.trace(stress) * np.eye(3)
    expected = [*np.diag(strain), 2.0 * strain[1, 2], 2.0 * strain[0, 2], 2.0 * strain[0, 1]]
    np.testing.assert_allclose(strained(machine, 1), expected, rtol=1e-4, atol=1e-9)
    assert machine.energy["force_work"] > 0.0
    assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["force_work"]


def test_strains_turn_with_the_frame() -> None:
    """A column on an inclined base, gravity inclined alike, has the strains of the upright one."""
    angle, axis = 0.7, np.array([1.0, 2.0, 0.5]) / math.sqrt(5.25)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    steps, machines = 30, []
    for rotation in (np.eye(3), turn):
        blocks = [Block(b.name, b.vertices @ rotation.T, b.faces, b.density, b.group, b.fixed) for b in tower(2, side=0.5, height=0.25)]
        down = rotation @ [1.0, 0.5, -GRAVITY]
        machine = stepper(blocks, steps, acceleration=gravity(steps, tuple(down)), material=soft(strain_theta=1.0), tolerance=1e-12)
        advance(machine, steps)
        machines.append(machine)
    upright, inclined = (
        body_maps(m.assembly, m.state.orientation, m.state.strain) - body_maps(m.assembly, m.state.orientation, 0.0 * m.state.strain)
        for m in machines
    )
    np.testing.assert_allclose(turn.T @ inclined[1:] @ turn, upright[1:], atol=1e-6 * np.abs(upright).max())


def test_energy_closes_where_blocks_fall_spin_and_slide() -> None:
    """Two blocks dropped askew on a third: with the midpoint rule nothing is lost but by friction and impacts."""
    blocks = [ground(3.0), box("a", (-0.5, -0.5, 0.0), (0.5, 0.5, 0.3)), box("b", (-0.1, -0.2, 0.5), (0.4, 0.3, 0.8))]
    steps = 400
    material = soft(young=2e7, poisson=0.2, strain_theta=0.5)
    start = turned(Assembly.from_blocks(blocks, 0.3), 2, (0.6, 0.8, 0.0), 0.3, (0.0, 0.0, 0.6))
    start.strain = np.zeros((3, 6))
    machine = stepper(blocks, steps, friction=0.3, material=material, start=start)
    advance(machine, steps)
    energy = machine.energy
    assert energy["friction"] > 0.0
    assert energy["impact"] > 0.0
    assert abs(energy["damping"]) < 1e-8 * energy["gravity_work"]
    assert abs(energy["balance"]) < 1e-3 * energy["gravity_work"]


def test_viscosity_takes_its_share_of_critical() -> None:
    """A strain with damping xi at its own frequency decays by exp(-2 pi xi / sqrt(1 - xi^2)) per period."""
    share, frequency = 0.05, math.sqrt(12.0 * YOUNG / (DENSITY * 0.5**2)) / (2.0 * math.pi)
    dt, steps = 1.0 / (400.0 * frequency), 2000
    blocks = [box("base", (-1.0, -1.0, -3.0), (1.0, 1.0, -2.0), fixed=True), box("b", (-0.3, -0.4, 0.0), (0.3, 0.4, 0.5))]
    material = soft(poisson=0.0, strain_theta=0.5, damping=share, damping_frequency=frequency)
    machine = stepper(blocks, steps, acceleration=np.zeros((steps + 1, 3)), material=material, dt=dt, duration=1.0, gravity=[0, 0, 0])
    machine.state.strain[1, ZZ] = 1e-5
    seen = np.array([strained(machine, 1)[ZZ] for _ in range(steps) if machine.step()])
    peaks = seen[1:-1][(seen[1:-1] > seen[:-2]) & (seen[1:-1] >= seen[2:])]
    assert peaks[1:4] / peaks[:3] == pytest.approx(math.exp(-2.0 * math.pi * share / math.sqrt(1.0 - share**2)), rel=0.01)
    assert machine.energy["damping"] > 0.0
    assert abs(machine.energy["balance"]) < 1e-12 * machine.energy["damping"] + 1e-18


def test_rigid_blocks_next_to_soft_ones_stay_rigid() -> None:
    """Groups of both kinds in one tower: only the soft one is strained, by the weight that it carries."""
    blocks = tower(3, side=0.5, height=0.25)
    blocks[2] = Block("soft", blocks[2].vertices, blocks[2].faces, DENSITY, "pad")
    material = ElasticBlocks.model_validate({"deformable": {"pad": "uniform"}, "young": {"pad": YOUNG}, "poisson": 0.0})
    machine = stepper(blocks, 20, friction=0.3, material=material, tolerance=1e-12)
    settle(machine)
    advance(machine, 20)
    assert not machine.state.strain[[0, 1, 3]].any()
    assert strained(machine, 2)[ZZ] == pytest.approx(-DENSITY * GRAVITY * 0.25 * 1.5 / YOUNG, rel=1e-7)


def test_a_run_goes_on_from_its_snapshot_to_the_bit() -> None:
    """:meth:`Stepper.snapshot` keeps all that the next step depends on."""
    machines = [stepper(tower(2), 40, material=soft(), dt=2e-3) for _ in range(2)]
    for _ in range(20):
        machines[0].step()
    machines[1].restore(deepcopy(machines[0].snapshot()))
    for _ in range(20):
        for machine in machines:
            machine.step()
    assert np.array_equal(machines[0].state.strain, machines[1].state.strain)
    assert np.array_equal(machines[0].state.position, machines[1].state.position)


def test_a_start_without_strains_is_one_at_rest() -> None:
    """States of rigid blocks have no strains, those of others one row each."""
    rigid = Assembly.from_blocks(tower(2), 0.5)
    assert State.at_rest(rigid).strain.shape == (0, 6)
    assert State.at_rest(Assembly.from_blocks(tower(2), material_of(0.5, None, soft()))).strain.shape == (3, 6)
