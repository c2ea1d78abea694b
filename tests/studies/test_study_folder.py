# SPDX-License-Identifier: GPL-3.0-or-later
"""The progress that a study reports, which files in its folder are its own, and what runs in one process share."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from masonry_cd.analysis.run_row import RunRow
from masonry_cd.foundation import own_files
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.folder import KEPT, NAME, StudyFolder
from masonry_cd.studies.study.progress import StudyProgress
from masonry_cd.studies.study.task import Task, run_task


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


@pytest.mark.parametrize(
    "place", ["runs/notes.txt", "runs/a/thesis.tex", "rows/r.csv", "joints/x.npz", "reference/result.h5", "study.html"]
)
@pytest.mark.parametrize("listed", [True, False])
def test_files_of_others_stay(tmp_path: Path, place: str, listed: bool) -> None:
    if listed:
        for folder in (tmp_path, *(tmp_path / name for name in KEPT)):
            own_files.begin(folder, ())
    theirs = tmp_path / place
    theirs.parent.mkdir(parents=True, exist_ok=True)
    theirs.write_text("theirs", encoding="utf-8")
    with pytest.raises(InputError) as refused:
        StudyFolder(tmp_path).require_own()
    assert place in str(refused.value)


def test_a_study_of_an_earlier_version_is_cleared(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text(json.dumps({"format": 1, "program": "0.1", "identity": {}}), encoding="utf-8")
    for name in ("rows/a.json", "joints/a.npz", "reference/run.txt", "runs/a/joints.csv", "runs/b.12.part/joints.csv"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("", encoding="utf-8")
    here = StudyFolder(tmp_path)
    here.require_own()
    here.clear()
    assert not list(tmp_path.iterdir())


def test_what_a_kill_leaves_is_cleared(tmp_path: Path) -> None:
    for folder in (tmp_path, *(tmp_path / name for name in KEPT)):
        own_files.begin(folder, ())
    for name in ("rows/a.part.json", "rows/a.hang", "runs/a.12.part/result.h5"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("", encoding="utf-8")
    StudyFolder(tmp_path).require_own()


def tables(height: float, several: bool) -> dict[str, Any]:
    """A wall of a height, alone or next to another one, at rest for a few steps."""
    own = {"kind": "wall", "length": 1.0, "thickness": 0.5, "height": height, "course_height": 0.5, "unit_length": 0.5}
    second = own | {"name": "low", "height": 0.5, "at": [3.0, 0.0, 0.0]}
    return {
        **({"structures": [own | {"name": "tall"}, second]} if several else {"structure": own}),
        "material": {"density": 2000.0, "friction": 0.6},
        "run": {"dt": 1e-2, "duration": 0.05},
    }


@pytest.mark.parametrize("several", [False, True])
def test_runs_of_other_structures_share_none(several: bool) -> None:
    """Structures are kept from run to run, by all tables that they are made of."""
    heights = (1.0, 1.5, 1.0)
    outcomes = [run_task(Task(f"run{k}", tables(height, several), 60.0)) for k, height in enumerate(heights)]
    assert [outcome.row.status for outcome in outcomes] == ["done"] * 3, outcomes
    joints = [0 if outcome.joints is None else len(outcome.joints["opening"]) for outcome in outcomes]
    assert joints[0] == joints[2] < joints[1]
