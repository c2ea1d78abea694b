# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables that could be read in two ways are refused until the key layout decides; what can only be columns is read as columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from records import side_by_side, wrapped

from loads.readers import RawRecord, Request, Source, read
from loads.readers.wrapped import in_reading_order
from masonry_cd.foundation.errors import InputError

STEP = 0.01
TIME = STEP * np.arange(402)
QUAKE = np.round(np.sin(np.pi * TIME / 4.02) ** 2 * (np.sin(21.0 * TIME) + 0.4 * np.sin(47.0 * TIME + 1.0)), 6)
OTHER = np.round(np.sin(np.pi * TIME / 4.02) ** 2 * (np.sin(26.0 * TIME + 2.0) + 0.4 * np.sin(39.0 * TIME)), 6)


def load(folder: Path, text: str, **request: object) -> RawRecord:
    (folder / "quake.txt").write_text(text)
    return read(Source.open(folder / "quake.txt", "p"), "auto", Request(**request))[1]


@pytest.mark.parametrize("width", [2, 3, 5, 8, 10])
@pytest.mark.parametrize("between", ["  ", ",", ";"])
def test_a_series_of_several_values_a_line_is_refused_and_read_on_request(tmp_path: Path, width: int, between: str) -> None:
    text = wrapped(QUAKE, width, between)
    for request in ({"column": 0, "time_step": STEP}, {"time_step": STEP}, {"column": 1}, {}):
        with pytest.raises(InputError, match=f'{width} columns that could be one series, .* the key layout decides: "series" reads'):
            load(tmp_path, text, **request)
    record = load(tmp_path, text, layout="series", time_step=STEP)
    assert record.values == pytest.approx(QUAKE, abs=1e-9)
    assert record.step == STEP


def test_a_delimiter_at_the_end_of_the_lines_or_words_above_them_hide_no_series(tmp_path: Path) -> None:
    text = wrapped(QUAKE[:400], 8, ",")
    for table in (text.replace("\n", ",\n"), "Acceleration,of,station,X,comp,NS,run,1b\n" + text):
        with pytest.raises(InputError, match="8 columns that could be one series"):
            load(tmp_path, table, column=0, time_step=STEP)


def test_numbers_at_the_end_of_lines_are_no_part_of_a_series(tmp_path: Path) -> None:
    text = "".join(f"{line} {k + 1}\n" for k, line in enumerate(wrapped(QUAKE[:400], 8).splitlines()))
    with pytest.raises(InputError, match="8 columns before the numbers of the lines that could be one series"):
        load(tmp_path, text, column=0, time_step=STEP)
    with pytest.raises(InputError, match="each line ends with its time or number"):
        load(tmp_path, text, layout="series", time_step=STEP)


def test_columns_that_are_asked_for_are_read_even_where_they_could_be_a_series(tmp_path: Path) -> None:
    record = load(tmp_path, wrapped(QUAKE[:400], 8), layout="columns", column=2, time_step=STEP)
    assert record.values == pytest.approx(QUAKE[2:400:8], abs=1e-9)


def test_text_above_a_series_is_passed_over(tmp_path: Path) -> None:
    record = load(tmp_path, "Gemona 1976 NS\n" + wrapped(QUAKE, 8, ", "), layout="series", time_step=STEP)
    assert record.values == pytest.approx(QUAKE, abs=1e-9)
    with pytest.raises(InputError, match=r'8 columns below a heading of 3; layout = "series" reads one series'):
        load(tmp_path, "Gemona 1976 NS\n" + wrapped(QUAKE, 8), time_step=STEP)


@pytest.mark.parametrize(
    "columns",
    [(QUAKE, OTHER), (QUAKE, OTHER, 0.5 * QUAKE), (QUAKE, 0.3 * OTHER), (QUAKE, QUAKE), (QUAKE, np.round(0.98 * QUAKE, 6), OTHER)],
)
def test_components_side_by_side_stay_columns(tmp_path: Path, columns: tuple[np.ndarray, ...]) -> None:
    assert load(tmp_path, side_by_side(*columns), column=1, time_step=STEP).values == pytest.approx(columns[1], abs=1e-6)
    assert load(tmp_path, side_by_side(TIME, *columns), column=1).values == pytest.approx(columns[0], abs=1e-6)


