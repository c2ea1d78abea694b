# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of blocks that deform and of spheres from the command line: loads, islands, elastic joints, resuming, and what is refused."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from block_files import cuboid
from command_line import done, masonry_cd, refusal
from datasets import contents
from places import ROOT
from small_runs import ctrl_c_before_step, write_scene

from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.faults import ContactFault, TooManyPoints, UnexplainedOverlap

BITS = ROOT / "benchmarks" / "bits"
MESHED = ("deformable=tetrahedra", "mesh_size=10", "young=5e9", "damping=0.05", "damping_frequency=10")
UNIFORM = ("deformable=uniform", *MESHED[2:])
LONG = pytest.mark.slow(reason="hundreds of steps of an arch that is cut into elements")
BOTH = pytest.mark.parametrize("material", [pytest.param(UNIFORM, id="uniform"), pytest.param(MESHED, id="meshed", marks=LONG)])
KINDS = """
[material]
density = 2000.0
friction = 0.6
young = 1e7
poisson = 0.0
mesh_size.cut = 1.0
damping = 0.2
damping_frequency = 20.0
[material.deformable]
even = "uniform"
cut = "tetrahedra"
default = "rigid"
{joints}
[[loads]]
kind = "sinusoidal"
direction = "x"
amplitude = 0.05
frequency = 4.0
cycles = 1
[run]
dt = 1e-3
duration = 1.2
tolerance = 1e-9
"""
JOINTS = "[material.joints.even-cut]\nnormal_stiffness = 1e8"


def run(scene: Path, out: Path, *keys: str, material: tuple[str, ...] = MESHED, more: tuple[str, ...] = ("-q",)):
    """A scene with these keys in place of its own, and those of the material."""
    asked = [f"material.{key}" for key in material] + list(keys)
    return masonry_cd("run", scene, "-o", out, *(word for key in asked for word in ("--set", key)), *more)


def summary_of(folder: Path) -> dict:
    return json.loads((folder / "summary.json").read_text())


def towers(folder: Path, joints: str = "") -> Path:
    """A scene of two towers of a rigid, a uniform and a meshed block each, far apart; weights of 2000 x 9.81 x 0.25 Pa."""
    blocks = [cuboid((-1.0, -0.25, -0.5), (3.0, 0.25, 0.0)) | {"name": "plate", "fixed": True, "group": "base"}]
    for at in (0.0, 2.0):
        for k, group in enumerate(("hard", "even", "cut")):
            corners = (at - 0.25, -0.25, 0.25 * k), (at + 0.25, 0.25, 0.25 * (k + 1))
            blocks.append(cuboid(*corners) | {"name": f"{group}{at:g}", "group": group})
    return write_scene(folder, blocks, KINDS.format(joints=joints))


@BOTH
@pytest.mark.parametrize(("name", "duration"), [("settlement", 0.2), ("record", 0.2), ("elastic", 0.1)])
def test_blocks_that_deform_bear_what_rigid_ones_do(tmp_path: Path, name: str, duration: float, material: tuple[str, ...]) -> None:
    """Supports that part and sink, records, elastic joints: every step is solved and the energy closes."""
    result = run(BITS / f"{name}.toml", tmp_path / "out", f"run.duration={duration}", material=material)
    assert result.exit_code == 0, result.output
    found = summary_of(tmp_path / "out")
    assert found["solver"]["steps_missed"] == 0
    assert abs(found["energy"]["balance_error"]) < 1e-9
    gradient = Results.open(tmp_path / "out" / "result.h5").gradient(-1)
    assert gradient is not None
    assert np.abs(gradient).max() > 1e-7


@pytest.mark.slow(reason="an arch is tilted until it falls")
@BOTH
def test_an_arch_that_deforms_falls_where_it_is_tilted_as_far_as_a_rigid_one(tmp_path: Path, material: tuple[str, ...]) -> None:
    """Its load factor is that of limit analysis, less what its blocks give way at 5 GPa."""
    result = run(BITS / "tilt.toml", tmp_path / "out", more=(), material=material)
    assert result.exit_code == 0, result.output
    factor = summary_of(tmp_path / "out")["load_factor"]
    assert factor["given_way"] == pytest.approx(factor["limit_analysis"]["least_found"], rel=0.03)
    assert factor["given_way"] < factor["limit_analysis"]["least_found"]


