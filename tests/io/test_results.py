# SPDX-License-Identifier: GPL-3.0-or-later
"""The result file: what was written comes back, also after a kill."""

import signal
import subprocess
import sys
import textwrap
import time
import tracemalloc
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from hostile import refused_at
from models import stepper, tower
from places import ROOT

from masonry_cd.app.run_loop import RunPlan, run
from masonry_cd.foundation.errors import InputError
from masonry_cd.io import result_writer
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.find_joints import find_joints


def test_a_run_comes_back_as_it_was(tmp_path):
    machine = stepper(tower(3), 10)
    joints = find_joints(machine.assembly)
    with ResultWriter(tmp_path / "result.h5", machine.assembly, joints, "scene text", "three cubes") as writer:
        report = run(machine, joints, writer, RunPlan(10, 4))
    with Results.open(tmp_path / "result.h5") as results:
        assert results.time == pytest.approx([0.0, 4e-3, 8e-3, 10e-3])
        assert results.position[-1] == pytest.approx(machine.state.position)
        assert results.orientation.shape == (4, 4, 4)
        assert results.per_step("solver/error").max() == report.error_max
        assert len(results.per_step("energy/balance")) == 10
        assert (results.title, results.scene) == ("three cubes", "scene text")
        assert [b.name for b in results.blocks] == list(machine.assembly.names)
        assert results.blocks[2].faces == machine.assembly.blocks[2].faces
        assert results.joints.area == pytest.approx(joints.area)
        weight = machine.assembly.mass[1:].sum() * 9.81
        assert results.joint_history("normal_force")[-1] == pytest.approx(weight * np.array([1, 2 / 3, 1 / 3]), rel=1e-6)
        assert set(results.peaks) == {"opening", "sliding", "rotation", "contact_area_loss", "first_opening_time"}


def test_a_profiler_that_holds_frames_does_not_keep_a_file_from_being_published(tmp_path):
    """As that of a dask worker does for an instant: with them it holds attributes open, with which HDF5 begins no single-writer mode."""
    machine, held = stepper(tower(2), 1), []
    joints = find_joints(machine.assembly)
    before = sys.getprofile()
    sys.setprofile(lambda frame, event, argument: held.append(frame))
    try:
        with ResultWriter(tmp_path / "r.h5", machine.assembly, joints) as writer:
            writer.append({"time": 1.0})
            writer.flush()
            sys.setprofile(before)
            assert (tmp_path / "r.h5").exists()
    finally:
        sys.setprofile(before)
    assert held
    with h5py.File(tmp_path / "r.h5") as file:
        assert file["time"][...].tolist() == [1.0]


def test_memory_of_the_writer_does_not_grow(tmp_path):
    machine, row = stepper(tower(2), 1), np.zeros((3, 100))
    with ResultWriter(tmp_path / "r.h5", machine.assembly, find_joints(machine.assembly)) as writer:
        tracemalloc.start()
        try:
            for k in range(3000):
                writer.append({"time": float(k), "position": row + k})
            _, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    assert 3000 * row.nbytes > 2 * (3 << 20)
    assert peak < 3 << 20  # what waits, and its copy while it is written
    with h5py.File(tmp_path / "r.h5") as file:
        assert (file["time"][...] == np.arange(3000)).all()
        assert (file["position"][:, 1, 7] == np.arange(3000)).all()


