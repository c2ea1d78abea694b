# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/code_check under a table of ordinates: as under the code that it is taken from, and not decided beyond its end."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_code_check import BUILDING, checked, wall

from loads.signal.spectra.ec8 import ec8
from masonry_cd.analysis.code_check.ground import ground_of
from masonry_cd.analysis.code_check.spectra import spectra
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import NOT_DECIDED, verdict_of
from masonry_cd.foundation.errors import InputError, parse_table


def sampled(end: float, count: int = 800) -> dict:
    """The keys of EC8 with ag 1.5 m/s2 on ground C, in a table that ends at a period [s]."""
    period = np.r_[0.0, np.geomspace(0.01, end, count)]
    return {"spectrum": "table", "table": {"period": period.tolist(), "acceleration": ec8(1.5, "C").at(period).tolist()}}


@pytest.mark.parametrize("more", [{}, {"code": "NTC2008"}, {"code": "EC8"}, BUILDING, {"element_period": 0.1}], ids=str)
def test_a_table_of_eurocode_8_gives_the_check_of_eurocode_8(more: dict):
    code, by_code = checked(spectrum="EC8", ag=1.5, ground="C", **more)
    table, by_table = checked(**sampled(4.0), **more)
    for one, other in zip(code.verdicts, table.verdicts, strict=True):
        assert (other.check, other.state, other.period) == (one.check, one.state, one.period)
        assert other.demand == pytest.approx(one.demand, rel=2e-3)
    assert by_table["ag S"] == pytest.approx(by_code["ag S"])
    for one, other in zip(code.borne, table.borne, strict=True):  # of EC8 on rock, of a table that of the ground
        assert other.share == pytest.approx(one.share, rel=2e-3)
        assert other.asked == pytest.approx(1.15 * one.asked)


@pytest.mark.parametrize("code", ["NTC2018", "NTC2008"])
def test_a_check_whose_period_is_beyond_the_table_is_not_decided(code: str):
    asked = {"code": code, "behaviour_factor": 1.0}
    whole, _ = checked(**asked, **sampled(4.0))
    made, value = checked(**asked, **sampled(1.0))
    period = value["TSLV" if code == "NTC2018" else "Ts"]
    assert whole.verdicts[0].state != NOT_DECIDED and period > 1.0
    assert [(one.check, one.state) for one in made.verdicts] == [("linear", NOT_DECIDED)]
    assert f"{period:.4g} s is beyond the spectrum, whose table ends at 1 s" in verdict_of(made.verdicts).because
    assert made.unread == made.verdicts[0].unread and any(line.endswith(made.unread) for line in made.lines())
    assert checked(**asked, **sampled(1.0), displacements=False)[0].verdicts[0].state == whole.verdicts[0].state
    table = parse_table(CheckTable, asked | sampled(1.0), "limit.check")
    assert [one.period[-1] for one in spectra(made, table, ground_of(table, Path()), wall().gravity)] == [1.0]


def test_where_the_mechanism_does_not_start_the_end_of_a_table_decides_nothing():
    made, _ = checked(confidence_factor=1.0, behaviour_factor=2.0, spectrum="table", table={"period": [0, 1], "acceleration": [0.4, 0.2]})
    assert [(one.check, one.state) for one in made.verdicts] == [("linear", "satisfied")]


def test_a_building_slower_than_the_table_is_refused():
    table = parse_table(CheckTable, {**sampled(1.0), **BUILDING, "building_period": 1.2}, "limit.check")
    with pytest.raises(InputError, match=r"limit.check.building_period: 1.2 s is beyond the spectrum, whose table ends at 1 s"):
        ground_of(table, Path())