@pytest.mark.slow(reason="1.2 s until all is at rest")
@pytest.mark.parametrize("joints", ["", JOINTS], ids=["rigid", "elastic"])
def test_rigid_uniform_and_meshed_blocks_come_to_rest_under_their_weight(tmp_path: Path, joints: str) -> None:
    """After a shake, on two islands: each block is strained by the weight that it carries, or not at all."""
    scene = towers(tmp_path, joints)
    done("run", scene, "-o", tmp_path / "out", "-q")
    results = Results.open(tmp_path / "out" / "result.h5")
    gradient = results.gradient(-1)
    assert gradient is not None
    weight = -2000.0 * 9.81 * 0.25 / 1e7
    np.testing.assert_allclose(gradient[1:, 2, 2].reshape(2, 3), [[0.0, 1.5 * weight, 0.5 * weight]] * 2, rtol=2e-2, atol=1e-9)
    assert abs(summary_of(tmp_path / "out")["energy"]["balance_error"]) < 1e-9
    assert summary_of(tmp_path / "out")["solver"]["steps_missed"] == 0
    assert summary_of(tmp_path / "out")["islands"]["max"] == 2


@BOTH
@pytest.mark.parametrize("name", ["elastic", "tilt"])
def test_a_run_that_was_stopped_ends_with_the_bits_of_one_that_was_not(tmp_path: Path, name: str, material: tuple[str, ...]) -> None:
    """Ctrl-C on its way, then --resume: all that the steps depend on is in the checkpoint."""
    scene, keys = BITS / f"{name}.toml", ("run.duration=0.05", "report.stress=true")
    assert run(scene, tmp_path / "whole", *keys, material=material).exit_code == 0

    with ctrl_c_before_step(12):
        assert run(scene, tmp_path / "parts", *keys, material=material).exit_code == 130
    assert run(scene, tmp_path / "parts", *keys, material=material, more=("-q", "--resume")).exit_code == 0
    whole, parts = (contents(tmp_path / word / "result.h5") for word in ("whole", "parts"))
    assert any(name.endswith("gradient") for name in whole)
    assert material == UNIFORM or {"meshes/elements", "meshes/displacement", "meshes/stress"} <= {name.lstrip("/") for name in whole}
    assert whole == parts


def test_without_gmsh_a_line_says_what_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "gmsh", None)
    result = run(BITS / "tilt.toml", tmp_path / "out", material=(*MESHED, "mesh_size=7"))
    assert result.exit_code == 2
    assert "gmsh does not start" in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert not (tmp_path / "out").exists()
    assert run(BITS / "tilt.toml", tmp_path / "out", "run.duration=0.02", material=()).exit_code == 0  # rigid blocks need none


@pytest.mark.parametrize("fault", [TooManyPoints((0, 1)), UnexplainedOverlap((0, 1), 0.167, 0.003)], ids=["crowded", "unexplained"])
@pytest.mark.parametrize("dt", ["dt = 1e-3", 'dt = "auto"\ndt_min = 1e-3'], ids=["fixed", "adapting"])
def test_a_run_whose_contacts_are_not_found_ends_with_its_results(
    block_on_plate, tmp_path: Path, monkeypatch, dt: str, fault: ContactFault
) -> None:
    """Found in the detection of a step: one line with the blocks, exit code 1, and all that was computed can be read."""
    detect, far = Detector.detect, 0.01

    def faulty(self: Detector, position: np.ndarray, *where: object) -> object:
        if far < position[0, 0] < 0.05:  # the plate, which is shaken
            raise fault
        return detect(self, position, *where)

    monkeypatch.setattr(Detector, "detect", faulty)
    result = masonry_cd("run", block_on_plate(dt=dt), "-o", tmp_path / "out")
    assert result.exit_code == 1, result.output
    found = summary_of(tmp_path / "out")
    assert found["stopped"] == f"step {found['steps'] + 1}: " + fault.text.format('"plate"', '"block"')
    assert f"the run ended early, {found['stopped']}; the results hold all frames up to there" in result.output
    with Results.open(tmp_path / "out" / "result.h5") as results:
        assert len(results.per_step("solver/error")) == found["steps"] > 10
        assert 0.5 * far < results.position[results.frames - 1, 0, 0] <= far  # frames are 20 ms apart
    assert "plate" in (tmp_path / "out" / "joints.csv").read_text()


RADIUS, ROLLING = 0.1, 0.1
SCENE = """
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
    "motion": """
[[loads]]
kind = "motion"
path = "levels.csv"
about = [3.0, 0.0, 0.0]
""",
    "tilt": """
