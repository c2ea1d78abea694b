# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/code_check: every value of a check against formulas written out here, for a wall of 0.5 x 4 m and other oscillators."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from loads.signal.response import response_spectrum
from loads.signal.spectra.ec8 import ec8
from loads.signal.spectra.ntc import ntc
from masonry_cd.analysis.code_check.check import check_at, with_borne
from masonry_cd.analysis.code_check.ground import ground_of
from masonry_cd.analysis.code_check.level import HeldLevel
from masonry_cd.analysis.code_check.steps import CodeCheck
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import NO_SEARCH
from masonry_cd.analysis.limit.oscillator import Oscillator
from masonry_cd.foundation.errors import InputError, parse_table

G = 9.81
ALPHA, REACH = 0.125, 0.5 * 4.0 * 0.125 / (1.0 + 0.125**2)  # of the wall: factor, d0* of its centre
PARAMETERS = {"ag": 2.0, "f0": 2.5, "tc_star": 0.3, "ground": "B"}  # of NTC: SS = 1.196
BUILDING = {"height": 6.0, "building_height": 10.0, "building_period": 0.3, "storeys": 3}


def wall() -> Oscillator:
    """The oscillator of the free-standing wall: every point of it moves by its height; the control point is its top."""
    weight = 2000.0 * G * 0.5 * 4.0 * 2.0
    return Oscillator(ALPHA, G, weight, 0.5 * weight, 0.25 * weight, np.array([0.0, 2.0 * REACH]), np.array([ALPHA, 0.0]))


def code_check(table: CheckTable, oscillator: Oscillator, folder: Path, doubt: str = NO_SEARCH) -> CodeCheck:
    """The check of a mechanism at the height of its table, with what it just bears."""
    ground, level = ground_of(table, folder), HeldLevel(0.0, table.height, "limit.check.height", table.height)
    return with_borne(check_at(table, level, oscillator, ground, doubt), table, level, oscillator, ground)


def checked(oscillator: Oscillator | None = None, folder=None, **keys):
    """The check, and its values by symbol."""
    made = code_check(parse_table(CheckTable, keys, "limit.check"), oscillator or wall(), folder, "")
    return made, {step.symbol: step.value for step in made.steps}


def test_the_wall_on_the_ground_by_ntc_2018():
    made, value = checked(spectrum="NTC", **PARAMETERS)
    share = 2.0 / G  # one g in all formulas, that of the scene
    soil = 1.4 - 0.4 * 2.5 * share
    tc, td = 1.1 * 0.3**-0.2 * 0.3, 4.0 * share + 1.6
    assert value["alpha0"] == ALPHA
    assert value["M*"] == pytest.approx(8000.0)
    assert value["e*"] == pytest.approx(1.0)
    assert value["CF"] == 1.35
    assert value["a0*"] == pytest.approx(ALPHA * G / 1.35)
    assert value["d0*"] == pytest.approx(REACH)
    assert value["ag S"] == pytest.approx(2.0 * soil)
    assert value["a asked"] == pytest.approx(soil)
    assert value["dSLV"] == pytest.approx(0.4 * REACH)
    assert value["a(dSLV)"] == pytest.approx(0.6 * ALPHA * G / 1.35)
    period = 1.68 * math.pi * math.sqrt(0.4 * REACH / (0.6 * ALPHA * G / 1.35))
    assert value["TSLV"] == pytest.approx(period)
    assert tc < period < td
    eta = math.sqrt(10.0 / 13.0)
    asked = 2.0 * soil * eta * 2.5 * tc / period * (period / (2.0 * math.pi)) ** 2
    assert value["d asked"] == pytest.approx(asked)
    linear, displaced = made.verdicts
    assert (linear.capacity, linear.demand) == (value["a0*"], value["a asked"])
    assert (displaced.capacity, displaced.demand) == (value["dSLV"], value["d asked"])
    assert not linear.passed and not displaced.passed
    assert "NOT satisfied" in linear.words and "C8.7.1.2.1.7" in linear.words


def test_without_an_end_of_the_curve_there_is_no_check_by_displacements():
    endless = Oscillator(ALPHA, G, 1.0, 1.0, 1.0, np.zeros(0), np.zeros(0), "the curve ends: blocks meet")
    for code in ("NTC2018", "NTC2008"):
        made, value = checked(endless, code=code, spectrum="EC8", ag=2.0)
        assert [one.check for one in made.verdicts] == ["linear"]
        assert "d0*" not in value
        assert made.notes[0] == "no non-linear check: the curve ends: blocks meet"
        assert checked(endless, code=code, spectrum="EC8", ag=2.0, displacements=False)[0].notes == ()


