# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks cut into uniform-strain elements: patch test, shortening, energy, snapshots."""

from __future__ import annotations

import math
from copy import deepcopy

import numpy as np
import pytest
from models import BOX_FACES, GRAVITY, advance, box, ground, material_of, stepper, still, tower, turned

from loads.bars import Forces, PointLoad
from masonry_cd.foundation.arrays import Stored
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.mean_stress import MeanStress, check_sums
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.dynamics.strain import Strains, unknowns_of_strain
from masonry_cd.mechanics.linalg.small_blocks import inverses
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.state import State, body_maps, rotation_matrices
from masonry_cd.mechanics.model.warping import warp_shapes
from masonry_cd.mechanics.solvers import SOLVERS

YOUNG, DENSITY = 1e9, 2000.0
BOTH = pytest.mark.parametrize("planar", [True, False])
ZZ = 2


def meshed(**keys: object) -> ElasticBlocks:
    """Blocks with as few elements as they can have, with keys of the table [material]."""
    return ElasticBlocks.model_validate({"deformable": "tetrahedra", "young": YOUNG, "mesh_size": 10.0} | keys)


def pressed_stack(planar: bool, press: float = 1e3, steps: int = 25) -> Stepper:
    """Three blocks on a smooth base, whose meshes do not match, under a rigid plate that is pressed down [N]."""
    levels = {"a": (0.0, 0.25), "b": (0.25, 0.5), "c": (0.5, 0.8)}
    blocks = [ground(3.0)]
    for name, (low, high) in levels.items():
        blocks.append(Block(name, box("", (-0.4, -0.2, low), (0.4, 0.2, high)).vertices, BOX_FACES, DENSITY, name))
    blocks.append(Block("plate", box("", (-0.5, -0.3, 0.8), (0.5, 0.3, 0.9)).vertices, BOX_FACES, 1e5, "plate"))
    forces = Forces((PointLoad(len(blocks) - 1, np.zeros(3), np.array([0.0, 0.0, -press]), np.ones(steps + 1)),), ())
    run = Run(dt=0.02, theta=1.0, duration=1e3, solver="newton", tolerance=1e-13, planar=planar, gravity=(0.0, 0.0, 0.0))
    material = meshed(
        deformable=dict.fromkeys(levels, "tetrahedra"), poisson=0.25, strain_theta=1.0, mesh_size={"a": 0.5, "b": 0.35, "c": 0.25}
    )
    assembly = Assembly.from_blocks(blocks, material_of(0.0, None, material))
    return Stepper(assembly, still(steps), np.zeros((steps + 1, 3)), run, forces=forces)


def misfit(machine: Stepper, press: float = 1e3) -> float:
    """How far the strains of such a stack, and its warps over its height, are from those of uniform stress, over its strain."""
    strain = -press / (0.8 * 0.4) / YOUNG
    expected = strain * np.array([-0.25, -0.25, 1.0, 0.0, 0.0, 0.0])
    found = machine.state.strain[1:-1]
    return max(float(np.abs(found[:, :6] - expected).max()), float(np.abs(found[:, 6:]).max()) / 0.8) / abs(strain)


@BOTH
def test_uniform_stress_passes_between_meshes_that_do_not_match(planar: bool) -> None:
    """Patch test: forces at the corners of the overlaps of facets carry a uniform pressure on both sides at once."""
    machine = pressed_stack(planar)
    assert machine.system.strains is not None
    assert machine.system.strains.warps is not None
    assert len({len(mesh.nodes) for mesh in machine.system.strains.warps.meshes}) > 1
    advance(machine, 25)
    assert misfit(machine) < 1e-9


def test_meshes_of_all_sizes_share_their_kernels() -> None:
    """Another number of unknowns compiles nothing."""
    blocks, seen = [ground(3.0), box("a", (-0.4, -0.2, 0.0), (0.4, 0.2, 0.5))], {}
    for size in (0.5, 0.3):
        strains = Strains.of(Assembly.from_blocks(blocks, material_of(0.0, None, meshed(mesh_size=size))), None, 1e-3)
        assert strains is not None
        seen[len(strains.columns)] = len(inverses.outer.signatures)
    assert len(seen) == 2
    assert len(set(seen.values())) == 1


def test_corners_of_whole_faces_fail_the_patch_test() -> None:
    """Without the facets, forces at the corners of the faces' overlap bend the meshes between them."""
    machine = pressed_stack(True)
    machine.detector = Detector(machine.assembly)
    advance(machine, 25)
    assert misfit(machine) > 0.1


