# SPDX-License-Identifier: GPL-3.0-or-later
"""The step against closed forms: sliding, rocking, free flight, rest, and the balance of energy."""

import numpy as np
import pytest
from models import GRAVITY, box, gravity, ground, stepper, still, tower, turned, wall
from places import EXAMPLES

from masonry_cd.app.case import prepare
from masonry_cd.app.run_loop import RunPlan, run
from masonry_cd.app.scene import read_scene
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.moreau_jean import RunStopped, Stepper
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.joints import JointPeaks, measure_joints
from masonry_cd.mechanics.model.state import State, rotation_matrices


def advance(machine: Stepper, steps: int) -> list:
    return [machine.step() for _ in range(steps)]


# --- free flight ------------------------------------------------------------------------------------------------------------------


def thrown(dt: float, seconds: float, spin: tuple[float, float, float]) -> Stepper:
    """A brick in free flight."""
    steps = round(seconds / dt)
    blocks = [ground(), box("brick", (0.0, 0.0, 50.0), (0.25, 0.12, 50.06))]
    start = State.at_rest(Assembly.from_blocks(blocks, 0.6))
    start.velocity[1] = [1.0, 2.0, 3.0, *spin]
    machine = stepper(blocks, steps, dt=dt, start=start)
    advance(machine, steps)
    return machine


def test_a_thrown_block_follows_its_parabola_exactly():
    machine = thrown(1e-2, 1.0, (0.0, 0.0, 0.0))
    moved = machine.state.position[1] - machine.assembly.centre[1]
    assert moved == pytest.approx([1.0, 2.0, 3.0 - GRAVITY / 2], rel=1e-12)


@pytest.mark.parametrize("dt", [1e-3, 1e-2, 3e-2])
def test_a_tumbling_block_keeps_its_angular_momentum_and_gains_no_energy(dt):
    spin = (0.3, 30.0, 0.1)  # about the middle axis: unstable, it tumbles
    blocks = [ground(), box("brick", (0.0, 0.0, 50.0), (0.25, 0.12, 50.06))]
    assembly = Assembly.from_blocks(blocks, 0.6)
    start = State.at_rest(assembly)
    start.velocity[1, 3:] = spin
    momentum = assembly.inertia[1] @ spin
    energy = 0.5 * np.dot(spin, momentum)
    machine = stepper(blocks, 2000, dt=dt, start=start, acceleration=np.zeros((2001, 3)))
    largest = 0.0
    for _ in range(2000):
        machine.step()
        largest = max(largest, machine.energy["kinetic"])
    turn = rotation_matrices(machine.state.orientation)[1]
    assert turn @ assembly.inertia[1] @ turn.T @ machine.state.velocity[1, 3:] == pytest.approx(momentum, rel=1e-9)
    assert np.dot(machine.state.velocity[1, 3:], turn[:, 1]) < 0.99 * 30.0 or dt > 1e-2  # it has tumbled
    assert largest < energy * (1.0 + 1e-9 + 0.05 * (30.0 * dt) ** 2)


# --- sliding ----------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("pulse", "mu", "duration", "slip"), [(0.5, 0.3, 0.2, 0.0654), (1.0, 0.4, 0.1, 0.073575), (0.6, 0.5, 0.5, 0.14715)]
)
def test_slip_under_a_rectangular_pulse(pulse, mu, duration, slip, capsys):
    errors = []
    for dt in (4e-3, 2e-3, 1e-3):
        steps = round((pulse * duration / mu + 0.1) / dt)
        velocity = still(steps)
        velocity[:, 0, 0] = pulse * GRAVITY * np.minimum(np.arange(steps + 1) * dt, duration)
        machine = stepper([ground(), box("b", (0, 0, 0), (1, 1, 0.2))], steps, friction=mu, dt=dt, support_velocity=velocity)
        advance(machine, steps)
        moved = machine.state.position - machine.assembly.centre
        errors.append(abs(moved[0, 0] - moved[1, 0] - slip))
    with capsys.disabled():
        print(f"\nslip under {pulse} g, mu {mu}: error [um] at dt 4, 2, 1 ms: " + ", ".join(f"{1e6 * e:.3f}" for e in errors), end=" ")
    assert errors[2] < 1e-6
    assert errors[2] <= errors[0] / 3 + 1e-12  # at least first order


