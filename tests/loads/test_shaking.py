# SPDX-License-Identifier: GPL-3.0-or-later
"""Sines, pulses, sequences of shocks and accelerograms of a code: the motion required, its impulse, its rests, its spectrum."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import refused_at
from models import box

import loads
from loads.kinds import artificial
from loads.kinds.artificial import ArtificialTable, drawn, envelope
from loads.signal.response import response_spectrum
from loads.signal.spectra.ec8 import ec8
from loads.signal.spectra.ntc import ntc
from masonry_cd.mechanics.model.blocks import Assembly

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


GRAVITY = (0.0, 0.0, -9.81)
SHAKES = "begins while the ground shakes"  # said of a record that is cut, and not of a pulse
PULSE: dict[str, Any] = {"kind": "pulse", "direction": "x", "acceleration": 1.5, "duration": 0.25, "start": 0.1}


@pytest.mark.parametrize(("shape", "impulse"), [("half-sine", 2.0 / np.pi), ("rectangle", 1.0), ("sine", 0.0), ("cosine", 0.0)])
@pytest.mark.parametrize("dt", [5e-3, 7e-3])  # of which the pulse is not a multiple
def test_a_pulse_puts_in_its_impulse_and_ends(shape: str, impulse: float, dt: float) -> None:
    found = loads.build([PULSE | {"shape": shape}], dt, 100, GRAVITY, Path())
    x = found.acceleration[:, 0]
    assert dt * x.sum() == pytest.approx(1.5 * 0.25 * impulse, abs=1e-12)
    assert not x[dt * np.arange(101) > 0.35 + dt].any()
    assert (found.acceleration[:, 2] == -9.81).all()


def test_a_cosine_pulse_brings_the_ground_back_and_half_of_its_size_has_passed_at_its_middle() -> None:
    found = loads.build([PULSE | {"shape": "cosine", "start": 0.0, "direction": 30.0}], 1e-3, 260, GRAVITY, Path())
    along = found.acceleration[:, 0] / np.cos(np.radians(30.0))
    assert found.acceleration[:, 1] == pytest.approx(along * np.sin(np.radians(30.0)))
    velocity = 1e-3 * np.cumsum(along)
    assert np.abs(velocity).max() == pytest.approx(1.5 * 0.25 / (2.0 * np.pi), rel=1e-3)
    assert np.sum(velocity[:251]) == pytest.approx(0.0, abs=1e-9)
    (acted,) = found.acted
    assert [acted.row(0.25 * x)["share"] for x in (0.25, 0.5, 0.75, 1.0)] == pytest.approx([0.25, 0.5, 0.75, 1.0])


@pytest.mark.parametrize("values", [np.sin(np.pi * np.linspace(0.0, 1.0, 30)), np.r_[np.ones(30), np.zeros(5)]])
def test_a_pulse_in_a_file_does_not_begin_while_the_ground_shakes(values: np.ndarray, tmp_path: Path) -> None:
    table = "time,acceleration\n" + "\n".join(f"{0.01 * k:g},{value:.6g}" for k, value in enumerate(values))
    (tmp_path / "pulse.csv").write_text(table + "\n")
    record = {"kind": "record", "path": "pulse.csv", "direction": "x", "units": "m/s2", "correction": "none"}
    found = loads.build([record], 1e-3, 100, GRAVITY, tmp_path)
    assert not any(SHAKES in line for line in found.warnings)


def test_a_record_that_is_cut_is_still_warned_of_in_plain_numbers(tmp_path: Path) -> None:
    values = np.sin(np.linspace(0.5, 60.0, 600)) * np.r_[np.ones(500), np.linspace(1.0, 0.0, 100)]
    table = "time,acceleration\n" + "\n".join(f"{0.01 * k:g},{value:.6g}" for k, value in enumerate(values))
    (tmp_path / "cut.csv").write_text(table + "\n")
    record = {"kind": "record", "path": "cut.csv", "direction": "x", "units": "m/s2", "correction": "none"}
    found = loads.build([record], 1e-3, 100, GRAVITY, tmp_path)
    (line,) = [line for line in found.warnings if SHAKES in line]
    assert "e+" not in line


def test_a_run_without_a_duration_lasts_as_long_as_its_loads() -> None:
    ground = box("ground", (-2.0, -2.0, -0.5), (3.0, 3.0, 0.0), fixed=True)
    assembly = Assembly.from_blocks([ground, box("b", (0.0, 0.0, 0.0), (0.5, 1.0, 2.0))], 0.5)

    def end(*tables: dict[str, Any]) -> tuple[float, float]:
        return loads.end_of(tables, 1e-3, GRAVITY, Path(), assembly)

    sine = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.1, "frequency": 2.0, "cycles": 3, "start": 0.5}
    assert end(sine, PULSE) == pytest.approx((2.0, 1.0))
    push = {"kind": "push", "control": "displacement", "direction": "x", "blocks": "b", "targets": [0.01, 0.0], "speed": 0.01, "hold": 0.2}
    assert end(push) == pytest.approx((2 * 1.875 + 0.4, 0.0))
    assert end({"kind": "tilt", "direction": "x", "rate": 2.0, "angle": 10.0}) == pytest.approx((5.0, 1.0))
    with refused_at("run.duration"):
        end({"kind": "push", "direction": "x", "rate": 0.1})
    with refused_at("run.duration"):
        end()


G = (0.0, 0.0, -9.81)
DT_SHOCKS = 5e-3
DRAWN = {"direction": "y", "spectrum": "EC8", "ag": 1.0, "duration": 8.0, "level": 4.0, "tolerance": 0.3, "seed": 3}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A record of 2 s: two periods of a sine of 1 Hz and 2 m/s2."""
    path = tmp_path_factory.mktemp("records")
    times = 0.01 * np.arange(201)
    rows = (f"{t:.2f},{2.0 * np.sin(2 * np.pi * t):.8f}" for t in times)
    (path / "sine.csv").write_text("\n".join(["time_s,a_m_s2", *rows]) + "\n")
    return path


