# SPDX-License-Identifier: GPL-3.0-or-later
"""loads: tables add up, gravity acts in full or ramped, and how much of a load has acted by a time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bridge_scenes import bridge, grid
from models import box, ground

import loads
from loads.kinds.vehicle import KINDS as VEHICLE
from masonry_cd.foundation.errors import parse_table
from masonry_cd.mechanics.model.blocks import Assembly

G = (0.0, 0.0, -9.81)
STONE = Assembly.from_blocks([ground(2.0), box("stone", (-0.5, -0.5, 0.0), (0.5, 0.5, 1.0))], 0.6)
SINE = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.1, "frequency": 2.0, "cycles": 4}
PULSE = {"kind": "pulse", "direction": "x", "acceleration": 1.0, "duration": 2.0}
POINT = {"kind": "point", "block": "stone", "force": [1, 0, 0]}


def shares(table: dict[str, Any], times: list[float], assembly: Assembly | None = STONE, folder: Path = Path(".")) -> list[float]:
    """Of the only table whose share is known, at some times."""
    (acted,) = loads.build([table], 0.01, 100, G, folder, assembly).acted
    assert acted.where == "loads[0]"
    return [acted.row(time)["share"] for time in times]


@pytest.mark.parametrize(
    ("table", "times", "wanted"),
    [
        (SINE | {"start": 1.0}, [0.9, 2.0, 3.0], [0, 0.5, 1]),
        (
            SINE | {"delay": {"seconds": {"base": 2.0}}},
            [2.0, 4.0],
            [0, 1],
        ),  # the last support
        (PULSE | {"acceleration": -1.0}, [-1, 1, 2, 3], [0, 0.5, 1, 1]),
        (PULSE | {"shape": "rectangle"}, [0.5, 2.0], [0.25, 1]),
        (PULSE | {"shape": "sine"}, [0.5, 1.0, 1.5, 2.0], [0.25, 0.5, 0.75, 1]),
        ({"kind": "settlement", "supports": "base", "displacement": -0.1, "duration": 2.0, "start": 1.0}, [1.0, 2.0, 3.0], [0, 0.5, 1]),
        ({"kind": "tilt", "direction": "x", "rate": 1.0, "angle": 20.0, "initial": 5.0}, [0.0, 7.5, 15.0], [0.25, 0.625, 1]),
        ({"kind": "tilt", "direction": "x", "rate": 1.0, "start": 3.0}, [3.0, 3.1], [0, 1]),  # without an end: it has begun
        ({"kind": "push", "direction": "x", "rate": 0.1, "peak": 0.5}, [0.0, 2.5, 5.0], [0, 0.5, 1]),
        (POINT | {"start": 2.0}, [1.9, 2.0], [0, 1]),
        (POINT | {"ramp": 1.0, "stages": [1, 0, 2], "hold": 1.0}, [1.0, 3.0, 4.5, 5.0], [0.25, 0.5, 0.75, 1]),
        ({"kind": "gravity", "ramp": 2.0}, [0.0, 1.0, 2.0], [0, 0.5, 1]),
    ],
)
def test_each_kind_measures_what_it_does(table: dict[str, Any], times: list[float], wanted: list[float]) -> None:
    assert shares(table, times) == pytest.approx(wanted, abs=1e-9)


def test_a_push_by_displacement_counts_its_way_to_and_fro() -> None:
    table = {"kind": "push", "control": "displacement", "direction": "x", "blocks": "stone", "targets": [0.1, 0.0], "speed": 0.01}
    leg = 1.875 * 0.1 / 0.01
    assert shares(table, [leg, 2.0 * leg]) == pytest.approx([0.5, 1.0])


def record(folder: Path) -> dict[str, Any]:
    """A rest of 9 s, and a second in which the ground shakes."""
    time = 0.01 * np.arange(1001)
    shaken = np.where(time < 9.0, 0.0, np.sin(2.0 * np.pi * 4.0 * time))
    np.savetxt(folder / "late.csv", np.column_stack([time, shaken]), delimiter=",", header="time_s,acc_m_s2", comments="")
    return {"path": "late.csv", "correction": "linear"}


def test_records_and_sequences_go_by_their_arias_intensity(tmp_path: Path) -> None:
    table = {"kind": "record", "direction": "x", "start": 1.0, **record(tmp_path)}
    early, half, end = shares(table, [6.0, 10.5, 11.0], folder=tmp_path)
    assert early < 1e-3 and half == pytest.approx(0.5, abs=0.02) and end == 1.0
    shock = {"components": [{"direction": "x", **record(tmp_path)}]}
    row = {"kind": "sequence", "rest": 5.0, "shocks": [shock, shock]}
    assert shares(row, [8.0, 10.0, 15.0, 25.0], folder=tmp_path) == pytest.approx([0.0, 0.5, 0.5, 1.0], abs=1e-3)


def test_a_vehicle_goes_by_its_way_over_the_deck() -> None:
    made, assembly = bridge(width=3.0)
    fill, kind = made.fills[0], VEHICLE["vehicle"]
    long = fill.deck[1] - fill.deck[0]

    def at(time: float, **keys: object) -> float:
        table = parse_table(kind.table, {"kind": "vehicle", "axles": [1e4, 1e4], "spacing": [2.0], **keys}, "loads[0]")
        acted = kind.part(table, grid(made, assembly), "loads[0]").acted
        assert acted is not None
        return float(acted.row(time)["share"])

    assert at(0.5 * (long + 2.0), speed=1.0) == pytest.approx(0.5)
    assert at(0.5 * long, speed=1.0, position=fill.deck[0] + 0.5 * long) == pytest.approx(0.5 * long / (0.5 * long + 2.0))
    assert at(1.0, position=fill.deck[0] + 1.0, ramp=4.0) == pytest.approx(0.25)


SINE_LOADS = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.2, "frequency": 2.0, "cycles": 4}


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
    along = build(SINE_LOADS).support_velocity[:, 0]
    assert not along[:, 1:].any()
    against = build({**SINE_LOADS, "direction": "-x"}).support_velocity[:, 0]
    assert (along == -against).all()
    both = build(SINE_LOADS, {**SINE_LOADS, "direction": [0.0, 3.0, 4.0]}).support_velocity[:, 0]
    assert both[:, 0] == pytest.approx(along[:, 0])
    assert both[:, 1] == pytest.approx(0.6 * along[:, 0])
    assert both[:, 2] == pytest.approx(0.8 * along[:, 0])
