# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic and bonded joints: frequencies, energy, order, slip, strength, and the rigid limit."""

from dataclasses import replace

import numpy as np
import pytest
from block_on_joint import AREA, HEIGHT, MASS, SIDES, STIFFNESS, block, history, on_joint
from models import GRAVITY, advance, box, gravity, ground, stepper, still, tower, turned, wall

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.mechanics.model.state import State, rotation_matrices


def on_spring(dt: float, steps: int, kick: dict[int, float] | None = None, planar: bool = True, **law: float) -> Stepper:
    """A block in equilibrium on an elastic joint, with a velocity to begin with."""
    joints = {"default": JointLaw(**({"normal_stiffness": STIFFNESS, "theta": 0.5} | law))}
    return on_joint(dt, steps, joints, kick or {}, planar=planar)


# --- areas ------------------------------------------------------------------------------------------------------------------------


def prism(name: str, corners: np.ndarray, low: float, high: float) -> Block:
    """An upright prism over a convex polygon (n, 2), counter-clockwise."""
    n = len(corners)
    vertices = np.array([[*corner, z] for z in (low, high) for corner in corners])
    sides = [(i, (i + 1) % n, n + (i + 1) % n, n + i) for i in range(n)]
    return Block(name, vertices, (tuple(range(n))[::-1], tuple(range(n, 2 * n)), *sides), 2000.0)


def contacts_of(corners: np.ndarray) -> ContactSet:
    """The contacts of an elastic prism on the ground."""
    material = Material(friction=0.6, joints={"default": JointLaw(normal_stiffness=1e9)})
    assembly = Assembly.from_blocks([ground(2.0), prism("p", corners, 0.0, 0.5)], material)
    state = State.at_rest(assembly)
    return Detector(assembly).detect(state.position, rotation_matrices(state.orientation), np.zeros((2, 6)), 1e-3, 0.0, np.zeros(3))


def moments(corners: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """Area, centroid and second moments about it of a polygon (n, 2), by the midpoints of the sides of a fan of triangles."""
    a, b, c = np.broadcast_to(corners[0], (len(corners) - 2, 2)), corners[1:-1], corners[2:]
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    points, weight = np.concatenate([0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]), np.tile(area / 3.0, 3)
    centroid = weight @ points / weight.sum()
    return weight.sum(), centroid, np.einsum("q,qi,qj->ij", weight, points - centroid, points - centroid)


RECTANGLE = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 0.3], [0.0, 0.3]])
SLANTED = RECTANGLE @ np.array([[1.0, 0.0], [0.4, 1.0]])
TRIANGLE = np.array([[0.0, 0.0], [0.7, 0.1], [0.2, 0.5]])
HEXAGON = 0.4 * np.column_stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3)])
ODD = np.array([[0.0, 0.0], [0.6, 0.05], [0.7, 0.3], [0.3, 0.5], [0.05, 0.4]])


@pytest.mark.parametrize(
    ("corners", "exact"), [(RECTANGLE, True), (SLANTED, True), (TRIANGLE, True), (HEXAGON, True), (ODD, False), (ODD[:4], False)]
)
def test_areas_of_contact_points_bend_and_twist_like_the_joint(corners, exact):
    contacts = contacts_of(corners)
    area, centroid, second = moments(corners)
    assert len(contacts.gap) == len(corners) + 1
    assert contacts.area.min() > 0.0
    assert contacts.area.sum() == pytest.approx(area, rel=1e-12)
    arm = contacts.point[:, :2] - centroid
    assert contacts.area @ arm == pytest.approx([0.0, 0.0], abs=1e-14)
    got = np.einsum("c,ci,cj->ij", contacts.area, arm, arm)
    assert np.trace(got) == pytest.approx(np.trace(second), rel=1e-12)
    assert got == pytest.approx(second, rel=1e-12 if exact else 0.1, abs=1e-14 if exact else 0.02 * np.trace(second))


def test_a_corner_of_a_rectangle_has_a_twelfth():
    assert sorted(contacts_of(RECTANGLE).area / AREA) == pytest.approx([1 / 12] * 4 + [2 / 3], rel=1e-12)


