# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies from end to end: on two workers and on one, continued after kills, grown, and with runs that yield no data."""

from __future__ import annotations

import json
import math
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import studied
from command_line import done, masonry_cd
from studied import GRID, LONG, PATIENCE, SCENE, row_names, rows_without_seconds, started, wait_until, write_scene, write_study
from typer.testing import Result

from masonry_cd.analysis.run_row import RunRow
from masonry_cd.io.results import Results
from masonry_cd.studies.study.clusters import ONE_THREAD, RunPlace
from masonry_cd.studies.study.designs import DesignedRun
from masonry_cd.studies.study.engine import ClusterLost, Engine
from masonry_cd.studies.study.plan import Planned
from masonry_cd.studies.study.task import Outcome, Task


@pytest.fixture(scope="module")
def processes() -> Iterator[str]:
    """The address of a scheduler whose two workers are processes, which may be killed."""
    with studied.cluster(2, env=ONE_THREAD) as address:
        yield address


@pytest.fixture(scope="module")
def study(scheduler: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A grid of six runs, made by two workers: its folder, next to study.toml."""
    folder = tmp_path_factory.mktemp("study")
    write_study(folder)
    result = invoke(folder / "study.toml", "--scheduler", scheduler)
    assert result.exit_code == 0, result.output
    assert "6 of 6 runs done, 0 failed, 0 timed out" in result.stdout, (folder / "out" / "runs.csv").read_text()
    return folder / "out"


def invoke(path: Path, *options: str) -> Result:
    """The command on a study file, its results next to it."""
    with studied.undrawn():
        return masonry_cd("study", path, "-o", path.parent / "out", *options)


# --- what a study leaves ------------------------------------------------------------------------------------------------------------


def test_the_table_has_a_row_of_each_run(study: Path) -> None:
    from pyarrow import parquet

    lines = (study / "runs.csv").read_text().splitlines()
    header = lines[0].split(",")
    first = "run,motion,level,seed,status,reason,seconds,loads[0].amplitude,material.friction,max_opening,max_sliding,displacement_max"
    assert lines[0].startswith(first)
    assert header[-2:] == ["block.grade_number", "block.drift"]
    rows = [dict(zip(header, line.split(",", len(header) - 1), strict=False)) for line in lines[1:]]
    assert [row["loads[0].amplitude"] for row in rows] == ["0.3", "0.3", "0.4", "0.4", "0.6", "0.6"]
    assert {row["status"] for row in rows} == {"done"}
    for slippery, rough in zip(rows[::2], rows[1::2], strict=True):
        assert float(slippery["max_sliding"]) > float(rough["max_sliding"])
    table = parquet.read_table(study / "runs.parquet").to_pydict()
    assert list(table) == header
    assert [repr(value) for value in table["max_sliding"]] == [row["max_sliding"] for row in rows]


def test_the_numbers_are_those_of_a_run(study: Path, tmp_path: Path) -> None:
    done("run", study.parent / "scene.toml", "-o", tmp_path / "run")
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    row = next(row for row in read_rows(study) if row["values"] == {"loads[0].amplitude": 0.4, "material.friction": 0.4})
    assert row["displacement_max"] == summary["displacement_max"]
    assert row["max_sliding"] == summary["sliding_max"]
    assert row["steps"] == summary["steps"]
    assert row["error_max"] == summary["solver"]["error_max"]
    with np.load(study / "joints" / f"{row['run']}.npz") as joints, Results.open(tmp_path / "run" / "result.h5") as results:
        assert joints["sliding"].dtype == np.float32
        assert np.array_equal(joints["sliding"], results.peaks["sliding"].astype(np.float32))
        assert joints["lost"].tolist() == [False]
    assert len({int(np.load(file)["shape"]) for file in (study / "joints").glob("*.npz")}) == 1


def read_rows(study: Path) -> list[dict[str, Any]]:
    """The rows as the engine wrote them."""
    return [json.loads(file.read_text()) for file in sorted((study / "rows").glob("*.json"))]


def test_the_reference_is_the_first_run_of_the_plan(study: Path) -> None:
    first = (study / "runs.csv").read_text().splitlines()[1].partition(",")[0]
    assert (study / "reference" / "run.txt").read_text().strip() == first
    with Results.open(study / "reference" / "result.h5") as results:
        assert [block.name for block in results.blocks] == ["plate", "block"]
    said = json.loads((study / "study.json").read_text())
    assert (said["runs"], said["design"], said["measure"], said["varied"]) == (6, "grid", None, ["loads[0].amplitude", "material.friction"])
    assert said["limit_states"] == {"slid": {"quantity": "max_sliding", "above": 1e-3}}


@pytest.mark.slow(reason="starts a worker")
def test_one_worker_of_its_own_leaves_the_same_bytes(study: Path, tmp_path: Path) -> None:
    result = invoke(write_study(tmp_path), "--workers", "1")
    assert result.exit_code == 0, result.output
    assert "1 worker of this machine, one thread and at most" in result.stderr
    assert rows_without_seconds(tmp_path / "out") == rows_without_seconds(study)
    for file in (study / "joints").glob("*.npz"):
        assert file.read_bytes() == (tmp_path / "out" / "joints" / file.name).read_bytes()


# --- going on -----------------------------------------------------------------------------------------------------------------------


def test_the_same_command_makes_no_run_again(study: Path) -> None:
    before, table = row_names(study), (study / "runs.csv").read_bytes()
    result = invoke(study.parent / "study.toml", "--scheduler", "tcp://127.0.0.1:1")  # of which none is needed
    assert result.exit_code == 0, result.output
    assert row_names(study) == before
    assert (study / "runs.csv").read_bytes() == table


def test_more_values_make_their_own_runs_only(study: Path, scheduler: str, tmp_path: Path) -> None:
    small = write_study(tmp_path, GRID, **{'"loads': '"loads[0].amplitude" = [0.4]'})
    assert invoke(small, "--scheduler", scheduler).exit_code == 0
    before = row_names(tmp_path / "out")
    write_study(tmp_path)
    result = invoke(small, "--scheduler", scheduler)
    assert "6 runs, 4 still to run" in result.stderr
    assert {name: row_names(tmp_path / "out")[name] for name in before} == before
    assert rows_without_seconds(tmp_path / "out") == rows_without_seconds(study)
    assert (tmp_path / "out" / "reference" / "run.txt").read_bytes() == (study / "reference" / "run.txt").read_bytes()


@pytest.mark.parametrize(
    ("what", "old", "new"),
    [
        ("design", '"grid"', '"sample"\nsamples = 4'),
        ("intensity measure", "[vary]", '[intensity]\nkey = "loads[0].frequency"\nlevels = [1.0]\n[vary]'),
        ("set of varied keys or distributions", '"material.friction" = [0.2, 0.4]\n', ""),
    ],
)
def test_the_folder_of_another_study_is_refused(study: Path, what: str, old: str, new: str) -> None:
    before, other = row_names(study), study.parent / "other.toml"
    other.write_text(GRID.replace(old, new))
    result = invoke(other)
    assert result.exit_code == 2
    assert f"{study}: " in result.stderr and f"of another {what};" in result.stderr
    assert row_names(study) == before


def test_an_ida_hunts_and_its_runs_are_found_again(scheduler: str, tmp_path: Path) -> None:
    studied.write_records(tmp_path)
    hunt = '[ida]\nlimit_state = "slid"\nstart = 2.0\nstep = 2.0\nresolution = 0.3\nfill = 0\n'
    path = write_study(tmp_path, studied.RECORDS.replace("stripes", "ida").replace("levels = [1.0, 2.0, 4.0]", "") + hunt)
    write_scene(tmp_path, SCENE.replace("amplitude = 0.4", "amplitude = 0.0"))
    result = invoke(path, "--scheduler", scheduler)
    assert result.exit_code == 0, result.output
    rows = read_rows(tmp_path / "out")
    for motion in studied.NAMES:
        own = {row["level"]: row["max_sliding"] > 1e-3 for row in rows if row["motion"] == motion}
        capacity = min(level for level, slid in own.items() if slid)
        assert capacity > 0.4 * 9.81  # a rigid block slides where the base accelerates beyond mu g
        assert capacity - max(level for level in own if level < capacity) <= 0.3 * capacity
    assert json.loads((tmp_path / "out" / "study.json").read_text())["runs"] == len(rows)
    table = rows_without_seconds(tmp_path / "out")
    again = invoke(path)
    assert f"{len(rows)} runs so far, 0 still to run" in again.stderr
    assert rows_without_seconds(tmp_path / "out") == table


def test_adaptive_stripes_make_some_of_the_runs_and_stripes_make_the_others(scheduler: str, tmp_path: Path) -> None:
    studied.write_records(tmp_path)
    write_scene(tmp_path, SCENE.replace("amplitude = 0.4", "amplitude = 0.0"))
    path = write_study(tmp_path, studied.RECORDS + '[adaptive]\nlimit_state = "slid"\nruns = 6\nbatch = 3\n')
    result = invoke(path, "--scheduler", scheduler)
    assert result.exit_code == 0, result.output
    assert "slid: 6 of 9 runs know its median to " in result.stdout
    chosen = rows_without_seconds(tmp_path / "out")
    assert json.loads((tmp_path / "out" / "study.json").read_text())["runs"] == len(chosen) - 1 == 6
    again = invoke(path)
    assert "6 runs so far, 0 still to run" in again.stderr
    write_study(tmp_path, studied.RECORDS)
    result = invoke(path, "--scheduler", scheduler)
    assert "9 runs, 3 still to run" in result.stderr
    write_study(tmp_path, studied.RECORDS + '[adaptive]\nlimit_state = "slid"\nruns = 6\nbatch = 3\n')
    assert invoke(path).exit_code == 0  # of runs that are there
    assert rows_without_seconds(tmp_path / "out") == chosen


@pytest.fixture
def long(tmp_path: Path) -> Path:
    """A study of 18 runs that take a while."""
    return write_study(tmp_path, GRID, **LONG)


@pytest.mark.slow(reason="a program of its own with a worker, 18 runs")
def test_a_program_that_is_killed_goes_on(long: Path, scheduler: str) -> None:
    program = started(long, "--workers", "1")
    wait_until(lambda: len(row_names(long.parent / "out")) >= 2 or program.poll() is not None)
    program.kill()
    program.communicate()
    before = row_names(long.parent / "out")
    assert 2 <= len(before) < 18
    torn = long.parent / "out" / "rows" / f"{min(before)}.part.json"  # as a kill leaves it that comes while a row is written
    torn.write_bytes((long.parent / "out" / "rows" / f"{min(before)}.json").read_bytes())
    result = invoke(long, "--scheduler", scheduler, "--resume")
    assert f"18 runs, {18 - len(before)} still to run" in result.stderr
    assert "18 of 18 runs done" in result.stdout
    assert {name: row_names(long.parent / "out")[name] for name in before} == before
    assert not list((long.parent / "out").rglob("*.part*"))


@pytest.mark.slow(reason="a program of its own with a worker")
def test_ctrl_c_ends_a_study_and_says_how_to_go_on(long: Path) -> None:
    program = started(long, "--workers", "1")
    wait_until(lambda: len(row_names(long.parent / "out")) >= 1 or program.poll() is not None)
    os.killpg(program.pid, signal.SIGINT)
    _, said = program.communicate(timeout=PATIENCE)
    assert program.returncode == 130
    lines = [line for line in said.splitlines() if line.startswith("masonry-cd: ")]
    assert lines[-2].startswith("masonry-cd: warning: interrupted")
    assert lines[-1] == f"masonry-cd: continue with: masonry-cd study {long} -o {long.parent / 'out'} --workers 1"
    assert "Traceback" not in said
    assert 1 <= len(row_names(long.parent / "out")) < 18


# --- runs without data --------------------------------------------------------------------------------------------------------------


def test_a_run_out_of_time_is_a_row_and_made_again_when_asked(scheduler: str, tmp_path: Path) -> None:
    path = write_study(tmp_path, GRID + "[run]\ntimeout = 1e-4\n")
    result = invoke(path, "--scheduler", scheduler)
    assert (result.exit_code, "0 of 6 runs done, 0 failed, 6 timed out" in result.stdout) == (0, True)
    assert "warning: 6 of 6 runs without data: timed out after 0.0001 s" in result.stderr
    assert {(row["status"], row["reason"]) for row in read_rows(tmp_path / "out")} == {("timeout", "timed out after 0.0001 s")}
    write_study(tmp_path)
    assert "0 of 6 runs done" in invoke(path, "--scheduler", scheduler).stdout
    assert "6 of 6 runs done" in invoke(path, "--scheduler", scheduler, "--retry").stdout


def test_a_run_that_fails_is_a_row_with_its_reason(scheduler: str, tmp_path: Path) -> None:
    path = write_study(tmp_path, GRID, **{'"loads': '"loads[0].amplitude" = [0.3, 2e4]'})
    result = invoke(path, "--scheduler", scheduler)
    assert (result.exit_code, "2 of 4 runs done, 2 failed" in result.stdout) == (0, True)
    lines = rows_without_seconds(tmp_path / "out")
    assert [",failed," in line for line in lines] == [False, False, False, True, True]
    assert "the supports would move at up to 2e+04 m/s" in lines[3]


def test_what_is_kept_of_runs(scheduler: str, tmp_path: Path) -> None:
    for keep, files in (
        ("summary", {"summary.json", "joints.csv", "scene.toml"}),
        ("all", {"result.h5", "joints.csv", "summary.json", "scene.toml"}),
    ):
        folder = tmp_path / keep
        folder.mkdir()
        path = write_study(folder, GRID + f'[run]\nkeep = "{keep}"\n', **{'"loads': '"loads[0].amplitude" = [0.4]'})
        result = invoke(path, "--scheduler", scheduler)
        assert result.exit_code == 0, result.output
        kept = list((folder / "out" / "runs").iterdir())
        assert {place.name for place in kept} == set(row_names(folder / "out"))
        assert all({file.name for file in place.glob("[!.]*")} == files for place in kept)


def test_a_scheduler_that_does_not_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("masonry_cd.studies.study.clusters.ANSWER", 0.5)
    result = invoke(write_study(tmp_path), "--scheduler", "tcp://127.0.0.1:1")
    assert result.exit_code == 2
    line = "--scheduler tcp://127.0.0.1:1: no scheduler answers there within 0.5 s; start one with: dask scheduler"
    assert result.stderr.endswith(f"masonry-cd: error: {line}\n")


# --- the engine ---------------------------------------------------------------------------------------------------------------------


def test_a_study_without_workers_ends_after_a_while(tmp_path: Path) -> None:
    from distributed import Client, LocalCluster

    with LocalCluster(n_workers=0, dashboard_address=":0") as cluster, Client(cluster, set_as_default=False) as client:
        task = Task("a", {}, 1.0, folder=str(tmp_path))
        engine = Engine(client, lambda _: task, lambda *_: [], lambda *_: None, studied.stub, patience=0.5)
        with pytest.raises(ClusterLost, match="no worker has been there for "):
            engine.execute([Planned("a", DesignedRun(), 1.0)])
    assert (
        RunPlace(workers=2).patience < math.inf == RunPlace(scheduler="tcp://10.0.0.1:8786").patience == RunPlace(slurm=tmp_path).patience
    )


def executed(scheduler: str, folder: Path, function: Callable[[Task], Outcome], names: str) -> dict[str, RunRow]:
    """The rows of tasks that stand in for runs, by name."""
    from distributed import Client

    rows: dict[str, RunRow] = {}

    def ended(run: Planned, outcome: Outcome) -> list[Planned]:
        rows[run.name] = outcome.row
        return [Planned("followed", DesignedRun(), 1.0)] if run.name == "a" else []

    with Client(scheduler, set_as_default=False) as client:
        engine = Engine(client, lambda run: Task(run.name, {}, 1.0, folder=str(folder)), ended, lambda *_: None, function)
        engine.execute(Planned(name, DesignedRun(), 1.0) for name in names)
    return rows


@pytest.mark.slow(reason="a worker is killed, whose whole time counts then, and another one started")
def test_a_worker_that_is_killed_costs_its_run_which_is_made_again(processes: str, tmp_path: Path) -> None:
    rows = executed(processes, tmp_path, studied.dies_once, "abcd")
    assert (tmp_path / "b.died").exists()
    assert {name: row.status for name, row in rows.items()} == dict.fromkeys(["a", "b", "c", "d", "followed"], "done")


def test_an_error_of_the_program_is_a_row(scheduler: str, tmp_path: Path) -> None:
    rows = executed(scheduler, tmp_path, studied.raises, "xy")
    assert {name: row.reason for name, row in rows.items()} == {name: f"RuntimeError: {name} is broken" for name in "xy"}


# --- slurm ----------------------------------------------------------------------------------------------------

SLURM = """\
jobs = 3
cores = 8
memory = "32 GB"
walltime = "02:00:00"
queue = "short"
account = "arches"
directives = ["--constraint=avx2"]
prologue = ["source /opt/env/bin/activate"]
python = "/opt/env/bin/python"
"""


def test_the_job_script_of_slurm(tmp_path: Path) -> None:
    (tmp_path / "slurm.toml").write_text(SLURM)
    result = invoke(write_study(tmp_path), "--slurm", str(tmp_path / "slurm.toml"), "--print-job")
    assert result.exit_code == 0 and not (tmp_path / "out").exists()
    lines = result.stdout.splitlines()
    asked = [
        "#SBATCH -p short",
        "#SBATCH -A arches",
        "#SBATCH --cpus-per-task=8",
        "#SBATCH --mem=30G",
        "#SBATCH -t 02:00:00",
        "#SBATCH --constraint=avx2",
    ]
    assert set(asked) <= set(lines)
    assert lines.index("source /opt/env/bin/activate") < lines.index("export NUMBA_NUM_THREADS=1") < len(lines) - 1
    assert lines[-1].startswith("/opt/env/bin/python -m distributed.cli.dask_worker tcp://")
    assert all(word in lines[-1] for word in ("--nthreads 1 ", "--nworkers 8 ", "--memory-limit 3.73GiB ", "--nanny "))


@pytest.mark.parametrize(
    ("text", "message"),
    [(SLURM.replace("queue", "queu"), 'queu: unknown key (did you mean "queue"?)'), ("cores = 4", "jobs: missing")],
)
def test_a_bad_file_for_slurm(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "slurm.toml").write_text(text)
    result = invoke(write_study(tmp_path), "--slurm", str(tmp_path / "slurm.toml"))
    assert result.exit_code == 2
    first, *others = result.stderr.partition("masonry-cd: error: ")[2].splitlines()
    assert first == f"{tmp_path / 'slurm.toml'}: {message}"
    assert all(line.startswith(f"{tmp_path / 'slurm.toml'}: ") for line in others)


@pytest.mark.parametrize("words", [["--slurm", "slurm.toml"], ["--print-job"]])
def test_without_slurm_nothing_is_begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str]) -> None:
    (tmp_path / "slurm.toml").write_text(SLURM)
    study = write_study(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    result = invoke(study, *words)
    assert result.exit_code == 2 and result.stderr.startswith(f"masonry-cd: error: {words[0]}: ") and result.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_nothing_wrong_with_all_runs_gets_as_far_as_a_worker(tmp_path: Path) -> None:
    path = studied.write_study(tmp_path)
    write_scene(tmp_path, SCENE.replace("amplitude = 0.4", "amplitude = 0.4\nphase = 0.1"))
    result = invoke(path)
    assert result.exit_code == 2
    assert "phase: unknown key" in result.stderr
    assert not (tmp_path / "out").exists()