@BOTH
def test_the_number_of_nodes_tells_that_of_unknowns(planar: bool) -> None:
    machine = pressed_stack(planar)
    assert machine.system.strains is not None
    assert machine.system.strains.warps is not None
    assert machine.system.unknowns == len(machine.system.blocks.columns) + unknowns_of_strain(machine.assembly, machine.plane)
    for mesh in machine.system.strains.warps.meshes:
        assert mesh.warps == warp_shapes(mesh).shape[2] > 0


def recorded(machine: Stepper, steps: int) -> MeanStress:
    """The stresses of a given number of further steps."""
    record = MeanStress(machine, find_joints(machine.assembly))
    for _ in range(steps):
        machine.step()
        record.take_step(np.full(len(machine.detector.pairs), -1))
    return record


@BOTH
def test_each_element_of_a_pressed_stack_has_the_same_stress(planar: bool) -> None:
    """Patch test of the stress: the pressure, and nothing else, whatever the mesh."""
    press = 1e3
    machine = pressed_stack(planar, press)
    advance(machine, 24)
    record = recorded(machine, 1)
    pressure = press / (0.8 * 0.4)
    assert len(record.of_elements()) > 3 * (4 if planar else 12)
    assert np.abs(record.of_elements() - [0.0, 0.0, -pressure, 0.0, 0.0, 0.0]).max() < 1e-9 * pressure
    shortened = record.node_displacements()[:, ZZ]
    assert np.abs(shortened).max() == pytest.approx(0.15 * pressure / YOUNG, rel=1e-9)  # half of the highest block


@BOTH
def test_the_stress_of_a_block_is_the_mean_of_its_elements(planar: bool) -> None:
    """While it falls askew, turns and rings, viscosity included: by volume, over the same steps."""
    blocks = [ground(3.0), box("a", (-0.5, -0.5, 0.0), (0.5, 0.5, 0.3)), box("b", (-0.1, -0.5, 0.31), (0.4, 0.5, 0.6))]
    material = meshed(young=2e7, damping=0.05, damping_frequency=20.0, mesh_size=0.3)
    machine = stepper(blocks, 60, friction=0.3, material=material, solver="auto", tolerance=1e-8, planar=planar)
    machine.kick(np.array([[0.0] * 6, [0.0] * 6, [0.3, 0.0, -1.0, 0.0, 2.0, 0.0]]))
    record, strains = recorded(machine, 60), machine.system.strains
    assert strains is not None
    assert strains.warps is not None
    meshes = [strains.warps.meshes[g] for g in strains.warps.of_block[1:]]
    ends = np.cumsum([len(mesh.elements) for mesh in meshes])
    for b, of_block, mesh in zip((1, 2), np.split(record.of_elements(), ends[:-1]), meshes, strict=True):
        own = record.stresses()[b]
        assert np.abs(mesh.shares() @ of_block - own).max() < 1e-9 * np.abs(own).max()
        assert np.ptp(of_block[:, ZZ]) > 0.1 * np.abs(own).max()  # it bends
    kept, sizes = record.snapshot(), (len(blocks), find_joints(machine.assembly).count)
    check_sums(Stored(kept), *sizes, len(record.of_elements()))
    for wrong in (kept | {"elements": kept["elements"][1:]}, {name: array for name, array in kept.items() if name != "elements"}):
        with pytest.raises(InputError, match="elements"):
            check_sums(Stored(wrong), *sizes, len(record.of_elements()))


def places(machine: Stepper, block: int) -> tuple[np.ndarray, np.ndarray]:
    """Places of the nodes of a meshed block (N, 3) [m]: as built, from its centre, and now."""
    strains, state = machine.system.strains, machine.state
    assert strains is not None
    assert strains.warps is not None
    nodes = strains.warps.meshes[strains.warps.of_block[block]].nodes
    maps = body_maps(machine.assembly, state.orientation, state.strain)[block]
    return nodes, state.position[block] + nodes @ maps.T + strains.warps.shapes(block) @ state.strain[block, 6:]


