# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/code_check/site.py: what a hazard gives a check, F0 and TC* that follow ag, return period and risk class by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from test_code_check import ALPHA, G, wall

from masonry_cd.analysis.code_check.check import check_at, with_borne
from masonry_cd.analysis.code_check.ground import ground_of
from masonry_cd.analysis.code_check.level import HeldLevel
from masonry_cd.analysis.code_check.site import completed, known_at
from masonry_cd.analysis.code_check.steps import CodeCheck, with_numbers
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.hazard.curve import Hazard
from masonry_cd.analysis.hazard.life import Life
from masonry_cd.analysis.hazard.risk import RARE, frequencies, loss
from masonry_cd.foundation.errors import InputError, parse_table

STARTS = ALPHA * G / 1.35  # a0* [m/s2]
PERIODS, PEAKS = np.array([30.0, 50.0, 475.0, 975.0, 2475.0]), np.array([0.4, 0.7, 1.9, 2.4, 3.1])
F0, TC_STAR = np.array([2.4, 2.35, 2.45, 2.5, 2.6]), np.array([0.25, 0.27, 0.32, 0.35, 0.4])
KNOWN = {"sqrt": math.sqrt, "max": max, "min": min, "pi": math.pi, "ln": math.log}


def hazard(rows: int = 5, life: Life | None = None, shapes: bool = True) -> Hazard:
    more = (F0[:rows], TC_STAR[:rows]) if shapes else (None, None)
    return Hazard("PGA", PEAKS[:rows], 1.0 / PERIODS[:rows], *more, life or Life())


def checked(site: Hazard, **keys: object) -> CodeCheck:
    """The check of the wall of test_code_check."""
    table = parse_table(CheckTable, completed({"spectrum": "NTC"} | keys, site), "limit.check")
    ground, level = ground_of(table, Path(), known_at(site, table)), HeldLevel(0.0, 0.0, "", 0.0)
    return with_borne(check_at(table, level, wall(), ground, ""), table, level, wall(), ground)


def value(made: CodeCheck, symbol: str) -> float:
    return next(step.value for step in made.steps if step.symbol == symbol)


def test_ag_f0_and_tc_star_are_those_of_the_return_period_of_the_limit_state():
    made, years = checked(hazard()), 50.0 / -math.log(0.9)
    power = math.log(years / 50.0) / math.log(475.0 / 50.0)
    assert value(made, "TR") == pytest.approx(years)
    assert value(made, "ag") == pytest.approx(0.7 * (1.9 / 0.7) ** power)
    assert (value(made, "F0"), value(made, "TC*")) == (
        pytest.approx(2.35 * (2.45 / 2.35) ** power),
        pytest.approx(0.27 * (0.32 / 0.27) ** power),
    )
    assert checked(hazard(shapes=False), f0=2.5, tc_star=0.3, code="EC8", spectrum="NTC").risk is None


def test_the_return_period_of_what_is_borne_and_the_class_by_hand():
    """On rock the linear checks bear q a0* at SLV and a0* at SLD."""
    made = checked(hazard(), displacements=False)
    (one,) = made.borne
    assert one.borne == pytest.approx(2.0 * STARTS) and one.period is not None

    def years(ag: float) -> float:
        k = int(np.searchsorted(PEAKS, ag))
        return PERIODS[k - 1] * (ag / PEAKS[k - 1]) ** (math.log(PERIODS[k] / PERIODS[k - 1]) / math.log(PEAKS[k] / PEAKS[k - 1]))

    assert one.period.years == pytest.approx(years(2.0 * STARTS)) and not one.period.bound
    risk = made.risk
    assert risk is not None and risk.index == pytest.approx(2.0 * STARTS / value(made, "ag")) and risk.index_class == "A"
    often = {"SLD": 1.0 / years(STARTS), "SLV": 1.0 / years(2.0 * STARTS)}
    assert {one.state: one.frequency for one in risk.capacities} == {key: pytest.approx(each) for key, each in often.items()}
    assert risk.loss == pytest.approx(loss(frequencies(often))) == pytest.approx(value(made, "PAM"))
    assert value(made, "lambda(SLC)") == pytest.approx(RARE * often["SLV"])
    assert risk.risk_class == max(risk.index_class, risk.loss_class)


