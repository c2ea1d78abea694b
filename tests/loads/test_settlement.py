# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.kinds.settlement and loads.supports: the supports named end where they should, a wave reaches them one after the other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from models import advance, box

import loads
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly

G = (0.0, 0.0, -9.81)
DT = 1e-3
PIERS = (0.0, 4.0, 10.0)


@pytest.fixture(scope="module")
def three_piers() -> Assembly:
    """Three fixed blocks in a row, a free one on each."""
    blocks = [box(f"foot{i}", (x, 0, -1), (x + 1, 1, 0), fixed=True) for i, x in enumerate(PIERS)]
    blocks += [box(f"pier{i}", (x, 0, 0), (x + 1, 1, 2)) for i, x in enumerate(PIERS)]
    return Assembly.from_blocks(blocks, 0.6)


def build(assembly: Assembly | None, *tables: dict, dt: float = DT, steps: int = 4000) -> loads.Loading:
    return loads.build(tables, dt, steps, G, Path("."), assembly)


def moved(loading: loads.Loading, dt: float = DT) -> np.ndarray:
    """Displacement of each fixed block by the trapezoidal rule of the step, (N + 1, 3 feet, 3)."""
    assert loading.support_of is not None
    v = loading.support_velocity[:, loading.support_of[:3]]
    return np.concatenate([np.zeros((1, 3, 3)), np.cumsum(0.5 * dt * (v[1:] + v[:-1]), axis=0)])


SETTLES = {"kind": "settlement", "supports": ["foot1"], "displacement": 0.02, "start": 0.5, "duration": 1.5}


@pytest.mark.parametrize("dt", [1e-3, 7e-3, 0.1])
def test_the_support_named_ends_exactly_where_asked_and_the_others_stay(three_piers: Assembly, dt: float) -> None:
    loading = build(three_piers, SETTLES, dt=dt, steps=round(3.0 / dt))
    at = moved(loading, dt)
    assert at[-1, 1] == pytest.approx([0.0, 0.0, -0.02], abs=1e-15)
    assert not at[:, [0, 2]].any()
    assert not loading.support_velocity[[0, -1]].any()
    assert loading.support_velocity.shape[1] == 2
    assert loading.support_of.tolist()[3:] == [-1, -1, -1]
    assert (np.diff(at[:, 1, 2]) <= 0.0).all()


def test_the_pulse_has_no_jump_in_acceleration(three_piers: Assembly) -> None:
    v = build(three_piers, SETTLES).support_velocity[..., 2].min(axis=1)
    assert abs(np.diff(v, 2)).max() / DT**2 < 1.01 * 60.0 * 0.02 / 1.5**3  # d''' of the quintic is at most 60 D / T^3


def test_spreading_parts_the_outermost_supports_and_stretches_between(three_piers: Assembly) -> None:
    loading = build(three_piers, {"kind": "spreading", "direction": "x", "displacement": 0.05, "duration": 2.0})
    ends = moved(loading)[-1]
    assert ends[:, 0] == pytest.approx([-0.025, -0.005, 0.025], abs=1e-15)  # feet at 0, 4 and 10 m
    assert not ends[:, 1:].any()
    two = build(three_piers, {"kind": "spreading", "supports": ["foot0", "foot1"], "direction": "x", "displacement": 0.05, "duration": 2.0})
    assert moved(two)[-1][:, 0] == pytest.approx([-0.025, 0.025, 0.0], abs=1e-15)


SINE = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.2, "frequency": 2.0, "cycles": 4}


def test_a_wave_reaches_the_supports_one_after_the_other(three_piers: Assembly) -> None:
    together = build(three_piers, SINE).support_velocity[:, 0]
    loading = build(three_piers, {**SINE, "delay": {"direction": "x", "speed": 20.0}})
    assert loading.support_velocity.shape == (4001, 3, 3)
    for foot, x in enumerate(PIERS):
        late = round(x / 20.0 / DT)
        v = loading.support_velocity[:, loading.support_of[foot]]
        assert not v[: late + 1].any()
        assert v[late:] == pytest.approx(together[: 4001 - late], abs=1e-12)
    assert any("3 motions of the supports, apart by at most" in line for line in loading.lines)
    back = build(three_piers, {**SINE, "delay": {"direction": "-x", "speed": 20.0}})
    assert back.support_velocity[:, back.support_of[2]] == pytest.approx(together, abs=1e-12)


def test_delays_by_name_and_a_settlement_on_top(three_piers: Assembly) -> None:
    tables = ({**SINE, "delay": {"seconds": {"foot2": 0.3, "foot0": 0.1}}}, SETTLES)
    loading = build(three_piers, *tables)
    assert sorted(loading.support_of.tolist()) == [-1, -1, -1, 0, 1, 2]
    together = build(three_piers, SINE).support_velocity[:, 0, 0]
    assert loading.support_velocity[300:, loading.support_of[2], 0] == pytest.approx(together[:3701], abs=1e-12)
    assert loading.support_velocity[:, loading.support_of[1], 0] == pytest.approx(together, abs=1e-12)
    assert moved(loading)[-1, 1, 2] == pytest.approx(-0.02)


def test_supports_that_move_alike_share_one_motion(three_piers: Assembly) -> None:
    assert build(three_piers, SINE).support_velocity.shape[1] == 1
    assert build(three_piers).support_of.tolist() == [0, 0, 0, -1, -1, -1]
    assert build(None, SINE).support_of is None
    assert build(three_piers, {**SETTLES, "supports": "base"}).support_velocity.shape[1] == 1
    assert build(three_piers, {**SETTLES, "supports": "foot[01]"}).support_velocity.shape[1] == 2


def test_a_pier_goes_down_with_its_foot(three_piers: Assembly) -> None:
    dt = 5e-3
    loading = build(three_piers, {**SETTLES, "start": 0.0, "duration": 0.5}, dt=dt, steps=120)
    assembly = replace(three_piers, support_of=loading.support_of)
    run = Stepper(assembly, loading.support_velocity, loading.acceleration, Run(dt=dt, duration=0.6, solver="nlgs", tolerance=1e-8))
    advance(run, 120)
    down = (run.state.position - assembly.centre)[:, 2]
    assert down == pytest.approx([0.0, -0.02, 0.0, 0.0, -0.02, 0.0], abs=1e-6)