def test_collapse_and_damage_by_ntc_2018():
    made, value = checked(spectrum="EC8", ag=2.0, limit_state="SLC", confidence_factor=1.0)
    assert value["dSLC"] == pytest.approx(0.6 * REACH)
    assert value["TSLC"] == pytest.approx(1.56 * math.pi * math.sqrt(0.6 * REACH / (0.4 * ALPHA * G)))
    assert value["xi"] == 0.10
    assert [one.check for one in made.verdicts] == ["non-linear"]
    made, value = checked(spectrum="EC8", ag=0.5, limit_state="SLD")
    assert [(one.check, one.demand) for one in made.verdicts] == [("linear", pytest.approx(0.5))]
    assert made.verdicts[0].passed and "q" not in value


def test_what_does_not_start_is_satisfied_by_displacements_too():
    slow = Oscillator(0.01, G, 1.0, 1.0, 1.0, np.array([0.0, 1e-3]), np.array([0.01, 0.0]))
    for size, starts in ((0.07, False), (0.08, True)):  # a0* is 0.0727
        made, _ = checked(slow, spectrum="EC8", ag=size)
        displaced = made.verdicts[1]
        assert displaced.demand > displaced.capacity
        assert displaced.passed is not starts
        assert ("does not start" in displaced.words) is not starts


def test_the_wall_at_a_height_by_ntc_2018():
    made, value = checked(spectrum="EC8", ag=1.5, **BUILDING)
    floor = 1.5 * 2.5 * (9.0 / 7.0) * 0.6 * math.sqrt(1.0 + 0.0004 * 25.0)
    assert value["gamma1"] == pytest.approx(9.0 / 7.0)
    assert value["psi1(z)"] == pytest.approx(0.6)
    assert value["aZ"] == pytest.approx(floor)
    assert value["a asked"] == pytest.approx(0.5 * floor)
    period, eta = value["TSLV"], math.sqrt(10.0 / 13.0)
    most = 1.1 * 0.05**-0.5 * eta
    flank = most * floor / (1.0 + (most - 1.0) * (period / 0.33 - 1.0) ** 1.2)
    here = max(flank, 1.5 * eta * 2.5 * 0.4 * 2.0 / period**2) * (period / (2.0 * math.pi)) ** 2
    assert value["d asked"] == pytest.approx(max(here, most * floor * (0.33 / (2.0 * math.pi)) ** 2))
    assert made.verdicts[1].clause == "C8.7.1.2.1.8"


@pytest.mark.parametrize(("own", "away"), [(0.06, (1.0 - 0.06 / 0.24) ** 1.6), (0.3, 0.0), (0.5, (0.5 / 0.33 - 1.0) ** 1.2)])
def test_a_part_that_is_free_to_vibrate_sees_the_spectrum_of_the_floor(own, away):
    _, value = checked(spectrum="EC8", ag=1.5, element_period=own, **BUILDING)
    most, floor = 1.1 * 0.05**-0.5, value["aZ"]
    assert value["SeZ(T0)"] == pytest.approx(most * floor / (1.0 + (most - 1.0) * away))


def test_the_wall_by_the_circolare_of_2009():
    _, value = checked(code="NTC2008", spectrum="EC8", ag=1.5, **BUILDING)
    raised = 1.5 * 2.5 * 0.6 * 9.0 / 7.0
    assert value["Se psi gamma"] == pytest.approx(raised)
    assert value["a asked"] == pytest.approx(0.5 * raised)
    assert value["du*"] == pytest.approx(0.4 * REACH)
    assert value["ds*"] == pytest.approx(0.16 * REACH)
    assert value["as*"] == pytest.approx(0.84 * ALPHA * G / 1.35)
    period = 2.0 * math.pi * math.sqrt(0.16 * REACH / (0.84 * ALPHA * G / 1.35))
    assert value["Ts"] == pytest.approx(period)
    assert value["SDe(Ts)"] == pytest.approx(1.5 * 2.5 * 0.4 / period * (period / (2.0 * math.pi)) ** 2)
    ratio = period / 0.3
    first = 1.5 * 2.5 * (0.3 / (2.0 * math.pi)) ** 2
    assert value["d raised"] == pytest.approx(first * 0.6 * 9.0 / 7.0 * ratio**2 / math.sqrt((1.0 - ratio) ** 2 + 0.02 * ratio))


