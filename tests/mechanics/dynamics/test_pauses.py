# SPDX-License-Identifier: GPL-3.0-or-later
"""dynamics/pauses.py: a rest ends as soon as the structure is still, and each shock leaves its own record of the damage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from datasets import contents
from models import GRAVITY, box, gravity, ground, still

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.joint_damage import joint_damage, shock_rows
from masonry_cd.analysis.damage.part_damage import DamageSettings, part_damage
from masonry_cd.app import run_loop
from masonry_cd.app.run_report import RunReport
from masonry_cd.app.time_step_checks import restless
from masonry_cd.io import checkpoint
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.pauses import Pauses, fallen, standing_of
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.shocks import Pause, Shock
from masonry_cd.mechanics.model.state import State

DT, MU, STEPS = 2e-3, 0.3, 500
SHOCKS = (Shock("first", 0, 50), Shock("second", 250, 300))
PAUSES = (Pause(50, 250, 1e-3, 10, "first"), Pause(300, 500, 1e-3, 10, "second"))
PULSE = 0.5 * GRAVITY  # of the base for 0.05 s forwards, then as long backwards


def shaken() -> Stepper:
    """A block that slides 1.5 mm or so in each shock; its base goes forth and stops."""
    velocity = still(STEPS)
    since = np.arange(STEPS + 1)
    for shock in SHOCKS:
        velocity[:, 0, 0] += PULSE * DT * np.clip(np.minimum(since - shock.first, shock.last - since), 0, None)
    assembly = Assembly.from_blocks([ground(), box("b", (0, -0.5, 0), (1, 0.5, 0.2))], MU)
    return Stepper(assembly, velocity, gravity(STEPS), Run(dt=DT, duration=STEPS * DT, solver="nlgs", tolerance=1e-9, checkpoint_every=0.0))


def write(path: Path, machine: Stepper, pauses: tuple[Pause, ...] = PAUSES) -> RunReport:
    joints = find_joints(machine.assembly)
    rests = Pauses(machine.assembly, pauses, SHOCKS, STEPS)
    with ResultWriter(path, machine.assembly, joints) as writer:
        return run_loop.run(machine, joints, writer, run_loop.RunPlan(STEPS, 7, pauses=rests))


def test_rests_end_when_all_is_still_and_nothing_else_changes(tmp_path: Path) -> None:
    short, full = shaken(), shaken()
    write(tmp_path / "short.h5", short)
    write(tmp_path / "full.h5", full, ())
    assert full.steps == STEPS
    assert short.load_step == STEPS
    # 100 ms of shock, then the block slides on for a while, and 10 steps more that it has to be still
    slides_on = short.steps - 2 * (50 + 10)
    assert 0 <= slides_on < 2 * 25
    assert short.state.position == pytest.approx(full.state.position, abs=1e-9)
    with Results.open(tmp_path / "short.h5") as results:
        first, second = results.shocks
        assert (first.name, first.start, first.end) == ("first", 0.0, pytest.approx(0.1))
        assert second.start == pytest.approx(results.time[first.frame])
        assert second.end - second.start == pytest.approx(0.1)
        assert results.time[second.frame] == results.time[-1] == pytest.approx(short.steps * DT)


def test_rests_that_wait_for_what_the_tolerance_does_not_resolve_are_reported(tmp_path: Path) -> None:
    """Rests that took their whole length are named, and only where the tolerance is to blame."""
    write(tmp_path / "short.h5", shaken())
    write(tmp_path / "full.h5", shaken(), ())
    with Results.open(tmp_path / "short.h5") as short, Results.open(tmp_path / "full.h5") as full:
        warnings = restless(full, PAUSES, GRAVITY, DT, 0.1)  # 0.1 g h sqrt(2) = 2.8 mm/s in the plane, still is 1 mm/s
        assert [line.split('"')[1] for line in warnings] == ["first", "second"]
        assert "0.0028 m/s" in warnings[0]
        assert restless(full, PAUSES, GRAVITY, DT, 0.01) == []
        assert restless(short, PAUSES, GRAVITY, DT, 0.1) == []


def test_each_shock_adds_to_the_damage(tmp_path: Path) -> None:
    write(tmp_path / "run.h5", shaken())
    with Results.open(tmp_path / "run.h5") as results:
        rows = shock_rows(results, Thresholds(slid=2e-3))
        tables = [joint_damage(results, Thresholds(), i) for i in range(2)]
        total, parts = joint_damage(results), part_damage(results, DamageSettings())
        after, end = [results.step_peaks_after(i) for i in range(2)], results.step_peaks
    assert parts.of_steps
    for name in ("drift", "hinge_opening"):
        assert (after[0][name] <= after[1][name]).all() and (after[1][name] == end[name]).all()
    slid = [row.sliding_max for row in rows]
    assert 0.0 < slid[0] < slid[1] == total.max_sliding[0]
    assert [table.max_sliding[0] for table in tables] == slid
    assert [row.residual_sliding_max for row in rows] == pytest.approx([tables[0].residual_sliding[0], total.residual_sliding[0]])
    assert [row["shock"] for row in parts.shocks] == ["first"] * len(parts.parts) + ["second"] * len(parts.parts)
    assert [{k: v for k, v in row.items() if k != "shock"} for row in parts.shocks[len(parts.parts) :]] == parts.parts


def test_a_sequence_resumes_to_the_same_bits(tmp_path: Path) -> None:
    write(tmp_path / "unbroken.h5", shaken())
    saved, machine = tmp_path / checkpoint.NAME, shaken()
    joints = find_joints(machine.assembly)

    class Killed(BaseException):
        pass

    def kill(_: int) -> None:
        if machine.steps == 64:  # within the first rest, while the still steps are counted
            raise Killed

    writer = ResultWriter(tmp_path / "run.h5", machine.assembly, joints)
    rests = Pauses(machine.assembly, PAUSES, SHOCKS, STEPS)
    with pytest.raises(Killed):
        run_loop.run(machine, joints, writer, run_loop.RunPlan(STEPS, 7, pauses=rests), kill, run_loop.Checkpoints(saved))
    assert rests.quiet > 0
    writer.close()
    machine, rests = shaken(), Pauses(machine.assembly, PAUSES, SHOCKS, STEPS)
    with ResultWriter.resumed(tmp_path / "run.h5", checkpoint.load(saved)[1]["rows"]) as writer:
        run_loop.run(
            machine, joints, writer, run_loop.RunPlan(STEPS, 7, pauses=rests), checkpoints=run_loop.Checkpoints(saved, resume=True)
        )
    assert contents(tmp_path / "run.h5") == contents(tmp_path / "unbroken.h5")


def test_a_block_falls_relative_to_a_support_that_stays() -> None:
    """The first of two supports sinks by 1 m with the block on it; a block of 0.2 m next to the other has dropped by 0.15 m."""
    supports = [box("sinks", (-2.0, 0, -1), (-1, 1, 0), fixed=True), box("stays", (0, 0, -1), (1, 1, 0), fixed=True)]
    assembly = Assembly.from_blocks([*supports, box("a", (-2.0, 0, 0), (-1, 1, 0.2)), box("b", (1.0, 0, 0), (2, 1, 0.2))], MU)
    built, state = standing_of(assembly), State.at_rest(assembly)
    state.position[0, 2] -= 1.0
    state.position[3, 2] -= 0.15
    assert fallen(assembly, built, state).tolist() == [True, False, False, True]
    state.position[2, 2] -= 1.0
    assert fallen(assembly, built, state).tolist() == [True, False, True, True]


def test_a_sphere_may_roll_and_settle_and_has_fallen_when_it_lies_outside() -> None:
    """On the top of a wall from 0 to 1 m: it sinks by 0.9 m inside; in front of it by no more than its radius; by more. The base rides."""
    assembly = Assembly.from_blocks(
        [ground(), box("wall", (0, 0, 0), (1, 1, 1)), Block.sphere("s", np.array([0.5, 0.5, 2.0]), 0.1, 2000.0)], MU
    )
    built, state = standing_of(assembly), State.at_rest(assembly)
    state.orientation[2] = [0.0, 1.0, 0.0, 0.0]
    for x, drop, fell in ((0.0, 0.9, False), (0.6, 0.09, False), (0.6, 0.11, True)):
        state.position[2] = [0.5 + x, 0.5, 2.0 - drop]
        assert fallen(assembly, built, state)[2] == fell
        state.position[:, 0] += 3.0
        assert fallen(assembly, built, state)[2] == fell
        state.position[:, 0] -= 3.0


def test_what_has_fallen_may_roll_while_the_rest_is_still() -> None:
    assembly = Assembly.from_blocks([ground(), box("b", (0, 0, 0), (1, 1, 0.4)), box("c", (2, 0, 0), (3, 1, 0.4))], MU)
    rests = Pauses(assembly, (Pause(0, 100, 1e-3, 1, "s"),), (Shock("s", 0, 0),), 100)
    machine = Stepper(assembly, still(1), gravity(1), Run(dt=DT, duration=1.0))
    state = machine.state
    state.velocity[2] = [0.0, 0.0, 0.0, 0.1, 0.0, 0.0]
    assert rests.next_step(5, state) == 5  # it turns where it stands
    state.position[2, 2] -= 0.21
    assert rests.next_step(6, state) == 100  # it lies more than half its height lower
    state.velocity[1, 0] = 2e-3
    assert rests.next_step(7, state) == 7
    assert rests.next_step(7, state, 1, -state.velocity) == 100  # it rattles to and fro
    assert rests.next_step(7, state, 1, state.velocity) == 7
    assert rests.next_step(100, state) == 100  # no pause
    assert rests.over(6, 100) is not None
    assert rests.over(5, 6) is None


def test_what_vibrates_about_a_place_is_still_by_its_mean_velocity_over_a_step() -> None:
    """At 1.2 and 0.4 of the speed below which a block counts as still, 0.8 in the mean; the velocity at the end alone is too large."""
    assembly = Assembly.from_blocks([ground(), box("b", (0, -0.5, 0), (1, 0.5, 0.2))], MU)
    state, before = State.at_rest(assembly), np.zeros((2, 6))
    state.velocity[1, 0], before[1, 0] = 1.2e-3, 0.4e-3
    ends = []
    for earlier in (None, before):
        pauses = Pauses(assembly, PAUSES, SHOCKS, STEPS)
        ends.append([pauses.next_step(step, state, earlier=earlier) for step in range(51, 61)][-1])
    assert ends == [60, 250]