@pytest.mark.parametrize("mu", [0.3, 0.6])
def test_a_block_on_a_slope_stays_or_slides(mu):
    angle, steps = np.radians(30.0), 1000
    pull = gravity(steps, (-GRAVITY * np.sin(angle), 0.0, -GRAVITY * np.cos(angle)))
    machine = stepper([ground(), box("b", (0, 0, 0), (1, 1, 0.2))], steps, friction=mu, acceleration=pull)
    advance(machine, steps)
    moved = machine.state.position[1] - machine.assembly.centre[1]
    expected = max(0.0, 0.5 * GRAVITY * (np.sin(angle) - mu * np.cos(angle)))
    assert -moved[0] == pytest.approx(expected, abs=1e-6)
    assert abs(moved[2]) < 1e-9  # no sinking
    assert abs(machine.state.orientation[1, 1:]).max() < 1e-9  # no tilt


# --- rocking ----------------------------------------------------------------------------------------------------------------------

ROCKING = [  # free_rocking of the reference numbers: Housner's block, restitution 1 - 1.5 sin(alpha)^2
    (0.2, 1.0, [0.34709, 0.95092, 1.48794, 1.97207], [0.42219, 0.36097, 0.31113]),
    (0.4, 1.6, [0.44167, 1.16049, 1.77042, 2.29932], [0.38671, 0.3064, 0.24606]),
]


