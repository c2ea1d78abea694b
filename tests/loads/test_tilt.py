# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.kinds.tilt: gravity turns and keeps its size, a push grows; a block on a slope and a dry wall give way where theory says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from models import box, ground

import loads
from loads.kinds.tilt import load_factors
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, Block

G = (0.0, 0.0, -9.81)


def build(*tables: dict, dt: float = 1e-2, steps: int = 1000, gravity: tuple = G) -> loads.Loading:
    return loads.build(tables, dt, steps, gravity, Path("."))


def test_a_tilt_turns_gravity_and_keeps_its_size() -> None:
    a = build({"kind": "tilt", "direction": "x", "rate": 3.0, "start": 2.0, "angle": 20.0}).acceleration
    assert np.linalg.norm(a, axis=1) == pytest.approx(9.81)
    phi = np.clip(3.0 * (0.01 * np.arange(1001) - 2.0), 0.0, 20.0)
    assert np.degrees(np.arctan2(a[:, 0], -a[:, 2])) == pytest.approx(phi, abs=1e-9)
    assert not a[:, 1].any()  # exactly: a scene that moves in its plane stays in it
    assert build({"kind": "tilt", "direction": "-y", "rate": 3.0, "initial": 10.0}).acceleration[0, 1] == pytest.approx(
        -9.81 * np.sin(np.pi / 18)
    )


def test_an_axis_turns_gravity_by_the_right_hand_rule() -> None:
    about = build({"kind": "tilt", "axis": "y", "rate": 3.0}).acceleration
    towards = build({"kind": "tilt", "direction": "-x", "rate": 3.0}).acceleration
    assert about == pytest.approx(towards, abs=1e-12)


def test_a_push_grows_linearly_and_load_factors_read_both_back() -> None:
    t = 0.01 * np.arange(1001)
    pushed = build({"kind": "push", "direction": "y", "rate": 0.05, "start": 1.0, "initial": 0.1, "peak": 0.3})
    wanted = np.clip(0.1 + 0.05 * np.maximum(t - 1.0, 0.0), 0.0, 0.3)
    assert pushed.acceleration[:, 1] == pytest.approx(9.81 * wanted)
    assert (pushed.acceleration[:, 2] == -9.81).all()
    assert pushed.load_factor(G) == pytest.approx(wanted)
    tilted = build({"kind": "tilt", "direction": [1, 1, 0], "rate": 2.0})
    assert tilted.load_factor(G) == pytest.approx(np.tan(np.radians(2.0 * t)))
    assert load_factors(np.array([[1.0, 0.0, 0.0]]), np.array(G))[0] == np.inf


def gives_way_at(blocks: list[Block], mu: float, table: dict, dt: float, limit: float = 0.01, seconds: float = 10.0) -> float:
    """lambda at which a block has moved by a limit [m] from where it was built."""
    steps, assembly = round(seconds / dt), Assembly.from_blocks(blocks, mu)
    loading = loads.build([table], dt, steps, G, Path("."), assembly)
    settings = Run(dt=dt, duration=seconds, solver="nlgs", tolerance=1e-6)
    run = Stepper(assembly, loading.support_velocity, loading.acceleration, settings)
    for k in range(steps):
        run.step()
        if np.linalg.norm(run.state.position - assembly.centre, axis=1).max() > limit:
            return float(loading.load_factor(G)[k])
    return float("nan")


@pytest.mark.parametrize("kind", ["tilt", "push"])
def test_a_block_slides_at_its_coefficient_of_friction_and_a_slender_one_tips_at_its_slenderness(kind: str) -> None:
    table = {"kind": kind, "direction": "x"} | ({"rate": 4.0, "initial": 15.0} if kind == "tilt" else {"rate": 0.05, "initial": 0.25})
    squat, slender = box("b", (0, 0, 0), (0.6, 0.4, 0.3)), box("b", (0, 0, 0), (0.4, 0.4, 1.0))
    growth = 0.05 if kind == "push" else np.radians(4.0) * (1.0 + 0.35**2)  # of lambda, per second
    lag = (6.0 * 1e-3 / (growth * 9.81)) ** (1 / 3)  # a slip of 1 mm under an acceleration that grows by growth g: d = growth g t^3 / 6
    assert gives_way_at([ground(), squat], 0.35, table, 5e-3, limit=1e-3) == pytest.approx(0.35 + growth * lag, abs=1e-3)
    assert 0.40 < gives_way_at([ground(), slender], 0.9, table, 5e-3, limit=1e-3) < 0.42
