# SPDX-License-Identifier: GPL-3.0-or-later
"""A study of 60 runs whose workers are killed ten times, at random, leaves the bytes of one that was not disturbed."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from studied import GRID, rows_without_seconds, write_study

KILLS, RUNS = 10, 60
VALUES = {
    '"loads': '"loads[0].amplitude" = {from = 0.3, to = 0.6, count = 15}',
    '"material': '"material.friction" = [0.2, 0.4]\n"run.dt" = [1e-3, 5e-4]',
}


def command(study: Path) -> list[str]:
    return [sys.executable, "-m", "masonry_cd", "study", str(study), "-o", str(study.parent / "out"), "--workers", "2", "--quiet"]


def workers_of(pid: int) -> list[int]:
    """The worker processes of a study."""
    import psutil

    return [child.pid for child in psutil.Process(pid).children(recursive=True) if "spawn_main" in " ".join(child.cmdline())]


@pytest.mark.validation
def test_ten_kills_change_no_byte(tmp_path: Path) -> None:
    random = np.random.default_rng(4)
    studies = [tmp_path / name for name in ("still", "disturbed")]
    for folder in studies:
        folder.mkdir()
        write_study(folder, GRID, **VALUES)
    subprocess.run(command(studies[0] / "study.toml"), check=True)
    program = subprocess.Popen(command(studies[1] / "study.toml"))
    rows, killed = studies[1] / "out" / "rows", 0
    marks = np.sort(random.choice(np.arange(2, RUNS - 6), KILLS, replace=False))  # after a given number of rows
    while program.poll() is None and killed < KILLS:
        if rows.is_dir() and len(list(rows.glob("*.json"))) >= marks[killed] and (alive := workers_of(program.pid)):
            time.sleep(random.random() * 0.2)
            try:
                os.kill(int(random.choice(alive)), 9)
            except ProcessLookupError:
                continue
            killed += 1
        time.sleep(0.01)
    assert program.wait(600) == 0
    assert killed == KILLS
    assert len(rows_without_seconds(studies[0] / "out")) == RUNS + 1
    assert rows_without_seconds(studies[1] / "out") == rows_without_seconds(studies[0] / "out")
    for file in (studies[0] / "out" / "joints").glob("*.npz"):
        assert file.read_bytes() == (studies[1] / "out" / "joints" / file.name).read_bytes()