def mean_height_of_top(machine: Stepper, block: int, half: float) -> float:
    """Return the mean height of the top of a meshed block now [m], by the area of its facets; in a plane by their length."""
    nodes, now = places(machine, block)
    assert machine.system.strains is not None
    assert machine.system.strains.warps is not None
    warps = machine.system.strains.warps
    facets = warps.meshes[warps.of_block[block]].facets
    top = facets[(nodes[facets, ZZ] > half - 1e-9).all(axis=1)]
    side, other = nodes[top[:, 1]] - nodes[top[:, 0]], nodes[top[:, -1]] - nodes[top[:, 0]]
    area = np.linalg.norm(np.cross(side, other) if machine.plane is None else side, axis=1)
    return float(np.average(now[top, ZZ].mean(axis=1), weights=area))


@pytest.mark.parametrize("young", [1e9, 1e10, 1e11, 1e12, 1e15])
@pytest.mark.parametrize(("planar", "size"), [(True, 0.12), (True, 10.0), (False, 0.25)])
def test_a_column_shortens_as_its_weight_tells(planar: bool, size: float, young: float) -> None:
    """Four blocks on a smooth base, without Poisson's ratio: the mean stress of each is the weight above its middle, whatever its mesh, and
    the top comes down by rho g H^2 / 2 E, to 0.1 % of it."""
    height, count = 0.25, 4
    material = meshed(poisson=0.0, mesh_size=size, young=young)
    machine = stepper(tower(count, height=height), 2, friction=0.0, material=material, planar=planar, tolerance=1e-12, solver="auto")
    assert settle(machine) > 0
    assert machine.system.strains is not None
    at_rest = np.zeros_like(machine.motion.v)
    upright = np.tile(np.eye(3), (count + 1, 1, 1))
    stress = machine.system.strains.stresses(machine.state.strain, at_rest, at_rest, upright)
    weight = -DENSITY * GRAVITY * height
    np.testing.assert_allclose(stress[:, ZZ, ZZ], weight * (count - 0.5 - np.arange(count)), rtol=1e-6)
    down = mean_height_of_top(machine, count, 0.5 * height) - count * height
    assert down == pytest.approx(0.5 * weight * height * count**2 / young, rel=1e-3)


def test_energy_closes_where_blocks_fall_spin_and_slide() -> None:
    """A soft block dropped askew on another: with the midpoint rule nothing is lost but by friction and impacts."""
    blocks = [ground(3.0), box("a", (-0.5, -0.5, 0.0), (0.5, 0.5, 0.3)), box("b", (-0.1, -0.2, 0.31), (0.4, 0.3, 0.6))]
    steps = 200
    material = meshed(young=2e7, poisson=0.2, strain_theta=0.5)
    machine = stepper(blocks, steps, friction=0.3, material=material, solver="auto", tolerance=1e-8)
    first = np.zeros((3, 6))
    first[2] = [0.3, 0.0, -0.5, 0.2, 0.5, 0.1]
    machine.kick(first)
    advance(machine, steps)
    energy = machine.energy
    assert energy["friction"] > 0.0
    assert energy["impact"] > 0.0
    assert abs(energy["damping"]) < 1e-6 * energy["impact"]
    assert abs(energy["balance"]) < 1e-3 * energy["impact"]


def test_all_kinds_stand_in_one_tower() -> None:
    """Rigid, uniform and meshed blocks: each is strained by the weight that it carries, or not at all."""
    blocks = tower(3, side=0.5, height=0.25)
    for k, group in enumerate(("hard", "even", "cut"), start=1):
        blocks[k] = Block(group, blocks[k].vertices, blocks[k].faces, DENSITY, group)
    material = ElasticBlocks.model_validate(
        {"deformable": {"even": "uniform", "cut": "tetrahedra"}, "young": YOUNG, "poisson": 0.0, "mesh_size": {"cut": 1.0}}
    )
    machine = stepper(blocks, 4, friction=0.0, material=material, tolerance=1e-12)
    settle(machine)
    weight = -DENSITY * GRAVITY * 0.25 / YOUNG
    assert not machine.state.strain[:2].any()
    np.testing.assert_allclose(machine.state.strain[2:, ZZ], [1.5 * weight, 0.5 * weight], rtol=1e-6)
    assert not machine.state.strain[2, 6:].any()


