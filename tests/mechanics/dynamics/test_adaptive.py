# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps that adapt against closed forms, and against the rules that they rest on."""

import numpy as np
import pytest
from models import GRAVITY, box, gravity, ground, stepper, still, tower, turned, wall

from masonry_cd.mechanics.dynamics.adaptive import AdaptiveSteps
from masonry_cd.mechanics.dynamics.local_error import base_drift
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.system import RunLoads
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.state import State

LONGEST, TICK = 1e-2, 1e-2 / 32
AUTO = {"dt": "auto", "dt_max": LONGEST}


def advance(machine: Stepper, ticks: int, room: int = 10**6) -> list:
    pace, steps = AdaptiveSteps(machine), []
    while machine.load_step < ticks:
        steps.append(pace.step(min(room, ticks - machine.load_step)))
    return steps


def test_a_thrown_block_follows_its_parabola_exactly_in_long_steps():
    blocks, ticks = [ground(), box("brick", (0.0, 0.0, 50.0), (0.25, 0.12, 50.06))], 3200
    start = State.at_rest(Assembly.from_blocks(blocks, 0.6))
    start.velocity[1, :3] = [0.1, 0.2, 0.3]
    machine = stepper(blocks, ticks, start=start, **AUTO)
    steps = advance(machine, ticks)
    moved = machine.state.position[1] - machine.assembly.centre[1]
    assert machine.state.time == 1.0
    assert moved == pytest.approx([0.1, 0.2, 0.3 - GRAVITY / 2], rel=1e-11)
    assert steps[-1].span == 4  # no step takes it farther than a quarter of its width, 15 mm, at 9.5 m/s
    assert max(step.span for step in steps) == 32
    assert machine.energy["balance"] == pytest.approx(0.0, abs=1e-9 * machine.energy["gravity_work"])


@pytest.mark.parametrize(
    ("pulse", "mu", "duration", "slip"), [(0.5, 0.3, 0.2, 0.0654), (1.0, 0.4, 0.1, 0.073575), (0.6, 0.5, 0.5, 0.14715)]
)
def test_slip_under_a_rectangular_pulse_in_a_fifth_of_the_steps(pulse, mu, duration, slip):
    ticks = round((pulse * duration / mu + 0.6) / TICK)
    velocity = still(ticks)
    velocity[:, 0, 0] = pulse * GRAVITY * np.minimum(np.arange(ticks + 1) * TICK, duration)
    machine = stepper(
        [ground(), box("b", (0, 0, 0), (1, 1, 0.2))], ticks, friction=mu, support_velocity=velocity, dt_tolerance=1e-5, **AUTO
    )
    steps = advance(machine, ticks)
    moved = machine.state.position - machine.assembly.centre
    assert moved[0, 0] - moved[1, 0] == pytest.approx(slip, abs=2e-5)
    assert len(steps) < 0.2 * ticks * TICK / 1e-3  # of steps of 1 ms


def rocking(tolerance: float) -> tuple[int, float, float]:
    """Free rocking of Housner's block 0.2 x 1.0 m: steps, largest error of the impact times [s] and of the peaks [-]."""
    impacts, peaks = np.array([0.34709, 0.95092, 1.48794, 1.97207]), np.array([0.42219, 0.36097, 0.31113])
    blocks, alpha = [ground(), box("b", (-0.1, -0.2, 0.0), (0.1, 0.2, 1.0))], np.arctan2(0.2, 1.0)
    start = turned(Assembly.from_blocks(blocks, 0.8), 1, (0.0, 1.0, 0.0), alpha / 2, (0.1, 0.0, 0.0))
    ticks = 6464  # 2.02 s
    machine = stepper(blocks, ticks, friction=0.8, start=start, dt_tolerance=tolerance, **AUTO)
    pace, time, angle = AdaptiveSteps(machine), [], []
    while machine.load_step < ticks:
        pace.step(ticks - machine.load_step)
        time.append(machine.state.time)
        angle.append(2.0 * np.arctan2(machine.state.orientation[1, 2], machine.state.orientation[1, 0]))
    t, a = np.array(time), np.array(angle)
    through = np.flatnonzero(np.sign(a[1:]) * np.sign(a[:-1]) < 0)
    got = t[through] + (t[through + 1] - t[through]) * a[through] / (a[through] - a[through + 1])
    highest = np.array([np.abs(part).max() / alpha for part in np.split(a, through + 1)[1:-1]])
    return len(time), float(np.abs(got[:4] - impacts).max()), float(np.abs(highest[:3] / peaks - 1.0).max())


def test_free_rocking_follows_housner_with_less_than_half_of_the_steps(capsys):
    found = [rocking(tolerance) for tolerance in (1e-4, 3e-6)]
    with capsys.disabled():
        print("\nrocking, tolerance 100, 3 um: " + "; ".join(f"{n} steps, {1e3 * t:.2f} ms, {100 * p:.2f} %" for n, t, p in found), end=" ")
    steps, late, low = found[1]
    assert late < 0.9e-3 and low < 0.93e-3  # what 1010 fixed steps of 2 ms meet
    assert steps < 1010 / 2.5
    assert found[0][0] < steps and found[0][1] > late