SINE = {"direction": "x", "path": "sine.csv"}


def build_shocks(folder: Path, *shocks: dict, seconds: float = 60.0, **keys: object) -> loads.Loading:
    table = {"kind": "sequence", "shocks": list(shocks), **keys}
    return loads.build([table], DT_SHOCKS, round(seconds / DT_SHOCKS), G, folder)


def test_shocks_follow_one_another_after_their_rests(folder: Path) -> None:
    one = {"components": [SINE]}
    loading = build_shocks(folder, one, {"name": "main", "components": [SINE], "scale": 2.0}, rest=3.0, start=1.0)
    assert [(s.name, s.first, s.last) for s in loading.shocks] == [("shock 1", 200, 600), ("main", 1200, 1600)]
    assert loading.pauses == ()  # rests of a given length are not ended early
    v = loading.support_velocity[:, 0, 0]
    assert v[1200:1601] == pytest.approx(2.0 * v[200:601])
    assert not v[:200].any() and not v[600:1200].any() and not v[1600:].any()
    still = build_shocks(folder, one, one, longest_rest=4.0, hold=0.1, still=2e-3)
    assert [(p.first, p.last, p.speed, p.hold) for p in still.pauses] == [(400, 1200, 2e-3, 20), (1600, 2400, 2e-3, 20)]
    assert any(
        "the run ends at 5 s: run.duration = 12 would hold all" in line
        for line in build_shocks(folder, one, one, longest_rest=4.0, seconds=5.0).lines
    )


def test_a_pause_in_which_another_load_acts_is_not_ended_early(folder: Path) -> None:
    pushed = {"kind": "push", "direction": "x", "rate": 0.01, "start": 7.0}
    shocks = {"kind": "sequence", "shocks": [{"components": [SINE]}] * 2, "longest_rest": 4.0}
    loading = loads.build([shocks, pushed], DT_SHOCKS, round(12.0 / DT_SHOCKS), G, folder)
    assert [pause.after for pause in loading.pauses] == ["shock 1"]
    assert any('rest after "shock 2": not ended early' in line for line in loading.lines)


def test_components_share_one_factor_and_may_be_artificial(folder: Path) -> None:
    loading = build_shocks(folder, {"components": [SINE, {**DRAWN, "direction": "x"}], "target_pga": 3.0}, rest=0.0)
    again = build_shocks(folder, {"components": [SINE, {**DRAWN, "direction": "x"}], "target_pga": 3.0}, rest=0.0)
    assert (loading.support_velocity == again.support_velocity).all()
    (shock,) = loading.summary["tables"][0]["shocks"]
    peaks = [component["after"]["pga"] for component in shock["components"]]
    assert max(peaks) == pytest.approx(3.0)
    alone = loads.build([{"kind": "artificial", **DRAWN}], DT_SHOCKS, round(8.0 / DT_SHOCKS), G, folder)
    own = build_shocks(folder, {"components": [DRAWN]}, rest=0.0)
    assert own.support_velocity[: round(7.5 / DT_SHOCKS)] == pytest.approx(alone.support_velocity[: round(7.5 / DT_SHOCKS)])
    assert any("artificial, EC8 spectrum, ground A, seed 3 along y" in line for line in own.lines)


EC8 = {"kind": "artificial", "direction": "x", "spectrum": "EC8", "ag": 2.0, "ground": "B"}
NTC = {"kind": "artificial", "direction": "y", "spectrum": "NTC", "ag": 2.5, "f0": 2.4, "tc_star": 0.35, "ground": "C"}


def build_artificial(**keys: object) -> loads.Loading:
    return loads.build([{**EC8, **keys}], 5e-3, 5200, G, Path("."))


