# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: what a user types, what comes back, and that nothing is left half made."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from block_files import write_plate_scene
from command_line import done, masonry_cd
from datasets import contents
from pictures import main_colours
from places import EXAMPLES
from scipy import sparse

from loads.picture import AFTER, BEFORE
from masonry_cd.app import case
from masonry_cd.app.closing_lines import closing_lines
from masonry_cd.app.progress import Interrupt
from masonry_cd.app.recorder import Recorder
from masonry_cd.cli import main
from masonry_cd.foundation import own_files
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.system import STOPPING
from masonry_cd.io.lock import locked
from masonry_cd.io.problem_files import write_problem
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results
from masonry_cd.io.summary import read_summary
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.dynamics.islands import Islands
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.friction.problem import LocalProblem
from reports import damage as damage_files

SUMMARY_KEYS = {
    "blocks", "joints", "steps", "wall_seconds", "stepping_seconds", "contacts_mean", "contacts_max", "penetration_max",
    "displacement_max", "collapsed_blocks", "joints_opened", "joints_slid", "joints_separated",
}  # fmt: skip
SOLVER_KEYS = {"name", "iterations_mean", "iterations_max", "error_max", "error_mean", "steps_missed"}


def modules_loaded_by(folder: Path, *words: object) -> tuple[set[str], str]:
    """Modules loaded by a command in an interpreter of its own, and what it said on standard error."""
    argv = ["masonry-cd", *map(str, words)]
    code = f"""
import sys
from masonry_cd.cli import main
sys.argv = {argv!r}
try:
    main()
except SystemExit:
    pass
print("modules", *sys.modules)
"""
    out = subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True)
    return set(out.stdout.splitlines()[-1].split()), out.stderr


def test_ctrl_c_that_no_command_takes_leaves_one_line(monkeypatch, capsys):
    def struck():
        raise KeyboardInterrupt

    monkeypatch.setattr("masonry_cd.cli.app.app", struck)
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 130
    assert capsys.readouterr().err == "masonry-cd: interrupted\n"


def test_help_and_bad_scenes_need_no_heavy_import(tmp_path):
    modules, errors = modules_loaded_by(tmp_path, "run", "no.toml", "-o", "out")
    assert "masonry_cd.app.scene" in modules
    assert not {"numba", "scipy", "h5py", "matplotlib", "vtk", "pyvista", "gmsh", "pandas"} & modules
    assert errors == "masonry-cd: error: no.toml: no such scene file\n"


@pytest.mark.slow(reason="a process of its own loads the kernels again")
def test_a_run_without_a_picture_imports_neither_vtk_nor_matplotlib_nor_dask(block_on_plate, tmp_path):
    modules, errors = modules_loaded_by(tmp_path, "run", block_on_plate(duration="duration = 0.01"), "-o", "out")
    assert (tmp_path / "out" / "summary.json").exists(), errors
    assert (
        not {"matplotlib", "vtk", "vtkmodules", "pyvista", "gmsh", "pandas", "trimesh", "meshio", "skfem", "dask", "distributed", "pyarrow"}
        & modules
    )


def test_a_frictionless_block_stays_while_the_plate_moves_under_it(block_on_plate, tmp_path):
    result = done("run", block_on_plate(), "-o", tmp_path / "out", "--set", "run.frames_per_second=200")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary.keys() >= SUMMARY_KEYS
    assert summary["solver"].keys() >= SOLVER_KEYS
    assert {"kinetic_end", "balance_error"} <= summary["energy"].keys()
    assert summary["steps"] == 500
    assert summary["displacement_max"] == pytest.approx(0.2 / (math.pi * 2.0), rel=1e-4)  # the plate's own, C / (pi f)
    assert summary["joints_slid"] == 1
    assert (tmp_path / "out" / "joints.csv").read_text().startswith("joint,block_a,block_b,area,max_opening")
    assert "1 slid (at most 31.8 mm)" in result.stdout
    assert not (tmp_path / "out" / "crack_map.png").exists()


