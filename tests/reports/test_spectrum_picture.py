# SPDX-License-Identifier: GPL-3.0-or-later
"""reports/limit/spectrum_picture.py: a panel for each check, under the spectrum of a code and under a record."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from masonry_cd.analysis.code_check.check import check_at
from masonry_cd.analysis.code_check.ground import ground_of
from masonry_cd.analysis.code_check.level import level_of
from masonry_cd.analysis.code_check.spectra import spectra
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.code_check.verdicts import Spectrum
from masonry_cd.analysis.limit.oscillator import Oscillator
from masonry_cd.foundation.errors import parse_table
from reports.limit.spectrum_picture import spectrum_picture

G = 9.81
WALL = Oscillator(0.125, G, 1.0, 0.5, 0.25, np.array([0.0, 0.5]), np.array([0.125, 0.0]))
HELD = {"spectrum": "EC8", "ag": 1.5, "building_height": 10.0, "building_period": 0.3}


def of(keys: dict[str, Any], folder: Path) -> tuple[Spectrum, ...]:
    """The spectra of the check of a wall, held 6 m up."""
    table = parse_table(CheckTable, keys, "limit.check")
    level, ground = level_of(table, 6.0, 0.0), ground_of(table, folder)
    return spectra(check_at(table, level, WALL, ground), table, ground, G)


def test_a_picture_has_a_panel_for_each_check(tmp_path: Path) -> None:
    times = 0.01 * np.arange(400)
    samples = 1.5 * np.sin(8.0 * times) * np.sin(np.pi * times / 3.99) ** 2
    (tmp_path / "a.csv").write_text("time,a\n" + "\n".join(f"{t:.2f},{a:.8f}" for t, a in zip(times, samples, strict=True)))
    record = {"record": {"path": "a.csv", "units": "m/s2", "correction": "none"}}
    widths = []
    for name, keys in {"both": HELD | {"storeys": 3}, "record": record, "linear": HELD | {"code": "EC8"}}.items():
        with Image.open(spectrum_picture(of(keys, tmp_path), tmp_path / f"{name}.png", "A wall", "as built, $ and all")) as drawn:
            widths.append(drawn.width)
            assert np.asarray(drawn.convert("L")).std() > 10.0
    assert widths[0] == widths[1] > 1.3 * widths[2]
    _, displaced = of(record, tmp_path)
    assert displaced.asked[displaced.largest] == pytest.approx(displaced.check.demand, rel=5e-3)
