# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis/code_check/spectra.py and its picture: what a check asks for lies on the curve that is drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from test_code_check import checked, wall
from test_steps import CASES

from masonry_cd.analysis.code_check.ground import ground_of
from masonry_cd.analysis.code_check.spectra import Spectrum, spectra
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.foundation.errors import parse_table
from reports.limit.spectrum_picture import spectrum_picture


def of(keys: dict, folder: Path = Path()) -> tuple[Spectrum, ...]:
    made, _ = checked(folder=folder, **keys)
    table = parse_table(CheckTable, keys, "limit.check")
    return spectra(made, table, ground_of(table, folder), wall().gravity)


@pytest.mark.parametrize("keys", CASES.values(), ids=list(CASES))
def test_the_demand_lies_on_the_curve(keys: dict) -> None:
    for one in of(keys):
        there = int(np.searchsorted(one.period, one.check.period))
        assert one.period[there] == one.check.period < one.period[-1]
        assert one.asked[there] / one.check.q == pytest.approx(one.check.demand, rel=1e-12)
        assert (one.raised is not None) is ("height" in keys)


def test_a_picture_has_a_panel_for_each_check(tmp_path: Path) -> None:
    times = 0.01 * np.arange(400)
    samples = 1.5 * np.sin(8.0 * times) * np.sin(np.pi * times / 3.99) ** 2
    (tmp_path / "a.csv").write_text("time,a\n" + "\n".join(f"{t:.2f},{a:.8f}" for t, a in zip(times, samples, strict=True)))
    record = {"record": {"path": "a.csv", "units": "m/s2", "correction": "none"}}
    widths = []
    for name, keys in {"both": CASES["height"], "record": record, "linear": CASES["Eurocode"]}.items():
        with Image.open(spectrum_picture(of(keys, tmp_path), tmp_path / f"{name}.png", "A wall", "as built, $ and all")) as drawn:
            widths.append(drawn.width)
            assert np.asarray(drawn.convert("L")).std() > 10.0
    assert widths[0] == widths[1] > 1.3 * widths[2]
    _, displaced = of(record, tmp_path)
    assert displaced.asked[displaced.largest] == pytest.approx(displaced.check.demand, rel=5e-3)
