"""The result file: what was written comes back, also after a kill."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from models import stepper, tower

from masonry_cd import results
from masonry_cd.errors import InputError
from masonry_cd.joints import find_joints
from masonry_cd.results import Results, ResultWriter
from masonry_cd.runner import run


def test_a_run_comes_back_as_it_was(tmp_path):
    machine = stepper(tower(3), 10)
    joints = find_joints(machine.assembly)
    with ResultWriter(tmp_path / "result.h5", machine.assembly, joints, "scene text", "three cubes") as writer:
        report = run(machine, joints, writer, 10, frame_every=4)
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


def test_memory_of_the_writer_does_not_grow(tmp_path):
    machine = stepper(tower(2), 1)
    with ResultWriter(tmp_path / "r.h5", machine.assembly, find_joints(machine.assembly)) as writer:
        for k in range(3000):
            writer.append({"time": float(k), "position": np.full((3, 100), float(k))})
            assert writer._pending_bytes <= 2 << 20
    with h5py.File(tmp_path / "r.h5") as file:
        assert (file["time"][...] == np.arange(3000)).all()
        assert (file["position"][:, 1, 7] == np.arange(3000)).all()


def test_what_a_killed_run_wrote_can_be_read(tmp_path):
    script = textwrap.dedent("""
        import sys, time
        sys.path.insert(0, sys.argv[2])
        from models import stepper, tower
        from masonry_cd.joints import find_joints
        from masonry_cd.results import ResultWriter
        machine = stepper(tower(2), 1)
        with ResultWriter(sys.argv[1], machine.assembly, find_joints(machine.assembly)) as writer:
            for k in range(10):
                writer.append({"time": 0.1 * k, "position": machine.state.position, "orientation": machine.state.orientation})
            writer.flush()
            print("written", flush=True)
            time.sleep(60)
    """)
    path = tmp_path / "result.h5"
    here = os.path.dirname(__file__)
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
    with pytest.raises(InputError, match=r"text\.h5: not a readable HDF5 file"):
        Results.open(tmp_path / "text.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["time"] = [0.0]
    with pytest.raises(InputError, match=r"other\.h5: not the result of a run"):
        Results.open(tmp_path / "other.h5")


@pytest.mark.parametrize("share", [0.01, 0.5, 0.98])
def test_a_file_that_was_cut_off_is_told_at_once(tmp_path, share):
    machine = stepper(tower(2), 5)
    joints = find_joints(machine.assembly)
    with ResultWriter(tmp_path / "whole.h5", machine.assembly, joints) as writer:
        run(machine, joints, writer, 5)
    whole = (tmp_path / "whole.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InputError, match=r"cut\.h5: cut off: parts of the file are missing"):
        Results.open(tmp_path / "cut.h5")


def test_a_full_disc_is_told_and_what_was_written_is_kept(tmp_path, monkeypatch):
    machine = stepper(tower(3), 20)
    joints = find_joints(machine.assembly)

    def fill(done: int) -> None:
        if done == 12:
            writer.flush()
            monkeypatch.setattr(results.shutil, "disk_usage", lambda folder: SimpleNamespace(free=0))

    with pytest.raises(OSError, match="no room on the disc"), ResultWriter(tmp_path / "result.h5", machine.assembly, joints) as writer:
        run(machine, joints, writer, 20, frame_every=4, progress=fill)
    with Results.open(tmp_path / "result.h5") as kept:
        assert kept.time == pytest.approx([0.0, 4e-3, 8e-3, 12e-3])
