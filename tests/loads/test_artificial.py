# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.kinds.artificial and loads.signal.code_spectrum: the codes' numbers, and accelerograms that meet them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at

import loads
from loads.kinds import artificial
from loads.kinds.artificial import ArtificialTable, drawn, envelope
from loads.signal.code_spectrum import ec8, ntc
from loads.signal.response import response_spectrum

G = (0.0, 0.0, -9.81)
EC8 = {"kind": "artificial", "direction": "x", "spectrum": "EC8", "ag": 2.0, "ground": "B"}
NTC = {"kind": "artificial", "direction": "y", "spectrum": "NTC", "ag": 2.5, "f0": 2.4, "tc_star": 0.35, "ground": "C"}


def build(**keys: object) -> loads.Loading:
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
    first, again, other = (build(seed=seed) for seed in (4, 4, 5))
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
        build(tolerance=0.03, level=0.5, rise=0.1, duration=2.0)
