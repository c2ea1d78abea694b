# SPDX-License-Identifier: GPL-3.0-or-later
"""Pushes and gauges of a scene: their tables, their numbers in Python, and a run that is resumed in the middle of a push."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_runs import ctrl_c_before_step

import masonry_cd as mc
from masonry_cd.app.case import prepare
from masonry_cd.app.run_case import run_case

BLOCKS = [
    mc.box((-2, -2, -0.5), (3, 3, 0)),
    mc.box((0, 0, 0), (0.5, 1, 1)),
    mc.box((0, 0, 1), (0.5, 1, 2)),
]
SCENE = {
    "title": "Two blocks pushed",
    "structure": {"blocks": BLOCKS, "fixed": "b0"},
    "material": {"density": 2000.0, "friction": 0.3},
    "loads": [
        {
            "kind": "push", "control": "displacement", "direction": "x", "blocks": "b1", "rotation": "held",
            "targets": [0.004, -0.004, 0.0], "speed": 0.008,
        },
    ],
    "run": {"dt": 5e-3},
    "output": {
        "point": [{"block": "b2", "corner": "+x+z"}, {"place": [0.0, 0.5, 0.5], "relative": False, "name": "side"}],
        "joint": [{"blocks": ["b1", "b2"]}],
        "crack": [{"points": [[0.0, 0.5, 0.9], [0.0, 0.5, 1.1]], "name": "gauge"}],
        "support": [{"block": "b0"}],
    },
}  # fmt: skip
WEIGHT = 2000.0 * 9.81


def test_a_cyclic_push_has_loops_whose_energy_is_that_of_friction_and_gauges_that_follow(tmp_path: Path) -> None:
    run = mc.run(mc.scene(SCENE), tmp_path / "out", progress=False)
    numbers = run.force_displacement().attrs["numbers"]
    (cycle,) = numbers["cycles"]
    assert numbers["peak_force"] == pytest.approx(0.3 * WEIGHT, rel=0.01)
    assert cycle["dissipated"] == pytest.approx(0.3 * WEIGHT * 0.016, rel=2e-3)
    assert cycle["damping"] == pytest.approx(2.0 / np.pi, rel=0.01)  # of a rectangle
    assert run.energy["friction"].iloc[-1] == pytest.approx(numbers["energy"], rel=1e-3)
    top, side = run.gauge("b2 +x+z"), run.gauge("side")
    assert np.abs(top["ux"]).max() == pytest.approx(0.004, rel=0.01)
    assert np.abs(top["ux"] - side["ux"]).max() < 1e-5
    assert top.attrs["units"]["ax"] == "m/s2"
    joint = run.gauge("b1 - b2")
    assert joint["normal_force"].iloc[10] == pytest.approx(0.5 * WEIGHT, rel=1e-3)
    assert joint["depth"].iloc[-1] == pytest.approx(0.5, rel=0.05)
    ground = run.gauge("b0")
    assert ground["fz"].iloc[10] == pytest.approx(WEIGHT, rel=1e-3)
    assert np.abs(run.gauge("gauge")["opening"]).max() < 1e-4
    for name in ("force_displacement.csv", "push_cycles.csv", "points.csv", "joint_gauges.csv", "cracks.csv", "supports.csv"):
        assert (tmp_path / "out" / name).stat().st_size > 0
    assert (tmp_path / "out" / "force_displacement.png").exists()
    assert "push" in run.lines[2]


def test_a_run_that_is_resumed_in_the_middle_of_a_push_has_the_same_bits(tmp_path: Path) -> None:
    scene = mc.scene(SCENE | {"run": {"dt": 5e-3, "duration": 0.2}})
    whole = mc.run(scene, tmp_path / "whole", progress=False)
    with ctrl_c_before_step(20):
        run_case(prepare(scene.checked), tmp_path / "parts")
    resumed = mc.resume(tmp_path / "parts", progress=False)
    assert not resumed.stopped
    first, second = whole.force_displacement(), resumed.force_displacement()
    assert first.to_numpy().tobytes() == second.to_numpy().tobytes()
    assert whole.gauge("b1 - b2").to_numpy().tobytes() == resumed.gauge("b1 - b2").to_numpy().tobytes()
