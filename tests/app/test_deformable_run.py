# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of blocks that deform, from the scene file to the page."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from masonry_cd.analysis.deformed import Pose, solids_of
from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import read_scene
from masonry_cd.io.results import Results

SOFT = 'friction = 0.5\ndeformable.block = "uniform"\nyoung = 1e7\npoisson = 0.0\ndamping = 0.2\ndamping_frequency = 50.0'
MESHED = SOFT.replace('"uniform"', '"tetrahedra"') + "\nmesh_size = 1.0"
WEIGHT = 2000.0 * 9.81 * 0.4  # of the block over its area [Pa]


def test_results_hold_what_a_block_shortens_by_and_pictures_draw_it(block_on_plate: Callable[..., Path], tmp_path: Path) -> None:
    """At rest in the end the mean strain is half the weight over E, so the top has sunk by that times the height."""
    case = prepare(read_scene(block_on_plate(friction=SOFT, report="[report]\nhtml = true")))
    summary = run_case(case, tmp_path / "out")
    results = Results.open(tmp_path / "out" / "result.h5")
    gradient = results.gradient(results.frames - 1)
    assert gradient is not None
    assert gradient.shape == (2, 3, 3)
    assert not gradient[0].any()
    np.testing.assert_allclose(gradient[1, 2, 2], -0.5 * WEIGHT / 1e7, rtol=1e-3)
    solids, pose = solids_of(results.blocks), Pose.of(results, solids_of(results.blocks))
    top = np.flatnonzero((solids.vertex_block == 1) & (solids.vertices[:, 2] > 0.3))
    sunk = (pose.moved(solids, solids.vertices[top], solids.vertex_block[top]) - solids.vertices[top])[:, 2]
    np.testing.assert_allclose(sunk, -0.4 * 0.5 * WEIGHT / 1e7, rtol=1e-3)
    assert summary.energy.elastic > 0.0
    assert not [line for line in summary.explanation if line.startswith("strains of blocks")]
    assert "elastic, with one strain each" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


def test_a_run_of_rigid_blocks_says_that_it_left_strains_out(block_on_plate: Callable[..., Path], tmp_path: Path) -> None:
    """And its results have none."""
    summary = run_case(prepare(read_scene(block_on_plate(duration="duration = 0.05"))), tmp_path / "out")
    assert [line for line in summary.explanation if line.startswith("strains of blocks: none")]
    assert Results.open(tmp_path / "out" / "result.h5").gradient(0) is None


def test_a_meshed_block_runs_from_the_scene_file_to_the_page(block_on_plate: Callable[..., Path], tmp_path: Path) -> None:
    """At rest its best-fitting strain is that of its weight, and the page says what it is."""
    case = prepare(read_scene(block_on_plate(friction=MESHED, report="[report]\nhtml = true\nstress = true")))
    summary = run_case(case, tmp_path / "out")
    results = Results.open(tmp_path / "out" / "result.h5")
    gradient = results.gradient(results.frames - 1)
    assert gradient is not None
    np.testing.assert_allclose(gradient[1, 2, 2], -0.5 * WEIGHT / 1e7, rtol=2e-2)
    assert abs(summary.energy.balance_error) < 1e-9
    assert "elastic, meshed" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert [line for line in summary.explanation if "meshes of triangles" in line]
