# SPDX-License-Identifier: GPL-3.0-or-later
"""The mean stress of blocks against closed forms: weight, push, eccentric load, tie, spin; turned scenes; the sum over all blocks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from models import GRAVITY, box, gravity, ground, material_of, stepper, still, tower
from numpy.linalg import eigvalsh

from loads.bars import Forces, PointLoad, Tie
from masonry_cd.mechanics.contact.find_joints import find_joints, joint_parts
from masonry_cd.mechanics.dynamics.mean_stress import MeanStress, symmetric
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.edge_stress import edge_stresses, largest_compression
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.state import State

XX, YY, ZZ, XY, YZ, XZ = range(6)
STEPS = 20


class Measured:
    """Blocks after some steps, and their stress over these."""

    def __init__(
        self,
        blocks: list[Block],
        pull: tuple[float, float, float] = (0.0, 0.0, -GRAVITY),
        forces: Forces | None = None,
        start: State | None = None,
        material: ElasticBlocks | None = None,
        **settings: object,
    ) -> None:
        run = Run.model_validate({"dt": 1e-3, "duration": 1.0, "solver": "interior", "tolerance": 1e-13} | settings)
        self.assembly = Assembly.from_blocks(blocks, material_of(0.6, None, material))
        self.machine = Stepper(self.assembly, still(6 * STEPS), gravity(6 * STEPS, pull), run, start, forces)
        self.joints = find_joints(self.assembly)
        self.record = MeanStress(self.machine, self.joints)
        self.stress = self.after(STEPS)

    def after(self, steps: int) -> np.ndarray:
        """The mean stress over a given number of further steps."""
        self.record.begin()
        for _ in range(steps):
            self.machine.step()
            self.record.take_step(self.pair_joint())
        return self.record.stresses()

    def pair_joint(self) -> np.ndarray:
        joint_of = {pair: k for k, pair in enumerate(map(tuple, joint_parts(self.assembly).tolist()))}
        return np.array([joint_of.get(tuple(pair), -1) for pair in self.machine.detector.pairs.tolist()], dtype=np.int64)

    def edges(self) -> np.ndarray:
        force, moment = self.record.joint_forces()
        return edge_stresses(self.joints, self.assembly, self.machine.state, force, moment, np.zeros(len(force), bool))


def turned_about_z(blocks: list[Block]) -> list[Block]:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return [replace(block, vertices=block.vertices @ turn.T) for block in blocks]


def tensor(six: np.ndarray) -> np.ndarray:
    return np.array([[six[XX], six[XY], six[XZ]], [six[XY], six[YY], six[YZ]], [six[XZ], six[YZ], six[ZZ]]])


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("solver", ["interior", "nlgs", "admm"])
def test_a_column_bears_the_weight_above_the_middle_of_each_block(solver, planar):
    side, height, count = 0.5, 0.25, 6
    measured = Measured(tower(count, side, height), solver=solver, tolerance=1e-12, planar=planar)
    expected = np.zeros((count, 6))
    expected[:, ZZ] = -2000.0 * GRAVITY * height * (count - np.arange(count) - 0.5)
    assert np.abs(measured.stress[1:] - expected).max() < 1e-9 * -expected.min()
    assert np.isnan(measured.stress[0]).all()  # the ground


@pytest.mark.parametrize("planar", [True, False])
def test_blocks_that_deform_have_the_stress_of_their_strain(planar):
    """At rest that is what the forces say of rigid ones: the weight above the middle, and the share of a push that it carries."""
    height, push = 0.25, 2.0
    material = ElasticBlocks(deformable="uniform", young=1e9, poisson=0.25, strain_theta=1.0)
    measured = Measured(tower(2, 0.5, height), (push, 0.0, -GRAVITY), material=material, planar=planar)
    stress = measured.after(5 * STEPS)  # the swing of the first steps has died away
    above = 2000.0 * height * (1.5 - np.arange(2))
    assert stress[1:, ZZ] == pytest.approx(-GRAVITY * above, rel=1e-5)  # the strain itself, which moves the forces, is 1e-5
    assert stress[1:, XZ] == pytest.approx(push * above, rel=1e-5)
    across = [YY, XY, YZ] if planar else [XY, YZ]  # in space friction holds the sides of the lower block
    assert np.abs(stress[1:, across]).max() < 1e-6 * push * above.max()


def test_a_push_on_the_top_shears_what_is_below():
    """Half of the stress that the push puts into the base lies at mid-height of the one block; its moment bends, which the mean hides."""
    push = 0.3
    measured = Measured([ground(), box("b", (-1.0, -0.5, 0.0), (1.0, 0.5, 0.5))], pull=(push * GRAVITY, 0.0, -GRAVITY))
    base = 2000.0 * 0.5 * push * GRAVITY  # shear stress in the joint [Pa]
    assert measured.stress[1, XZ] == pytest.approx(base / 2, rel=1e-9)
    load = Forces((PointLoad(1, np.array([0.0, 0.0, 0.25]), np.array([1000.0, 0.0, 0.0]), np.ones(STEPS + 2)),), ())
    sheared = Measured([ground(), box("b", (-1.0, -0.5, 0.0), (1.0, 0.5, 0.5))], forces=load)
    assert sheared.stress[1, XZ] == pytest.approx(1000.0 / (2.0 * 1.0), rel=1e-9)  # the same in all heights


@pytest.mark.parametrize("planar", [True, False])
@pytest.mark.parametrize("inside", [0.5, 0.4, 1 / 3, 0.2, 0.05])
def test_the_edge_of_a_joint_under_an_eccentric_load_bears_2n_over_3ub(inside, planar):
    """A light block with a load at u from one edge of its joint, as a share of its depth."""
    depth, breadth, load = 1.0, 0.8, 1e5
    u = inside * depth
    forces = Forces((PointLoad(1, np.array([u - depth / 2, 0.0, 0.25]), np.array([0.0, 0.0, -load]), np.ones(STEPS + 2)),), ())
    block = box("b", (0.0, -breadth / 2, 0.0), (depth, breadth / 2, 0.5), density=1e-3)
    measured = Measured([ground(), block], forces=forces, planar=planar)
    e = depth / 2 - u
    expected = load / (depth * breadth) * (1 + 6 * e / depth) if e <= depth / 6 else 2 * load / (3 * u * breadth)
    assert measured.edges() == pytest.approx([expected], rel=1e-6)
    assert measured.stress[1, ZZ] == pytest.approx(-load / (depth * breadth), rel=1e-6)


def test_a_hinge_at_the_edge_has_no_finite_stress_and_a_joint_without_force_none():
    blocks = [ground(), box("b", (-0.5, -0.5, 0.0), (0.5, 0.5, 0.5))]
    assembly = Assembly.from_blocks(blocks, 0.6)
    joints, state, none = find_joints(assembly), State.at_rest(assembly), np.zeros(1, bool)
    assert edge_stresses(joints, assembly, state, np.zeros(1), np.zeros((1, 3)), none).tolist() == [0.0]
    place = np.array([0.5, 0.0, 0.0]) - assembly.centre[joints.block_a[0]]
    assert np.isinf(edge_stresses(joints, assembly, state, np.array([1e3]), 1e3 * place[None], none)).all()
    held = edge_stresses(joints, assembly, state, np.array([1e3]), 1e3 * place[None], ~none)  # by cohesion: Navier
    assert held == pytest.approx([4e3], rel=1e-9)


def test_after_a_joint_has_slid_only_the_shared_area_counts():
    blocks = [ground(0.5), box("b", (-0.5, -0.5, 0.0), (0.5, 0.5, 0.5))]
    assembly = Assembly.from_blocks(blocks, 0.6)
    joints, state = find_joints(assembly), State.at_rest(assembly)
    state.position[1, 0] += 0.2  # 0.8 of its depth still lie on the other
    place = np.array([0.1, 0.0, 0.0]) - assembly.centre[joints.block_a[0]]
    found = edge_stresses(joints, assembly, state, np.array([1e3]), 1e3 * place[None], np.zeros(1, bool))
    assert found == pytest.approx([1e3 / 0.8], rel=1e-9)


def linear_stress(polygon: np.ndarray, place: np.ndarray) -> float:
    """The largest compression in a convex polygon (n, 2) [m] by a force of 1 at a place (2,) [m], as [1/m2]."""
    n, corners = len(polygon), np.column_stack([polygon, np.zeros(len(polygon))])
    return float(largest_compression(corners, n, 1.0, float(place[0]), float(place[1]), False, np.zeros(n), np.zeros((2 * n, 3))))


def test_the_distribution_balances_the_force_on_any_convex_polygon():
    """A corner load on a triangle: by its own closed form, and the same stress however the polygon is turned or numbered."""
    triangle = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 2.0]])
    assert linear_stress(triangle, triangle.mean(axis=0)) == pytest.approx(1 / 3.0, rel=1e-12)
    near = 0.9 * triangle[0] + 0.1 * triangle.mean(axis=0)  # the compressed part is a triangle at the corner, its force at 1/4 of its sides
    sides = 4.0 * near
    assert linear_stress(triangle, near) == pytest.approx(6.0 / (sides[0] * sides[1]), rel=1e-9)
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    for moved in (triangle[::-1], np.roll(triangle, 1, axis=0), triangle @ turn.T + [5.0, -7.0]):
        place = near if moved[0, 0] < 4.0 else turn @ near + [5.0, -7.0]
        assert linear_stress(moved, place) == pytest.approx(linear_stress(triangle, near), rel=1e-9)


def test_a_tie_through_two_blocks_presses_them_together():
    blocks = [ground(), box("a", (-1.0, -0.5, 0.0), (0.0, 0.5, 1.0)), box("b", (0.0, -0.5, 0.0), (1.0, 0.5, 1.0))]
    arms = np.array([[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]])
    tie = Tie((1, 2), arms, 2.0, 1e-4, 1e5, 2e4, 0.0)
    measured = Measured(blocks, pull=(0.0, 0.0, 0.0), forces=Forces((), (tie,)))
    assert measured.stress[1:, XX] == pytest.approx([-2e4, -2e4], rel=1e-6)  # over 1 m2


def test_a_spinning_block_is_under_the_tension_of_its_own_inertia():
    """rho w^2 a^2 / 12 across the axis, whatever the time that it is averaged over; none along it."""
    side, spin = 0.4, 10.0
    blocks = [ground(), box("b", (-side / 2, -side / 2, 5.0), (side / 2, side / 2, 5.5))]
    start = State.at_rest(Assembly.from_blocks(blocks, 0.6))
    start.velocity[1, 5] = spin
    measured = Measured(blocks, pull=(0.0, 0.0, 0.0), start=start)
    tension = 2000.0 * spin**2 * side**2 / 12.0
    assert measured.stress[1] == pytest.approx([tension, tension, 0.0, 0.0, 0.0, 0.0], abs=1e-9 * tension)


def test_a_block_that_spins_up_has_the_shear_of_its_angular_acceleration():
    """A couple on a free beam along x, whose second moments along x and z differ: m (sxz) of the couple less that of its inertia."""
    length, high, couple = 2.0, 0.2, 3.0
    blocks = [ground(), box("beam", (-length / 2, -0.5, 5.0), (length / 2, 0.5, 5.0 + high))]
    up = PointLoad(1, np.array([length / 2, 0.0, 0.0]), np.array([0.0, 0.0, couple]), np.ones(STEPS + 2))
    down = PointLoad(1, np.array([-length / 2, 0.0, 0.0]), np.array([0.0, 0.0, -couple]), np.ones(STEPS + 2))
    measured = Measured(blocks, pull=(0.0, 0.0, 0.0), forces=Forces((up, down), ()), planar=False)
    volume, mass = length * high, 2000.0 * length * high
    jx, jz = mass * length**2 / 12, mass * high**2 / 12
    rate = couple * length / (jx + jz)  # of rotation from x to z [rad/s2]
    expected = (0.5 * couple * length - 0.5 * rate * (jx - jz)) / volume
    assert measured.stress[1, XZ] == pytest.approx(expected, rel=1e-6)


def arch_like() -> list[Block]:
    """Two piers and a lintel, pushed sideways."""
    return [
        ground(),
        box("left", (-1.0, -0.3, 0.0), (-0.6, 0.3, 1.5)),
        box("right", (0.6, -0.3, 0.0), (1.0, 0.3, 1.5)),
        box("lintel", (-1.0, -0.3, 1.5), (1.0, 0.3, 1.9)),
    ]


def test_a_scene_turned_about_z_gives_turned_stresses():
    first = Measured(arch_like(), pull=(0.15 * GRAVITY, 0.0, -GRAVITY), planar=False)
    second = Measured(turned_about_z(arch_like()), pull=(0.0, 0.15 * GRAVITY, -GRAVITY), planar=False)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    size = np.nanmax(np.abs(first.stress))
    for one, two in zip(first.stress[1:], second.stress[1:], strict=True):
        assert turn @ tensor(one) @ turn.T == pytest.approx(tensor(two), abs=1e-6 * size)
        assert eigvalsh(tensor(one)) == pytest.approx(eigvalsh(tensor(two)), abs=1e-6 * size)
    assert np.abs(first.stress[1:, XZ]).max() > 0.01 * size  # it is pushed


def test_the_stresses_of_all_blocks_sum_to_the_virial_of_supports_and_weight():
    """Internal forces leave nothing but the places of the bodies they act between: sum V sigma = forces of the supports and weights."""
    pull = np.array([0.15 * GRAVITY, 0.0, -GRAVITY])
    measured = Measured(arch_like(), pull=tuple(pull), planar=False)
    stress = measured.after(1)  # the thrust of the lintel is not unique, and may go on from step to step
    assembly, made = measured.assembly, measured.machine.last
    assert made is not None
    h, rows = measured.machine.system.constants.step, made.rows
    impulse, outer = measured.machine.solution.impulse / h, np.zeros((3, 3))
    for pair in np.unique(rows.pair[(rows.blocks == 0).any(axis=1)]):
        own = rows.pair == pair  # one joint, whose forces act together where the normal ones cross it
        place = np.average(made.found.point[rows.active[own]], axis=0, weights=impulse[own, 0])
        on_free = 1.0 if rows.blocks[own][0, 1] == 0 else -1.0
        outer += on_free * np.outer(np.einsum("ci,cid->d", impulse[own], rows.frame[own]), place)
    free = ~assembly.fixed
    outer += sum(m * np.outer(pull, x) for m, x in zip(assembly.mass[free], assembly.centre[free], strict=True))
    total = (assembly.volume[free, None] * stress[free]).sum(axis=0)
    assert total == pytest.approx(symmetric(outer[None])[0], abs=1e-7 * np.abs(outer).max())
    assert np.abs(total).min() < 1e-7 * np.abs(outer).max() < 1e-2 * np.abs(total[XZ])  # it is pushed


def test_friction_that_pulls_the_corners_of_a_joint_apart_is_left_out(monkeypatch):
    """Self-balanced friction within a joint moves nothing; whatever a solver leaves of it, the stress is the same."""
    measured = Measured(tower(1), planar=False)
    before = measured.stress[1].copy()
    made, solution = measured.machine.last, measured.machine.solution
    assert made is not None
    outward = made.found.point[made.rows.active] - measured.assembly.centre[1]
    impulse = solution.impulse.copy()
    impulse[:, 1:] += 0.1 * np.einsum("cid,cd->ci", made.rows.frame[:, 1:], outward)
    measured.machine.solution = replace(solution, impulse=impulse)
    measured.record.begin()
    measured.record.take_step(measured.pair_joint())
    assert measured.record.stresses()[1] == pytest.approx(before, abs=1e-9 * np.abs(before).max())


def test_joints_carry_the_mean_force_of_the_steps():
    measured = Measured(tower(3))
    force, _ = measured.record.joint_forces()
    weight = 2000.0 * 0.5 * 0.5 * 0.25 * GRAVITY
    assert isinstance(measured.joints, Joints)
    assert sorted(force) == pytest.approx([weight, 2 * weight, 3 * weight], rel=1e-9)


def test_no_impulse_of_a_rocking_column_is_left_out():
    """The mean over all steps, impacts included, is weight and momentum of the column, less what impacts pass on without a contact."""
    steps, dt = 300, 2e-3
    shaking = still(steps)
    shaking[:, 0, 0] = 0.3 * np.sin(4 * np.pi * dt * np.arange(steps + 1)) * (np.arange(steps + 1) * dt < 0.5)
    machine = stepper(tower(4, 0.5, 0.5), steps, support_velocity=shaking, dt=dt, solver="auto")
    joints = find_joints(machine.assembly)
    record, apart, carried = MeanStress(machine, joints), 0, 0.0
    pairs = {pair: k for k, pair in enumerate(map(tuple, joint_parts(machine.assembly).tolist()))}
    for _ in range(steps):
        apart += machine.step().apart
        assert machine.last is not None
        taken = machine.last.predicted.carried_impulse
        up = machine.system.blocks.columns.tolist().index(2)
        carried += 0.0 if taken is None else float(taken[:, up].sum())
        record.take_step(np.array([pairs.get(tuple(pair), -1) for pair in machine.detector.pairs.tolist()]))
    force, _ = record.joint_forces()
    free, span = ~machine.assembly.fixed, steps * dt
    mass = machine.assembly.mass[free]
    momentum = float(mass @ machine.state.velocity[free, 2])
    assert apart > 0 and abs(carried) > 1e-5 * GRAVITY * mass.sum() * span
    assert force.max() * span + carried == pytest.approx(GRAVITY * mass.sum() * span + momentum, rel=1e-9)
    assert abs(carried) < 0.5 * apart * GRAVITY * mass.sum() * dt  # as bounded


def test_the_mean_over_an_impact_does_not_depend_on_the_time_step():
    """A block falls by 6 cm onto the ground, within the frame of 20 ms that begins after 0.1 s: all its momentum goes into that frame."""
    side, span, before = 0.5, 0.02, 0.1
    expected = -0.5 * 2000.0 * side * GRAVITY * (before + span) / span  # half of the pressure at its foot
    found, forces = [], []
    for dt in (2e-3, 1e-3, 5e-4):
        steps = round((before + span) / dt)
        machine = stepper([ground(), box("b", (-0.5, -0.5, 0.06), (0.5, 0.5, 0.06 + side))], steps, dt=dt, solver="auto")
        record, largest = MeanStress(machine, find_joints(machine.assembly)), 0.0
        for k in range(steps):
            if k == round(before / dt):
                assert not record.stresses()[1].any()  # it flies
                record.begin()
            machine.step()
            record.take_step(np.full(len(machine.detector.pairs), -1))
            largest = max(largest, float(machine.solution.impulse[:, 0].sum()) / dt)
        found.append(record.stresses()[1, ZZ])
        forces.append(largest)
    assert found == pytest.approx([expected] * 3, rel=2e-3)
    assert forces[2] > 2.0 * forces[0] > 20.0 * 2000.0 * side * GRAVITY  # of a step: it grows as steps shrink