def test_rigid_joints_have_corners_only():
    assembly = Assembly.from_blocks(block(), Material(friction=0.6, joints={"block-block": JointLaw(normal_stiffness=1e9)}))
    state = State.at_rest(assembly)
    found = Detector(assembly).detect(state.position, rotation_matrices(state.orientation), np.zeros((2, 6)), 1e-3, 0.0, np.zeros(3))
    assert len(found.gap) == 4
    assert not found.area.any()


# --- vibration --------------------------------------------------------------------------------------------------------------------


def frequency(values: np.ndarray, dt: float) -> float:
    """Return the frequency by the times at which a free vibration passes through zero [Hz]."""
    at = np.flatnonzero(values[1:] * values[:-1] < 0.0)
    when = at + values[at] / (values[at] - values[at + 1])
    return 0.5 * (len(when) - 1) / ((when[-1] - when[0]) * dt)


@pytest.mark.parametrize("planar", [True, False])
def test_a_block_swings_on_its_joint_as_the_scheme_says(planar):
    """theta = 1/2 is the trapezoidal rule: tan(omega h / 2) = omega_0 h / 2, and no energy is lost."""
    dt, steps = 1e-3, 500
    machine = on_spring(dt, steps, {2: 1e-3}, planar)
    omega = np.sqrt(STIFFNESS * AREA / MASS)
    got = frequency(history(machine, steps, 2), dt)
    assert got == pytest.approx(2.0 / dt * np.arctan(0.5 * omega * dt) / (2.0 * np.pi), rel=1e-5)
    at_start = 0.5 * MASS * 1e-6 + 0.5 * (MASS * GRAVITY) ** 2 / (STIFFNESS * AREA)
    assert abs(machine.energy["damping"]) < 1e-9 * at_start
    assert abs(machine.energy["balance"]) < 1e-9 * at_start