def test_f0_and_tc_star_follow_the_ag_that_is_just_borne():
    made = checked(hazard(), ground="C")
    displaced = made.borne[1]
    row = hazard().nearest(displaced.period.years)
    assert row.intensity == pytest.approx(displaced.borne)
    table = {"ag": displaced.borne, "f0": row.f0, "tc_star": row.tc_star, "spectrum": "NTC", "ground": "C"}
    own = parse_table(CheckTable, table, "limit.check")
    there = check_at(own, HeldLevel(0.0, 0.0, "", 0.0), wall(), ground_of(own, Path()), "")
    assert there.verdicts[1].met == pytest.approx(1.0, rel=1e-9)
    assert made.risk.capacities[2].state == "SLC" and made.risk.capacities[2].ag > displaced.borne


def test_each_line_comes_to_its_value():
    made = checked(hazard(life=Life(10.0, "II")), ground="B")
    lines = [(step, line) for step, line in zip(made.steps, with_numbers(made.steps), strict=True) if line]
    assert {"TR", "ag", "TC_C", "zeta_E", "PAM", "VR"} <= {step.symbol for step, _ in lines}
    for step, line in lines:
        numbers = line.split(" = ")[2].replace(" x ", " * ").replace("^", "**")
        assert eval(numbers, {"__builtins__": {}}, KNOWN) == pytest.approx(step.value, rel=5e-3), line


def test_a_capacity_beyond_the_rows_is_a_bound():
    made = checked(hazard(3), displacements=False, confidence_factor=1.0, behaviour_factor=4.0)
    (one,) = made.borne
    assert one.period == (475.0, ">=") and "return period of PGA_C >= 475 years" in one.words
    numbers = made.numbers()["borne"][0]
    assert (numbers["return_period_years"], numbers["return_period_bound"]) == (475.0, ">=")
    assert made.risk.loss_at_most and "PAM <=" in made.risk.words


def test_without_sld_among_the_rows_there_is_no_loss_and_the_reason_is_said():
    made = checked(Hazard("PGA", PEAKS[2:], 1.0 / PERIODS[2:], F0[2:], TC_STAR[2:], Life(60.0)), displacements=False)
    assert made.risk.loss is None and made.risk.risk_class is None and made.risk.index_class == "A"
    assert "it needs the capacity at SLD" in made.risk.words and "475 to 2475 years" in made.risk.words


def test_a_life_alone_takes_the_relation_of_the_guideline():
    made = checked(Hazard("PGA", np.zeros(0), np.zeros(0)), ag=1.6, f0=2.4, tc_star=0.3, displacements=False)
    years = 50.0 / -math.log(0.9)
    assert made.borne[0].period.years == pytest.approx(years * (2.0 * STARTS / 1.6) ** (1.0 / 0.43))
    assert any("1 / eta = 0.43" in note for note in made.notes)


@pytest.mark.parametrize("key", ["ag", "f0", "tc_star"])
def test_what_the_hazard_gives_is_not_given_twice(key: str):
    with pytest.raises(InputError, match=rf"limit.check.{key}: \[hazard\] gives it"):
        completed({"spectrum": "NTC", key: 0.3}, hazard())


def test_a_hazard_of_another_measure_leaves_the_check_alone():
    site = Hazard("Sa(0.5)", PEAKS, 1.0 / PERIODS)
    asked = {"spectrum": "EC8", "ag": 1.5}
    assert completed(asked, site) == asked and known_at(site, parse_table(CheckTable, asked, "limit.check")) is None


def test_the_hazard_of_ag_says_nothing_of_a_table_that_begins_above_zero():
    keys = {"spectrum": "table", "table": {"period": [0.1, 4.0], "acceleration": [3.0, 0.3]}, "ag": 1.5}
    assert known_at(hazard(), parse_table(CheckTable, keys, "limit.check")) is None
    assert known_at(hazard(), parse_table(CheckTable, {"spectrum": "EC8", "ag": 1.5}, "limit.check")) is not None
