# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of blocks that deform, meshed and of one strain, from the command line: loads of all kinds, groups, elastic joints, resuming, and
what is refused."""

from __future__ import annotations

import json
import signal
import sys
from pathlib import Path

import numpy as np
import pytest
from block_files import cuboid
from command_line import masonry_cd
from datasets import contents
from places import ROOT

from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.faults import ContactFault, TooManyPoints, UnexplainedOverlap
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

BITS = ROOT / "benchmarks" / "bits"
MESHED = ("deformable=tetrahedra", "mesh_size=10", "young=5e9", "damping=0.05", "damping_frequency=10")
UNIFORM = ("deformable=uniform", *MESHED[2:])
LONG = pytest.mark.slow(reason="hundreds of steps of an arch that is cut into elements")
BOTH = pytest.mark.parametrize("material", [pytest.param(UNIFORM, id="uniform"), pytest.param(MESHED, id="meshed", marks=LONG)])
KINDS = """
[structure]
kind = "file"
path = "blocks.json"
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
    (folder / "blocks.json").write_text(json.dumps({"units": "m", "blocks": blocks}))
    (folder / "scene.toml").write_text(KINDS.format(joints=joints))
    return folder / "scene.toml"


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
    result = masonry_cd("run", scene, "-o", tmp_path / "out", "-q")
    assert result.exit_code == 0, result.output
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
def test_a_run_that_was_stopped_ends_with_the_bits_of_one_that_was_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, material: tuple[str, ...]
) -> None:
    """Ctrl-C on its way, then --resume: all that the steps depend on is in the checkpoint."""
    scene, advance, keys = BITS / f"{name}.toml", Stepper.step, ("run.duration=0.1", "report.stress=true")
    assert run(scene, tmp_path / "whole", *keys, material=material).exit_code == 0

    def step(self: Stepper) -> object:
        if self.steps == 12:
            signal.raise_signal(signal.SIGINT)
        return advance(self)

    monkeypatch.setattr(Stepper, "step", step)
    assert run(scene, tmp_path / "parts", *keys, material=material).exit_code == 130
    monkeypatch.setattr(Stepper, "step", advance)
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
