# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that are killed and resumed where a table has rows without columns: no joints, no supports, no motion, joints that all vanish."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import pytest
from block_files import cuboid
from command_line import masonry_cd
from datasets import contents

from masonry_cd.app import run_loop
from masonry_cd.io.results import Results

STEPS, SAVED, KILLED = 60, 37, 45  # the last before the kill, which leaves rows of a frame and of steps beyond the checkpoint
PLATE = cuboid((-1.0, -1.0, -0.2), (1.0, 1.0, 0.0)) | {"name": "plate", "fixed": True, "group": "base"}


def block(name: str, low: float) -> dict[str, Any]:
    """A cube of 0.2 m whose lower face is at a height [m]."""
    return cuboid((-0.1, -0.1, low), (0.1, 0.1, low + 0.2)) | {"name": name}


SCENES = {  # blocks, and direction of gravity
    "no joints": ([PLATE, block("a", 0.05), block("b", 0.5)], -1.0),
    "one block": ([block("a", 0.0)], -1.0),
    "no motion": ([PLATE, block("a", 0.0), block("b", 0.2)], -1.0),
    "joints that vanish": ([PLATE, block("a", 0.0), block("b", 0.2)], 1.0),
}


def run(scene: Path, out: Path, *more: str) -> dict[str, Any]:
    """A run by the command line, with its damage; its summary."""
    words = ["run", str(scene), "-o", str(out), "-q", "--set", "report.damage=true", "--set", "run.until_still=false", *more]
    result = masonry_cd(*words)
    assert result.exit_code == 0, result.output
    return json.loads((out / "summary.json").read_text())


class Killed(BaseException):
    """Stands for a kill between two steps."""


@pytest.mark.parametrize("name", SCENES)
def test_a_killed_run_ends_as_the_unbroken_one(tmp_path, monkeypatch, name):
    blocks, up = SCENES[name]
    (tmp_path / "blocks.json").write_text(json.dumps({"units": "m", "blocks": blocks}))
    scene = tmp_path / "scene.toml"
    scene.write_text(
        '[structure]\nkind = "file"\npath = "blocks.json"\n[material]\ndensity = 2000.0\nfriction = 0.5\n'
        f"[run]\ndt = 4e-3\nduration = {STEPS * 4e-3}\nframes_per_second = 50\ngravity = [0.0, 0.0, {up * 9.81}]\n"
    )
    whole = run(scene, tmp_path / "whole")

    def save(loop: Any) -> None:
        if loop.report.steps == SAVED:
            loop.save(loop.save_to)
        if loop.report.steps == KILLED:
            raise Killed

    with monkeypatch.context() as kill:
        kill.setattr(run_loop._Loop, "save_when_due", save)
        with pytest.raises(Killed):
            run(scene, tmp_path / "broken")
    with Results.open(tmp_path / "broken" / "result.h5") as results:
        assert results.rows("step_time") == KILLED
        assert results.words == ()
    resumed = run(scene, tmp_path / "broken", "--resume")
    assert contents(tmp_path / "broken" / "result.h5") == contents(tmp_path / "whole" / "result.h5")
    assert shapes(tmp_path / "broken" / "result.h5") == shapes(tmp_path / "whole" / "result.h5")  # empty rows have no bytes to compare
    for table in tmp_path.glob("whole/*.csv"):
        assert (tmp_path / "broken" / table.name).read_bytes() == table.read_bytes()
    seconds = {"wall_seconds", "stepping_seconds"}
    assert {key: resumed[key] for key in resumed.keys() - seconds} == {key: whole[key] for key in whole.keys() - seconds}


def shapes(path: Path) -> dict[str, tuple[int, ...]]:
    """Of all datasets but the segments, which end where checkpoints were."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: getattr(item, "shape", ())}) if "segments" not in name else None)
    return {name: shape for name, shape in found.items() if name != "closing"}
