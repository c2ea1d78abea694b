# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of measured modes, the MAC, and the pairing with computed modes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hostile import refusal
from models import box, tower

from masonry_cd.analysis.modal.measured_modes import fit_factor, mac, pair, read_measured
from masonry_cd.analysis.modal.modes import Modes, modal
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block

SHAPED = """\
# ambient vibration test
mode,frequency_hz,point,x_mm,y_mm,z_mm,ux,uz
1,4.0,top,0,0,2000,1.0,0.1
1,,middle,0,0,1000,0.4,
2, 9.5 ,top,0,0,2000,,1.0
"""


@pytest.fixture(scope="module")
def modes() -> Modes:
    """Eight blocks on a rectangular footprint, so that no two frequencies coincide."""
    blocks: list[Block] = [tower(1)[0]]
    blocks += [box(f"b{k}", (-0.3, -0.2, k * 0.25), (0.3, 0.2, (k + 1) * 0.25)) for k in range(8)]
    return modal(blocks, 2e9, method="joints", modes=6)


def written(folder: Path, text: str) -> Path:
    path = folder / "measured.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_shapes_units_and_gaps_are_read(tmp_path: Path) -> None:
    first, second = read_measured(written(tmp_path, SHAPED))
    assert (first.mode, first.frequency, second.mode, second.frequency) == (1, 4.0, 2, 9.5)
    assert first.points == pytest.approx(np.array([[0.0, 0.0, 2.0], [0.0, 0.0, 1.0]]))
    assert np.array_equal(np.isnan(first.shape), [[False, True, False], [False, True, True]])
    assert second.has_shape and second.shape[0, 2] == 1.0


def test_periods_and_bare_frequencies(tmp_path: Path) -> None:
    modes = read_measured(written(tmp_path, "mode,period_s\n2,0.1\n1,0.25\n"))
    assert [(m.mode, m.frequency) for m in modes] == [(1, 4.0), (2, pytest.approx(10.0))]
    assert not modes[0].has_shape


def test_mac_is_blind_to_sign_and_scale_and_to_what_was_not_measured() -> None:
    a = np.array([1.0, 2.0, -1.0, 0.5])
    assert mac(a, -3.0 * a) == pytest.approx(1.0)
    assert mac(np.array([1.0, 0.0]), np.array([0.0, 2.0])) == 0.0
    assert mac(np.array([1.0, 1.0]), np.array([1.0, 0.0])) == pytest.approx(0.5)
    assert mac(np.array([1.0, np.nan]), np.array([7.0, 5.0])) == pytest.approx(1.0)


def test_measured_modes_find_the_computed_ones_that_they_resemble(modes: Modes, tmp_path: Path) -> None:
    """The computed modes, written in another order and with a few per cent of noise."""
    noise = np.random.default_rng(0)
    moving = np.flatnonzero(np.abs(modes.shapes).max(axis=(1, 2)) > 0.1)  # torsion does not move the centroids
    order = moving[[2, 0, 1]].tolist()
    lines = ["mode,frequency_hz,x_m,y_m,z_m,ux,uy,uz"]
    for number, k in enumerate(order, start=1):
        for point, shape in zip(modes.points, modes.shapes[k], strict=True):
            moved = -2.0 * shape + 0.03 * noise.standard_normal(3)
            lines.append(",".join(map(str, [number, 1.1 * modes.frequencies[k], *point, *moved])))
    pairs = pair(modes, read_measured(written(tmp_path, "\n".join(lines))))
    assert [p.mode for p in pairs] == [k + 1 for k in order]
    assert min(p.mac for p in pairs) > 0.99
    assert [p.error_percent for p in pairs] == pytest.approx([100 * (1 / 1.1 - 1)] * 3)


def test_fit_meets_the_first_measured_frequency(modes: Modes, tmp_path: Path) -> None:
    measured = read_measured(written(tmp_path, f"mode,frequency_hz\n1,{1.3 * modes.frequencies[0]}\n"))
    factor = fit_factor(modes, measured)
    assert factor == pytest.approx(1.69)
    assert pair(modes.scaled(factor), measured)[0].error_percent == pytest.approx(0.0, abs=1e-9)


