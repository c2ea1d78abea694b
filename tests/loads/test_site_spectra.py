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
from loads.signal.spectra.shape import ElasticSpectrum
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
