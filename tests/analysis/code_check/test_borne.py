# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/code_check/borne.py: the ag that is just borne against closed forms, and where there is none or no end."""

from __future__ import annotations

import numpy as np
import pytest
from test_code_check import ALPHA, BUILDING, PARAMETERS, G, checked, wall

from masonry_cd.analysis.code_check.borne import just_borne
from masonry_cd.analysis.limit.oscillator import Oscillator

STARTS = ALPHA * G / 1.35  # a0* [m/s2]


def test_on_the_ground_of_eurocode_8_it_is_q_a0_over_s() -> None:
    made, value = checked(code="EC8", spectrum="EC8", ag=1.5, ground="B")
    (one,) = made.borne
    assert one.borne == pytest.approx(2.0 * STARTS / 1.2, rel=1e-9)
    assert (one.asked, one.share) == (1.5, pytest.approx(made.verdicts[0].ratio, rel=1e-9))
    assert (value["PGA_C"], value["PGA_D"], value["zeta_E"]) == (one.borne, one.asked, one.share)


@pytest.mark.parametrize("more", [{}, BUILDING, BUILDING | {"element_period": 0.3}, {"code": "NTC2008"} | BUILDING])
def test_under_a_spectrum_in_proportion_to_ag_both_checks_have_their_own_ratio(more: dict) -> None:
    made, _ = checked(spectrum="EC8", ag=1.5, **more)
    assert [one.check for one in made.borne] == ["linear", "non-linear"]
    for one, verdict in zip(made.borne, made.verdicts, strict=True):
        assert one.share == pytest.approx(verdict.met, rel=1e-9)


def test_the_soil_factor_of_ntc_follows_ag() -> None:
    """On ground B ag (1.4 - 0.4 F0 ag/g) = q a0*, a quadratic; at that ag the check is just met."""
    asked = {"spectrum": "NTC", "confidence_factor": 1.0} | PARAMETERS
    made, _ = checked(**asked)
    slope = 0.4 * 2.5 / G
    by_hand = (1.4 - np.sqrt(1.4**2 - 4.0 * slope * 2.0 * ALPHA * G)) / (2.0 * slope)
    linear, displaced = made.borne
    assert 1.2 > 1.4 - slope * by_hand > 1.0  # between the limits of SS
    assert linear.borne == pytest.approx(by_hand, rel=1e-9) and linear.share != pytest.approx(made.verdicts[0].ratio, rel=1e-3)
    again, _ = checked(**asked | {"ag": displaced.borne})
    assert again.verdicts[1].met == pytest.approx(1.0, rel=1e-9) and again.borne[1].share == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("ratio", [0.2, 0.95, 1.01, 3.0])
def test_where_the_demand_falls_for_a_while_it_goes_with_the_verdict(ratio: float) -> None:
    """Ground D: ag SS = ag (2.4 - 1.5 F0 ag/g) falls between F0 ag/g of 0.8 and 1."""
    asked = {"spectrum": "NTC", "ag": 0.95 * G / 2.5, "f0": 2.5, "tc_star": 0.3, "ground": "D", "displacements": False}
    peak = checked(**asked)[1]["ag S"]
    made, _ = checked(Oscillator(ratio * peak / 2.0 * 1.35 / G, G, 1.0, 1.0, 1.0, np.zeros(0), np.zeros(0)), **asked)
    (one,) = made.borne
    assert one.share is not None and (one.share >= 1.0) is (ratio >= 1.0)
    assert checked(spectrum="NTC", **PARAMETERS | {"ground": "D", "f0": 2.5, "ag": one.borne})[1]["ag S"] == pytest.approx(ratio * peak)


@pytest.mark.parametrize("more", [{}, BUILDING])
def test_a_record_grows_as_a_whole(more: dict, tmp_path) -> None:
    times = 0.01 * np.arange(400)
    samples = 1.5 * np.sin(8.0 * times) * np.sin(np.pi * times / 3.99) ** 2
    (tmp_path / "a.csv").write_text("time,a\n" + "\n".join(f"{t:.2f},{a:.8f}" for t, a in zip(times, samples, strict=True)))
    made, value = checked(folder=tmp_path, record={"path": "a.csv", "units": "m/s2", "correction": "none"}, **more)
    for one, verdict in zip(made.borne, made.verdicts, strict=True):
        assert one.share == pytest.approx(verdict.met, rel=1e-9) and one.asked == value["ag S"]


def test_none_and_every_ag_are_said() -> None:
    none, every = just_borne("linear", lambda _: 0.0, 2.0), just_borne("linear", lambda ag: 5.0 - 1e-9 * ag, 2.0)
    assert (none.borne, none.share) == (0.0, 0.0) and "no ag" in none.words
    assert (every.borne, every.share) == (None, None) and "every ag" in every.words
    made, _ = checked(Oscillator(0.0, G, 1.0, 1.0, 1.0, np.zeros(0), np.zeros(0)), spectrum="EC8", ag=1.0)
    assert made.borne[0].borne == 0.0


def test_what_does_not_start_counts_as_borne_by_displacements() -> None:
    slow = Oscillator(0.01, G, 1.0, 1.0, 1.0, np.array([0.0, 1e-3]), np.array([0.01, 0.0]))
    made, _ = checked(slow, spectrum="EC8", ag=0.07)
    assert made.borne[1].borne == pytest.approx(0.01 * G / 1.35) and made.verdicts[1].ratio < 1.0
    assert wall().falls