@BOTH
def test_two_forces_that_pull_at_a_block_stretch_it_in_the_mean(planar: bool) -> None:
    """F on either end of a free box: the mean stress is force times place over the volume, and single forces warp the block."""
    blocks = [box("base", (-1.0, -1.0, -3.0), (1.0, 1.0, -2.0), fixed=True), box("b", (-0.2, -0.3, -0.5), (0.2, 0.3, 0.5))]
    steps, force = 60, np.array([0.0, 0.0, 5e4])
    arm, always = np.array([0.0, 0.0, 0.5]), np.ones(steps + 1)
    forces = Forces((PointLoad(1, arm, force, always), PointLoad(1, -arm, -force, always)), ())
    run = Run(dt=1e-3, duration=1.0, solver="nlgs", tolerance=1e-10, planar=planar, gravity=(0.0, 0.0, 0.0))
    assembly = Assembly.from_blocks(blocks, material_of(0.5, None, meshed(poisson=0.0, strain_theta=1.0)))
    machine = Stepper(assembly, still(steps), np.zeros((steps + 1, 3)), run, forces=forces)
    advance(machine, steps)
    assert machine.system.strains is not None
    v = machine.motion.v
    own = machine.system.strains.stresses(machine.state.strain, v, v, np.tile(np.eye(3), (2, 1, 1)))
    np.testing.assert_allclose(own[0], np.outer(force, 2.0 * arm) / 0.24, atol=1e-4 * 5e4 / 0.24)
    assert machine.state.strain[1, 6:].any()
    assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["force_work"]


@pytest.mark.parametrize("settings", [{}, {"dt": 5e-4}])
def test_a_run_goes_on_from_its_snapshot_to_the_bit(settings: dict[str, float]) -> None:
    """:meth:`Stepper.snapshot` keeps all that the next step depends on."""
    machines = [stepper(tower(2), 40, material=meshed(), **({"dt": 2e-3} | settings)) for _ in range(2)]
    for _ in range(20):
        machines[0].step()
    machines[1].restore(deepcopy(machines[0].snapshot()))
    for _ in range(20):
        for machine in machines:
            machine.step()
    assert machines[0].state.strain[:, 6:].any()
    assert np.array_equal(machines[0].state.strain, machines[1].state.strain)
    assert np.array_equal(machines[0].state.position, machines[1].state.position)


def test_a_meshed_block_on_springs_sinks_as_both_are_soft() -> None:
    """An elastic joint under a meshed block, in a plane and in space: the weight over the stiffness of the joint, and the block's own."""
    law = {"default": JointLaw(normal_stiffness=1e8, tangential_stiffness=1e8)}
    for planar in (True, False):
        machine = stepper(tower(1, height=0.5), 4, joints=law, material=meshed(poisson=0.0), planar=planar, tolerance=1e-12, solver="auto")
        settle(machine)
        nodes, now = places(machine, 1)
        low = nodes[:, ZZ] < -0.25 + 1e-9
        weight = DENSITY * GRAVITY * 0.5
        share = np.array([0.5, 0.5]) if planar else np.array([0.25 * 2 / 3] * 4 + [1 / 3])
        assert float(share.sum()) == pytest.approx(1.0)
        assert (now[low, ZZ] * share).sum() == pytest.approx(-weight / 1e8, rel=2e-2)


def test_a_bonded_block_hangs() -> None:
    """Mortar holds a meshed block under a fixed one: the joint carries its weight."""
    blocks = [box("top", (-0.5, -0.5, 0.0), (0.5, 0.5, 0.5), fixed=True), box("b", (-0.25, -0.25, -0.5), (0.25, 0.25, 0.0))]
    law = {"default": JointLaw(normal_stiffness=1e10, cohesion=1e5)}
    machine = stepper(blocks, 40, joints=law, material=meshed(strain_theta=1.0), tolerance=1e-10, solver="auto")
    advance(machine, 40)
    assert machine.state.position[1, ZZ] == pytest.approx(-0.25, abs=1e-4)
    assert machine.state.strain[1, ZZ] > 0.0


def test_blocks_turn_with_their_warps() -> None:
    """A warped block spins freely: its warps stay those of the body frame, and no momentum is lost."""
    blocks = [box("base", (-1.0, -1.0, -3.0), (1.0, 1.0, -2.0), fixed=True), box("b", (-0.3, -0.4, -0.25), (0.3, 0.4, 0.25))]
    assembly, steps = Assembly.from_blocks(blocks, 0.5), 100
    start = turned(assembly, 1, (0.0, 0.6, 0.8), 0.7, (0.0, 0.0, 0.0))
    start = State(0.0, start.position, start.orientation, start.velocity, np.zeros((2, 6)))
    none = np.zeros((steps + 1, 3))
    machine = stepper(
        blocks, steps, acceleration=none, material=meshed(young=1e8, strain_theta=0.5), start=start, dt=1e-4, gravity=[0, 0, 0]
    )
    machine.state.strain[1, 6] = 1e-4
    energies = []
    for _ in range(steps):
        machine.step()
        energies.append(machine.energy["kinetic"] + machine.energy["elastic"])
    np.testing.assert_allclose(energies, energies[0], rtol=1e-9)
    np.testing.assert_allclose(rotation_matrices(machine.state.orientation), rotation_matrices(start.orientation), atol=1e-12)


