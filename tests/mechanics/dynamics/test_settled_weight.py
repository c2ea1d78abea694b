# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic joints settle under the weight: where, a run's tolerance does not decide."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from masonry_cd.app.case import prepare
from masonry_cd.app.scene import parse_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper


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
