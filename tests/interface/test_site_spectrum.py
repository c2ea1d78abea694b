# SPDX-License-Identifier: GPL-3.0-or-later
"""mc.Spectrum: ordinates, keys that make the same spectrum in a scene, and a picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import masonry_cd as mc


def test_it_has_ordinates_in_the_shape_of_the_periods() -> None:
    code = mc.Spectrum("EC8", ag=2.0, ground="B")
    assert code.at(0.3) == pytest.approx(6.0)
    assert code.at(np.array([[0.0], [0.3]])).shape == (2, 1)
    assert code.displacement([0.0, 0.3])[1] == pytest.approx(6.0 * (0.3 / (2.0 * np.pi)) ** 2)
    assert mc.Spectrum("EC8", ag=2.0, vertical=True).at(0.1) == pytest.approx(0.9 * 2.0 * 3.0)
    assert code.longest == np.inf


def test_its_keys_make_it_again_whatever_it_came_from(tmp_path: Path) -> None:
    (tmp_path / "site.csv").write_text("period [s],5 % [g],10 % [g]\n0.1,0.5,0.4\n2,0.1,0.08\n")
    period = np.linspace(0.0, 2.0, 9)
    arrays = mc.Spectrum("table", table={"period": period, "acceleration": 3.0 - period})
    for one in (mc.Spectrum.read(tmp_path / "site.csv", ag="0.2 g"), arrays, mc.Spectrum("NZS1170", hazard_factor=0.3, ground="D")):
        again = mc.Spectrum(**one.keys)
        assert np.array_equal(again.at(period, 0.07), one.at(period, 0.07))
        assert again.keys == one.keys and str(again) == str(one)
    assert arrays.longest == 2.0


def test_its_picture_has_both_panels() -> None:
    figure = mc.Spectrum("EC8", ag=2.0).plot([0.05, 0.1])
    assert [len(axes.lines) for axes in figure.axes] == [2, 2]


def test_what_does_not_apply_is_refused(tmp_path: Path) -> None:
    table = mc.Spectrum("table", table={"period": [0, 1], "acceleration": [2, 1]})
    for place, call in {
        "spectrum: ag": lambda: mc.Spectrum("EC8"),
        "damping": lambda: table.at(0.5, damping=0.0),
        "spectrum: f0": lambda: mc.Spectrum("EC8", ag=2.0, f0=2.5),
        "spectrum.spectrum": lambda: mc.Spectrum("IBC"),
        "spectrum: vertical": lambda: mc.Spectrum("NZS1170", hazard_factor=0.3, vertical=True),
        "spectrum.table.path: none.csv": lambda: mc.Spectrum.read("none.csv"),
        "period": lambda: table.at([-1.0]),
        "table": lambda: table.displacement(2.0),
    }.items():
        with pytest.raises(mc.InputError) as refused:
            call()
        assert str(refused.value).startswith(place)
