# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic joints settle under the weight: where, a run's tolerance does not decide."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from masonry_cd.app.case import prepare
from masonry_cd.app.scene import parse_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.geometry import Polyhedron
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material
from structures.geometry.prism import box


def settled(tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Where the voussoirs of an arch are before and after, (B, 3) [m]."""
    tables = {
        "structure": {"kind": "arch", "span": 4.0, "thickness": 0.5, "voussoirs": 15},
        "material": {"masonry": "split stone", "friction": 0.5},
        "run": {"dt": 5e-3, "duration": 0.1, "tolerance": tolerance},
    }
    case = prepare(parse_scene(dump_toml(tables), Path("arch.toml"), called="arch"))
    stepper = Stepper(case.assembly, case.loading.support_velocity, case.loading.acceleration, case.scene.run)
    settle(stepper)
    return case.assembly.centre, stepper.state.position


def test_the_tolerance_of_a_run_does_not_decide_where_its_joints_settle() -> None:
    before, coarse = settled(1e-3)
    _, fine = settled(1e-9)
    sunk = float(np.abs(fine - before).max())
    assert sunk > 1e-5
    assert np.abs(coarse - fine).max() < 1e-5 * sunk


def test_a_stone_may_sink_by_more_than_a_sliver_of_it_is_thick() -> None:
    """The limit is a share of the thinnest block, not of the parts into which a stone is cut."""
    sliver = 1e-4
    parts = [Polyhedron(*box(low, high)) for low, high in (((0, 0, 0), (1, 1, 1)), ((0, 0, 1), (1, 1, 1 + sliver)))]
    whole = box((0.0, 0.0, 0.0), (1.0, 1.0, 1.0 + sliver))
    blocks = [
        Block("ground", *box((-1.0, -1.0, -0.5), (2.0, 2.0, 0.0)), 2000.0, "base", fixed=True),
        Block("stone", *whole, 2000.0, "stone", parts=tuple(parts)),
    ]
    stiffness = 1e8
    assembly = Assembly.from_blocks(blocks, Material(friction=0.6, joints={"default": JointLaw(normal_stiffness=stiffness)}))
    stepper = Stepper(assembly, np.zeros((3, 1, 3)), np.tile([0.0, 0.0, -9.81], (3, 1)), Run(dt=1e-3, duration=2e-3))
    settle(stepper)
    sunk = float(assembly.centre[1, 2] - stepper.state.position[1, 2])
    assert sunk == pytest.approx(2000.0 * 9.81 / stiffness, rel=1e-3)
    assert sunk > 0.1 * sliver
