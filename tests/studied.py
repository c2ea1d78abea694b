# SPDX-License-Identifier: GPL-3.0-or-later
"""A small scene and its studies, and tasks that stand in for runs: workers import them from here."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event
from typing import Any
from unittest import mock

import numpy as np
from block_files import write_plate_and_block

from masonry_cd.analysis.run_row import DONE, RunRow
from masonry_cd.studies.study.clusters import SETTINGS
from masonry_cd.studies.study.task import Outcome, Task

SCENE = """\
title = "Block on a plate"
[structure]
kind = "file"
path = "blocks.json"
[material]
density = 2000.0
friction = 0.4
[[loads]]
kind = "sinusoidal"
direction = "x"
amplitude = 0.4
frequency = 2.0
cycles = 1
[run]
dt = 1e-2
duration = 0.5
tolerance = 1e-6
"""
GRID = """\
scene = "scene.toml"
design = "grid"
[vary]
"loads[0].amplitude" = [0.3, 0.4, 0.6]
"material.friction" = [0.2, 0.4]
[limit_states]
slid = {quantity = "max_sliding", above = 1e-3}
"""
RECORDS = """\
scene = "scene.toml"
design = "stripes"
[records]
folder = "records"
pattern = '(?P<motion>.+)_(?P<component>[^_]+)\\.acc'
x = ["NS", "H1"]
y = ["EW", "H2"]
z = ["UD"]
shake = ["x"]
units = "m/s2"
dt = 0.01
[intensity]
measure = "PGA"
levels = [1.0, 2.0, 4.0]
[limit_states]
slid = {quantity = "max_sliding", above = 1e-3}
"""
LONG = {"[limit_states]": '"run.dt" = [1e-3, 8e-4, 5e-4]\n[limit_states]'}  # some seconds of runs
PATIENCE = 120.0  # [s] for another process to get so far
HANGING = 0.6  # amplitude of a load: scenes that hang, see hanging_worker.py
HANGS = "be"  # names of tasks that hang
SAMPLES, STEP = 100, 0.01
NAMES = {"quake_a": ("NS", "EW", "UD"), "quake_b": ("H1", "H2", "UD"), "far_c": ("NS", "EW", "UD")}


def write_scene(folder: Path, text: str = SCENE) -> None:
    """The scene and its two blocks."""
    write_plate_and_block(folder)
    (folder / "scene.toml").write_text(text)


def write_study(folder: Path, text: str = GRID, **changes: str) -> Path:
    """A study of the scene; lines are replaced by what they begin with."""
    write_scene(folder)
    path = folder / "study.toml"
    path.write_text(changed(text, changes))
    return path


def changed(text: str, changes: dict[str, str]) -> str:
    """A text some of whose lines are others."""
    lines = text.splitlines()
    for begin, line in changes.items():
        (place,) = (i for i, old in enumerate(lines) if old.startswith(begin))
        lines[place] = line
    return "\n".join(lines) + "\n"


def wave(k: int) -> np.ndarray:
    """An acceleration (SAMPLES,) that is unlike those of other numbers [m/s2]."""
    t = STEP * np.arange(SAMPLES)
    return np.asarray((1.0 + 0.3 * k) * np.sin((9.0 + 2.0 * k) * t) * np.exp(-(((t - 0.4) / 0.15) ** 2)))


def write_records(folder: Path, names: dict[str, tuple[str, ...]] = NAMES) -> None:
    """Three motions of three components, one column each."""
    (folder / "records").mkdir()
    for k, (motion, components) in enumerate(names.items()):
        for i, component in enumerate(components):
            values = wave(3 * k + i)
            (folder / "records" / f"{motion}_{component}.acc").write_text("".join(f"{v:.8f}\n" for v in values))


def rows_without_seconds(folder: Path) -> list[str]:
    """The lines of runs.csv without what differs from time to time."""
    with (folder / "runs.csv").open(newline="") as file:
        lines = list(csv.reader(file))
    place = lines[0].index("seconds")
    return [",".join(cell for i, cell in enumerate(line) if i != place) for line in lines]


def row_names(folder: Path) -> dict[str, int]:
    """The rows that are there whole, by name, with the instant at which each was written."""
    rows = [file for file in (folder / "rows").glob("*.json") if ".part" not in file.name]
    return {file.stem: file.stat().st_mtime_ns for file in rows}


def started(path: Path, *options: str) -> subprocess.Popen[str]:
    """The command in a process group of its own."""
    command = [sys.executable, "-m", "masonry_cd", "study", str(path), "-o", str(path.parent / "out"), *options]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, env=dict(os.environ)
    )


def wait_until(holds: Callable[[], bool]) -> None:
    """Wait for another process."""
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end, "it did not come so far"
        time.sleep(0.02)


@contextmanager
def cluster(workers: int, **more: Any) -> Iterator[str]:
    """The address of a scheduler with workers, as a user would have started them."""
    import dask
    from distributed import LocalCluster  # before its settings are changed

    alone = {"threads_per_worker": 1, "dashboard_address": ":0", "silence_logs": 50}
    with dask.config.set(SETTINGS), LocalCluster(n_workers=workers, **alone, **more) as made:
        yield made.scheduler_address


@contextmanager
def undrawn() -> Iterator[None]:
    """Studies draw no pictures, which take longer than their runs: tests/reports/test_study_outputs.py looks at these."""
    from reports.study import outputs

    with mock.patch.object(outputs, "diagrams", lambda _: []), mock.patch.object(outputs, "draw_joint_maps", lambda _: ([], [], [])):
        yield


def address_in(file: Path) -> str:
    """The address of a scheduler, once it has written the file on itself, which is there and empty for a moment."""
    wait_until(lambda: file.exists() and file.read_text(encoding="utf-8").endswith("}"))
    return str(json.loads(file.read_text(encoding="utf-8"))["address"])


# --- tasks that stand in for runs ---------------------------------------------------------------------------------------------------


def stub(task: Task) -> Outcome:
    """Ten milliseconds."""
    time.sleep(0.01)
    return Outcome(task.name, _row())


def dies_once(task: Task) -> Outcome:
    """Kills its worker the first time, if its folder says so."""
    mark = Path(task.folder) / f"{task.name}.died"
    if task.name == "b" and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return Outcome(task.name, _row())


def waits_for_ever(task: Task) -> Outcome:
    """Two of the runs never return; other threads of their worker go on, as they do next to the kernels."""
    if task.name in HANGS:
        Event().wait()
    return Outcome(task.name, _row())


def raises(task: Task) -> Outcome:
    """An error that no run reports by itself."""
    raise RuntimeError(f"{task.name} is broken")


def _row() -> RunRow:
    return RunRow(DONE, seconds=0.01, worker=str(os.getpid()))
