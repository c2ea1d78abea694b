# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs from Python: the bits of the command line, folders, interrupts, threads, and going on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import done, masonry_cd
from hostile import refused_at
from made_run import at_rest, box, write_run
from places import ROOT
from two_blocks import shaking, two_blocks

import masonry_cd as mc
from masonry_cd.app.progress import Progress

pytestmark = pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")  # short, coarse and strong, as wanted here


def command(*words: object) -> str:
    """Run the command line; return what it prints."""
    return done(*words).output


def same_bits(one: mc.Run, other: mc.Run) -> bool:
    """Return True if two runs hold the same frames and steps."""
    with one.results() as a, other.results() as b:
        return (
            all(np.array_equal(a.file[name][...], b.file[name][...]) for name in ("time", "position", "orientation", "velocity"))
            and all(np.array_equal(values, b.energies[name]) for name, values in a.energies.items())
            and all(np.array_equal(values, b.peaks[name], equal_nan=True) for name, values in a.peaks.items())
        )


def test_a_duration_that_follows_from_the_loads_is_kept(tmp_path: Path) -> None:
    made = two_blocks()
    made["run"].pop("duration")
    run = mc.run(mc.scene(made), tmp_path / "out", progress=False)
    last = run.summary["steps"] * made["run"]["dt"]
    assert run.summary["duration"] == pytest.approx(last) and last > 0.0
    assert run.summary["steps_asked"] == run.summary["steps"]


@pytest.fixture
def interrupted(monkeypatch: pytest.MonkeyPatch) -> Iterator[pytest.MonkeyPatch]:
    """Ctrl-C comes during the 20th step; undoing the fixture's patches lets runs end."""
    calls = Progress.__call__

    def call(self: Progress, done: int) -> None:
        if done == 20:
            os.kill(os.getpid(), signal.SIGINT)
        calls(self, done)

    with monkeypatch.context() as patched:
        patched.setattr(Progress, "__call__", call)
        yield patched


def test_a_run_has_the_bits_of_the_command_line(tables: dict[str, Any], tmp_path: Path) -> None:
    made = mc.scene(tables | {"loads": [shaking(3)]})
    file = made.write(tmp_path / "two.toml")
    command("run", file, "-o", tmp_path / "cli", "-q")
    run = mc.run(made, tmp_path / "python", progress=False)
    assert same_bits(run, mc.open(tmp_path / "cli"))
    assert same_bits(run, mc.run(file, progress=False))
    assert run.joints.drop(columns=["x", "y", "z"]).equals(mc.open(str(tmp_path / "cli")).joints.drop(columns=["x", "y", "z"]))


def test_a_folder_of_its_own_lives_as_long_as_the_run(tables: dict[str, Any]) -> None:
    run = mc.run(tables, progress=False)
    folder = run.folder
    assert {"result.h5", "summary.json", "joints.csv", "blocks.json", "scene.toml"} <= {path.name for path in folder.iterdir()}
    del run
    assert not folder.exists()


def test_a_folder_that_holds_results_is_refused(tables: dict[str, Any], tmp_path: Path) -> None:
    mc.run(tables, tmp_path, progress=False)
    with pytest.raises(mc.InputError, match="holds results already; choose another folder with -o, or overwrite them with --force"):
        mc.run(tables, tmp_path)
    assert mc.run(mc.open(tmp_path).scene.changed("run.duration=0.04"), tmp_path, force=True, progress=False).time[-1] == pytest.approx(
        0.04
    )


def test_files_of_ones_own_in_the_folder_are_not_overwritten(tables: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "blocks.json").write_text("mine")
    for force in (False, True):
        with pytest.raises(mc.InputError, match=r"did not write.*blocks\.json"):
            mc.run(tables, tmp_path, force=force, progress=False)
        assert [path.name for path in tmp_path.iterdir()] == ["blocks.json"]
        assert (tmp_path / "blocks.json").read_text() == "mine"
    mc.run(tables, tmp_path / "out", progress=False)
    assert mc.run(tables, tmp_path / "out", force=True, progress=False).scene.structure.names == ["b0", "b1", "b2"]