def test_more_modes_measured_than_computed(modes: Modes, tmp_path: Path) -> None:
    pairs = pair(modes, read_measured(written(tmp_path, "mode,frequency_hz\n1,4\n50,900\n")))
    assert pairs[0].mode == 1
    assert pairs[1].mode is None


def test_a_point_far_from_the_structure_is_an_error(modes: Modes, tmp_path: Path) -> None:
    text = "mode,frequency_hz,x_m,y_m,z_m,ux\n1,4.0,0,0,2000,1.0\n"
    with pytest.raises(InputError, match=r"measured.csv:2: the point \(0, 0, 2000\) m lies 2e\+03 m outside the structure"):
        pair(modes, read_measured(written(tmp_path, text)))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mode,frequency\n1,4\n", 'column "frequency" has no unit; write frequency_hz'),
        ("mode,frequency_hz,x,y,z,ux\n1,4,0,0,0,1\n", 'column "x" has no unit; write x_m'),
        ("mode,frequenzy_hz\n1,4\n", 'unknown column "frequenzy_hz" \\(did you mean "frequency_hz"'),
        ("mode,frequency_hz,damping\n1,4,2\n", 'unknown column "damping"; known: mode, frequency_hz'),
        ("frequency_hz\n4\n", "column mode: missing"),
        ("mode\n1\n", "should have one of the columns frequency_hz and period_s"),
        ("mode,frequency_hz,mode\n1,4,1\n", 'column "mode" occurs twice'),
        ("mode,frequency_hz,x_m,y_m,ux\n1,4,0,0,1\n", "a shape needs the columns x_m, y_m, z_m"),
        ("mode,frequency_hz\n1,four\n", 'measured.csv:2: frequency_hz: should be a number, got "four"'),
        ("mode,frequency_hz\n1,4\n2,-1\n", "measured.csv:3: frequency_hz: must be above 0"),
        ("mode,frequency_hz\nfirst,4\n", 'measured.csv:2: mode: should be a number from 1, got "first"'),
        ("mode,frequency_hz\n1,4\n1,5\n", "measured.csv:3: frequency_hz: mode 1 has another one before, 5"),
        ("mode,frequency_hz,x_m,y_m,z_m,ux\n1,,0,0,0,1\n", "measured.csv:2: mode 1 has no frequency"),
        ("mode,frequency_hz\n1,4,7\n", "measured.csv:2: 3 values under 2 columns"),
        ("# nothing\n", "holds no modes"),
    ],
)
def test_bad_files_are_reported_in_one_line(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message) as caught:
        read_measured(written(tmp_path, text))
    assert "\n" not in str(caught.value)
    assert "measured.csv" in str(caught.value)


def test_no_such_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none.csv: cannot be read"):
        read_measured(tmp_path / "none.csv")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("mode,frequency_hz\n²,4\n", ':2: mode: should be a number from 1, got "²"'),
        (f"mode,frequency_hz\n{'1' * 5000},4\n", ":2: mode: should be a number from 1, got "),
        (f"mode,frequency_hz\n1,{'4' * 140_000}\n", ":2: no line of a table: field larger than field limit (131072)"),
        ("mode,period_s\n1,5e-324\n", ":2: period_s: a frequency between 1e-06 and 1e+09 Hz is needed, got 4.94066e-324"),
        ("mode,frequency_hz\n1,1e308\n", ":2: frequency_hz: a frequency between 1e-06 and 1e+09 Hz is needed, got 1e+308"),
    ],
)
def test_numbers_that_no_mode_has(tmp_path: Path, text: str, message: str) -> None:
    path = written(tmp_path, text)
    assert (refusal(tmp_path, lambda: read_measured(path)) or "").startswith(f"{path.name}{message}")


def test_components_of_any_size_resemble_alike() -> None:
    shape = np.array([[1.0, np.nan, 0.5], [0.2, 0.1, -0.3]])
    for size in (1e308, 1e-300, -1e200):
        assert mac(size * shape, shape) == pytest.approx(1.0)
    assert mac(0.0 * shape, shape) == 0.0
