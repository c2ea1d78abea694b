# SPDX-License-Identifier: GPL-3.0-or-later
"""loads: tables are checked by kind and add up; gravity acts in full or ramped."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import loads

G = (0.0, 0.0, -9.81)
SINE = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.2, "frequency": 2.0, "cycles": 4}


def build(*tables: dict, dt: float = 1e-3, steps: int = 3000) -> loads.Loading:
    return loads.build(tables, dt, steps, G, Path("."))


def test_without_tables_gravity_acts_in_full_and_nothing_moves() -> None:
    loading = build(steps=10)
    assert loading.support_velocity.shape == (11, 1, 3)
    assert not loading.support_velocity.any()
    assert (loading.acceleration == np.array(G)).all()


def test_gravity_ramp_rises_without_a_kink_and_stays() -> None:
    pull = -build({"kind": "gravity", "ramp": 0.5}).acceleration[:, 2]
    assert pull[0] == 0.0
    assert pull[250] == pytest.approx(0.5 * 9.81)
    assert (pull[500:] == 9.81).all()
    assert (np.diff(pull) >= 0.0).all()
    assert abs(np.diff(pull, 2)).max() < 1.01 * 6.0 / 0.5**2 * 9.81 * 1e-6  # s'' of the smooth step is at most 6 / ramp^2


def test_tables_add_up_and_directions_are_unit_vectors() -> None:
    along = build(SINE).support_velocity[:, 0]
    assert not along[:, 1:].any()
    against = build({**SINE, "direction": "-x"}).support_velocity[:, 0]
    assert (along == -against).all()
    both = build(SINE, {**SINE, "direction": [0.0, 3.0, 4.0]}).support_velocity[:, 0]
    assert both[:, 0] == pytest.approx(along[:, 0])
    assert both[:, 1] == pytest.approx(0.6 * along[:, 0])
    assert both[:, 2] == pytest.approx(0.8 * along[:, 0])


def test_a_base_that_still_moves_at_the_end_of_the_run_is_reported() -> None:
    assert not any("still moving" in line for line in build(SINE).lines)
    assert any("still moving at 0.2 m/s when the run ends at 0.125 s" in line for line in build(SINE, steps=125).lines)