def test_ec8_spectra_by_hand() -> None:
    level = ec8(2.0, "B", 1)
    wanted = [2.4, 2.4 * (1 + 0.5 * 1.5), 6.0, 6.0, 6.0, 3.0, 1.5, 6.0 * 0.5 * 2.0 / 16.0]
    assert level.at(np.array([0.0, 0.075, 0.15, 0.3, 0.5, 1.0, 2.0, 4.0])) == pytest.approx(wanted)
    assert level.at(np.array([0.3]), damping=0.2) == pytest.approx(2.4 * 2.5 * np.sqrt(10 / 25))
    assert level.at(np.array([0.3]), damping=0.9) == pytest.approx(2.4 * 2.5 * 0.55)
    assert ec8(1.0, "D", 2).at(np.array([0.2, 1.2])) == pytest.approx([4.5, 4.5 * 0.3 / 1.2])
    assert ec8(2.0, "B", 1, vertical=True).at(np.array([0.0, 0.1, 0.3])) == pytest.approx([1.8, 5.4, 2.7])


def test_ntc_spectra_by_hand() -> None:
    share = 2.5 / 9.80665
    soil, tc = 1.7 - 0.6 * 2.4 * share, 1.05 * 0.35**0.67
    level = ntc(2.5, 2.4, 0.35, "C", "T2")
    assert level.at(np.array([0.0, tc / 3, tc, 2 * tc])) == pytest.approx(2.5 * soil * 1.2 * np.array([1.0, 2.4, 2.4, 1.2]))
    td = 4 * share + 1.6
    assert level.at(np.array([2 * td])) == pytest.approx(2.5 * soil * 1.2 * 2.4 * tc * td / (2 * td) ** 2)
    assert ntc(5.0, 2.6, 0.3, "D").size == pytest.approx(0.9 * 5.0)  # the amplification is held at its lower limit
    assert ntc(0.3, 2.5, 0.3, "D").size == pytest.approx(1.8 * 0.3)  # and at its upper one
    fv = 1.35 * 2.4 * np.sqrt(share)
    assert ntc(2.5, 2.4, 0.35, "C", vertical=True).at(np.array([0.0, 0.1])) == pytest.approx([2.5 * fv / 2.4, 2.5 * fv])


@pytest.mark.parametrize(
    "keys",
    [{**EC8, "period": 0.5}, {**EC8, "seed": 7}, {**EC8, "type": 2, "ground": "D", "seed": 1}, {**NTC, "period": 0.2}, {**NTC, "seed": 3}],
)
def test_the_spectrum_stays_within_ten_per_cent_of_the_target(keys: dict) -> None:
    table = ArtificialTable(**keys)
    motion = drawn(table, "loads[0]")
    low, high = table.range
    periods = np.geomspace(low, high, 487)  # not those at which it was brought to the target
    ratio = response_spectrum(motion.acceleration, motion.step, periods).acceleration / table.target.at(periods)
    assert ratio.min() >= 0.9
    assert ratio.max() <= 1.1
    assert ratio.mean() == pytest.approx(1.0, abs=0.03)


def test_the_motion_starts_and_ends_at_rest_and_is_strong_where_the_envelope_is_level() -> None:
    motion = drawn(ArtificialTable(**EC8), "loads[0]")
    numbers = motion.numbers()
    assert abs(numbers["end_velocity"]) < 1e-12
    assert abs(numbers["end_displacement"]) < 1e-12
    assert abs(motion.acceleration[[0, -1]]).max() < 0.02 * numbers["pga"]
    power = np.add.reduceat(motion.acceleration[:-1] ** 2, np.arange(0, 5000, 1000))  # five parts of 5 s
    assert power[1] > 2.0 * power[3]
    assert power[1] > 10.0 * power[4]
    e = envelope(np.array([0.0, 1.0, 2.0, 7.0, 12.0, 18.5, 25.0]), 2.0, 10.0, 25.0)
    assert e == pytest.approx([0.0, 0.25, 1.0, 1.0, 1.0, np.exp(-1.5), 0.0])


def test_equal_seeds_give_equal_bits_and_others_another_motion() -> None:
    first, again, other = (build_artificial(seed=seed) for seed in (4, 4, 5))
    assert (first.support_velocity == again.support_velocity).all()
    v, w = first.support_velocity[:, 0, 0], other.support_velocity[:, 0, 0]
    assert abs(np.corrcoef(v, w)[0, 1]) < 0.5
    assert first.summary["tables"][0]["ratio"] == pytest.approx([1.0, 1.0], abs=0.1)
    assert any("spectrum over target" in line for line in first.lines)
    assert not first.support_velocity[-1].any()


def test_a_spectrum_that_no_draw_meets_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A second of strong motion is too short for 3 %; two draws show that the best of all is reported."""
    monkeypatch.setattr(artificial, "DRAWS", 2)
    with refused_at("loads[0]"):
        build_artificial(tolerance=0.03, level=0.5, rise=0.1, duration=2.0)