def test_what_a_killed_run_wrote_can_be_read(tmp_path):
    script = textwrap.dedent("""
        import sys, time
        sys.path.insert(0, sys.argv[2])
        from models import stepper, tower
        from masonry_cd.mechanics.contact.find_joints import find_joints
        from masonry_cd.io.result_writer import ResultWriter
        machine = stepper(tower(2), 1)
        with ResultWriter(sys.argv[1], machine.assembly, find_joints(machine.assembly)) as writer:
            for k in range(10):
                writer.append({"time": 0.1 * k, "position": machine.state.position, "orientation": machine.state.orientation})
            writer.flush()
            print("written", flush=True)
            time.sleep(60)
    """)
    path = tmp_path / "result.h5"
    here = str(ROOT / "tests")
    with subprocess.Popen([sys.executable, "-c", script, str(path), here], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "written\n"
        time.sleep(0.1)
        process.send_signal(signal.SIGKILL)
        process.wait()
    with Results.open(path) as results:
        assert results.time == pytest.approx(0.1 * np.arange(10))
        assert results.position[9].shape == (3, 3)


def test_what_is_no_result_is_named(tmp_path):
    with pytest.raises(InputError, match="no such result file"):
        Results.open(tmp_path / "nothing.h5")
    (tmp_path / "text.h5").write_text("not HDF5")
    with refused_at("text.h5"):
        Results.open(tmp_path / "text.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["time"] = [0.0]
    with refused_at("other.h5"):
        Results.open(tmp_path / "other.h5")


@pytest.mark.parametrize("share", [0.01, 0.5, 0.98])
def test_a_file_that_was_cut_off_is_reported_at_once(tmp_path, share):
    machine = stepper(tower(2), 5)
    joints = find_joints(machine.assembly)
    with ResultWriter(tmp_path / "whole.h5", machine.assembly, joints) as writer:
        run(machine, joints, writer, RunPlan(5))
    whole = (tmp_path / "whole.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: int(share * len(whole))])
    with refused_at("cut.h5"):
        Results.open(tmp_path / "cut.h5")


def test_a_full_disc_is_reported_and_what_was_written_is_kept(tmp_path, monkeypatch):
    machine = stepper(tower(3), 20)
    joints = find_joints(machine.assembly)

    def fill(done: int) -> None:
        if done == 12:
            writer.flush()
            monkeypatch.setattr(result_writer.shutil, "disk_usage", lambda folder: SimpleNamespace(free=0))

    with pytest.raises(OSError, match="the disk is full"), ResultWriter(tmp_path / "result.h5", machine.assembly, joints) as writer:
        run(machine, joints, writer, RunPlan(20, 4), fill)
    with Results.open(tmp_path / "result.h5") as kept:
        assert kept.time == pytest.approx([0.0, 4e-3, 8e-3, 12e-3])


def cut_rows(path) -> dict[str, int]:
    with Results.open(path) as kept:
        return {"time": len(kept.time), "position": len(kept.position), "orientation": len(kept.orientation)}


def written(path, frames: int = 77):
    """A result of some frames of a tower of two, and its assembly."""
    machine = stepper(tower(2), 1)
    with ResultWriter(path, machine.assembly, find_joints(machine.assembly)) as writer:
        for k in range(frames):
            writer.append({"time": 0.1 * k, "position": machine.state.position, "orientation": machine.state.orientation})
    return machine


def test_rows_that_are_none_leave_those_before_as_they_are(tmp_path):
    """A resumed run hands over no rows first, and its frames may fill the buffer before there are some."""
    machine = written(tmp_path / "r.h5")
    with ResultWriter.resumed(tmp_path / "r.h5", cut_rows(tmp_path / "r.h5")) as writer:
        writer.extend({"time": np.empty(0), "position": np.empty((0, 3, 3))})
        writer.flush()
        writer.extend({"time": np.array([7.7]), "position": machine.state.position[None], "orientation": machine.state.orientation[None]})
    with Results.open(tmp_path / "r.h5") as kept:
        assert kept.time == pytest.approx(0.1 * np.arange(78))
        assert np.array_equal(kept.position[77], machine.state.position)


def test_an_error_is_not_hidden_by_one_of_closing_the_file(tmp_path, monkeypatch):
    machine = written(tmp_path / "r.h5")
    with (
        pytest.raises(InputError, match="the true one"),
        ResultWriter.resumed(tmp_path / "r.h5", cut_rows(tmp_path / "r.h5")) as writer,
    ):
        writer.append({"time": 7.7, "position": machine.state.position, "orientation": machine.state.orientation})
        monkeypatch.setattr(result_writer.shutil, "disk_usage", lambda folder: SimpleNamespace(free=0))
        raise InputError("", "the true one")


def test_a_first_frame_that_fills_the_buffer_does_not_shut_out_what_comes_after(tmp_path, monkeypatch):
    monkeypatch.setattr(result_writer, "BUFFER_BYTES", 0)
    machine = stepper(tower(3), 10)
    joints = find_joints(machine.assembly)
    with ResultWriter(tmp_path / "result.h5", machine.assembly, joints) as writer:
        run(machine, joints, writer, RunPlan(10, 4))
    with Results.open(tmp_path / "result.h5") as kept:
        assert kept.joint_history("normal_force").shape == (4, 3)


def test_a_resumed_file_can_be_read_from_the_first_moment_on(tmp_path):
    written(tmp_path / "r.h5")
    writer = ResultWriter.resumed(tmp_path / "r.h5", cut_rows(tmp_path / "r.h5"))
    copy = tmp_path / "as_a_kill_leaves_it.h5"
    copy.write_bytes((tmp_path / "r.h5").read_bytes())
    with Results.open(copy) as kept:
        assert kept.time == pytest.approx(0.1 * np.arange(77))
    writer.close()


def test_there_is_no_result_file_before_it_can_be_read(tmp_path):
    machine = stepper(tower(2), 1)
    with ResultWriter(tmp_path / "r.h5", machine.assembly, find_joints(machine.assembly)) as writer:
        writer.append({"time": 0.0, "position": machine.state.position, "orientation": machine.state.orientation})
        assert not (tmp_path / "r.h5").exists()
        writer.flush()
        with Results.open(tmp_path / "r.h5") as kept:
            assert kept.time.tolist() == [0.0]
    assert [path.name for path in tmp_path.iterdir()] == ["r.h5"]
