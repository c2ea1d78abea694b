# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/hazard: return periods by hand, files, frequencies against closed forms and a quadrature, the numbers of the Italian decree."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

import masonry_cd as mc
from masonry_cd.analysis.hazard.curve import G, Hazard, exponent
from masonry_cd.analysis.hazard.frequency import frequency, probability
from masonry_cd.analysis.hazard.life import Life
from masonry_cd.analysis.hazard.risk import FIRST_DAMAGE, capacity_of, class_of_index, class_of_loss, frequencies, loss
from masonry_cd.analysis.hazard.table import HazardTable, hazard_of
from masonry_cd.foundation.errors import InputError, parse_table

PERIODS, PEAKS = [50.0, 475.0, 2475.0], [0.8, 2.0, 3.5]
TABLE = {"return_period": PERIODS, "ag": PEAKS, "f0": [2.3, 2.5, 2.6], "tc_star": [0.25, 0.32, 0.36]}
OPENQUAKE = (
    "#,,,,\"generated_by='OpenQuake engine 3.16.3', kind='mean', investigation_time=50.0, imt='{imt}'\"\n"
    "lon,lat,depth,poe-0.0100000,poe-0.1000000,poe-0.4000000,poe-2.0000000\n"
    "13.40000,42.35000,0.00000,1.000000E+00,5.000000E-01,2.000000E-02,0.000000E+00\n"
    "13.50000,42.35000,0.00000,9.000000E-01,4.000000E-01,1.000000E-02,1.000000E-05\n"
)


def made(folder: Path = Path(), **keys) -> Hazard:
    return hazard_of(parse_table(HazardTable, keys, "hazard"), folder)


def test_between_two_rows_ag_f0_and_tc_star_are_powers_of_the_return_period():
    hazard, years = made(**TABLE), 200.0
    power = math.log(years / 50.0) / math.log(475.0 / 50.0)
    row = hazard.at(years)
    assert row.intensity == pytest.approx(0.8 * (2.0 / 0.8) ** power)
    assert (row.f0, row.tc_star) == (pytest.approx(2.3 * (2.5 / 2.3) ** power), pytest.approx(0.25 * (0.32 / 0.25) ** power))
    assert hazard.return_period(row.intensity).years == pytest.approx(years) and not hazard.return_period(row.intensity).bound
    for period, peak in zip(PERIODS, PEAKS, strict=True):
        assert hazard.at(period).intensity == pytest.approx(peak) and hazard.return_period(peak).years == pytest.approx(period)


def test_beyond_the_rows_a_return_period_is_a_bound_and_an_intensity_is_refused():
    hazard = made(**TABLE)
    assert hazard.return_period(3.6).words == ">= 2475 years" and hazard.return_period(0.7).words == "<= 50 years"
    for years in (49.0, 2500.0):
        with pytest.raises(InputError, match="50 to 2475 years"):
            hazard.at(years)


def test_the_return_periods_of_limit_states_are_those_of_the_code():
    assert [Life().asked(state) for state in ("SLO", "SLD", "SLV", "SLC")] == pytest.approx([30.1, 50.3, 474.6, 974.8], abs=0.05)
    grand = Life(100.0, "IV")
    assert grand.return_period("SLC") == 2475.0 and "beyond the national grid" in grand.notes("SLC")[0]
    assert grand.return_period("SLC", limited=False) == pytest.approx(200.0 / -math.log(0.95)) and not grand.notes("SLV")
    assert Life(10.0, "I").reference == 35.0 and "below 35" in Life(10.0, "I").notes("SLV")[0]


@pytest.mark.parametrize(("theta", "beta"), [(2.5, 0.4), (0.3, 0.8), (8.0, 0.15)])
def test_of_one_power_law_the_frequency_is_the_closed_form(theta: float, beta: float):
    k0, k = 2e-3, 2.7
    intensity = np.exp(np.linspace(-14.0, 14.0, 57))
    found = frequency(Hazard("PGA", intensity, k0 * intensity**-k), np.array([theta]), np.array([beta]))
    exact = k0 * theta**-k * math.exp(0.5 * (k * beta) ** 2)
    assert found.least[0] == pytest.approx(exact, rel=1e-10) and found.most[0] == pytest.approx(exact, rel=1e-10)


