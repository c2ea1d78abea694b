# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/code_check/spectra.py: what a check asks for lies on the curve that is drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_code_check import checked, wall
from test_steps import CASES

from masonry_cd.analysis.code_check.ground import ground_of
from masonry_cd.analysis.code_check.spectra import spectra
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.foundation.errors import parse_table


@pytest.mark.parametrize("keys", CASES.values(), ids=list(CASES))
def test_the_demand_lies_on_the_curve(keys: dict) -> None:
    made, _ = checked(**keys)
    table = parse_table(CheckTable, keys, "limit.check")
    for one in spectra(made, table, ground_of(table, Path()), wall().gravity):
        there = int(np.searchsorted(one.period, one.check.period))
        assert one.period[there] == one.check.period < one.period[-1]
        assert one.asked[there] / one.check.q == pytest.approx(one.check.demand, rel=1e-12)
        assert (one.raised is not None) is ("height" in keys)