def test_a_scene_without_joints_runs_and_reports(block_on_plate, tmp_path):
    scene, out = block_on_plate(duration="duration = 0.2"), tmp_path / "out"
    blocks = json.loads((tmp_path / "blocks.json").read_text())
    for vertex in blocks["blocks"][1]["vertices"]:
        vertex[2] += 0.05
    (tmp_path / "blocks.json").write_text(json.dumps(blocks))
    done("run", scene, "-o", out)
    assert json.loads((out / "summary.json").read_text())["joints"] == 0
    with Results.open(out / "result.h5") as results:
        assert results.position[-1, 1, 2] == pytest.approx(results.position[0, 1, 2] - 0.05, abs=1e-7)
        assert results.joint_history("force_point").shape == (results.frames, 0, 3)
    assert masonry_cd("report", out, "--thrust").exit_code == 0


def test_the_same_scene_gives_the_same_bits(block_on_plate, tmp_path):
    scene = block_on_plate(friction="friction = 0.3", amplitude="amplitude = 0.6")
    positions = []
    for name in ("one", "two"):
        masonry_cd("run", scene, "-o", tmp_path / name, "-q")
        with Results.open(tmp_path / name / "result.h5") as results:
            positions.append(results.position[...])
    assert np.array_equal(*positions)


def test_quiet_says_nothing(block_on_plate, tmp_path):
    scene = block_on_plate(duration="duration = 0.01")
    result = masonry_cd("run", scene, "-o", tmp_path / "out", "--quiet", "--set", "loads=[]")
    assert (result.exit_code, result.output) == (0, "")


def test_more_threads_than_cores_and_missed_tolerances_are_said_and_written_down(block_on_plate, tmp_path):
    scene = block_on_plate(friction="friction = 0.3", duration="duration = 0.01", amplitude="amplitude = 0.6")
    changes = [word for key in ("max_iterations=1", "tolerance=1e-15", "threads=1000") for word in ("--set", f"run.{key}")]
    result = done("run", scene, "-o", tmp_path / "out", "-q", *changes)
    solver = json.loads((tmp_path / "out" / "summary.json").read_text())["solver"]
    assert solver["steps_missed"] > 0
    assert f"{solver['steps_missed']} of 10 steps missed the tolerance 1e-15" in result.stderr
    assert f"run.threads: 1000 requested, {solver['threads']} used" in result.stderr


def test_a_folder_with_a_run_is_kept_unless_forced(block_on_plate, tmp_path):
    scene, out = block_on_plate(duration="duration = 0.01"), tmp_path / "out"
    assert masonry_cd("run", scene, "-o", out).exit_code == 0
    before = (out / "result.h5").read_bytes()
    (out / "drift.csv").write_bytes(b"of the former run")
    own_files.note(out / "drift.csv")
    refused = masonry_cd("run", scene, "-o", out, "--set", "run.duration=0.02")
    assert refused.exit_code == 2
    assert "--force" in refused.stderr
    assert (out / "result.h5").read_bytes() == before
    assert masonry_cd("run", scene, "-o", out, "--force", "--set", "run.duration=0.02").exit_code == 0
    assert json.loads((out / "summary.json").read_text())["steps"] == 20
    assert not (out / "drift.csv").exists()


def test_a_run_keeps_files_of_others_and_names_them(block_on_plate, tmp_path):
    """Neither overwritten nor removed, --force or not, by a run, a resumed one or a report; they are all named."""
    scene, out = block_on_plate(duration="duration = 0.01"), tmp_path / "out"
    out.mkdir()
    theirs = {out / name: b"theirs" for name in ("joints.csv", "report.html", "crack_map_1s.png", "problem_3.npz")}
    for path, content in theirs.items():
        path.write_bytes(content)
    for force in ((), ("--force",)):
        refused = masonry_cd("run", scene, "-o", out, *force)
        assert refused.exit_code == 2 and len(refused.stderr.splitlines()) == 1
        assert all(path.name in refused.stderr for path in theirs)
        assert {path: path.read_bytes() for path in out.iterdir()} == theirs