def test_over_several_power_laws_it_is_the_integral_of_the_fragility_between_its_bounds():
    hazard, theta, beta = made(**TABLE), 2.2, 0.5
    x, logs = np.log(hazard.intensity), np.log(hazard.frequency)

    def contribution(at: float) -> float:
        k = min(int(np.searchsorted(x, at, side="right")), 2) - 1
        slope = -(logs[k + 1] - logs[k]) / (x[k + 1] - x[k])
        return float(norm.cdf((at - math.log(theta)) / beta) * slope * math.exp(np.interp(at, x, logs)))

    inside = sum(quad(contribution, a, b - 1e-13, epsabs=0.0, epsrel=1e-12)[0] for a, b in pairwise(x))
    found = frequency(hazard, np.array([theta]), np.array([beta]))
    last = norm.cdf((x[-1] - math.log(theta)) / beta) * hazard.frequency[-1]
    assert found.least[0] == pytest.approx(inside + last, rel=1e-9)
    slope = -(logs[1] - logs[0]) / (x[1] - x[0])
    steady = quad(
        lambda at: norm.cdf((at - math.log(theta)) / beta) * slope * hazard.frequency[0] * math.exp(-slope * (at - x[0])), -9.0, x[0]
    )
    assert found.most[0] == pytest.approx(inside + steady[0] + hazard.frequency[-1], rel=1e-7)


def test_a_step_nothing_everything_and_no_fragility():
    found = frequency(made(**TABLE), np.array([2.0, np.inf, 0.0, np.nan]), np.array([0.0, np.nan, np.nan, np.nan]))
    for one in found:
        assert one[0] == pytest.approx(1.0 / 475.0, rel=1e-6) and one[1] == 0.0 and np.isinf(one[2]) and np.isnan(one[3])
    assert probability(np.array([1.0 / 475.0])) == pytest.approx(1.0 - math.exp(-50.0 / 475.0))


def test_the_losses_that_the_decree_states():
    """D.M. 65/2017, annex A, 2: a new building of V_R 50, 75 and 100 years has a PAM of 1.13, 0.87 and 0.74 %, IS-V = 1 of class A."""
    for years, percent in ((50.0, 1.13), (75.0, 0.87), (100.0, 0.74)):
        exact = {state: 1.0 / Life(years).asked(state) for state in ("SLO", "SLD", "SLV", "SLC")}
        assert round(100.0 * loss({"SLID": FIRST_DAMAGE} | exact), 2) == percent
    assert (class_of_loss(0.0113), class_of_loss(0.005), class_of_loss(0.075), class_of_loss(0.0751)) == ("B", "A+", "F", "G")
    indices = (1.01, 1.0, 0.8, 0.79, 0.6, 0.45, 0.3, 0.151, 0.15, None)
    assert [class_of_index(value) for value in indices] == ["A+", "A", "A", "B", "B", "C", "D", "E", "F", "A+"]


def test_slv_and_sld_suffice_and_damage_is_not_reached_after_slv():
    two = frequencies({"SLV": 1.0 / 300.0, "SLD": 1.0 / 60.0})
    assert (two["SLO"], two["SLC"]) == (pytest.approx(1.67 / 60.0), pytest.approx(0.49 / 300.0))
    late = frequencies({"SLV": 1.0 / 100.0, "SLD": 1.0 / 600.0})
    assert late["SLD"] == late["SLV"] and late["SLO"] == pytest.approx(0.0167)


def test_a_capacity_beyond_the_rows_is_bounded_and_below_them_the_guideline_goes_on():
    hazard = made(**TABLE)
    assert capacity_of("SLV", 4.0, hazard, 2.0).at_most and capacity_of("SLV", None, hazard, 2.0).frequency == pytest.approx(1.0 / 2475.0)
    below = capacity_of("SLD", 0.6, hazard, 2.0)
    assert exponent(2.0) == 0.43 and below.frequency == pytest.approx(1.0 / (50.0 * (0.6 / 0.8) ** (1.0 / 0.43)))
    assert capacity_of("SLD", 0.0, hazard, 2.0).frequency == FIRST_DAMAGE


