# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of spheres from the command line: records, settlements, tilt, islands, resuming, and what is refused."""

from __future__ import annotations

import json
import math
import signal
from pathlib import Path

import numpy as np
import pytest
from block_files import cuboid
from command_line import masonry_cd
from datasets import contents

from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

RADIUS, ROLLING = 0.1, 0.1
SCENE = """
[structure]
kind = "file"
path = "blocks.json"
[material]
density = 2000.0
friction = 0.8
rolling_friction = 0.1
{material}
{load}
[run]
dt = 2e-3
duration = {duration}
tolerance = 1e-9
"""
LOADS = {
    "record": """
[[loads]]
kind = "artificial"
direction = "x"
spectrum = "EC8"
ag = 2.0
ground = "B"
rise = 0.1
level = 0.3
duration = 3.0
periods = [0.1, 0.5]
tolerance = 0.3
seed = 5
""",
    "settlement": """
[[loads]]
kind = "settlement"
supports = "far"
displacement = 0.02
start = 0.02
duration = 0.1
""",
    "tilt": """
[[loads]]
kind = "tilt"
direction = "x"
initial = 0.0
rate = 10.0
""",
}


def scene(folder: Path, load: str, duration: float, material: str = "") -> Path:
    """Four balls, and one on them, on each of two plates that lie apart."""
    blocks = []
    for name, at in (("near", 0.0), ("far", 4.0)):
        blocks.append(cuboid((at - 1.0, -1.0, -0.5), (at + 1.0, 1.0, 0.0)) | {"name": name, "fixed": True, "group": name})
        places = [(x, y, RADIUS) for x in (-RADIUS, RADIUS) for y in (-RADIUS, RADIUS)] + [(0.0, 0.0, RADIUS * (1.0 + math.sqrt(2.0)))]
        for k, (x, y, z) in enumerate(places):
            blocks.append({"name": f"{name} {k}", "centre": [at + x, y, z], "radius": RADIUS, "group": "balls"})
    (folder / "blocks.json").write_text(json.dumps({"units": "m", "blocks": blocks}))
    (folder / "scene.toml").write_text(SCENE.format(load=LOADS.get(load, ""), duration=duration, material=material))
    return folder / "scene.toml"


def ran(folder: Path, balance: float = 1e-6) -> dict:
    """The summary of a run that ends well, each step of it solved and with its energy closed."""
    result = masonry_cd("run", folder / "scene.toml", "-o", folder / "out", "-q")
    assert result.exit_code == 0, result.output
    found = json.loads((folder / "out" / "summary.json").read_text())
    assert found["solver"]["steps_missed"] == 0
    assert abs(found["energy"]["balance_error"]) < balance
    return found


def moved(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times (F,) [s], and displacements of the balls (F, 10, 3) [m]."""
    with Results.open(folder / "out" / "result.h5") as results:
        position, free = np.array([results.position[k] for k in range(results.frames)]), [1, 2, 3, 4, 5, 7, 8, 9, 10, 11]
        return np.array(results.time), position[:, free] - position[0, free]


def test_a_record_shakes_two_piles_on_islands_of_their_own(tmp_path: Path) -> None:
    scene(tmp_path, "record", 0.3)
    found = ran(tmp_path)
    assert found["islands"]["max"] == 2
    _, displacement = moved(tmp_path)
    assert np.abs(displacement[-1, :, 0]).max() > 1e-3
    np.testing.assert_allclose(displacement[:, :5], displacement[:, 5:], atol=1e-6)  # equal piles


def test_a_pile_sinks_with_its_support(tmp_path: Path) -> None:
    scene(tmp_path, "settlement", 0.2)
    ran(tmp_path)
    _, displacement = moved(tmp_path)
    np.testing.assert_allclose(displacement[-1, :5], 0.0, atol=1e-6)
    np.testing.assert_allclose(displacement[-1, 5:], np.tile([0.0, 0.0, -0.02], (5, 1)), atol=1e-5)


def test_a_tilted_ball_rolls_from_the_angle_of_its_rolling_friction_on(tmp_path: Path) -> None:
    blocks = [cuboid((-2.0, -1.0, -0.5), (2.0, 1.0, 0.0)) | {"name": "plate", "fixed": True, "group": "base"}]
    blocks.append({"name": "ball", "centre": [0.0, 0.0, RADIUS], "radius": RADIUS, "group": "balls"})
    scene(tmp_path, "tilt", 0.9)
    (tmp_path / "blocks.json").write_text(json.dumps({"units": "m", "blocks": blocks}))
    ran(tmp_path)
    with Results.open(tmp_path / "out" / "result.h5") as results:
        time = np.array(results.time)
        gone = np.abs(np.array([results.position[k][1] - results.position[0][1] for k in range(results.frames)])).max(axis=1)
    begins = math.degrees(math.atan(ROLLING)) / 10.0
    assert gone[time < 0.98 * begins].max() < 1e-9
    assert gone[-1] > 1e-3


def test_spheres_go_on_from_their_checkpoint_to_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, advance = scene(tmp_path, "record", 0.2), Stepper.step
    assert masonry_cd("run", path, "-o", tmp_path / "whole", "-q").exit_code == 0

    def step(self: Stepper) -> object:
        if self.steps == 30:
            signal.raise_signal(signal.SIGINT)
        return advance(self)

    monkeypatch.setattr(Stepper, "step", step)
    assert masonry_cd("run", path, "-o", tmp_path / "parts", "-q").exit_code == 130
    monkeypatch.setattr(Stepper, "step", advance)
    assert masonry_cd("run", path, "-o", tmp_path / "parts", "-q", "--resume").exit_code == 0
    assert contents(tmp_path / "whole" / "result.h5") == contents(tmp_path / "parts" / "result.h5")


@pytest.mark.parametrize("pair", ["balls-near", "balls-*", "default"])
def test_springs_of_spheres_are_refused_in_one_line(tmp_path: Path, pair: str) -> None:
    """Also by default, where all that can touch are spheres on supports."""
    path = scene(tmp_path, "", 0.1, f'[material.joints."{pair}"]\nnormal_stiffness = 1e9\n')
    result = masonry_cd("run", path, "-o", tmp_path / "out")
    assert result.exit_code == 2
    line = f"material.joints.{pair}: spheres touch in points, without springs and bonds, and no other joint has this law"
    assert line in " ".join(result.stderr.split())
    assert not (tmp_path / "out").exists()


def test_stones_beside_spheres_have_springs_by_default(tmp_path: Path) -> None:
    """The law of the stones; what is said of spheres alone is refused there too."""
    blocks = [cuboid((-1.0, -1.0, -0.5), (1.0, 1.0, 0.0)) | {"name": "plate", "fixed": True, "group": "base"}]
    blocks.append(cuboid((-0.2, -0.2, 0.0), (0.2, 0.2, 0.4)) | {"name": "stone", "group": "stones"})
    blocks.append({"name": "ball", "centre": [0.0, 0.0, 0.4 + RADIUS], "radius": RADIUS, "group": "balls"})
    scene(tmp_path, "", 0.1, "[material.joints.default]\nnormal_stiffness = 1e9\n")
    (tmp_path / "blocks.json").write_text(json.dumps({"units": "m", "blocks": blocks}))
    found = ran(tmp_path, balance=1e-3)  # of the work of settling alone, some joules
    weight = 2000.0 * 9.81 * (0.4**3 + 4.0 / 3.0 * math.pi * RADIUS**3)
    assert found["energy"]["elastic"] == pytest.approx(0.5 * weight**2 / (1e9 * 0.16), rel=1e-3)
