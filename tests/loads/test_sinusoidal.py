# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.kinds.sinusoidal: the velocity is the sine asked for, starts and ends without a jump, and its printed numbers are true."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import loads

C, F, DT = 0.2, 2.0, 1e-3


def build(dt: float = DT, steps: int = 6000, **keys: object) -> loads.Loading:
    table = {"kind": "sinusoidal", "direction": "x", "amplitude": C, "frequency": F, **keys}
    return loads.build([table], dt, steps, (0.0, 0.0, -9.81), Path("."))


def velocity(**keys: object) -> np.ndarray:
    return build(**keys).support_velocity[:, 0, 0]


def test_it_is_the_sine_asked_for() -> None:
    t = DT * np.arange(6001)
    wanted = np.where((t > 0.5) & (t < 5.5), C * np.sin(2 * np.pi * F * (t - 0.5)), 0.0)
    assert velocity(cycles=10, start=0.5) == pytest.approx(wanted, abs=1e-12)
    assert velocity(duration=5.0, start=0.5) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize(
    "keys", [{"cycles": 10}, {"duration": 1.3}, {"cycles": 2.6}, {"duration": 1.3, "ramp": 0.4}, {"cycles": 3, "ramp": 0.2}]
)
def test_the_velocity_never_jumps(keys: dict) -> None:
    v = velocity(**keys)
    peak = 2 * np.pi * F * C
    assert abs(np.diff(v)).max() <= 1.3 * peak * DT  # a jump would be of the size of C, 0.2 m/s
    assert v[0] == 0.0
    assert v[-1] == 0.0
    assert abs(v).max() == pytest.approx(C, rel=1e-3)


def test_an_end_inside_a_half_cycle_is_carried_on_and_reported() -> None:
    loading = build(duration=1.3)
    t = DT * np.arange(6001)
    moving = t[np.flatnonzero(loading.support_velocity[:, 0, 0])]
    assert moving[-1] == pytest.approx(1.5, abs=2 * DT)
    assert any("1.3 s ends inside a half cycle: the motion goes on to the next zero of the sine, 1.5 s" in line for line in loading.lines)
    assert not any("half cycle" in line for line in build(duration=1.5).lines)


def test_printed_numbers_follow_the_closed_form() -> None:
    after = build(cycles=10).summary["tables"][0]["after"]
    assert after["pga"] == pytest.approx(2 * np.pi * F * C)
    assert after["pgv"] == pytest.approx(C)
    assert after["pgd"] == pytest.approx(C / (np.pi * F), rel=1e-4)  # integral of half a sine
    assert after["end_displacement"] == pytest.approx(0.0, abs=1e-12)
    half = build(cycles=0.5).summary["tables"][0]["after"]
    assert half["end_displacement"] == pytest.approx(C / (np.pi * F), rel=1e-4)


def test_a_ramp_tapers_both_ends_and_whole_cycles_still_return() -> None:
    v = velocity(cycles=10, ramp=1.0)
    first, middle = abs(v[:500]).max(), abs(v[2000:3000]).max()
    assert first < 0.55 * C
    assert middle == pytest.approx(C, rel=1e-4)
    assert abs(DT * v.sum()) < 1e-9  # odd about the middle of the motion: no displacement is left
    assert v[:5001] == pytest.approx(-v[5000::-1], abs=1e-12)


def test_a_coarse_step_is_reported_by_number() -> None:
    assert any("gives only 10 steps per cycle" in line for line in build(dt=0.05, steps=100, cycles=4).lines)
    assert not any("steps per cycle" in line for line in build(cycles=4).lines)
