# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a study says it is."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest

from masonry_cd.analysis.run_row import RunRow
from masonry_cd.studies.study.progress import StudyProgress
from masonry_cd.studies.study.study_case import Made


def row(seconds: float, worker: str = "a", status: str = "done", reason: str = "", **timing: float) -> RunRow:
    return RunRow(status, reason, seconds, worker, timing=timing)


@pytest.mark.parametrize("seed", range(10))
def test_after_a_tenth_of_the_runs_the_time_left_is_right_within_one_half(seed: int) -> None:
    random = np.random.default_rng(seed)
    steps = random.integers(2000, 12000, 200).astype(float)  # of motions that last from 8 to 48 s
    strong = random.integers(1, 4, 200)  # levels at which a step costs more
    seconds = 5e-4 * steps * strong * np.exp(0.4 * random.normal(size=200))
    progress = StudyProgress(200, 0, float(steps.sum()), quiet=True)
    for k in range(20):
        first = 20.0 if k < 2 else 0.0  # to load the kernels
        progress.ended(steps[k], row(seconds[k] + first, worker=str(k % 2), set_up=first + 0.1))
    left = progress.seconds_left(2)
    assert left is not None
    assert 1 / 1.5 < left / (seconds[20:].sum() / 2) < 1.5


def test_the_line_counts_what_is_done_running_and_failed() -> None:
    said = io.StringIO()
    progress = StudyProgress(10, 4, 6.0, stream=said)
    assert progress.line(2, 2).startswith("4 of 10 runs done, 2 running, ")
    progress.ended(1.0, row(3.0))
    progress.ended(1.0, row(5.0, status="timeout"))
    line = progress.line(2, 2)
    assert line.startswith("6 of 10 runs done, 1 failed, 2 running, ")
    assert line.endswith(", 8.0 s left")  # four runs of 4 s on two threads
    progress.planned(2.0)
    assert progress.line(2, 2).endswith("12.0 s left")
    assert progress.line(0, 0).endswith("waiting for workers")


def test_reasons_that_are_not_named_at_the_end_are_counted(tmp_path: Path) -> None:
    rows = {f"{k} {n}": row(1.0, status="failed", reason=f"reason {k}") for k in range(8) for n in range(9 - k)}
    *named, others = Made(44, rows).warnings(tmp_path / "runs.csv")
    assert [line.rpartition(": ")[2] for line in named] == [f"reason {k}" for k in range(5)]
    assert "9 of 44" in others and str(tmp_path / "runs.csv") in others