def test_the_wall_by_eurocode_8():
    made, value = checked(code="EC8", spectrum="EC8", ag=1.5, ground="B")
    assert value["a asked"] == pytest.approx(0.5 * 1.8)
    assert [one.check for one in made.verdicts] == ["linear"]
    _, value = checked(code="EC8", spectrum="EC8", ag=1.5, height=6.0, building_height=10.0, building_period=0.3, element_period=0.06)
    assert value["Sa g"] == pytest.approx(1.5 * (3.0 * 1.6 / (1.0 + 0.8**2) - 0.5))


def test_a_record_gives_the_largest_displacement_up_to_the_period(tmp_path):
    step = 0.01
    times = step * np.arange(800)
    samples = 1.5 * np.sin(2.0 * math.pi * times / 0.8) * np.sin(math.pi * times / 7.99) ** 2
    (tmp_path / "shake.csv").write_text("time,a\n" + "\n".join(f"{t:.2f},{a:.8f}" for t, a in zip(times, samples, strict=True)))
    record = {"path": "shake.csv", "units": "m/s2", "correction": "none", "scale": 2.0}
    made, value = checked(folder=tmp_path, record=record)
    assert value["ag S"] == pytest.approx(2.0 * np.abs(samples).max(), rel=1e-6)
    period = value["TSLV"]
    periods = np.linspace(0.02, period, 400)
    longer = np.append(2.0 * samples, np.zeros(int(period / step) + 2))
    most = response_spectrum(longer, step, periods, 0.08).displacement
    assert value["d asked"] == pytest.approx(most.max(), rel=5e-3)
    assert most[-1] < 0.9 * most.max()  # resonance with the record asks for more than the period itself
    assert "shake.csv" in made.ground


@pytest.mark.parametrize(("spectrum", "corners", "plateau"), [(ec8(2.0, "B"), (0.5, 2.0), 2.5), (ntc(2.0, 2.4, 0.35, "A"), None, 2.4)])
def test_displacements_of_long_periods_come_down_to_that_of_the_ground(spectrum, corners, plateau):
    tc, td = spectrum.corners[1:]
    assert corners is None or corners == (tc, td)
    begin, end = spectrum.long
    found = spectrum.displacement(np.array([3.0, begin, 0.5 * (begin + end), end, 20.0]))
    ground = 0.025 * spectrum.size * tc * td
    assert found[0] == pytest.approx(float(spectrum.at(np.array([3.0]))[0]) * (3.0 / (2.0 * math.pi)) ** 2)
    assert found[1] == pytest.approx(plateau * ground, rel=0.014)  # 1 / (4 pi^2) is rounded to 0.025
    assert found[2:] == pytest.approx([0.5 * (1.0 + plateau) * ground, ground, ground])


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({}, "spectrum: missing"),
        ({"spectrum": "EC8"}, "ag: missing"),
        ({"spectrum": "NTC", "ag": 2.0}, "f0: missing"),
        ({"spectrum": "EC8", "ag": 2.0, "f0": 2.5}, "f0: does not apply"),
        ({"ag": 2.0, "record": {"path": "a.csv"}}, "ag: does not apply with a record"),
        ({"spectrum": "EC8", "ag": 2.0, "storeys": 3}, "storeys: needs building_height"),
        ({"spectrum": "EC8", "ag": 2.0, "height": 3.0}, "building_height: missing"),
        ({"spectrum": "EC8", "ag": 2.0, "foundation": -3.0}, "building_height: missing"),
        ({"spectrum": "EC8", "ag": 2.0, **BUILDING, "foundation": -3.0}, "height: does not apply with foundation"),
        ({"spectrum": "EC8", "ag": 2.0, **BUILDING, "height": 12.0}, "above the building"),
        ({"spectrum": "EC8", "ag": 2.0, **BUILDING, "participation": 1.2}, "one of the two"),
        ({"spectrum": "EC8", "ag": 2.0, "code": "EC8", "limit_state": "SLV"}, "does not apply to EC8"),
        ({"spectrum": "EC8", "ag": 2.0, "code": "EC8", "element_period": 0.1}, "EC8 on the ground"),
        ({"spectrum": "EC8", "ag": 2.0, "code": "NTC2008", "limit_state": "SLC"}, "SLC does not apply"),
        ({"spectrum": "EC8", "ag": 2.0, "confidence_factor": 0.9}, "confidence_factor"),
        ({"spectrum": "EC8", "ag": 2.0, "cf": 1.2}, "unknown key"),
    ],
)
def test_keys_that_do_not_fit_are_refused_in_one_line(keys, message):
    with pytest.raises(InputError, match=message):
        checked(**keys)


def test_a_record_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match=r"limit\.check\.record\.path: no\.csv"):
        checked(folder=tmp_path, record={"path": "no.csv"})
