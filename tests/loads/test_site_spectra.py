# SPDX-License-Identifier: GPL-3.0-or-later
"""loads/signal/spectra: ordinates of each kind by hand, tables in files and as they are, and an accelerogram that meets one."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import loads
from loads.motion import STANDARD_GRAVITY
from loads.signal.code_spectrum import SiteSpectrum
from loads.signal.spectra.shape import CodeSpectrum, ElasticSpectrum
from masonry_cd.foundation.errors import InputError, parse_table

TABLE = {"period": [0.0, 0.1, 0.4, 2.0], "acceleration": [2.0, 5.0, 5.0, 1.0]}
ETA8 = math.sqrt(10.0 / 13.0)


def spectrum(name: str, **keys: Any) -> ElasticSpectrum:
    """A spectrum by its keys."""
    return parse_table(SiteSpectrum, {"spectrum": name, **keys}, "site").read(Path(), "site").spectrum_of_site()


def read(folder: Path, text: str, **keys: Any) -> ElasticSpectrum:
    """A spectrum from a file with some text."""
    (folder / "site.csv").write_text(text, encoding="utf-8")
    table = {"spectrum": "table", "table": {"path": "site.csv"}, **keys}
    return parse_table(SiteSpectrum, table, "site").read(folder, "site").spectrum_of_site()


def test_a_table_is_straight_in_logarithms_and_linear_from_zero():
    found = spectrum("table", table=TABLE)
    between = 5.0 * (0.8 / 0.4) ** (math.log(1.0 / 5.0) / math.log(2.0 / 0.4))  # S = 2 / T, by hand
    assert between == pytest.approx(2.5)
    assert found.at(np.array([0.0, 0.05, 0.1, 0.2, 0.4, 0.8, 2.0])) == pytest.approx([2.0, 3.5, 5.0, 5.0, 5.0, between, 1.0])
    assert found.displacement(np.array([0.8])) == pytest.approx(2.5 * (0.8 / (2.0 * math.pi)) ** 2)
    with pytest.raises(InputError, match=r"2.5 s is beyond the spectrum, whose table ends at 2 s"):
        found.at(np.array([1.0, 2.5]))


def test_dampings_are_those_of_eta_or_between_columns():
    one = spectrum("table", table=TABLE)
    assert one.at(np.array([0.0, 0.05, 0.1, 0.8]), 0.08) == pytest.approx([2.0, 1.0 + 2.5 * ETA8, 5.0 * ETA8, 2.5 * ETA8])
    two = spectrum("table", table={**TABLE, "acceleration": [TABLE["acceleration"], [2.0, 3.2, 3.2, 0.64]], "damping": [0.05, 0.2]})
    assert two.at(np.array([0.4]), 0.1) == pytest.approx(4.0)  # half-way in ln xi: the geometric mean
    assert two.at(np.array([0.4]), 0.2) == pytest.approx(3.2)
    assert two.at(np.array([0.4]), 0.02) == pytest.approx(5.0 * math.sqrt(10.0 / 7.0))
    assert two.at(np.array([0.4]), 0.25) == pytest.approx(3.2 * math.sqrt(25.0 / 30.0))


@pytest.mark.parametrize("damping", [0.02, 0.05, 0.08, 0.28])
@pytest.mark.parametrize("ground", "AD")
def test_a_table_of_a_code_has_the_ordinates_of_the_code(ground: str, damping: float):
    code = spectrum("EC8", ag=2.0, ground=ground)
    period = np.r_[0.0, np.geomspace(0.01, 4.0, 600)]
    table = spectrum("table", table={"period": period.tolist(), "acceleration": code.at(period).tolist()})
    between = np.linspace(0.0, 4.0, 701)
    assert table.at(between, damping) == pytest.approx(code.at(between, damping), rel=6e-3)  # 600 points, a corner between two


def test_files_in_other_units_and_with_other_dampings(tmp_path: Path):
    plain = read(tmp_path, "# UHS of the site\nT [s],Sa [g]\n0,0.2\n0.1,0.5\n2,0.1\n")
    assert plain.at(np.array([0.0, 0.1])) == pytest.approx([0.2 * STANDARD_GRAVITY, 0.5 * STANDARD_GRAVITY])
    other = read(tmp_path, "T (ms);5 % (cm/s2);10,0 % (cm/s2)\n100;500;400\n2000;100;80\n", ag=1.5)
    assert other.at(np.array([0.0, 0.05, 2.0])) == pytest.approx([1.5, 3.25, 1.0])
    assert other.at(np.array([2.0]), 0.1) == pytest.approx(0.8)


WRONG = {
    "line 2": "T [s],Sa [g]\n0,0.2\n",
    "line 4": "T [s],Sa [g]\n0,0.2\n0.4,0.5\n0.3,0.5\n",
    "line 3": "T [s],Sa [g]\n0,0.2\n0.1,-0.5\n",
    "line 2: ": "T [s],Sa [g]\n-0.1,0.2\n0.1,0.5\n",
    "line 3: nan": "T [s],Sa [g]\n0,0.2\n0.1,nan\n",
    "line 3: ": "T [s],Sa [g]\n0,0.2\n0.1,0.5,0.6\n",
    "line 1: ": "T [s],Sa [m]\n0,0.2\n0.1,0.5\n",
    "line 1": "T,Sa [g]\n0,0.2\n0.1,0.5\n",
    "site.csv: damping": "T [s],5 % [g],Sa [g]\n0,0.2,0.2\n0.1,0.5,0.4\n",
    "site: ag": "T [s],Sa [g]\n0.1,0.2\n0.2,0.5\n",
}


@pytest.mark.parametrize("place", WRONG)
def test_what_is_wrong_with_a_file_is_named_with_its_line(tmp_path: Path, place: str):
    with pytest.raises(InputError) as refused:
        read(tmp_path, WRONG[place])
    assert place.rstrip(": ") in str(refused.value)


def test_an_accelerogram_meets_a_table_and_nothing_beyond_it_is_asked_for():
    keys = {
        "kind": "artificial",
        "direction": "x",
        "spectrum": "table",
        "table": {**TABLE, "acceleration": ["0.2 g", "0.5 g", "0.5 g", "0.1 g"]},
    }
    found = loads.build([keys], 1e-2, 2500, (0.0, 0.0, -9.81), Path())
    low, high = found.summary["tables"][0]["ratio"]
    assert 0.9 <= low <= high <= 1.1
    with pytest.raises(InputError, match=r"loads\[0\]: 2.5 s is beyond"):
        loads.build([keys | {"periods": [0.2, 2.5]}], 1e-2, 2500, (0.0, 0.0, -9.81), Path())


G = STANDARD_GRAVITY


def hand_2024(t: float, alpha: float, beta: float, far: float, eta: float = 1.0) -> float:
    """S_e of EN 1998-1-1:2024 for S_alpha and S_beta, branch by branch."""
    end = beta / alpha
    begin = min(max(end / 4.0, 0.05), 0.1)
    if t < 0.02:
        return alpha / 2.5
    if t < begin:
        return alpha / (begin - 0.02) * (eta * (t - 0.02) + (begin - t) / 2.5)
    return eta * alpha if t < end else eta * beta / t if t < far else eta * far * beta / t**2


@pytest.mark.parametrize("damping", [0.05, 0.08])
@pytest.mark.parametrize(
    ("ground", "f_alpha", "f_beta"),
    [
        ("A", 1.0, 1.0),
        ("B", 1.3 * (1 - 0.5 / G), 1.6 * (1 - 0.4 / G)),
        ("C", 1.6 * (1 - 1.0 / G), 2.3 * (1 - 0.6 / G)),
        ("D", 1.8 * (1 - 1.5 / G), 3.2 * (1 - 2.0 / G)),
    ],
)
def test_eurocode_8_of_2024_by_hand(ground: str, f_alpha: float, f_beta: float, damping: float):
    found, eta = spectrum("EC8-2024", s_alpha=5.0, s_beta=2.0, ground=ground), math.sqrt(10.0 / (5.0 + 100.0 * damping))
    period = [0.0, 0.01, 0.03, 0.06, 0.09, 0.2, 0.5, 1.0, 2.0, 3.0, 4.0]
    by_hand = [hand_2024(t, f_alpha * 5.0, f_beta * 2.0, 3.0, eta) for t in period]
    assert found.at(np.array(period), damping) == pytest.approx(by_hand)


def test_the_corners_of_2024_have_their_bounds():
    slow, fast = (spectrum("EC8-2024", s_alpha=a, s_beta=b) for a, b in ((5.0, 3.0), (5.0, 0.5)))
    assert isinstance(slow, CodeSpectrum) and isinstance(fast, CodeSpectrum)
    assert slow.corners == pytest.approx((0.1, 0.6, 4.0))
    assert fast.corners == pytest.approx((0.05, 0.1, 2.0))


def test_asce_7_by_hand():
    found = spectrum("ASCE7", s_ds=8.0, s_d1=4.0, t_l=6.0)
    assert found.at(np.array([0.0, 0.05, 0.1, 0.3, 0.5, 1.0, 6.0, 8.0])) == pytest.approx(
        [3.2, 5.6, 8.0, 8.0, 8.0, 4.0, 4.0 / 6.0, 24.0 / 64.0]
    )


@pytest.mark.parametrize(
    ("ground", "start", "top", "at_one", "at_two", "at_four"),
    [
        ("A", 1.0, 2.35, 1.6 * 0.5**0.75, 0.525, 3.15 / 16),
        ("C", 1.33, 2.93, 2.0 * 0.5**0.75, 0.66, 3.96 / 16),
        ("D", 1.12, 3.0, 2.4 * 0.75**0.75, 1.07, 6.42 / 16),
        ("E", 1.12, 3.0, 3.0, 1.66, 9.96 / 16),
    ],
)
def test_nzs_1170_by_hand(ground: str, start: float, top: float, at_one: float, at_two: float, at_four: float):
    size = 0.3 * 1.3 * G
    shape = [start, 0.5 * (start + top), top, at_one, at_two, at_four]
    period = np.array([0.0, 0.05, 0.2, 1.0, 2.0, 4.0])
    assert spectrum("NZS1170", hazard_factor=0.3, return_factor=1.3, ground=ground).at(period) == pytest.approx(size * np.array(shape))
    near = spectrum("NZS1170", hazard_factor=0.3, return_factor=1.3, ground=ground, fault_distance="11 km").at(period)
    assert near == pytest.approx(size * np.array(shape) * [1, 1, 1, 1, 1.06, 1.3])  # half of N_max - 1: 0.12 at 2 s, 0.6 at 4 s
    often = spectrum("NZS1170", hazard_factor=0.3, return_factor=0.75, ground=ground, fault_distance="1 km").at(period)
    assert often == pytest.approx(0.75 / 1.3 * size * np.array(shape))


KINDS_OF_SITE: dict[str, dict[str, Any]] = {
    "EC8": {"ag": 2.0, "ground": "D"},
    "NTC": {"ag": 2.0, "f0": 2.4, "tc_star": 0.35, "ground": "C"},
    "EC8-2024": {"s_alpha": 5.0, "s_beta": 2.0, "ground": "C"},
    "ASCE7": {"s_ds": 8.0, "s_d1": 4.0, "t_l": 6.0},
    "NZS1170": {"hazard_factor": 0.3, "ground": "D", "fault_distance": "4 km"},
    "table": {"table": {"period": [0.0, 0.1, 0.5, 10.0], "acceleration": [2.0, 5.0, 5.0, 0.2]}},
}


@pytest.mark.parametrize("name", KINDS_OF_SITE)
@pytest.mark.parametrize("damping", [0.02, 0.05, 0.1])
def test_every_kind_is_continuous_and_grows_as_a_whole(name: str, damping: float):
    site = parse_table(SiteSpectrum, {"spectrum": name, **KINDS_OF_SITE[name]}, "site")
    found, period = site.spectrum_of_site(), np.linspace(0.0, 10.0, 200_001)
    values = found.at(period, damping)
    steepest = 3.0 * values.max() / 0.05  # of the rise
    assert np.abs(np.diff(values)).max() <= steepest * (period[1] - period[0]) + 0.005 * values.max()  # rounded constants of NZS 1170.5
    assert found.at(np.zeros(1), damping) == found.at(np.zeros(1))  # damping leaves the peak of the ground
    ag = site.of_kind.size(site, found)
    twice = site.of_kind.grown(site, ag, 2.0 * ag)
    assert twice.of_kind.size(twice, twice.spectrum_of_site()) == pytest.approx(2.0 * ag)
    if name not in ("NTC", "EC8-2024"):  # where soil and corners follow ag
        assert twice.spectrum_of_site().at(period[1:], damping) == pytest.approx(2.0 * values[1:])
