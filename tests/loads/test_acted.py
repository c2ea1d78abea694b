# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of a load has acted by a time, by the measure of its kind."""

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


def test_a_run_that_leaves_out_a_part_says_how_long_it_would_have_to_be() -> None:
    short, whole = (loads.build([SINE], 0.01, steps, G, Path("."), STONE).lines for steps in (100, 200))
    assert any("run.duration = 2" in line and "50 %" in line for line in short) and not any("run.duration" in line for line in whole)