def rock(base: float, height: float, dt: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Release a block at half its slenderness angle; impact times [s] and the peaks of |angle| / alpha after each."""
    alpha, half = np.arctan2(base, height), base / 2
    blocks = [ground(), box("b", (-half, -0.2, 0.0), (half, 0.2, height))]
    assembly = Assembly.from_blocks(blocks, 0.8)
    start = turned(assembly, 1, (0.0, 1.0, 0.0), alpha / 2, (half, 0.0, 0.0))
    steps = round(seconds / dt)
    machine = stepper(blocks, steps, friction=0.8, dt=dt, start=start)
    angle = np.empty(steps)
    for k in range(steps):
        machine.step()
        angle[k] = 2.0 * np.arctan2(machine.state.orientation[1, 2], machine.state.orientation[1, 0])
    through = np.flatnonzero(np.sign(angle[1:]) * np.sign(angle[:-1]) < 0)
    impacts = (through + 1 + angle[through] / (angle[through] - angle[through + 1])) * dt
    return impacts, np.array([np.abs(part).max() / alpha for part in np.split(angle, through + 1)[1:]])


@pytest.mark.parametrize(("base", "height", "impacts", "peaks"), ROCKING)
def test_free_rocking_follows_housner(base, height, impacts, peaks, capsys):
    late, low = [], []
    for dt in (4e-3, 1e-3, 2e-4):
        got_impacts, got_peaks = rock(base, height, dt, impacts[-1] + 0.05)
        late.append(np.abs(got_impacts[: len(impacts)] - impacts).max())
        low.append(np.abs(got_peaks[: len(peaks)] / peaks - 1.0).max())
    order = np.log(low[0] / low[2]) / np.log(20.0)
    with capsys.disabled():
        print(f"\nrocking {base} x {height} m, dt 4, 1, 0.2 ms: impacts off by [ms] " + ", ".join(f"{1e3 * x:.2f}" for x in late), end="")
        print("; peaks by [%] " + ", ".join(f"{100 * x:.2f}" for x in low) + f"; order {order:.2f}", end=" ")
    assert late[0] > late[1] > late[2]
    assert low[0] > low[1] > low[2]
    assert late[1] < 0.5e-3
    assert low[1] < 1e-3
    assert order > 0.9


# --- rest, impact, energy ---------------------------------------------------------------------------------------------------------


def test_a_blow_in_one_joint_does_not_part_others_under_thrust():
    """An arch that shakes slips by no more in a step so fine that its closing joints count as impacts than in one too coarse for that."""
    found = []
    for dt in (1e-3, 2.5e-4):
        scene = read_scene(EXAMPLES / "arch.toml", [f"run.dt={dt}", "run.duration=0.4"])
        made = prepare(scene)
        machine = Stepper(made.assembly, made.loading.support_velocity, made.loading.acceleration, scene.run)
        peaks, apart = JointPeaks(made.joints), 0
        for _ in range(scene.run.steps):
            apart += machine.step().apart
            peaks.update(measure_joints(made.joints, machine.assembly, machine.state), machine.state.time)
        found.append((peaks.opening.max(), peaks.sliding.max(), apart))
    (coarse, _, none), (fine, slip, some) = found
    assert (none, some > 0) == (0, True)
    assert fine == pytest.approx(coarse, rel=0.01)
    assert slip < 1.5e-6  # 3.4e-6 where the blow is solved without the thrust


def test_a_tower_at_rest_stays_where_it_was_built():
    machine = stepper(tower(10), 400, dt=5e-3, tolerance=1e-9, solver="auto")
    reports = advance(machine, 400)
    assert max(report.error for report in reports) <= 1e-9
    assert np.abs(machine.state.position - machine.assembly.centre).max() < 1e-8
    assert max(report.penetration for report in reports) < 1e-8


def test_a_dropped_block_lands_without_bouncing_or_sinking():
    blocks = [ground(), box("b", (0, 0, 0.05), (0.4, 0.3, 0.25))]
    machine = stepper(blocks, 400)
    advance(machine, 400)
    assert machine.state.position[1, 2] == pytest.approx(0.1, abs=1e-7)
    assert np.abs(machine.state.velocity[1]).max() < 1e-7
    lost = machine.assembly.mass[1] * GRAVITY * 0.05
    assert machine.energy["impact"] == pytest.approx(lost, rel=1e-6)


def shaken_wall(steps: int, **settings: object) -> Stepper:
    velocity = still(steps)
    velocity[:, 0, 0] = 0.4 * np.sin(2 * np.pi * 5.0 * np.arange(steps + 1) * 1e-3)
    return stepper(wall(2, 3), steps, support_velocity=velocity, **({"tolerance": 1e-7, "max_iterations": 2000} | settings))


def test_the_energy_balance_closes_while_joints_open_and_slide():
    machine = shaken_wall(200)
    advance(machine, 200)
    e = machine.energy
    assert e["friction"] > 0.1 * e["base_work"] > 0
    assert abs(e["balance"]) < 1e-9 * e["base_work"]
    moved = machine.state.position - machine.assembly.centre
    free = ~machine.assembly.fixed
    assert e["gravity_work"] == pytest.approx(-GRAVITY * machine.assembly.mass[free] @ moved[free, 2], rel=1e-9)


def test_the_same_seed_gives_the_same_bits():
    ends = []
    for seed in (0, 0, 1):
        machine = shaken_wall(60, seed=seed)
        advance(machine, 60)
        ends.append(machine.state.position.tobytes() + machine.state.velocity.tobytes())
    assert ends[0] == ends[1] != ends[2]


@pytest.mark.parametrize("law", [None, JointLaw(normal_stiffness=1e10, cohesion=2e4)], ids=["rigid", "mortar"])
def test_asking_for_the_friction_problem_changes_nothing_and_a_step_keeps_what_was_before(law):
    """A stepper that is asked before each step solves what it answered, and goes on to the bits of one that is not."""
    joints = None if law is None else {"default": law}
    asked, alone = (shaken_wall(30, joints=joints) for _ in range(2))
    for _ in range(30):
        before, held = snapshot(asked), asked.state
        kept = held.copy()
        answer = asked.friction_problem().problem
        assert snapshot(asked) == before
        asked.step()
        alone.step()
        for array in ("inverse_mass", "v_free", "bodies", "jacobian", "offset", "mu", "compliance"):
            assert getattr(answer, array).tobytes() == getattr(asked.last.problem, array).tobytes()
        assert (held.position == kept.position).all()
        assert (held.velocity == kept.velocity).all()
    assert answer.contacts > 0
    assert answer.compliance.any() == (law is not None)
    assert np.abs(asked.state.velocity[1:]).max() > 0.01
    assert snapshot(asked) == snapshot(alone)


def snapshot(machine: Stepper) -> dict[str, bytes]:
    return {name: array.tobytes() for name, array in machine.snapshot().items()}


def test_a_missed_tolerance_is_counted(tmp_path):
    machine = shaken_wall(5, max_iterations=2)
    joints = find_joints(machine.assembly)
    with ResultWriter(tmp_path / "r.h5", machine.assembly, joints) as writer:
        report = run(machine, joints, writer, RunPlan(5))
    assert report.steps_missed == 5
    assert report.error_max > 1e-7


def test_a_run_that_blows_up_names_step_and_block_and_keeps_what_it_had(tmp_path):
    steps = 20
    pull = gravity(steps)
    pull[11] = np.nan
    machine = stepper(tower(2), steps, acceleration=pull)
    joints = find_joints(machine.assembly)
    with ResultWriter(tmp_path / "r.h5", machine.assembly, joints) as writer:
        report = run(machine, joints, writer, RunPlan(steps))
    assert report.stopped.startswith('step 11: the velocity of block "b0" is not finite; the impulse of a contact between')
    assert report.steps == 10
    with Results.open(tmp_path / "r.h5") as results:
        assert results.time[-1] == pytest.approx(0.010)
    with pytest.raises(RunStopped):
        machine.step()


def test_the_rotation_of_a_free_spin_is_exact():
    machine = thrown(1e-3, 0.5, (0.0, 0.0, 7.0))  # about a principal axis
    angle = 3.5
    expected = [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    assert rotation_matrices(machine.state.orientation)[1] == pytest.approx(np.array(expected), abs=1e-9)


def test_overlaps_are_taken_away_without_feeding_motion():
    blocks = tower(3)
    assembly = Assembly.from_blocks(blocks, 0.6)
    start = State.at_rest(assembly)
    start.position[1:, 2] -= 1e-3 * np.arange(1, 4)  # every joint overlaps by 1 mm
    machine = stepper(blocks, 100, start=start)
    reports = advance(machine, 100)
    assert reports[0].penetration == pytest.approx(1e-3)
    assert reports[-1].penetration < 3e-7  # what is allowed, a millionth of the width
    assert machine.energy["kinetic"] < 1e-8 * machine.energy["correction"]
    assert machine.energy["correction"] == pytest.approx(GRAVITY * machine.assembly.mass[1:] @ (1e-3 * np.arange(1, 4)), rel=1e-3)


def test_what_the_solver_learnt_of_impacts_lasts_until_the_next_ones_and_is_resumed():
    steps = 180
    velocity = still(steps)
    velocity[:, 0, 0] = 0.6 * np.sin(2 * np.pi * 2.0 * np.arange(steps + 1) * 1e-3)
    make = {"support_velocity": velocity, "solver": "auto", "tolerance": 1e-8}
    first, second = (stepper(tower(4), steps, **make) for _ in range(2))
    while not first.step().apart:
        pass
    second.restore({name: array.copy() for name, array in first.snapshot().items()})
    for machine in (first, second):
        assert machine.step().apart
        assert machine.snapshot()["islands/impacts 0 steps"][0] == 2.0  # impacts solved so far
    assert first.state.velocity.tobytes() == second.state.velocity.tobytes()


# --- falls ------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lean", [0.02, -0.02])
def test_a_cube_on_its_edge_falls_onto_a_face(lean):
    blocks = [ground(), box("b", (0.0, -0.2, 0.0), (0.4, 0.2, 0.4))]
    start = turned(Assembly.from_blocks(blocks, 0.6), 1, (0.0, 1.0, 0.0), -np.pi / 4 + lean, (0.0, 0.0, 0.0))
    machine = stepper(blocks, 1500, start=start)
    deepest = max(report.penetration for report in advance(machine, 1500))
    turn = rotation_matrices(machine.state.orientation)[1]
    assert np.abs(turn).max(axis=0) == pytest.approx(np.ones(3), abs=1e-6)  # on a face
    assert turn[0, 0] == pytest.approx(1.0 if lean > 0 else 0.0, abs=1e-6)  # and on the one towards which it leant
    assert machine.state.position[1, 2] == pytest.approx(0.2, abs=1e-6)
    assert np.abs(machine.state.velocity[1]).max() < 1e-6
    assert deepest < 1e-4 * 0.4


def test_debris_lands_and_stays():
    rng = np.random.default_rng(5)
    pieces = [
        box(f"d{k}", (x, y, 0.2 + 0.3 * k), (x + 0.3, y + 0.2, 0.35 + 0.3 * k)) for k, (x, y) in enumerate(rng.uniform(-0.1, 0.1, (6, 2)))
    ]
    blocks = [ground(), *pieces]
    start = State.at_rest(Assembly.from_blocks(blocks, 0.6))
    spins = rng.normal(size=(6, 4))
    start.orientation[1:] = spins / np.linalg.norm(spins, axis=1)[:, None]
    machine = stepper(blocks, 5000, dt=2e-3, start=start, solver="auto", tolerance=1e-8)
    reports, width = advance(machine, 500), 0.15
    while len(reports) < 5000 and machine.energy["kinetic"] > 1e-12 * machine.energy["impact"]:  # they tumble as long as rounding has it
        reports += advance(machine, 100)
    before = machine.state.position.copy()
    reports += advance(machine, 100)
    assert max(report.penetration for report in reports[-100:]) < 1e-4 * width  # an overlap of less than 1e-4 of the volume
    assert machine.energy["kinetic"] < 1e-9 * machine.energy["impact"]
    assert np.abs(machine.state.position - before).max() < 1e-7 * width  # at rest
    lowest = [(b.vertices - machine.assembly.centre[k]) @ rotation_matrices(machine.state.orientation)[k].T for k, b in enumerate(blocks)]
    feet = [machine.state.position[k, 2] + part[:, 2].min() for k, part in enumerate(lowest)][1:]
    assert min(feet) > -1e-4 * width  # none has sunk in


def test_a_speed_whose_energy_overflows_names_its_block():
    machine = stepper([ground(), box("calm", (0, 0, 0), (1, 1, 1)), box("mad", (2, 2, 3), (3, 3, 4))], 2)
    velocity = np.zeros((3, 6))
    velocity[2, 0] = 1e200
    with np.errstate(all="ignore"):
        machine.kick(velocity)
        with pytest.raises(RunStopped, match=r'^step 1: the velocity of block "mad" is too large for a finite energy'):
            machine.step()
