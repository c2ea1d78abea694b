# SPDX-License-Identifier: GPL-3.0-or-later
"""Every kind of load, ours by its starter: it is built, acts, rests and is multiplied as it says; tables add up, and shares act in time."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bridge_scenes import bridge, grid
from models import box, ground

import loads
import structures
from loads.kinds.vehicle import KINDS as VEHICLE
from loads.motion import LoadKind, RunGrid
from loads.static import static_tables
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.mechanics.model.blocks import Assembly

DT, STEPS = 2e-3, 5000
ARCH = Assembly.from_blocks(
    structures.build({"kind": "arch", "span": 4.0, "thickness": 0.4, "width": 1.0, "voussoirs": 27}, 2200.0, Path()), 0.6
)


@pytest.fixture(params=sorted(loads.KINDS))
def first(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[LoadKind, dict[str, Any], RunGrid]:
    """A kind, a first load of it, and a run of 10 s."""
    rows = "".join(f"{0.01 * k:g},{np.sin(np.pi * k / 200) ** 2 * np.sin(0.7 * k):.6g}\n" for k in range(201))
    (tmp_path / "quake.csv").write_text(f"time_s,acc\n{rows}")
    kind = loads.KINDS[request.param]
    of_run = RunGrid(DT, STEPS, np.array([0.0, 0.0, -9.81]), tmp_path, ARCH)
    if request.param == "vehicle":
        of_run = replace(grid(*bridge(width=3.0), steps=STEPS, dt=DT), folder=tmp_path)
    return kind, {"kind": request.param, **kind.starter}, of_run


def test_a_run_takes_it_and_ends_with_it(first: tuple[LoadKind, dict[str, Any], RunGrid]) -> None:
    kind, keys, run = first
    table = loads.parse_load(keys, "loads[0]")
    part = kind.part(table, run, "loads[0]")
    assert part.summary["kind"] == keys["kind"] and json.loads(json.dumps(part.summary))
    assert all("loads[0]" in line or "shock" in line for line in (*part.lines, *part.warnings))
    if part.motion is not None:
        velocity = part.motion(run.times)
        assert velocity.shape == (STEPS + 1, 3) and not velocity[[0, -1]].any() and velocity.any()
    if part.acceleration is not None:
        assert part.acceleration.shape == (STEPS + 1, 3)
    assert kind.end is None or 0.0 <= kind.end(table, run, "loads[0]") <= run.end
    if part.acted is not None:
        shares = [part.acted.row(time)["share"] for time in np.linspace(0.0, run.end, 50)]
        assert (np.diff(shares) >= 0.0).all() and shares[-1] == 1.0 and part.acted.end <= run.end


def test_limit_analysis_takes_it_as_the_pattern_that_it_names(first: tuple[LoadKind, dict[str, Any], RunGrid]) -> None:
    kind, keys, run = first
    (found,) = static_tables([keys], run)
    assert found.left_out == (kind.static is None)
    given = {"push": found.does.direction, "tilt": found.does.direction, "settlement": found.does.velocity, "live": found.does.points}
    assert not found.pattern or (given[found.pattern] is not None and len(found.does.words) > 8)
    assert all(np.isfinite(force.force).all() and not run.blocks("").fixed[force.block] for force in found.does.points)


def test_one_that_may_grow_grows_by_the_factor(first: tuple[LoadKind, dict[str, Any], RunGrid]) -> None:
    kind, keys, run = first
    if kind.grown is None:
        return
    motions = [kind.part(loads.parse_load(one, "loads[0]"), run, "loads[0]").motion for one in (keys, kind.grown(keys, 2.0))]
    once, twice = (motion(run.times) for motion in motions if motion is not None)
    assert twice == pytest.approx(2.0 * once, abs=1e-12)


def test_motions_from_files_have_the_numbers_of_their_components(first: tuple[LoadKind, dict[str, Any], RunGrid]) -> None:
    kind, keys, run = first
    if kind.recorded is None:
        return
    made = kind.part(loads.parse_load(keys, "loads[0]"), run, "loads[0]").summary
    (motion,) = kind.recorded(keys, made, "loads[0]")
    assert motion.end - motion.begin == pytest.approx(2.0, abs=DT)
    assert [made["after"]["pga"] > 0.0 for _, _, made in motion.components] == [True]


def test_an_unknown_key_has_those_that_exist_next_to_it(first: tuple[LoadKind, dict[str, Any], RunGrid]) -> None:
    with pytest.raises(InputError) as refused:
        loads.parse_load({"kind": first[1]["kind"], "zzqq": 1}, "loads[0]")
    assert refused.value.place == "loads[0].zzqq" and all(key in refused.value.faults[0].text for key in first[0].table.model_fields)


G = (0.0, 0.0, -9.81)
STONE = Assembly.from_blocks([ground(2.0), box("stone", (-0.5, -0.5, 0.0), (0.5, 0.5, 1.0))], 0.6)
SINE = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.1, "frequency": 2.0, "cycles": 4}
PULSE = {"kind": "pulse", "direction": "x", "acceleration": 1.0, "duration": 2.0}
POINT = {"kind": "point", "block": "stone", "force": [1, 0, 0]}


def shares(table: dict[str, Any], times: list[float], assembly: Assembly | None = STONE, folder: Path = Path(".")) -> list[float]:
    """Return the share of the only table whose share is known, at some times."""
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
