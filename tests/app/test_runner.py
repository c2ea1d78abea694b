# SPDX-License-Identifier: GPL-3.0-or-later
"""The run loop: what it records, and runs that are stopped and resumed."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from datasets import contents
from forked import need_fork
from models import box, gravity, stepper, still, tower, wall

from masonry_cd.analysis.damage.joint_damage import bonds, joint_damage
from masonry_cd.app import recorder, run_loop
from masonry_cd.app.run_loop import Checkpoints, RunPlan, run
from masonry_cd.app.run_report import RunReport
from masonry_cd.app.staying_support import staying_support
from masonry_cd.foundation.errors import InputError
from masonry_cd.io import checkpoint, result_writer, segments
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.moreau_jean import ENERGIES, StepReport
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from reports.damage import write_joints_csv

STEPS = 60


def machine(columns: int = 2, **settings: float):
    velocity = still(STEPS)
    velocity[:, 0, 0] = 0.8 * np.sin(2 * np.pi * 8.0 * np.arange(STEPS + 1) * 1e-3)
    return stepper(wall(columns, 3), STEPS, support_velocity=velocity, tolerance=1e-6, max_iterations=300, **settings)


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory):
    path, m = tmp_path_factory.mktemp("run") / "unbroken.h5", machine()
    joints = find_joints(m.assembly)
    with ResultWriter(path, m.assembly, joints, "scene") as writer:
        return path, run(m, joints, writer, RunPlan(STEPS, 7))


class Killed(BaseException):
    """Stands for a kill between two steps."""


@pytest.mark.parametrize("buffer", [0, result_writer.BUFFER_BYTES])
@pytest.mark.parametrize("end", [KeyboardInterrupt, Killed])
def test_a_resumed_run_ends_with_the_same_bits(tmp_path, unbroken, end, buffer, monkeypatch):
    monkeypatch.setattr(result_writer, "BUFFER_BYTES", buffer)
    path, saved, m = tmp_path / "broken.h5", tmp_path / checkpoint.NAME, machine(checkpoint_every=0.0 if end is Killed else 1e9)
    joints = find_joints(m.assembly)

    def stop(step: int) -> None:
        if step == 33:
            raise end

    writer = ResultWriter(path, m.assembly, joints, "scene")
    try:
        report = run(m, joints, writer, RunPlan(STEPS, 7), stop, Checkpoints(saved))
        assert report.stopped == "interrupted after step 33"
    except Killed:
        pass
    writer.close()
    m = machine()
    with ResultWriter.resumed(path, checkpoint.load(saved)[1]["rows"]) as writer:
        report = run(m, joints, writer, RunPlan(STEPS, 7), checkpoints=Checkpoints(saved, resume=True))
    assert contents(path) == contents(unbroken[0])
    assert report.steps == STEPS
    assert report.error_max == unbroken[1].error_max
    assert report.energy == unbroken[1].energy
    assert checkpoint.load(saved)[1]["rows"]["step_time"] == STEPS  # what follows the steps can be done again


def lines_until(limit: int, files: tuple[str, ...], reached: Callable[[int], None]) -> Callable[..., Any]:
    """A trace function that counts the lines that run in some files, and kills the process before one of them."""
    count = 0

    def trace(frame: Any, event: str, _: Any) -> Any:
        nonlocal count
        if frame.f_code.co_filename not in files:
            return None
        if event == "line":
            count += 1
            reached(count)
            if count == limit:
                os.kill(os.getpid(), signal.SIGKILL)
        return trace

    return trace


def in_a_process_killed_at(line: int, body: Callable[[], object], counter: Path) -> int:
    """Run a body in a forked process, killed at the n-th line that it executes of the files that write; return how many it executed."""
    files = (result_writer.__file__, segments.__file__, checkpoint.__file__, recorder.__file__, run_loop.__file__)
    need_fork()
    if (pid := os.fork()) == 0:
        number = counter.open("w", encoding="utf-8")

        def reached(count: int) -> None:
            number.seek(0)
            number.write(f"{count}")
            number.flush()

        sys.settrace(lines_until(line, files, reached))
        try:
            body()
        finally:
            os._exit(0)
    os.waitpid(pid, 0)
    return int(counter.read_text(encoding="utf-8"))


MORE = pytest.mark.slow(reason="a process per kill, which traces each line")


@pytest.mark.parametrize("kills", [2, pytest.param(8, marks=MORE), pytest.param(24, marks=pytest.mark.validation)])
def test_a_kill_at_any_line_leaves_results_that_read_and_a_run_that_resumes(tmp_path, unbroken, monkeypatch, kills):
    """A run that begins, and one that is resumed, are killed at lines spread over all that its writing executes."""
    monkeypatch.setattr(result_writer, "BUFFER_BYTES", 4096)
    path, saved = tmp_path / "broken.h5", tmp_path / checkpoint.NAME

    def begin() -> None:
        m = machine(checkpoint_every=0.0)
        joints = find_joints(m.assembly)
        with ResultWriter(path, m.assembly, joints, "scene") as writer:
            run(m, joints, writer, RunPlan(STEPS, 7), leave if steps else None, Checkpoints(saved))

    def leave(done: int) -> None:
        if done == steps:
            os._exit(0)

    def go_on() -> None:
        m = machine(checkpoint_every=0.0)
        checkpoint.repair(saved)
        numbers = checkpoint.load(saved)[1]
        with ResultWriter.resumed(path, numbers["rows"], numbers["mark"]) as writer:
            run(m, find_joints(m.assembly), writer, RunPlan(STEPS, 7), leave if steps else None, Checkpoints(saved, resume=True))

    steps = 10
    total = in_a_process_killed_at(0, begin, tmp_path / "count")
    for line in np.linspace(1, total, kills).astype(int):
        for old in tmp_path.glob("broken*"):
            old.unlink()
        checkpoint.remove(saved)
        in_a_process_killed_at(int(line), begin, tmp_path / "count")
        assert_reads(path, saved)
    in_a_process_killed_at(0, begin, tmp_path / "count")
    kept = {name: (tmp_path / name).read_bytes() for name in (path.name, saved.name)}
    steps = 20
    total = in_a_process_killed_at(0, go_on, tmp_path / "count")
    for line in np.linspace(1, total, kills).astype(int):
        checkpoint.remove(saved)
        for name, data in kept.items():
            (tmp_path / name).write_bytes(data)
        in_a_process_killed_at(int(line), go_on, tmp_path / "count")
        assert assert_reads(path, saved) >= 10
    steps = 0
    go_on()
    assert contents(path) == contents(unbroken[0])


def assert_reads(path: Path, saved: Path) -> int:
    """A result file, where there is one, reads, and holds what the checkpoint counts; return the steps that this counts."""
    if not saved.exists() and not checkpoint.before(saved).exists():
        if path.exists():
            Results.open(path).file.close()
        return 0
    assert checkpoint.repair(saved) == ""
    with Results.open(path) as found:
        rows = checkpoint.load(saved)[1]["rows"]
        assert all(len(found.file[name]) >= count for name, count in rows.items())
        assert np.isfinite(found.position[rows["position"] - 1]).all()
        return rows["step_time"]


def test_a_checkpoint_of_another_structure_is_refused(tmp_path):
    saved, m = tmp_path / checkpoint.NAME, machine(checkpoint_every=0.0)
    joints = find_joints(m.assembly)
    with ResultWriter(tmp_path / "r.h5", m.assembly, joints) as writer:
        run(m, joints, writer, RunPlan(3), lambda step: saved.replace(tmp_path / "kept.npz") if step == 2 else None, Checkpoints(saved))
    other = machine(columns=3)
    with (
        ResultWriter(tmp_path / "o.h5", other.assembly, find_joints(other.assembly)) as writer,
        pytest.raises(InputError, match="another str"),
    ):
        run(other, find_joints(other.assembly), writer, RunPlan(3), checkpoints=Checkpoints(tmp_path / "kept.npz", resume=True))


def test_a_checkpoint_of_another_version_is_refused(tmp_path, monkeypatch):
    saved = tmp_path / checkpoint.NAME
    with monkeypatch.context() as older:
        older.setattr(checkpoint, "FORMAT", checkpoint.FORMAT - 1)
        checkpoint.save(saved, {"a": np.ones(2)}, {"rows": 3})
    with pytest.raises(InputError, match="of an older version of masonry_cd"):
        checkpoint.load(saved)


def test_the_report_adds_up(unbroken):
    path, report = unbroken
    with h5py.File(path) as file:
        assert report.iterations_mean == pytest.approx(file["solver/iterations"][...].mean())
        assert report.error_max == file["solver/error"][...].max()
        assert report.steps_missed == (file["solver/error"][...] > 1e-6).sum()
        assert len(file["time"]) == 1 + STEPS // 7 + 1  # the first state, every seventh, and the last
        assert file["step_time"][...] == pytest.approx(np.arange(1, STEPS + 1) * 1e-3)
    assert report.balance_error < 1e-10


def test_lifts_out_of_overlaps_are_reported_next_to_the_balance():
    assert RunReport().lift_share == 0.0
    assert RunReport(work_max=200.0, energy={"correction": 5.0}).lift_share == pytest.approx(0.025)


def test_a_balance_next_to_no_work_has_a_measure_of_its_own():
    report = RunReport(fall=2.0, balance_max=1e-11, work_max=1e-25)
    assert report.balance_error == pytest.approx(1e14)  # nothing was solved yet: no other measure
    energy = dict.fromkeys((*ENERGIES, "kinetic"), 0.0) | {"balance": 1e-11}
    step = StepReport(iterations=0, error=0.0, seconds=0.0, contacts=0, penetration=0.0, reason="")
    for _ in range(5):
        report.add(step, 1e-8, energy)
    assert report.resolution == pytest.approx(1e-7)
    assert report.balance_error == pytest.approx(1e-4)
    assert report.at_rest
    report.work_max = 1e-6
    assert (report.balance_error, report.at_rest) == (pytest.approx(1e-5), False)


def test_what_a_gentle_run_leaves_out_is_counted(tmp_path):
    steps = 200
    velocity = still(steps)
    velocity[:, 0, 0] = 0.05 * np.sin(2 * np.pi * 2.0 * np.arange(steps + 1) * 1e-3)  # far too little to move a joint
    velocity[100:] = velocity[100]  # then the base goes on evenly: rest, seen from the wall
    m = stepper(wall(3, 3), steps, support_velocity=velocity, solver="auto", tolerance=1e-8)
    joints = find_joints(m.assembly)
    with ResultWriter(tmp_path / "r.h5", m.assembly, joints) as writer:
        report = run(m, joints, writer, RunPlan(steps))
    done = report.left_out
    assert done["broad_phases"] == 1
    assert done["pairs_with_faces_searched"] < 2 * len(m.detector.pairs)  # once each, at the start
    assert done["pairs_with_points_kept"] > 0.9 * joints.count * steps
    assert report.steps_as_before > 40


def test_reasons_are_counted_without_their_numbers():
    energy = dict.fromkeys(ENERGIES, 0.0)
    report = RunReport()
    for k in range(50):
        report.add(StepReport(3, 1e-3, 0.1, 4, 0.0, f"newton: missed, error {k}.5e-03"), 1e-8, energy)
    assert report.solver_reasons == {"newton: missed, error #": 50}


def test_bonds_are_written_and_counted(tmp_path):
    """A bonded stack pulled apart: one joint breaks, the other holds."""
    pull = gravity(60)
    pull[20:, 2] = 30.0
    law = {"block-block": JointLaw(normal_stiffness=1e9, cohesion=1e6), "base-block": JointLaw(normal_stiffness=1e9, cohesion=1e3)}
    m = stepper(tower(2), 60, acceleration=pull, joints=law)
    joints = find_joints(m.assembly)
    with ResultWriter(tmp_path / "result.h5", m.assembly, joints) as writer:
        run(m, joints, writer, RunPlan(60, 10))
    with Results.open(tmp_path / "result.h5") as results:
        share = results.joint_history("bonded")
        table = joint_damage(results)
        assert bonds(results).as_dict() == {"joints_bonded": 2, "joints_broken": 1}
    assert share[0].tolist() == [1.0, 1.0]
    assert share[-1] == pytest.approx([0.0, 1.0], abs=1e-6)
    write_joints_csv(table, tmp_path / "joints.csv")
    head, first, second = (tmp_path / "joints.csv").read_text().splitlines()
    assert head.endswith(",state,bonded")
    assert (first.rpartition(",")[2], second.rpartition(",")[2]) == ("0", "1")


STEPS_RECORDER = 100
BLOCKS = [
    box("stone", (0, 0, 0), (6, 1, 1)),
    box("sinks", (0, 0, -1), (1, 1, 0), fixed=True),
    box("stays", (2, 0, -1), (3, 1, 0), fixed=True),
    box("stays as well", (4, 0, -1), (5, 1, 0), fixed=True),
]


def support_where(velocity: np.ndarray, support_of: list[int], blocks: list[Block] = BLOCKS) -> int:
    assembly = replace(Assembly.from_blocks(blocks, 0.6), support_of=np.array(support_of))
    return staying_support(assembly, velocity, 1e-3, find_joints(assembly), assembly.fixed)


def test_it_is_the_first_of_those_that_the_loads_move_least():
    velocity = np.zeros((STEPS_RECORDER + 1, 2, 3))
    velocity[:, :, 0] = 0.1 * np.sin(np.linspace(0, 6, STEPS_RECORDER + 1))[:, None]  # all shake
    assert support_where(velocity, [-1, 0, 1, 1]) == 1
    velocity[20:40, 0, 2] = -0.2  # and one settles
    assert support_where(velocity, [-1, 0, 1, 1]) == 2


def test_one_that_goes_and_comes_back_has_not_stayed():
    velocity = np.zeros((STEPS_RECORDER + 1, 2, 3))
    velocity[:, 0, 0] = np.sin(2 * np.pi * np.linspace(0, 1, STEPS_RECORDER + 1))
    velocity[:, 1, 2] = -1e-3
    assert support_where(velocity, [-1, 0, 1, 1]) == 2


def test_a_ground_on_which_nothing_stands_is_none():
    """Both abutments sink alike, and the ground between them stays."""
    velocity = np.zeros((STEPS_RECORDER + 1, 2, 3))
    velocity[:, 0, 2] = -1e-3
    blocks = [*BLOCKS[:3], box("ground", (-1, -1, -2), (7, 2, -1.5), fixed=True)]
    assert support_where(velocity, [-1, 0, 0, 1], blocks) == 1
    assert support_where(velocity, [-1, 0, 1, 1], blocks) == 2