def test_nothing_is_written_before_all_is_checked(tables: dict[str, Any], tmp_path: Path) -> None:
    with refused_at("loads[0].cycles"):
        mc.run(mc.scene(tables, "loads[0].cycles=-1"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_progress_is_shown_on_standard_error_or_not_at_all(
    tables: dict[str, Any], capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("masonry_cd.app.progress.LINE_SECONDS", 0.0)
    mc.run(tables, progress=False)
    assert capfd.readouterr() == ("", "")
    mc.run(tables)
    out, err = capfd.readouterr()
    assert (out, "step 50 of 50 (100 %)" in err) == ("", True)


def test_the_scene_of_a_run_makes_it_again(tables: dict[str, Any], tmp_path: Path) -> None:
    made = mc.scene(tables | {"loads": [shaking(2)]})
    run = mc.run(made, tmp_path / "first", progress=False)
    text, scene = made.text, mc.open(tmp_path / "first").scene
    del made
    (tmp_path / "first").rename(tmp_path / "moved")
    assert scene.text == text == mc.open(tmp_path / "moved").scene.text
    again = mc.run(mc.open(tmp_path / "moved").scene, progress=False)
    with again.results() as a, mc.open(tmp_path / "moved").results() as b:
        assert np.array_equal(a.file["position"][...], b.file["position"][...])
    assert mc.open(tmp_path / "moved").scene.changed("run.dt=1e-3").tables["run"]["dt"] == 1e-3
    assert run.title == "Two blocks"


def test_the_scene_of_a_run_of_a_file_is_read_where_the_file_lies(tables: dict[str, Any], tmp_path: Path) -> None:
    file = mc.scene(tables).write(tmp_path / "own" / "two.toml")
    command("run", file, "-o", tmp_path / "out", "-q", "--set", "run.duration=0.04")
    scene = mc.open(tmp_path / "out").scene
    assert scene.tables["run"]["duration"] == 0.04
    assert scene.structure.names == ["b0", "b1", "b2"]
    assert scene.changed("run.dt=1e-3").tables["run"]["dt"] == 1e-3
    with refused_at("run.dt"):
        scene.changed("run.dt=0")
    file.unlink()
    (tmp_path / "own" / "blocks.json").unlink()
    with refused_at("structure.path"):
        _ = mc.open(tmp_path / "out").scene.structure


@pytest.mark.parametrize("by", ["python", "command line"])
def test_ctrl_c_ends_a_run_that_reads_and_goes_on(interrupted: pytest.MonkeyPatch, tables: dict[str, Any], tmp_path: Path, by: str) -> None:
    run = mc.run(mc.scene(tables | {"loads": [shaking(3)]}), tmp_path / "cut", progress=False)
    assert run.stopped == "interrupted after step 20"
    assert repr(run) == '<Run "Two blocks": 3 frames to 0.04 s, interrupted after step 20>'
    assert (len(run.steps), len(run.blocks()), run.summary["steps"]) == (20, 3, 20)
    assert "interrupted" in run.provisional
    assert "the run ended early, interrupted after step 20" in run._repr_html_()
    interrupted.undo()
    whole = mc.run(run.scene, progress=False)
    if by == "python":
        ended = mc.resume(run, progress=False)
    else:
        command("run", tmp_path / "cut" / "scene.toml", "-o", tmp_path / "cut", "--resume", "-q")
        ended = mc.open(tmp_path / "cut")
    assert ended.stopped == ""
    assert same_bits(ended, whole)
    with pytest.raises(mc.InputError, match="no checkpoint to resume from"):
        mc.resume(tmp_path / "cut")


def test_a_run_of_the_command_line_goes_on_in_python(interrupted: pytest.MonkeyPatch, tables: dict[str, Any], tmp_path: Path) -> None:
    file = mc.scene(tables).write(tmp_path / "two.toml")
    stopped = masonry_cd("run", file, "-o", tmp_path / "cut", "-q", "--set", "run.duration=0.08")
    assert stopped.exit_code == 130
    interrupted.undo()
    assert same_bits(mc.resume(str(tmp_path / "cut"), progress=False), mc.run(mc.scene(file, "run.duration=0.08"), progress=False))


def test_an_interrupted_run_without_a_folder_goes_on_too(interrupted: pytest.MonkeyPatch, tables: dict[str, Any]) -> None:
    run = mc.run(tables, progress=False)
    interrupted.undo()
    ended = mc.resume(run, progress=False)
    del run
    assert (ended.stopped, ended.folder.exists(), ended.time[-1]) == ("", True, pytest.approx(0.1))


def test_a_run_in_another_thread_is_the_same_and_leaves_signals_alone(tables: dict[str, Any]) -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    found: list[mc.Run | BaseException] = []

    def work() -> None:
        try:
            found.append(mc.run(tables, progress=False))
        except BaseException as error:
            found.append(error)

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    here = mc.run(tables, progress=False)
    assert all(isinstance(run, mc.Run) and same_bits(run, here) for run in found), found
    assert len(found) == 2
    assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == before


@pytest.mark.slow(reason="a process of its own loads the kernels again")
def test_sigterm_ends_python_after_the_step_and_leaves_a_run_to_go_on_with(tables: dict[str, Any], tmp_path: Path) -> None:
    file = mc.scene(tables).write(tmp_path / "two.toml")
    code = (
        "import os, signal, masonry_cd as mc\n"
        "from masonry_cd.app.progress import Progress\n"
        "calls = Progress.__call__\n"
        "def call(self, done):\n"
        "    if done == 20: os.kill(os.getpid(), signal.SIGTERM)\n"
        "    calls(self, done)\n"
        "Progress.__call__ = call\n"
        f"mc.run({str(file)!r}, 'out', progress=False)\n"
        "print('still there')\n"
    )
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    ended = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout) == (-signal.SIGTERM, "")
    assert mc.open(tmp_path / "out").stopped == "stopped by SIGTERM after step 20"
    assert mc.resume(tmp_path / "out", progress=False).stopped == ""


def test_warnings_of_a_run_are_shown(tables: dict[str, Any]) -> None:
    loud = mc.scene(tables | {"loads": [shaking(1, peak=30.0) | {"direction": "x"}]}, "run.duration=0.02")
    with pytest.warns(mc.RunWarning, match="records of interest have 0.005 to 2 g"):
        run = mc.run(loud, progress=False)
    assert any("2 g" in line for line in run.warnings)


def test_a_run_that_was_killed_reads(tmp_path: Path) -> None:
    blocks = [box("base", (-2, -1, -0.5), (2, 1, 0), "base", fixed=True), box("s", (-0.5, -0.5, 0), (0.5, 0.5, 1))]
    scene = '[structure]\nkind = "file"\n'
    write_run(tmp_path / "result.h5", blocks, [at_rest(blocks)] * 3, peaks=False, scene=scene)
    run = mc.open(tmp_path)
    assert (run.stopped, run.summary["joints"], run.summary["collapsed_blocks"]) == ("the run was cut off", 1, 0)
    assert run.lines[0] == "a case: the run was cut off"
    assert "none of 2 blocks fell" in str(run)
    assert run.joints.loc[0, "state"] == "intact"


def test_a_folder_without_a_run_is_refused(tmp_path: Path) -> None:
    with refused_at("result.h5"):
        mc.open(tmp_path)
    with pytest.raises(mc.InputError, match="no checkpoint to resume from"):
        mc.resume(tmp_path)


LATE = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.05, "frequency": 5.0, "cycles": 1, "start": 0.1}


def checked(run: mc.Run) -> dict[str, str]:
    """The verdict of each check by its name."""
    return {row["check"]: row["verdict"] for row in run.summary["verdict"]["checks"]}


@pytest.mark.parametrize(("duration", "share", "wanted"), [(0.05, 0.0, "look"), (0.2, 0.5, "look"), (0.3, 1.0, "good")])
def test_a_run_that_ends_before_its_load_is_to_be_looked_at(tables: dict[str, Any], duration: float, share: float, wanted: str) -> None:
    run = mc.run(
        mc.scene(tables | {"loads": [LATE]}, f"run.duration={duration}", "run.until_still=true" if share == 1.0 else "run.seed=0"),
        progress=False,
    )
    assert run.summary["loads"]["acted"] == [{"load": "loads[0]", "measure": "cycles", "share": pytest.approx(share, abs=0.02)}]
    assert checked(run)["Loads"] == wanted
    assert any("loads[0]" in line and "%" in line for line in run.lines)
    assert any("loads[0]" in line for line in run.warnings) == (wanted == "look")


def test_motions_and_forces_of_python_count_as_well(tables: dict[str, Any]) -> None:
    still = mc.scene({key: value for key, value in tables.items() if key != "loads"}, "run.duration=0.05")
    push = (np.array([0.0, 0.1]), np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    run = mc.Simulation(still, forces={"b2": push}).record(progress=False)
    (row,) = run.summary["loads"]["acted"]
    assert "b2" in row["load"] and row["share"] == pytest.approx(0.5, abs=0.02) and checked(run)["Loads"] == "look"


def test_a_block_that_falls_next_to_its_warning_is_not_good() -> None:
    blocks = [mc.box((-1, -1, -0.5), (1, 1, 0)), mc.box((-0.5, -0.5, 0.1), (0.5, 0.5, 1.1))]
    scene = {
        "structure": {"blocks": blocks, "fixed": "b0"},
        "material": {"density": 2000.0, "friction": 0.5},
        "run": {"dt": 2e-3, "duration": 0.02},
    }
    run = mc.run(mc.scene(scene), progress=False)
    assert any("b1" in line for line in run.warnings)
    assert checked(run)["Model"] == "look" and "b1" in run.summary["verdict"]["why"]
