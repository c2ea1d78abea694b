# SPDX-License-Identifier: GPL-3.0-or-later
"""Workers started by hand, as docs/studies.md has it, and a scheduler that goes away while a study runs."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
import studied
from command_line import masonry_cd
from studied import GRID, rows_without_seconds, wait_until, write_study

from masonry_cd.studies.study.clusters import ONE_THREAD


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
            f"masonry-cd: go on with: {again}",
        ]
        assert "Traceback" not in said
    before = studied.row_names(tmp_path / "out")
    assert 2 <= len(before) < 18
    result = masonry_cd("study", path, "-o", tmp_path / "out", "--workers", "1")
    assert result.exit_code == 0, result.output
    assert f"18 runs, {18 - len(before)} of them to be made" in result.stderr
    assert {name: studied.row_names(tmp_path / "out")[name] for name in before} == before
    assert len(rows_without_seconds(tmp_path / "out")) == 19