def test_at_rest_steps_grow_to_the_longest_and_stay():
    ticks = 6400
    machine = stepper(tower(4), ticks, solver="auto", **AUTO)
    steps = advance(machine, ticks)
    assert len(steps) < 230  # 200 of the longest, and the way up
    assert [step.span for step in steps[-150:]] == [32] * 150
    assert np.abs(machine.state.position - machine.assembly.centre).max() < 1e-7


# --- what a step is given -----------------------------------------------------------------------------------------------------------


def test_a_step_gets_the_whole_impulse_of_body_forces_and_the_velocity_of_the_base():
    rng = np.random.default_rng(2)
    pull, velocity = rng.normal(size=(65, 3)), rng.normal(size=(65, 1, 3))
    loads = RunLoads(velocity, pull, None)
    long = loads.of_step(16, 32)
    assert np.allclose(long.acceleration, np.mean([loads.of_step(k).acceleration for k in range(16, 48)], axis=0), rtol=1e-13)
    assert np.array_equal(long.support_before, velocity[16]) and np.array_equal(long.support_after, velocity[48])
    one = loads.of_step(7)
    assert np.array_equal(one.acceleration, pull[8]) and np.array_equal(one.support_after, velocity[8])


def test_the_drift_of_the_base_is_what_one_trapezium_differs_from_many_by():
    t = TICK * np.arange(65)
    velocity = np.zeros((65, 1, 3))
    velocity[:, 0, 0] = t**2
    exact = t[48] ** 3 / 3 - t[16] ** 3 / 3
    one = 0.5 * (t[48] - t[16]) * (t[48] ** 2 + t[16] ** 2)
    assert base_drift(RunLoads(velocity, gravity(64), None), TICK, 16, 32)[0, 0] == pytest.approx(exact - one, rel=2e-3)
    assert not base_drift(RunLoads(velocity, gravity(64), None), TICK, 16, 1).any()


def test_a_jump_of_a_body_force_between_long_steps_puts_in_its_momentum():
    ticks, jump = 3200, 1237  # at no multiple of two
    pull = gravity(ticks, (0.0, 0.0, 0.0))
    pull[jump:, 0] = 0.4
    blocks = [ground(), box("b", (0.0, 0.0, 5.0), (0.5, 0.5, 5.5))]
    machine = stepper(blocks, ticks, acceleration=pull, **AUTO)
    steps = advance(machine, ticks)
    after = (ticks - jump + 1) * TICK
    assert machine.state.velocity[1, 0] == pytest.approx(0.4 * after, rel=1e-12)
    assert machine.state.position[1, 0] - 0.25 == pytest.approx(0.5 * 0.4 * after**2, abs=2e-5)
    assert len(steps) < 250


# --- going back, and the same bits ---------------------------------------------------------------------------------------------------


def shaken(ticks: int, tick: float = TICK, **settings) -> Stepper:
    velocity = still(ticks)
    velocity[:, 0, 0] = 0.5 * np.sin(2 * np.pi * 4.0 * np.arange(ticks + 1) * tick)
    own = AUTO | {"solver": "auto", "tolerance": 1e-8, "dt_min": tick}
    return stepper(wall(2, 4), ticks, support_velocity=velocity, **(own | settings))


def state_of(machine: Stepper) -> dict:
    return {name: array.copy() for name, array in machine.snapshot().items() if not name.startswith("islands")}


def test_a_step_undone_leaves_no_trace_but_what_the_solver_learnt():
    machine = shaken(320)
    for _ in range(20):
        machine.step(4)
    before, kept = state_of(machine), machine.begin_of_step()
    machine.step(16)
    assert any(not np.array_equal(array, before[name]) for name, array in state_of(machine).items() if array.shape == before[name].shape)
    machine.undo(kept)
    after = state_of(machine)
    assert before.keys() == after.keys()
    assert all(np.array_equal(array, before[name]) for name, array in after.items())


def test_equal_settings_give_equal_bits():
    runs = []
    for _ in range(2):
        machine = shaken(960)
        steps = advance(machine, 960)
        runs.append((machine.snapshot(), [step.span for step in steps], sum(step.repeated_error for step in steps)))
    assert runs[0][1] == runs[1][1]
    assert len(set(runs[0][1])) > 2 and runs[0][2] > 0  # it did adapt, and went back
    assert all(np.array_equal(array, runs[1][0][name], equal_nan=True) for name, array in runs[0][0].items())


def test_the_balance_of_energy_closes_over_steps_of_all_lengths():
    machine = shaken(960)
    advance(machine, 960)
    assert abs(machine.energy["balance"]) < 1e-9 * machine.energy["base_work"]
    law = {"default": JointLaw(normal_stiffness=1e9)}
    soft = stepper(tower(3), 960, joints=law, support_velocity=shaken(960).system.loads.support_velocity, solver="auto", **AUTO)
    advance(soft, 960)
    assert abs(soft.energy["balance"]) < 1e-9 * abs(soft.energy["base_work"])


def test_steps_that_the_solver_misses_are_made_again_and_reported():
    machine = shaken(60, 5e-3, solver="nlgs", max_iterations=60, tolerance=1e-6, dt_tolerance=1.0)
    steps = advance(machine, 60)
    assert sum(step.repeated_solver for step in steps) > 0
    assert sum(step.repeated_error for step in steps) == 0


def test_a_step_at_its_bound_that_should_be_shorter_says_so():
    machine = shaken(60, 5e-3, dt_tolerance=1e-7)
    assert sum(step.too_long for step in advance(machine, 60)) >= 5
