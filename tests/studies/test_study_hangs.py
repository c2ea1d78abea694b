# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that hang are rows with their reason, and a scheduler that goes away ends the study in a line."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import studied
from command_line import done
from studied import GRID, rows_without_seconds, wait_until, write_study

from masonry_cd.analysis.run_row import RunRow
from masonry_cd.studies.study.clusters import ONE_THREAD, RunPlace, connected
from masonry_cd.studies.study.designs import DesignedRun
from masonry_cd.studies.study.engine import Engine
from masonry_cd.studies.study.plan import Planned
from masonry_cd.studies.study.task import Outcome, Task

if TYPE_CHECKING:
    from distributed import Client

pytestmark = pytest.mark.slow(reason="runs hang until their time is over, and their workers are started again")
REASON = "timed out after 1 s, in a step or a set-up that did not end"


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """The address of a scheduler with two workers, in which scenes of the amplitude HANGING hang."""
    with studied.cluster(2, env=ONE_THREAD, preload=["hanging_worker"]) as address:
        yield address


def executed(client: Client, folder: Path, function: Callable[[Task], Outcome], names: str) -> dict[str, RunRow]:
    """The rows of tasks that stand in for runs, by name, each of which may take two seconds."""
    (folder / "rows").mkdir(exist_ok=True)
    rows: dict[str, RunRow] = {}

    def ended(run: Planned, outcome: Outcome) -> list[Planned]:
        rows[run.name] = outcome.row
        return []

    def task(run: Planned) -> Task:
        return Task(run.name, {}, timeout=1.0, grace=1.0, folder=str(folder))

    Engine(client, task, ended, lambda *_: None, function).execute(Planned(name, DesignedRun(), 1.0) for name in names)
    return rows


def test_a_run_that_hangs_is_a_row(scheduler: str, tmp_path: Path) -> None:
    from distributed import Client

    with Client(scheduler, set_as_default=False) as client:
        rows = executed(client, tmp_path, studied.waits_for_ever, "abcdef")
    assert {name: row.status for name, row in rows.items()} == dict.fromkeys("acdf", "done") | dict.fromkeys("be", "timeout")
    assert {rows[name].reason for name in "be"} == {REASON}
    traces = {file.stem: file.read_text() for file in (tmp_path / "rows").iterdir()}
    assert traces.keys() == {"b", "e"}  # what the others had written is gone
    assert all("Timeout" in trace and studied.waits_for_ever.__name__ in trace for trace in traces.values())


def test_the_workers_of_this_machine_go_on_after_a_hang(tmp_path: Path) -> None:
    with connected(RunPlace(workers=1, longest=2.0)) as (client, _):
        rows = executed(client, tmp_path, studied.waits_for_ever, "abc")
    assert {name: row.status for name, row in rows.items()} == {"a": "done", "b": "timeout", "c": "done"}


def test_a_set_up_that_hangs_is_a_row_of_the_table(scheduler: str, tmp_path: Path) -> None:
    """The scene with the largest amplitude hangs in its set-up, in the workers alone."""

    def made(*options: str) -> str:
        with studied.undrawn():
            return done("study", path, "-o", tmp_path / "out", "--scheduler", scheduler, *options).output

    path = write_study(tmp_path, GRID, **{'"loads': '"loads[0].amplitude" = [0.3, 0.4]'})
    assert "4 of 4 runs done" in made()
    before = rows_without_seconds(tmp_path / "out")
    quick = {'"loads': f'"loads[0].amplitude" = [0.3, 0.4, {studied.HANGING}]'}
    write_study(tmp_path, GRID + "[run]\ntimeout = 1.0\ngrace = 1.0\n", **quick)
    assert "4 of 6 runs done, 0 failed, 2 timed out" in made()
    table = rows_without_seconds(tmp_path / "out")
    assert table[:5] == before
    assert [f",timeout,{REASON}," in line for line in table] == [False] * 5 + [True] * 2
    rows = [json.loads(file.read_text()) for file in (tmp_path / "out" / "rows").glob("*.json")]
    assert sorted(row["status"] for row in rows) == ["done"] * 4 + ["timeout"] * 2
    assert "4 of 6 runs done, 0 failed, 2 timed out" in made("--retry")  # they are made again, and hang again
    assert rows_without_seconds(tmp_path / "out") == table


@contextmanager
def child(*words: str, log: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A program of dask that is ended with the test."""
    with log.open("wb") as file:
        environment = {**os.environ, **ONE_THREAD, "PYTHONPATH": os.pathsep.join(sys.path)}
        program = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]], stdout=file, stderr=file, env=environment
        )
        try:
            yield program
        finally:
            program.kill()
            program.wait()


@pytest.mark.slow(reason="a scheduler, a worker and a program, and workers again")
def test_a_scheduler_that_is_lost_ends_the_study_in_a_line_and_the_next_call_goes_on(tmp_path: Path) -> None:
    path = write_study(tmp_path, GRID, **studied.LONG)
    with ExitStack() as stack:
        where = tmp_path / "scheduler.json"
        file = ("--scheduler-file", str(where))
        scheduler = stack.enter_context(child("dask_scheduler", "--port", "0", "--no-dashboard", *file, log=tmp_path / "scheduler.log"))
        address = studied.address_in(where)
        worker = ("dask_worker", *file, "--nthreads", "1", "--memory-limit", "2GB", "--no-dashboard", "--death-timeout", "20")
        stack.enter_context(child(*worker, "--local-directory", str(tmp_path), log=tmp_path / "worker.log"))
        study = studied.started(path, "--scheduler", address)
        wait_until(lambda: len(studied.row_names(tmp_path / "out")) >= 2 or study.poll() is not None)
        scheduler.kill()
        _, said = study.communicate(timeout=studied.PATIENCE)
        assert study.returncode == 1, said
        own = [line for line in said.splitlines() if line.startswith("masonry-cd: ")]
        again = f"masonry-cd study {path} -o {tmp_path / 'out'} --scheduler {address}"
        assert own == [
            "masonry-cd: warning: the scheduler does not answer any more; finished runs are kept",
            f"masonry-cd: continue with: {again}",
        ]
        assert "Traceback" not in said
    before = studied.row_names(tmp_path / "out")
    assert 2 <= len(before) < 18
    with studied.undrawn():
        result = done("study", path, "-o", tmp_path / "out", "--workers", "1")
    assert f"18 runs, {18 - len(before)} still to run" in result.stderr
    assert {name: studied.row_names(tmp_path / "out")[name] for name in before} == before
    assert len(rows_without_seconds(tmp_path / "out")) == 19
