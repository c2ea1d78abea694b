# SPDX-License-Identifier: GPL-3.0-or-later
"""Results that no disc holds: refused before the first step, by an estimate that is near the truth."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest
from command_line import masonry_cd

from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import result_bytes
from masonry_cd.app.scene import read_scene


def invoke(*words: object) -> tuple[int, str]:
    result = masonry_cd(*words)
    return result.exit_code, result.stderr


def test_the_estimate_is_near_the_file(block_on_plate, tmp_path: Path) -> None:
    scene = block_on_plate(duration="duration = 20.0\nframes_per_second = 500.0", dt="dt = 2e-3", amplitude="amplitude = 0.0")
    case = prepare(read_scene(scene))
    estimate = result_bytes(case.assembly, case.joints, 10_002, 10_000)
    assert invoke("run", scene, "-o", tmp_path / "out", "-q") == (0, "")
    assert 0.8 * estimate < (tmp_path / "out" / "result.h5").stat().st_size < 1.25 * estimate + 2e5  # blocks, scene and heads of HDF5


def test_a_run_that_the_disc_has_no_room_for(block_on_plate, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, out = block_on_plate(duration="duration = 10.0\nframes_per_second = 1000.0"), tmp_path / "out"
    monkeypatch.setattr(shutil, "disk_usage", lambda place: SimpleNamespace(free=1_000_000, total=10_000_000))
    line = "run.frames_per_second: the results would take about 0.00528 GB, 0.001 GB are free where"
    code, said = invoke("run", scene, "-o", out)
    assert (code, said.count("\n")) == (2, 1)
    assert said.startswith(f"masonry-cd: error: {scene}:17: {line} {out} lies; fewer frames, "), said
    assert not out.exists()
    monkeypatch.setattr(shutil, "disk_usage", lambda place: SimpleNamespace(free=5_000_000, total=10_000_000))
    assert invoke("run", scene, "-o", out, "-q", "--set", "run.duration=0.01")[0] == 0