def test_our_own_table_and_one_of_openquake_are_read(tmp_path):
    (tmp_path / "own.csv").write_text("return_period_years,ag_g,f0\n# by hand\n50,0.1,2.4\n475,0.25,2.5\n", encoding="utf-8")
    own = made(tmp_path, path="own.csv")
    assert own.intensity == pytest.approx([0.1 * G, 0.25 * G]) and own.f0 == pytest.approx([2.4, 2.5]) and own.tc_star is None
    (tmp_path / "oq.csv").write_text(OPENQUAKE.format(imt="SA(0.50)"), encoding="utf-8")
    first = made(tmp_path, path="oq.csv", lon=13.4, lat=42.35)
    assert first.measure == "Sa(0.5)" and first.intensity == pytest.approx([0.1 * G, 0.4 * G]) and "2 of 4 levels" in first.notes[0]
    assert first.frequency == pytest.approx([math.log(2.0) / 50.0, -math.log(0.98) / 50.0])
    assert len(made(tmp_path, path="oq.csv", lon=13.5, lat=42.35).intensity) == 4


def test_python_has_it_from_arrays():
    site = mc.Hazard(return_period=np.array(PERIODS), ag=[f"{peak / G:.12f} g" for peak in PEAKS], use_class="III")
    assert site.measure == "PGA" and site.intensities == pytest.approx(PEAKS) and 1.0 / site.frequencies == pytest.approx(PERIODS)
    assert site.of_limit_state("SLV").intensity == pytest.approx(site.at(75.0 / -math.log(0.9)).intensity)
    least, most = site.frequency(2.0, 0.3)
    assert 0.0 < least < most and str(site).startswith("hazard: PGA, 3 rows")
    for call in (lambda: site.of_limit_state("ULS"), lambda: site.frequency(0.0, 0.3), lambda: mc.Hazard(use_class="II")):
        with pytest.raises(InputError):
            call()


@pytest.mark.parametrize(
    ("text", "keys", "place"),
    [
        ("return_period_years,ag\n50,0.1\n475,0.2\n", {}, "a.csv:1"),
        ("return_period_years,ag_g\n50,0.1\n475\n", {}, "a.csv:3"),
        ("return_period_years,ag_g\n50,0.1\n475,-2\n", {}, "a.csv:3"),
        ("return_period_years,ag_g\n50,0.1\n475,0.05\n", {}, "a.csv"),
        ("ag_m_s2,ag_g\n1,0.1\n", {}, "a.csv:1"),
        ("# nothing\n", {}, "a.csv"),
        ("return_period_years,ag_g\n50,0.1\n475,0.2\n", {"lon": 1.0, "lat": 2.0}, "hazard.lon"),
        (OPENQUAKE.format(imt="PGA"), {}, "hazard.lon"),
        (OPENQUAKE.format(imt="PGA"), {"lon": 13.45, "lat": 42.35}, "hazard.lon"),
        (OPENQUAKE.format(imt="PGA"), {"lon": 13.4, "lat": 42.35, "measure": "Sa(0.5)"}, "hazard.measure"),
        (OPENQUAKE.format(imt="MMI"), {"lon": 13.4, "lat": 42.35}, "a.csv"),
        (OPENQUAKE.partition("\n")[2], {"lon": 13.4, "lat": 42.35}, "a.csv"),
        (OPENQUAKE.format(imt="PGA").replace("5.000000E-01", "1.5"), {"lon": 13.4, "lat": 42.35}, "a.csv:3"),
    ],
)
def test_files_that_are_refused_by_their_place(text: str, keys: dict, place: str, tmp_path: Path):
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as refused:
        made(tmp_path, path="a.csv", **keys)
    assert str(refused.value).removeprefix(f"{tmp_path}/").startswith(f"{place}:")