def test_a_run_of_an_earlier_version_is_reported_and_forced(block_on_plate, tmp_path):
    """Its folder has no list of its files: its result.h5 proves that files of a run's names are those of a run."""
    scene, out = block_on_plate(duration="duration = 0.01"), tmp_path / "out"
    assert masonry_cd("run", scene, "-o", out, "-q").exit_code == 0
    for command in (("report", out, "--no-crack-map"), ("run", scene, "-o", out, "-q", "--force")):
        (out / own_files.LIST).unlink()
        assert masonry_cd(*command).exit_code == 0
    (out / own_files.LIST).unlink()
    (out / "blocks.json").write_text("theirs")  # no file of a run, so that a run proves nothing
    assert masonry_cd("build", scene, "-o", out, "--no-picture", "--force").exit_code == 2
    assert (out / "blocks.json").read_text() == "theirs"


def test_every_format_of_blocks_is_written_twice(block_on_plate, tmp_path):
    """Each is listed as it is in the end: its marks are put in before, so that --force finds it its own."""
    asked = [word for name in ("json", "obj", "stl", "vtu", "vtm", "vtkhdf", "step", "msh") for word in ("--format", name)]
    for force in ((), ("--force",)):
        assert masonry_cd("build", block_on_plate(), "-o", tmp_path / "out", "--no-picture", *asked, *force).exit_code == 0


@pytest.mark.parametrize(
    ("file", "command"),
    [
        ("limit.html", ["limit"]),
        ("mechanisms.csv", ["limit", "--macro-elements"]),
        ("modal.csv", ["modal", "--young", "1e9"]),
        ("plan.svg", ["build", "--no-picture"]),
        ("accuracy.csv", ["accuracy"]),
    ],
)
def test_no_command_takes_a_file_of_others(block_on_plate, tmp_path, file, command):
    out = tmp_path / "out"
    out.mkdir()
    (out / file).write_text("theirs")
    refused = masonry_cd(*command, block_on_plate(), "-o", out, "--force")
    assert (refused.exit_code, len(refused.stderr.splitlines())) == (2, 1)
    assert file in refused.stderr and [path.name for path in out.iterdir()] == [file]


def test_a_folder_that_may_not_be_written_is_refused_before_the_run(block_on_plate, tmp_path, monkeypatch):
    scene, allowed = block_on_plate(), os.access
    monkeypatch.setattr(os, "access", lambda path, mode, **more: mode != os.W_OK and allowed(path, mode, **more))  # root may write anywhere
    result = masonry_cd("run", scene, "-o", tmp_path / "out")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"masonry-cd: error: {tmp_path}: this folder is not writable")


