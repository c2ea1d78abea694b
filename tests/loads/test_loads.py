# SPDX-License-Identifier: GPL-3.0-or-later
"""loads: tables are checked by kind and add up; gravity acts in full or ramped."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import loads
from masonry_cd.foundation.errors import InputError

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


def test_equal_tables_give_equal_bits_and_the_summary_is_json() -> None:
    first, second = build(SINE), build(SINE)
    assert (first.support_velocity == second.support_velocity).all()
    assert json.loads(json.dumps(first.summary)) == second.summary


def test_a_base_that_still_moves_at_the_end_of_the_run_is_reported() -> None:
    assert not any("still moving" in line for line in build(SINE).lines)
    assert any("still moving at 0.2 m/s when the run ends at 0.125 s" in line for line in build(SINE, steps=125).lines)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"direction": "x"}, "loads[0].kind: missing; kinds: artificial, prop, point, tie, gravity, "),
        ({"kind": "sinusiodal"}, 'loads[0].kind: unknown kind "sinusiodal" (did you mean "sinusoidal"?)'),
        ({**SINE, "amplitud": 1.0}, 'loads[0].amplitud: unknown key (did you mean "amplitude"?)'),
        ({k: v for k, v in SINE.items() if k != "amplitude"}, "loads[0].amplitude: missing"),
        ({**SINE, "amplitude": "0.2"}, "loads[0].amplitude: "),
        ({**SINE, "amplitude": float("nan")}, "loads[0].amplitude: "),
        ({**SINE, "frequency": 0.0}, "loads[0].frequency: "),
        ({**SINE, "direction": "north"}, 'loads[0].direction: must be "x", "y", "z"'),
        ({**SINE, "direction": [0, 0, 0]}, "loads[0].direction: a vector of finite length above zero"),
        ({**SINE, "direction": [1, 0]}, "loads[0].direction: "),
        ({**SINE, "duration": 2.0}, "loads[0]: give exactly one of cycles and duration"),
        ({**SINE, "ramp": 1.5}, "loads[0]: ramp: 1.5 s in and out do not fit into the 2 s of motion"),
        ({**SINE, "frequency": 600.0}, "loads[0].frequency: 600 Hz is beyond run.dt 0.001 s"),
        ({"kind": "gravity", "ramp": -1.0}, "loads[0].ramp: "),
    ],
)
def test_bad_tables_are_named_by_key(table: dict, message: str) -> None:
    with pytest.raises(InputError) as failure:
        build(table)
    assert str(failure.value).startswith(message)
    assert "\n" not in str(failure.value)


def test_gravity_given_twice_is_refused() -> None:
    with pytest.raises(InputError, match=r"loads\[1\]: gravity is given twice, first in loads\[0\]"):
        build({"kind": "gravity"}, {"kind": "gravity", "ramp": 1.0})