@pytest.mark.validation
def test_a_bar_that_hits_a_wall_rebounds_after_two_passages_of_the_wave() -> None:
    """One block of 4 m in 305 nodes at 0.5 m/s: contact lasts 2 L / c, nearly all of the motion comes back, and the energy closes."""
    size, half, length, speed = 0.067, 0.0335, 4.0, 0.5
    wave = math.sqrt(YOUNG / DENSITY)
    dt = 0.25 * size / wave
    steps = round(3.0 * length / wave / dt)
    blocks = [ground(1.0), box("bar", (-half, -0.1, 0.0), (half, 0.1, length))]
    material = meshed(poisson=0.0, strain_theta=0.5, mesh_size=size)
    none = np.zeros((steps + 1, 3))
    machine = stepper(blocks, steps, friction=0.0, acceleration=none, material=material, dt=dt, duration=1.0, gravity=[0, 0, 0])
    first = np.zeros((2, 6))
    first[1, ZZ] = -speed
    machine.kick(first)
    pressed = np.zeros(steps)
    for k in range(steps):
        machine.step()
        pressed[k] = machine.solution.impulse[:, 0].sum()
    mass = DENSITY * 0.4 * half * length
    contact = dt * (1 + np.flatnonzero(pressed > 1e-3 * pressed.max())[-1])
    assert contact == pytest.approx(2.0 * length / wave, rel=0.02)
    assert pressed.sum() == pytest.approx(2.0 * mass * speed, rel=0.02)
    assert machine.state.velocity[1, ZZ] == pytest.approx(speed, rel=0.02)
    assert abs(machine.energy["balance"]) < 1e-10 * 0.5 * mass * speed**2


def test_steps_of_any_length_and_islands_of_their_own() -> None:
    """Two towers side by side are two islands; a step of two ticks takes the masses of its own length, and the energy closes."""
    blocks = tower(2)
    blocks += [Block(f"far {b.name}", b.vertices + [1.2, 0.0, 0.0], b.faces, b.density) for b in blocks[1:]]
    machine = stepper(blocks, 60, material=meshed(young=1e8), solver="auto", tolerance=1e-10)
    for ticks in (1,) * 30 + (2,) * 10 + (1,) * 5:
        report = machine.step(ticks)
    assert report.islands == 2
    assert machine.state.time == pytest.approx(0.055)
    assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["gravity_work"]
    np.testing.assert_allclose(machine.state.strain[1:3], machine.state.strain[3:5], atol=1e-6 * np.abs(machine.state.strain).max())


@pytest.mark.parametrize(
    ("planar", "solver", "most"),
    [*((True, name, 1e-10) for name in SOLVERS), (False, "auto", 1e-10), *((False, name, 1e-4) for name in ("nlgs", "admm", "newton"))],
)
def test_every_solver_finds_the_same_motion(planar: bool, solver: str, most: float) -> None:
    """A tower of two meshed blocks in a shake: blocks that deform leave one motion only. In space single steps are hard for all but
    ``interior`` and so ``auto``: the modes of one block differ in stiffness by orders of magnitude."""
    steps = 25
    shaken = np.zeros((steps + 1, 1, 3))
    shaken[:, 0, 0] = 0.2 * np.sin(2.0 * math.pi * np.arange(steps + 1) / 50.0)
    ends = []
    for name, allowed in (("interior", 1e-10), (solver, most)):
        machine = stepper(tower(2), steps, support_velocity=shaken, material=meshed(young=1e8), solver=name, planar=planar)
        for _ in range(steps):
            assert machine.step().error <= allowed
        ends.append(np.concatenate([machine.state.position[1:], machine.state.strain[1:, 6:]], axis=1))
    assert ends[0][:, 3:].any()
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-9 if most < 1e-9 else 1e-7)