@pytest.mark.slow(reason="a process of its own loads the kernels again")
def test_ctrl_c_leaves_readable_results(block_on_plate, tmp_path):
    out = tmp_path / "out"
    scene = block_on_plate(duration="duration = 3000.0\ncheckpoint_every = 0.1")
    command = [sys.executable, "-m", "masonry_cd", "run", str(scene), "-o", str(out)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not (out / "checkpoint.npz").exists() and process.poll() is None:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert process.returncode == 130, errors
    assert "interrupted after step" in errors
    steps = json.loads((out / "summary.json").read_text())["steps"]
    with Results.open(out / "result.h5") as results:
        assert 0 < steps < 3_000_000
        assert results.frames == 1 + steps // 20
        assert len(results.per_step("solver/error")) == steps
        assert np.isfinite(results.position[results.frames - 1]).all()


def signals_in(monkeypatch, owner: type, name: str, call: int, number: int = signal.SIGINT, times: int = 3) -> None:
    """Raise a signal several times at the end of the n-th call of a method in a run, in the midst of a step or of a write."""
    original, calls = getattr(owner, name), 0

    def called(*args: object) -> object:
        nonlocal calls
        calls += isinstance(getattr(signal.getsignal(number), "__self__", None), Interrupt)  # not those that compile the kernels
        out = original(*args)
        if calls == call:
            calls += 1
            for _ in range(times):
                signal.raise_signal(number)
        return out

    monkeypatch.setattr(owner, name, called)


SHAKEN = {"friction": "friction = 0.3", "amplitude": "amplitude = 0.6", "duration": "duration = 0.15"}


@pytest.mark.parametrize(
    ("owner", "name", "call"),
    [
        (Detector, "detect", 77),
        (Islands, "solve", 77),
        (Recorder, "step", 77),
        (Recorder, "write_frame", 3),
        (ResultWriter, "append", 8),
        (ResultWriter, "flush", 2),
    ],
)
def test_interrupts_are_taken_between_steps_only(block_on_plate, tmp_path, monkeypatch, owner, name, call):
    """However often Ctrl-C is pressed, and wherever: the run goes on to the same bits."""
    scene = block_on_plate(**SHAKEN)
    assert masonry_cd("run", scene, "-o", tmp_path / "whole", "-q").exit_code == 0
    with monkeypatch.context() as pressed:
        signals_in(pressed, owner, name, call)
        if name == "flush":
            signals_in(pressed, Stepper, "step", 77, times=1)
        result = masonry_cd("run", scene, "-o", tmp_path / "out", "-q")
    assert result.exit_code == 130, result.output
    assert result.stderr.count("finishing the step; results are being written") == 1
    steps = json.loads((tmp_path / "out" / "summary.json").read_text())["steps"]
    with Results.open(tmp_path / "out" / "result.h5") as results:
        assert len(results.per_step("step_time")) == steps < 150
    done("run", scene, "-o", tmp_path / "out", "-q", "--resume")
    assert contents(tmp_path / "out" / "result.h5") == contents(tmp_path / "whole" / "result.h5")


@pytest.mark.parametrize("number", STOPPING)
def test_signals_end_a_run_with_a_word_on_how_to_go_on(block_on_plate, tmp_path, monkeypatch, request, number):
    former = signal.signal(number, signal.SIG_DFL)  # or else a signal that nohup has tests ignore stays ignored, as it should
    request.addfinalizer(lambda: signal.signal(number, former))
    scene, out = block_on_plate(**SHAKEN), tmp_path / "out"
    signals_in(monkeypatch, Stepper, "step", 5, number)
    result = masonry_cd("run", scene, "-o", out, "-q", "--set", "run.duration=0.01")
    assert result.exit_code == 128 + number
    advice = result.stderr.splitlines()[-1]
    assert advice == f"masonry-cd: continue with: masonry-cd run {scene} -o {out} -q --set run.duration=0.01 --resume"
    assert json.loads((out / "summary.json").read_text())["steps"] == 5
    result = masonry_cd(*advice.split()[4:])
    assert result.exit_code == 0 and "of the cycles" in result.stderr  # 0.01 s are 2 % of its load
    assert json.loads((out / "summary.json").read_text())["steps"] == 10
    assert not list(out.glob("checkpoint*"))


def test_ctrl_c_leaves_the_reports_that_were_asked_for(block_on_plate, tmp_path, monkeypatch):
    """Outputs of what is there are provisional; a second Ctrl-C ends their drawing. SIGTERM leaves no time for them."""
    scene, out = block_on_plate(**SHAKEN, report="[report]\ndamage = true"), tmp_path / "out"
    with monkeypatch.context() as pressed:
        signals_in(pressed, Stepper, "step", 60)
        result = masonry_cd("run", scene, "-o", out)
    assert result.exit_code == 130
    summary = json.loads((out / "summary.json").read_text())
    assert summary["provisional"].startswith("provisional: interrupted after step 60")
    assert summary["parts"][-1]["provisional"] == summary["provisional"]
    assert (out / "damage.csv").exists()
    assert f"grades, mechanisms and residual values are {summary['provisional']}" in result.stdout
    assert result.stderr.splitlines()[-1].startswith("masonry-cd: continue with: masonry-cd run ")
    for number in (signal.SIGINT, signal.SIGTERM):
        with monkeypatch.context() as pressed:
            signals_in(pressed, Stepper, "step", 60, number)
            drawn = []
            pressed.setattr(damage_files, "write_part_damage", lambda *_, d=drawn: (d.append(1), signal.raise_signal(signal.SIGINT)))
            result = masonry_cd("run", scene, "-o", tmp_path / str(number))
        assert result.exit_code == 128 + number
        assert not (tmp_path / str(number) / "damage.csv").exists()
        assert bool(drawn) == (number == signal.SIGINT)
        assert "continue with: masonry-cd run" in result.stderr


def test_a_folder_belongs_to_one_run_at_a_time(block_on_plate, tmp_path, monkeypatch):
    scene, out, second = block_on_plate(duration="duration = 0.01"), tmp_path / "out", []
    advance = Stepper.step

    def step(self: Stepper) -> object:
        if (out / "run.lock").exists() and not second:
            second.append(None)
            second[0] = masonry_cd("run", scene, "-o", out, "-q", "--force")
        return advance(self)

    monkeypatch.setattr(Stepper, "step", step)
    assert masonry_cd("run", scene, "-o", out, "-q").exit_code == 0
    assert second[0].exit_code == 2
    assert f"another run is writing to this folder (process {os.getpid()} on " in second[0].stderr
    assert len(second[0].stderr.splitlines()) == 1
    assert not (out / "run.lock").exists()


def test_the_lock_of_a_dead_run_is_taken_over(block_on_plate, tmp_path):
    scene, out = block_on_plate(duration="duration = 0.01"), tmp_path / "out"
    take = f"held = locked(pathlib.Path({str(out)!r})); held.__enter__(); os._exit(9)"
    code = f"import os, pathlib; from masonry_cd.io.lock import locked; {take}"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 9
    holder = json.loads((out / "run.lock").read_text())
    assert masonry_cd("run", scene, "-o", out, "-q").exit_code == 0
    for change, code in (
        ({"pid": os.getpid()}, 0),  # the number is in use again, by another process
        ({"host": "elsewhere"}, 0),  # a container of this machine that had another name
        ({"host": "elsewhere", "started": "1 of-another-boot"}, 2),  # another machine, which cannot be asked
        ({"host": "elsewhere", "held": False}, 2),  # one whose system holds no files
    ):
        (out / "run.lock").write_text(json.dumps(holder | change))
        ended = masonry_cd("run", scene, "-o", out, "-q", "--force")
        assert ended.exit_code == code
        assert (f"remove {out / 'run.lock'}" in ended.stderr) == (code == 2)


def test_a_live_run_in_another_container_is_refused(tmp_path):
    """It has another name and a number that is nobody's here; the kernel, which both share, says that it holds the file."""
    with locked(tmp_path):
        holder = json.loads((tmp_path / "run.lock").read_text())
        for change in ({"host": "elsewhere", "pid": 1}, {"pid": 2**30}, {"host": "elsewhere", "started": "1 of-another-boot"}):
            (tmp_path / "run.lock").write_text(json.dumps(holder | change))
            with pytest.raises(InputError, match="another run is writing to this folder"), locked(tmp_path):
                pass


def test_what_follows_the_steps_can_be_finished(block_on_plate, tmp_path, monkeypatch):
    """A run that ended between its last step and its last file: the results are whole, the rest is written by --resume."""
    scene, out = block_on_plate(**SHAKEN), tmp_path / "out"
    with monkeypatch.context() as pressed:
        pressed.setattr(damage_files, "write_joint_damage", lambda *_: signal.raise_signal(signal.SIGINT))
        result = masonry_cd("run", scene, "-o", out, "-q", "--set", "run.duration=0.01")
    assert result.exit_code == 130
    assert "continue with: masonry-cd run" in result.stderr
    assert not (out / "summary.json").exists()
    before = contents(out / "result.h5")
    assert masonry_cd("run", scene, "-o", out, "-q", "--set", "run.duration=0.01", "--resume").exit_code == 0
    assert json.loads((out / "summary.json").read_text())["steps"] == 10
    assert (out / "joints.csv").exists()
    assert contents(out / "result.h5") == before
    assert not list(out.glob("checkpoint*"))


@pytest.mark.parametrize("place", [5, 0.3, 0.7, 0.99])
def test_a_damaged_checkpoint_is_one_line_or_gives_way_to_the_one_before(block_on_plate, tmp_path, monkeypatch, place):
    scene, out = block_on_plate(**SHAKEN), tmp_path / "out"
    asked = ("run", scene, "-o", out, "-q", "--set", "run.checkpoint_every=0", "--set", "run.duration=0.02")
    with monkeypatch.context() as pressed:
        signals_in(pressed, Stepper, "step", 7)
        assert masonry_cd(*asked).exit_code == 130
    newest, older = out / "checkpoint.npz", out / "checkpoint_before.npz"
    data = bytearray(newest.read_bytes())
    at = place if place >= 1 else int(place * len(data))
    data[at : at + 40] = bytes(255 - byte for byte in data[at : at + 40])
    newest.write_bytes(data)
    kept = older.read_bytes()
    older.unlink()
    result = masonry_cd(*asked, "--resume")
    assert (result.exit_code, len(result.stderr.splitlines())) == (2, 1)
    assert "checkpoint.npz: not a readable checkpoint" in result.stderr
    older.write_bytes(kept)
    result = done(*asked, "--resume")
    assert "the run continues from the previous checkpoint" in result.stderr
    assert json.loads((out / "summary.json").read_text())["steps"] == 20


def test_a_checkpoint_continues_its_own_results_alone(block_on_plate, tmp_path, monkeypatch):
    scene = block_on_plate(**SHAKEN)
    for name, call in (("one", 30), ("two", 40)):
        with monkeypatch.context() as pressed:
            signals_in(pressed, Stepper, "step", call)
            assert masonry_cd("run", scene, "-o", tmp_path / name, "-q").exit_code == 130
    (tmp_path / "one" / "checkpoint.npz").replace(tmp_path / "two" / "checkpoint.npz")
    before = (tmp_path / "two" / "result.h5").read_bytes()
    result = masonry_cd("run", scene, "-o", tmp_path / "two", "-q", "--resume")
    assert result.exit_code == 2
    assert result.stderr.endswith("result.h5: the checkpoint next to it belongs to other results, so the run cannot be resumed\n")
    assert len(result.stderr.splitlines()) == 1
    assert (tmp_path / "two" / "result.h5").read_bytes() == before


def test_build_writes_blocks_that_a_scene_reads_back(tmp_path):
    arch = EXAMPLES / "arch.toml"
    result = done("build", arch, "-o", tmp_path, "--no-picture", "--set", "structure.voussoirs=9")
    assert "9 blocks and 3 fixed ones, 10 joints" in result.stdout
    text = arch.read_text()
    head, tail = text[: text.index("[structure]")], text[text.index("[material]") :]
    (tmp_path / "again.toml").write_text(head + '[structure]\nkind = "file"\npath = "blocks.json"\n' + tail)
    again = masonry_cd("build", tmp_path / "again.toml", "-o", tmp_path / "again", "--no-picture")
    assert again.stdout.splitlines()[0] == result.stdout.splitlines()[0]
    one, two = (json.loads((folder / "blocks.json").read_text()) for folder in (tmp_path, tmp_path / "again"))
    assert one == two


def test_build_writes_the_formats_asked_for(tmp_path):
    arch = EXAMPLES / "arch.toml"
    done("build", arch, "-o", tmp_path, "--no-picture", "--format", "obj", "--format", "vtkhdf", "--format", "obj")
    assert sorted(path.name for path in tmp_path.glob("[!.]*")) == ["blocks.obj", "blocks.vtkhdf"]
    assert masonry_cd("build", arch, "-o", tmp_path, "--no-picture", "--format", "obj").exit_code == 2  # there is one already


def test_build_repairs_a_file_and_says_what_it_moved(block_on_plate, tmp_path):
    scene = block_on_plate()
    text = json.loads((tmp_path / "blocks.json").read_text())
    text["blocks"][1]["vertices"] = [[x, y, z + 0.001] for x, y, z in text["blocks"][1]["vertices"]]
    (tmp_path / "blocks.json").write_text(json.dumps(text))
    warned = masonry_cd("build", scene, "-o", tmp_path / "loose", "--no-picture")
    assert (warned.exit_code, "touches no other block" in warned.stderr) == (0, True)
    ran = masonry_cd("run", scene, "-o", tmp_path / "run", "--set", "run.duration=0.01")
    said = next(line for line in warned.stderr.splitlines() if "touches no other block" in line)
    assert said in ran.stderr, "build and run judge alike"
    result = masonry_cd("build", scene, "-o", tmp_path / "a", "--no-picture", "--repair", "gaps=0.002")
    assert "1 pairs of faces brought together, corners moved by at most 0.0009" in result.stdout


def test_build_draws_what_is_wrong(block_on_plate, tmp_path):
    scene = block_on_plate()
    text = json.loads((tmp_path / "blocks.json").read_text())
    text["blocks"][1]["faces"].pop()
    (tmp_path / "blocks.json").write_text(json.dumps(text))
    result = masonry_cd("build", scene, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert 'block "block": open shell' in result.stderr
    assert [path.name for path in (tmp_path / "out").glob("[!.]*")] == ["problem.png"]
    assert masonry_cd("build", scene, "-o", tmp_path / "bare", "--no-picture").exit_code == 2
    assert not (tmp_path / "bare").exists()


def test_pictures_are_drawn_where_asked_for(block_on_plate, tmp_path):
    scene = block_on_plate(duration="duration = 0.25", report="[report]\ncrack_map = true")
    result = done("run", scene, "-o", tmp_path / "out")
    assert "crack_map.png" in result.stdout
    assert (tmp_path / "out" / "crack_map.png").read_bytes().startswith(b"\x89PNG")
    assert masonry_cd("build", scene, "-o", tmp_path / "blocks").exit_code == 0
    assert (tmp_path / "blocks" / "structure.png").read_bytes().startswith(b"\x89PNG")


def test_solve_tells_the_error_of_its_solution(tmp_path):
    problem = LocalProblem(sparse.identity(3, format="csr"), np.array([[-1.0, 0.2, 0.0]]), np.array([0.5]))  # one contact that sticks
    write_problem(tmp_path / "one.npz", problem)
    result = done("solve", tmp_path / "one.npz", "--solver", "nlgs", "--json", "-o", tmp_path / "solution.npz")
    found = json.loads(result.stdout)
    assert found.keys() >= {"error", "error_unscaled", "iterations", "seconds", "converged"}
    assert found["converged"]
    solution = np.load(tmp_path / "solution.npz")
    assert solution["r"] == pytest.approx(np.array([[1.0, -0.2, 0.0]]), abs=1e-8)
    assert solution["u"] == pytest.approx(np.zeros((1, 3)), abs=1e-8)


def test_record_draws_a_picture_of_what_it_prints(tmp_path):
    file = tmp_path / "shock.csv"
    times = np.arange(0.0, 2.0, 0.01)
    rows = "\n".join(f"{t:.2f},{np.sin(9 * t) * np.exp(-t):.6f}" for t in times)
    file.write_text(f"time_s,a_m_s2\n{rows}\n")
    result = done("record", file, "-o", tmp_path / "shock.png")
    assert {BEFORE, AFTER} <= main_colours(tmp_path / "shock.png")
    assert re.search(r"Arias intensity \S+ m/s, CAV \S+ m/s, significant duration \S+ s", result.stdout)
    assert re.search(r"Sa\(0\.1\) \S+ m/s2, .*Sa\(2\) \S+ m/s2\n", result.stdout)
    alone = masonry_cd("record", file)
    assert alone.stdout + f"written: {tmp_path / 'shock.png'}\n" == result.stdout
    assert sorted(path.name for path in tmp_path.iterdir()) == ["shock.csv", "shock.png"]


def test_what_the_scene_asks_of_the_reports_is_written_after_the_run(block_on_plate, tmp_path):
    asked = '[report]\ndamage = true\ngrades.width = [{}]\ngrades.labels = ["a", "b", "c", "d", "e", "f"]'
    scene = block_on_plate(duration="duration = 0.05", report=asked.format("1e-9, 1e-8, 1, 2, inf"))
    modules, errors = modules_loaded_by(tmp_path, "run", scene, "-o", "out", "-q")
    document = json.loads((tmp_path / "out" / "damage.json").read_text())
    assert (document["parts"][-1]["grade"], document["parts"][-1]["grade_label"]) == ("D2", "c"), errors
    summary = read_summary(tmp_path / "out")
    assert any(line.split()[:2] == [document["parts"][-1]["part"], "D2"] for line in closing_lines(summary))
    assert not {"matplotlib", "vtk", "vtkmodules", "pyvista"} & modules
    asked = tmp_path / "out" / "damage.json"
    masonry_cd("run", block_on_plate(duration="duration = 0.02"), "-o", tmp_path / "out", "-q", "--force")
    assert not asked.exists(), "what a former run left must not pass for this one's"


def test_numbers_are_kept_when_a_picture_fails(block_on_plate, tmp_path, monkeypatch):
    from reports import outputs

    def fail(*_: object) -> None:
        raise InputError("", "no off-screen OpenGL")

    monkeypatch.setattr(outputs, "write_asked", fail)
    scene = block_on_plate(duration="duration = 0.01", report="[report]\ncrack_map = true")
    result = masonry_cd("run", scene, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert "no off-screen OpenGL" in result.stderr
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["steps"] == 10
    assert (tmp_path / "out" / "joints.csv").exists()


@pytest.mark.parametrize("words", [("init", "arch", "-o", "{}/arch.toml"), ("schema", "-o", "{}/schema.json")])
def test_what_the_system_refuses_is_one_line_with_the_file_in_front(tmp_path, words):
    """A file lies where a folder would have to."""
    (tmp_path / "taken").write_text("")
    result = masonry_cd(*(word.format(tmp_path / "taken") for word in words))
    assert (result.exit_code, result.stdout) == (1, "")
    assert re.fullmatch(rf"masonry-cd: error: {tmp_path}/taken\S*: (not a directory|file exists)\n", result.stderr)


def test_a_kernel_that_the_disc_does_not_take_is_reported_once(block_on_plate, tmp_path, monkeypatch):
    monkeypatch.setattr(case, "lost", lambda: OSError(28, "No space left on device", "x.nbc"))
    scene, said = block_on_plate(), "masonry-cd: warning: compiled kernels could not be kept, the next run compiles them again: x.nbc: "
    first, second = (masonry_cd("run", scene, "-o", tmp_path / name) for name in "ab")
    assert (first.exit_code, second.exit_code) == (0, 0)
    assert [line for line in first.stderr.splitlines() if "kept" in line] == [f"{said}no space left on device"]
    assert "could not be kept" not in second.stderr


def test_a_reader_that_goes_away_leaves_one_line(block_on_plate, tmp_path):
    """As in: masonry-cd run ... | head -1"""
    command = [sys.executable, "-m", "masonry_cd", "run", str(block_on_plate(duration="duration = 0.02")), "-o", str(tmp_path / "out")]
    read, write = os.pipe()
    os.close(read)
    ended = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    lines = [line for line in ended.stderr.splitlines() if not line.startswith("compiling")]
    assert (ended.returncode, lines) == (1, ["masonry-cd: error: the program that reads the output has gone (broken pipe)"])


@pytest.fixture(scope="module")
def smooth(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run of 0.1 s in which the plate slides off under its block."""
    folder = tmp_path_factory.mktemp("smooth")
    done("run", write_plate_scene(folder), "-o", folder / "out", "-q", "--set", "run.duration=0.1")
    return folder / "out"


def test_reports_are_redone_from_the_results_alone_which_keep_the_scene_that_was_run(smooth, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(smooth, out)
    (out / "joints.csv").unlink()
    done("report", out, "--no-crack-map", "--times", "0.02,0.1", "--cut", "y")
    assert (out / "joints.csv").read_bytes() == (smooth / "joints.csv").read_bytes()
    written = {"crack_map_0.02s.png", "crack_map_0.1s.png", "damage.csv", "damage.json", "hinges.csv", "drift.csv"}
    assert written <= {path.name for path in out.iterdir()}
    parts = json.loads((out / "damage.json").read_text())["parts"]
    assert [(row["part"], row["grade"], row["mechanism"]) for row in parts][:1] == [("block", "D2", "sliding")]
    with Results.open(out / "result.h5") as results:
        assert "duration = 0.1" in results.scene and results.title == "Block on a plate"
        assert results.time[-1] == pytest.approx(0.1)


def test_runs_are_exported_and_compared(smooth, block_on_plate, tmp_path):
    masonry_cd("run", block_on_plate(duration="duration = 0.1", friction="friction = 0.6"), "-o", tmp_path / "rough", "-q")
    result = done("export", smooth, "-o", tmp_path / "view")
    assert {path.name for path in (tmp_path / "view").glob("[!.]*")} == {"blocks.vtkhdf", "joints.vtkhdf", "names.csv"}
    result = done("compare", smooth, tmp_path / "rough")
    lines = {line.split("|")[1].strip(): line.split("|")[3:5] for line in result.stdout.splitlines()}
    assert [cell.strip() for cell in lines["material.friction"]] == ["0", "0.6"]
    assert [cell.strip() for cell in lines["joints slid"]] == ["1", "0"]