def test_theta_damps_a_mode_by_its_share_of_the_step():
    """Damping ratio (2 theta - 1) omega h / 2."""
    dt, steps, theta = 2e-4, 3000, 0.6
    velocity = history(on_spring(dt, steps, {2: 1e-3}, theta=theta), steps, 2)
    omega = np.sqrt(STIFFNESS * AREA / MASS)
    peaks = np.abs(velocity[: 2 * (steps // 2)]).reshape(2, -1).max(axis=1)  # of either half
    decay = np.log(peaks[0] / peaks[1]) / (0.5 * steps * dt * omega)
    assert decay == pytest.approx((2.0 * theta - 1.0) * 0.5 * omega * dt, rel=0.05)


def test_the_scheme_is_of_second_order():
    """Against the exact swing of a block in equilibrium that gets a kick."""
    omega, end, errors = np.sqrt(STIFFNESS * AREA / MASS), 0.016, []
    for dt in (1e-3, 5e-4, 2.5e-4):
        machine = on_spring(dt, round(end / dt), {2: 1e-3})
        history(machine, round(end / dt), 2)
        sunk = machine.assembly.centre[1, 2] - MASS * GRAVITY / (STIFFNESS * AREA)
        errors.append(abs(machine.state.position[1, 2] - sunk - 1e-3 / omega * np.sin(omega * end)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.05)


@pytest.mark.parametrize(("column", "width", "planar"), [(4, 0.5, True), (4, 0.5, False), (3, 0.3, False)])
def test_rocking_has_the_stiffness_of_the_whole_joint(column, width, planar):
    """Four springs at the corners would rock stiffer by sqrt(3). Rocking and shear make two modes of one plane."""
    dt, steps, tangential = 2e-4, 8000, STIFFNESS / 2.4
    machine = on_spring(dt, steps, {column: 1e-4}, planar)
    inertia, arm = machine.assembly.inertia[1, column - 3, column - 3], 0.5 * HEIGHT
    weight = STIFFNESS * AREA * width**2 / 12 - MASS * GRAVITY * arm  # the weight above the joint softens its rocking
    shear = tangential * AREA
    matrix = np.array([[shear, shear * arm], [shear * arm, weight + shear * arm**2]])
    modes = np.sort(np.sqrt(np.linalg.eigvals(np.linalg.solve(np.diag([MASS, inertia]), matrix)))) / (2 * np.pi)
    spectrum = np.abs(np.fft.rfft(history(machine, steps, column) * np.hanning(steps), 16 * steps))
    at = np.fft.rfftfreq(16 * steps, dt)
    for mode in modes:
        near = np.abs(at - mode) < 3.0
        assert at[near][spectrum[near].argmax()] == pytest.approx(mode, rel=5e-3)


def test_twisting_has_the_stiffness_of_the_whole_joint():
    dt, steps = 2e-4, 4000
    machine = on_spring(dt, steps, {5: 1e-4}, planar=False)
    polar = AREA * (SIDES[0] ** 2 + SIDES[1] ** 2) / 12
    expected = np.sqrt(STIFFNESS / 2.4 * polar / machine.assembly.inertia[1, 2, 2]) / (2 * np.pi)
    assert frequency(history(machine, steps, 5), dt) == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("theta", [0.5, 0.6, 1.0])
def test_no_spring_bounces_higher_than_it_fell(theta):
    """Whatever the stiffness and the moment of contact within the step; a stiff spring lands like a rigid joint."""
    for stiffness in (1e6, 1e8, 1e10, 1e13):
        for above in (1.00e-3, 1.03e-3, 1.06e-3):
            machine = stepper(block(above=above), 60, joints={"default": JointLaw(normal_stiffness=stiffness, theta=theta)})
            fall = MASS * GRAVITY * above
            for _ in range(60):
                machine.step()
                energy = machine.energy
                assert energy["kinetic"] + energy["elastic"] <= energy["gravity_work"] + 1e-9 * fall
                assert abs(energy["balance"]) < 1e-9 * fall
            if stiffness == 1e13:
                assert energy["kinetic"] < 0.01 * fall


# --- rest and the rigid limit -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stiffness", [1e9, 1e13])
def test_a_wall_stands_at_large_steps_whatever_its_stiffness(stiffness):
    machine = stepper(wall(3, 4), 100, dt=1e-2, joints={"default": JointLaw(normal_stiffness=stiffness)}, tolerance=1e-9)
    assert settle(machine) > 0
    rest = machine.state.position.copy()
    weight = MASS / 0.06 * 0.16 * 0.2 * GRAVITY * 4  # bounds the load on a unit
    assert np.abs(rest - machine.assembly.centre).max() < 4 * weight / (stiffness * 0.04)
    reports = [machine.step() for _ in range(100)]
    solved = 100 * 1e-9 * GRAVITY * 1e-2**2  # what the tolerance leaves of the motion, step by step
    assert np.abs(machine.state.position - rest).max() < 1e-3 * np.abs(rest - machine.assembly.centre).max() + solved
    assert max(report.penetration for report in reports) == 0.0  # shortened joints are no overlaps


def test_the_weight_at_once_makes_it_swing_about_the_settled_state():
    """Without settling the deflection comes to twice the static one."""
    joints = {"default": JointLaw(normal_stiffness=STIFFNESS, theta=0.5)}
    static = MASS * GRAVITY / (STIFFNESS * AREA)
    settled, sudden = (stepper(block(), 40, joints=joints) for _ in range(2))
    settle(settled)
    assert settled.assembly.centre[1, 2] - settled.state.position[1, 2] == pytest.approx(static, rel=1e-5)
    lowest = min(sudden.step() and sudden.state.position[1, 2] for _ in range(40))
    assert sudden.assembly.centre[1, 2] - lowest == pytest.approx(2 * static, rel=0.01)


def test_what_has_settled_carries_its_weight_before_the_first_step():
    machine = stepper(block(), 1, joints={"default": JointLaw(normal_stiffness=STIFFNESS)})
    settle(machine)
    force, _ = machine.joint_forces(np.zeros(1, dtype=np.int64), 1)
    assert force[0, 0] == pytest.approx(MASS * GRAVITY, rel=1e-6)


def test_a_tall_stack_settles_to_its_closed_form():
    """Its slowest swing is 190 times as long as that of a block: in steps that each begin from rest it would creep."""
    count, side, stiffness = 300, 0.2, 1e11
    stack = [box(f"b{i}", (-side / 2, -side / 2, i * side), (side / 2, side / 2, (i + 1) * side)) for i in range(count)]
    machine = stepper([ground(), *stack], 1, joints={"default": JointLaw(normal_stiffness=stiffness)}, tolerance=1e-8)
    assert settle(machine) < 150
    weight = machine.assembly.mass[1] * GRAVITY / (stiffness * side**2)
    shortening = weight * np.cumsum(np.arange(count, 0, -1))
    assert (machine.assembly.centre - machine.state.position)[1:, 2] == pytest.approx(shortening, rel=1e-4)


def test_what_cannot_settle_is_reported():
    leaning = [ground(2.0), box("low", (-0.2, -0.2, 0.0), (0.2, 0.2, 0.2)), box("high", (0.05, -0.2, 0.2), (0.85, 0.2, 0.4))]
    machine = stepper(leaning, 10, joints={"default": JointLaw(normal_stiffness=1e9)})
    with pytest.raises(InputError, match=r'run\.settle: block "high" does not come to rest'):
        settle(machine)


def test_weight_beyond_all_numbers_is_reported():
    machine = stepper(block(), 1, joints={"default": JointLaw(normal_stiffness=1e9)}, acceleration=np.full((2, 3), np.nan))
    with pytest.raises(InputError, match=r'run\.settle: step 1: the velocity of block "b" is not finite; .*settle = false starts the run'):
        settle(machine)


def test_stiff_joints_slip_like_rigid_ones():
    """A rectangular pulse of 0.5 g, friction 0.3, 0.2 s: the closed form is 65.4 mm."""
    dt, steps = 1e-3, 500
    velocity = still(steps)
    velocity[:, 0, 0] = 0.5 * GRAVITY * np.minimum(np.arange(steps + 1) * dt, 0.2)
    joints = {"default": JointLaw(normal_stiffness=1e12)}
    machine = stepper(block(0.1), steps, friction=0.3, joints=joints, support_velocity=velocity)
    advance(machine, steps)
    moved = machine.state.position - machine.assembly.centre
    assert moved[0, 0] - moved[1, 0] == pytest.approx(0.0654, rel=1e-3)
    assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["base_work"]


def test_stiff_joints_rock_like_rigid_ones():
    """Time to the first impact of a block released at half its slenderness, and the height of the next peak."""
    base, height, steps = 0.2, 1.0, 700
    blocks = [ground(), box("b", (-0.1, -0.2, 0.0), (0.1, 0.2, height))]
    assembly = Assembly.from_blocks(blocks, 0.8)
    alpha = np.arctan2(base, height)
    start = turned(assembly, 1, (0.0, 1.0, 0.0), 0.5 * alpha, (0.1, 0.0, 0.0))
    machine = stepper(blocks, steps, friction=0.8, start=start, joints={"default": JointLaw(normal_stiffness=1e12)})
    angle = np.empty(steps)
    for k in range(steps):
        machine.step()
        angle[k] = 2.0 * np.arctan2(machine.state.orientation[1, 2], machine.state.orientation[1, 0])
    hit = np.flatnonzero(angle < 0.0)[0] * 1e-3
    assert hit == pytest.approx(0.34709, abs=2e-3)
    assert -angle.min() / alpha == pytest.approx(0.42219, rel=0.05)


# --- friction and strength --------------------------------------------------------------------------------------------------------


def pushed(steps: int, factor: np.ndarray, **law: float) -> Stepper:
    """A flat block under its weight and a horizontal share of it, a factor (N + 1,), through the plane of its joint."""
    pull = gravity(steps)
    pull[:, 0] = GRAVITY * factor
    planar = law.pop("planar", True)
    return stepper(block(0.004), steps, friction=0.5, joints={"default": JointLaw(**law)}, acceleration=pull, planar=bool(planar))


def ramp(steps: int, top: float) -> np.ndarray:
    return top * np.minimum(1.0, np.arange(steps + 1) / (0.5 * steps))


@pytest.mark.parametrize("planar", [True, False])
def test_a_joint_sticks_elastically_below_its_friction_and_slips_above(planar):
    steps, weight = 300, 2000.0 * 0.004 * GRAVITY  # weight per area [Pa]
    below, above = (pushed(steps, ramp(steps, top), normal_stiffness=1e9, planar=planar) for top in (0.49, 0.52))
    for machine in (below, above):
        settle(machine)
        advance(machine, steps)
    stuck, slipped = (m.state.position[1, 0] - m.assembly.centre[1, 0] for m in (below, above))
    assert stuck == pytest.approx(0.49 * weight / (1e9 / 2.4), rel=0.02)
    assert slipped > 1e3 * stuck
    assert below.energy["friction"] < 1e-3 * above.energy["friction"]


@pytest.mark.parametrize("stiffness", [None, 1e10])
@pytest.mark.parametrize("planar", [True, False])
def test_cohesion_holds_a_shear_up_to_its_strength_and_not_a_second_time(stiffness, planar):
    """Cohesion 500 Pa on a weight of 78 Pa: mu W + c A is 6.87 W."""
    steps = 400
    strength = 0.5 + 500.0 / (2000.0 * 0.004 * GRAVITY)
    law = {"normal_stiffness": stiffness, "cohesion": 500.0, "planar": planar}
    holds = pushed(steps, ramp(steps, 0.97 * strength), **law)
    breaks = pushed(steps, ramp(steps, 1.03 * strength), **law)
    for machine in (holds, breaks):
        advance(machine, steps)
    assert abs(holds.state.position[1, 0]) < 1e-6
    assert breaks.state.position[1, 0] > 1e-3
    pair_joint, joints = np.zeros(1, dtype=np.int64), find_joints(holds.assembly)
    assert holds.joint_bonds(pair_joint, joints) == pytest.approx([1.0], rel=1e-6)
    assert breaks.joint_bonds(pair_joint, joints) == [0.0]
    again = pushed(steps, np.where(np.arange(steps + 1) < 250, ramp(steps, 1.03 * strength), 0.6), **law)
    advance(again, steps)
    assert again.state.velocity[1, 0] > breaks.state.velocity[1, 0] * 0.1  # friction alone does not stop it at 0.6 g
    assert again.joint_bonds(pair_joint, joints) == [0.0]


@pytest.mark.parametrize(("stiffness", "tension"), [(None, None), (1e9, None), (1e9, 3000.0)])
@pytest.mark.parametrize("planar", [True, False])
def test_a_bond_holds_a_pull_up_to_its_strength_and_breaks_for_good(stiffness, tension, planar):
    strength = tension or 2500.0 / 0.5
    steps, area_weight = 300, 2000.0 * HEIGHT * GRAVITY
    heights = []
    for share in (0.97, 1.03):
        top = share * strength / area_weight + 1.0  # net pull over weight
        time = np.arange(steps + 1) / steps
        pull = gravity(steps)
        pull[:, 2] = GRAVITY * np.interp(time, [0.0, 0.5, 0.55, 0.6, 1.0], [-1.0, top - 1.0, top - 1.0, -1.0, -1.0])
        law = JointLaw(normal_stiffness=stiffness, cohesion=2500.0, tension=tension)
        machine = stepper(block(), steps, friction=0.5, joints={"default": law}, acceleration=pull, planar=planar)
        highest = 0.0
        for _ in range(steps):
            machine.step()
            highest = max(highest, machine.state.position[1, 2] - machine.assembly.centre[1, 2])
        heights.append(highest)
        assert machine.motion.joints.bonded.any() == (share < 1.0)
    assert heights[0] <= 1.1 * strength / (stiffness or np.inf) + 1e-9
    assert heights[1] > 1e-4


@pytest.mark.parametrize("planar", [True, False])
def test_a_joint_bends_up_to_the_tensile_strength_at_its_edge(planar):
    """M = (f_t + N / A) A d / 6, from a slowly growing push on the block's centre; then it is dry, all of it, and stands by its weight."""
    tension, steps = 2e3, 800
    moment = (tension + MASS * GRAVITY / AREA) * AREA * SIDES[0] / 6
    share = moment / (MASS * GRAVITY * 0.5 * HEIGHT)
    bonded = []
    for factor in (0.98, 1.02):
        law = JointLaw(normal_stiffness=1e9, cohesion=1e5, tension=tension)
        pull = gravity(steps)
        pull[:, 0] = GRAVITY * ramp(steps, factor * share)
        machine = stepper(block(), steps, friction=0.5, joints={"default": law}, acceleration=pull, planar=planar)
        settle(machine)
        advance(machine, steps)
        bonded.append(int(machine.motion.joints.bonded.sum()))
    assert bonded == [len(machine.last.rows.active), 0]


def test_a_joint_that_broke_rests_dry():
    """Lifted off and put back on, a block slides at its friction as if there had never been mortar."""
    steps = 600
    pull = gravity(steps)
    pull[:4, 2] = 3.0 * GRAVITY
    pull[300:, 0] = 0.6 * GRAVITY
    machine = stepper(block(), steps, friction=0.5, joints={"default": JointLaw(normal_stiffness=1e9, cohesion=1e3)}, acceleration=pull)
    speed = history(machine, steps, 0)
    assert not machine.motion.joints.bonded.any()
    assert speed[-1] - speed[-101] == pytest.approx(0.1 * (0.6 - 0.5) * GRAVITY, rel=0.01)


def test_a_mortar_wall_stays_bonded_through_a_shake_that_moves_a_dry_one():
    steps = 200
    velocity = still(steps)
    velocity[:, 0, 0] = 0.4 * np.sin(2 * np.pi * 5.0 * np.arange(steps + 1) * 1e-3)
    law = {"normal_stiffness": 1e10}
    dry, mortar = (
        stepper(wall(2, 3), steps, support_velocity=velocity, joints={"default": JointLaw(**law, cohesion=c)}, tolerance=1e-7)
        for c in (0.0, 3e5)
    )
    for machine in (dry, mortar):
        settle(machine)
        advance(machine, steps)
    moved = [np.abs((m.state.position - m.state.position[0]) - (m.assembly.centre - m.assembly.centre[0])).max() for m in (dry, mortar)]
    assert moved[0] > 1e-3 > 20 * moved[1]
    assert mortar.motion.joints.bonded.sum() == len(mortar.last.rows.active)
    for machine in (dry, mortar):
        assert abs(machine.energy["balance"]) < 1e-9 * (machine.energy["base_work"] + machine.energy["elastic"])


def test_a_resumed_stepper_continues_to_the_same_bits():
    steps = 120
    velocity = still(steps)
    velocity[:, 0, 0] = 0.6 * np.sin(2 * np.pi * 8.0 * np.arange(steps + 1) * 1e-3)
    make = {"support_velocity": velocity, "joints": {"default": JointLaw(normal_stiffness=1e10, cohesion=2e4)}, "tolerance": 1e-6}
    first = stepper(wall(2, 3), steps, **make)
    settle(first)
    advance(first, 60)
    assert 0 < first.motion.joints.bonded.sum() < len(first.last.rows.active)  # amid the breaking
    saved = {name: array.copy() for name, array in first.snapshot().items()}
    second = stepper(wall(2, 3), steps, **make)
    second.restore(saved)
    for machine in (first, second):
        advance(machine, 60)
    assert first.state.position.tobytes() == second.state.position.tobytes()
    assert first.energy == second.energy


def test_a_dry_stone_lands_on_mortar_with_impacts_and_springs_in_one_step():
    """The stone's contact is rigid, those below are springs with bonds: what it loses is booked, and no step gains energy."""
    stone = replace(box("stone", (0.05, -0.25, 0.51), (0.35, 0.25, 0.61)), group="stone")
    law = JointLaw(normal_stiffness=5e9, cohesion=1e6)
    ends = []
    for planar in (True, False):
        joints = {"block-block": law, "base-block": law}
        machine = stepper([*tower(2), stone], 150, joints=joints, planar=planar, solver="auto", tolerance=1e-8)
        energies = []
        for _ in range(150):
            machine.step()
            energies.append(machine.energy["kinetic"] + machine.energy["elastic"] - machine.energy["gravity_work"])
        fall = 2000.0 * 0.3 * 0.5 * 0.1 * GRAVITY * 0.01
        assert machine.energy["impact"] > 0.5 * fall
        assert np.diff(energies).max() < 1e-3 * fall
        assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["gravity_work"]
        assert machine.state.position[3, 2] == pytest.approx(0.55, abs=1e-5)
        ends.append(machine.state.position.copy())
    assert ends[0] == pytest.approx(ends[1], abs=1e-7)
