# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks that stand on a base that turns, and move with it, are not displaced, have no drift and have not fallen."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

import masonry_cd as mc
from masonry_cd.analysis.deformed import Base
from masonry_cd.mechanics.model.state import rotation_matrices
from reports.paraview import export


@pytest.fixture(scope="module")
def turned(tmp_path_factory: pytest.TempPathFactory) -> mc.Run:
    """Two blocks on a platform that turns by 20 degrees about a point 4 m away, and so drops by a metre."""
    blocks = [mc.box((-1, -0.5, -0.5), (1, 0.5, 0)), mc.box((-0.3, -0.2, 0), (0.3, 0.2, 0.3)), mc.box((-0.3, -0.2, 0.3), (0.3, 0.2, 0.6))]
    turn = {"kind": "motion", "supports": "b0", "time": [0, 1.2], "rotation": [0, 20], "axis": "y", "about": [-4, 0, 0]}
    scene = mc.scene(
        structure={"blocks": blocks, "fixed": "b0"},
        material={"density": 2000.0, "friction": 1.1},
        loads=[turn],
        run={"dt": 2e-3, "duration": 1.4, "frames_per_second": 10},
        report={"crack_map": False},
    )
    return mc.run(scene, tmp_path_factory.mktemp("turned") / "out", progress=False)


def test_the_run_finds_nothing_displaced_and_nothing_fallen(turned: mc.Run) -> None:
    found = turned.summary
    assert (
        found["collapsed_blocks"] == 0 and found["displacement_max"] < 1e-4 and found["loads"]["base"]["peak_rotation"] == pytest.approx(20)
    )
    assert turned.parts["grade"].iloc[-1] == "D0" and turned.parts["max_drift"].max() < 1e-4
    rows = turned.blocks()
    assert rows[["ux", "uy", "uz", "rx", "ry", "rz"]].to_numpy() == pytest.approx(0.0, abs=1e-4)
    angle = np.radians(20.0)
    assert rows.loc["b1", "z"] == pytest.approx(-4 * np.sin(angle) + 0.15 * np.cos(angle), abs=1e-4)
    moved = turned.motion("b2")
    assert moved[["ux", "uz", "ry"]].to_numpy() == pytest.approx(0.0, abs=1e-4) and moved["base_z"].iloc[-1] < -1.0


def test_meshes_are_in_the_world_and_their_displacements_on_the_base(turned: mc.Run) -> None:
    mesh = turned.mesh()
    assert np.abs(mesh["displacement"]).max() < 1e-4 and mesh.points[:, 2].min() < -1.5


def test_points_are_seen_from_the_base_and_back() -> None:
    turn = np.array([[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5], [0.8, 0.0, 0.6, 0.0]])
    centre, place = np.array([[1.0, 2.0, 3.0]]), np.array([[[1.0, 2.0, 3.0]], [[0.0, 0.0, 1.0]], [[5.0, 1.0, 0.0]]])
    base, points = Base.of(0, centre, place, turn[:, None]), np.random.default_rng(1).normal(size=(3, 4, 3))
    for k in range(3):
        one = Base.of(0, centre, place[k], turn[k][None])
        assert base.seen(points)[k] == pytest.approx(one.seen(points[k])) and one.in_world(one.seen(points[k])) == pytest.approx(points[k])
        own = one.orientations(turn)
        assert rotation_matrices(own) == pytest.approx(one.rotations(rotation_matrices(turn))) and np.abs(own[k]) == pytest.approx(
            [1, 0, 0, 0]
        )
        assert base.orientations(np.stack([turn] * 3))[k] == pytest.approx(own)
    assert Base.of(0, centre, place[0], turn[0][None]).orientation is None


def test_paraview_has_joints_where_they_are(turned: mc.Run, tmp_path: Path) -> None:
    with turned.results() as found:
        export(found, tmp_path)
    with h5py.File(tmp_path / "joints.vtkhdf") as file:
        points = np.asarray(file["VTKHDF/Points"])
    angle = np.radians(20.0)
    wanted = [-(4.0 + x) * np.sin(angle) + 0.3 * np.cos(angle) for x in (0.3, 0.3, -0.3, -0.3)]  # of the upper joint, at the end
    assert points[0, 2] == 0.0 and np.sort(points[-4:, 2]) == pytest.approx(wanted, abs=1e-4)