def test_a_heading_that_names_units_makes_columns(tmp_path: Path) -> None:
    text = "ns_m_s2 ew_m_s2\n" + wrapped(QUAKE, 2)
    assert load(tmp_path, text, column="ew", time_step=STEP).values == pytest.approx(QUAKE[1::2], abs=1e-9)


def test_times_at_the_head_of_lines_of_one_series_are_noticed(tmp_path: Path) -> None:
    text = side_by_side(TIME[:400:8], *(QUAKE[k:400:8] for k in range(8)))
    with pytest.raises(InputError, match="8 columns behind the times that could be one series"):
        load(tmp_path, text, column=1)
    with pytest.raises(InputError, match="each line begins with its time"):
        load(tmp_path, text, layout="series", time_step=STEP)


def pairs(width: int) -> str:
    flat = np.column_stack([TIME, QUAKE])[:400].ravel()
    return "".join("  ".join(f"{v:.6f}" for v in flat[i : i + 2 * width]) + "\n" for i in range(0, len(flat), 2 * width))


@pytest.mark.parametrize("heading", ["", "time acc time acc time acc time acc\n"])
def test_pairs_in_reading_order_are_refused_and_read_on_request(tmp_path: Path, heading: str) -> None:
    for column in (1, 3, None):
        with pytest.raises(
            InputError, match=r'pairs side by side that could be one record; the key layout decides: "pairs" reads it as one'
        ):
            load(tmp_path, heading + pairs(4), column=column)
    record = load(tmp_path, heading + pairs(4), layout="pairs")
    assert record.values == pytest.approx(QUAKE[:400], abs=1e-9)
    assert record.step == pytest.approx(STEP)


def test_pairs_that_go_down_and_on_in_the_next_columns(tmp_path: Path) -> None:
    text = side_by_side(TIME[:201], QUAKE[:201], TIME[201:], QUAKE[201:])
    with pytest.raises(InputError, match="pairs side by side"):
        load(tmp_path, text, column=1)
    assert load(tmp_path, text, layout="pairs").values == pytest.approx(QUAKE, abs=1e-9)


def test_pairs_whose_last_line_is_short(tmp_path: Path) -> None:
    flat = np.column_stack([TIME, QUAKE]).ravel()
    text = "".join("  ".join(f"{v:.6f}" for v in flat[i : i + 8]) + "\n" for i in range(0, len(flat), 8))
    assert len(load(tmp_path, text, layout="pairs").values) == 402


def test_components_with_times_of_their_own_take_the_times_beside_them(tmp_path: Path) -> None:
    text = side_by_side(TIME, QUAKE, 2.0 * TIME + 5.0, OTHER)
    other = load(tmp_path, text, column=3)
    assert (other.step, other.origin) == (pytest.approx(2 * STEP), pytest.approx(5.0))
    assert load(tmp_path, text, column=1).step == pytest.approx(STEP)
    with pytest.raises(InputError, match="column 2 is the time; columns are counted from 0: 1, 3"):
        load(tmp_path, text, column=2)
    headed = load(tmp_path, "time,ns,time,ew\n" + side_by_side(TIME, QUAKE, 2.0 * TIME, OTHER, between=","), column="ew")
    assert headed.step == pytest.approx(2 * STEP)


def test_a_time_column_is_not_taken_for_values(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the key time_step is given, but column 0 advances evenly, as times do"):
        load(tmp_path, side_by_side(TIME, QUAKE), column=0, time_step=STEP)


def test_noise_and_short_tables_show_nothing() -> None:
    rng = np.random.default_rng(3)
    assert not in_reading_order(rng.normal(size=(3, 4)))
    assert sum(in_reading_order(rng.normal(size=(400, 3))) for _ in range(20)) == 0


def test_a_message_lists_some_of_many_columns(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"28, 29, 30 \.\.\.$") as failure:
        load(tmp_path, side_by_side(TIME, *[QUAKE] * 5000), layout="columns")
    assert len(str(failure.value)) < 400