[[loads]]
kind = "tilt"
direction = "x"
initial = 0.0
rate = 10.0
""",
}


def piles() -> list[dict[str, Any]]:
    """Four balls, and one on them, on each of two plates that lie apart."""
    blocks = []
    for name, at in (("near", 0.0), ("far", 4.0)):
        blocks.append(cuboid((at - 1.0, -1.0, -0.5), (at + 1.0, 1.0, 0.0)) | {"name": name, "fixed": True, "group": name})
        places = [(x, y, RADIUS) for x in (-RADIUS, RADIUS) for y in (-RADIUS, RADIUS)] + [(0.0, 0.0, RADIUS * (1.0 + math.sqrt(2.0)))]
        for k, (x, y, z) in enumerate(places):
            blocks.append({"name": f"{name} {k}", "centre": [at + x, y, z], "radius": RADIUS, "group": "balls"})
    return blocks


def scene(folder: Path, load: str, duration: float, material: str = "", blocks: list[dict[str, Any]] | None = None) -> Path:
    """A scene of a load on two piles, or on other blocks."""
    return write_scene(folder, blocks or piles(), SCENE.format(load=LOADS.get(load, ""), duration=duration, material=material))


def ran(folder: Path, balance: float = 1e-6) -> dict:
    """The summary of a run that ends well, each step of it solved and with its energy closed."""
    done("run", folder / "scene.toml", "-o", folder / "out", "-q")
    found = summary_of(folder / "out")
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
    scene(tmp_path, "tilt", 0.9, blocks=blocks)
    ran(tmp_path)
    with Results.open(tmp_path / "out" / "result.h5") as results:
        time = np.array(results.time)
        gone = np.abs(np.array([results.position[k][1] - results.position[0][1] for k in range(results.frames)])).max(axis=1)
    begins = math.degrees(math.atan(ROLLING)) / 10.0
    assert gone[time < 0.98 * begins].max() < 1e-9
    assert gone[-1] > 1e-3


@pytest.mark.parametrize("load", ["record", "motion"])
def test_spheres_go_on_from_their_checkpoint_to_the_same_bits(tmp_path: Path, load: str) -> None:
    (tmp_path / "levels.csv").write_text("time [h],far.z [mm],far.ry [deg]\n0,0,0\n0.00002,-1,0.2\n0.00004,-4,0.5\n")
    path = scene(tmp_path, load, 0.2)
    assert masonry_cd("run", path, "-o", tmp_path / "whole", "-q").exit_code == 0

    with ctrl_c_before_step(30):
        assert masonry_cd("run", path, "-o", tmp_path / "parts", "-q").exit_code == 130
    assert masonry_cd("run", path, "-o", tmp_path / "parts", "-q", "--resume").exit_code == 0
    assert contents(tmp_path / "whole" / "result.h5") == contents(tmp_path / "parts" / "result.h5")


@pytest.mark.parametrize("pair", ["balls-near", "balls-*", "default"])
def test_springs_of_spheres_are_refused(tmp_path: Path, pair: str) -> None:
    """Also by default, where all that can touch are spheres on supports."""
    path = scene(tmp_path, "", 0.1, f'[material.joints."{pair}"]\nnormal_stiffness = 1e9\n')
    assert refusal(masonry_cd("run", path, "-o", tmp_path / "out")).place.endswith(f"material.joints.{pair}")
    assert not (tmp_path / "out").exists()


def test_stones_next_to_spheres_have_springs_by_default(tmp_path: Path) -> None:
    """The law of the stones; what is said of spheres alone is refused there too."""
    blocks = [cuboid((-1.0, -1.0, -0.5), (1.0, 1.0, 0.0)) | {"name": "plate", "fixed": True, "group": "base"}]
    blocks.append(cuboid((-0.2, -0.2, 0.0), (0.2, 0.2, 0.4)) | {"name": "stone", "group": "stones"})
    blocks.append({"name": "ball", "centre": [0.0, 0.0, 0.4 + RADIUS], "radius": RADIUS, "group": "balls"})
    scene(tmp_path, "", 0.1, "[material.joints.default]\nnormal_stiffness = 1e9\n", blocks)
    found = ran(tmp_path, balance=1e-3)  # of the work of settling alone, some joules
    weight = 2000.0 * 9.81 * (0.4**3 + 4.0 / 3.0 * math.pi * RADIUS**3)
    assert found["energy"]["elastic"] == pytest.approx(0.5 * weight**2 / (1e9 * 0.16), rel=1e-3)
