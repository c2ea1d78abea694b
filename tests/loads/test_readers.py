# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.readers: each format read from a file made here; content decides, not the file's name; what is wrong is named with its line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from records import STEP, TIME, WAVE, at2, columns, esm, table

from loads.readers import RawRecord, Request, Source, read
from loads.readers.units import acceleration_unit, split_heading
from masonry_cd.foundation.errors import InputError


def load(tmp_path: Path, text: str, name: str = "auto", **request: object) -> tuple[str, RawRecord]:
    file = tmp_path / "quake.dat"
    file.write_text(text)
    return read(Source.open(file, "loads[0].path: quake.dat"), name, Request(**request))


@pytest.mark.parametrize(
    ("text", "request_", "format_", "unit"),
    [
        (at2(), {}, "at2", "G"),
        (at2().replace("NPTS=  40, DT=   .01 SEC", "  40   .0100   NPTS, DT"), {}, "at2", "G"),
        (at2().replace(".01 SEC", ".01SEC,"), {}, "at2", "G"),
        (esm(), {}, "esm", "cm/s^2"),
        (table(), {"column": "ns"}, "csv", "m_s2"),
        (table(), {"column": "NS_m_s2"}, "csv", "m_s2"),
        (table(), {"column": 1}, "csv", "m_s2"),
        (table('"Time (s)";"NS [gal]";"UP [gal]"', ";").replace(".", ","), {"column": "ns"}, "csv", "gal"),
        (table("t\tNS (cm/s2)\tUP (cm/s2)", "\t"), {"column": "NS"}, "csv", "cm/s2"),
        (table(""), {"column": 1}, "csv", None),
        (columns(), {}, "columns", None),
        (columns("% a quake\n# time [s]  acc [g]\n\n"), {}, "columns", "g"),
        (columns("time_ms acc_gal\n", 1000 * TIME), {}, "columns", "gal"),
        ("".join(f"{v}\n" for v in WAVE), {"time_step": STEP}, "columns", None),
        ("acc_g\n" + "".join(f"{v}\n" for v in WAVE), {"time_step": STEP}, "columns", "g"),
    ],
)
def test_formats_are_recognised_by_content_and_read(tmp_path: Path, text: str, request_: dict, format_: str, unit: str | None) -> None:
    found, record = load(tmp_path, text, **request_)
    assert found == format_
    assert record.values == pytest.approx(WAVE, abs=1e-6)
    assert record.step == pytest.approx(STEP)
    assert record.unit == unit
    assert load(tmp_path, text, format_, **request_)[1].values == pytest.approx(record.values)


def test_a_time_column_that_starts_late_is_kept_as_the_record_s_own_time(tmp_path: Path) -> None:
    assert load(tmp_path, columns(time=TIME + 30.0))[1].origin == pytest.approx(30.0)


def test_times_written_with_few_digits_are_even(tmp_path: Path) -> None:
    _, record = load(tmp_path, columns(time=np.round(np.arange(40) / 128.0, 3)))
    assert record.step == pytest.approx(1.0 / 128.0, rel=2e-3)


def replace_line(text: str, number: int, line: str) -> str:
    lines = text.splitlines()
    lines[number - 1] = line
    return "\n".join(lines)


UNEVEN = np.concatenate([TIME[:20], TIME[20:] + 0.01])
STOPPED = np.concatenate([TIME[:20], [TIME[19]], TIME[21:]])


@pytest.mark.parametrize(
    ("text", "request_", "message"),
    [
        (replace_line(at2(), 6, " 0.1 abc 0.2"), {}, ', line 6: "abc" where a number belongs'),
        (replace_line(at2(), 6, " 0.1 nan 0.2"), {}, ", line 6: nan is not a finite number"),
        (at2(step="0.0"), {}, ", line 4: the time step DT must be above zero, got 0"),
        (at2(step="-.02"), {}, ", line 4: the time step DT must be above zero, got -0.02"),
        (at2(count="many"), {}, ', line 4: "many" where a number belongs'),
        (at2(count="45"), {}, ", line 4: the header announces 45 values, the file holds 40: cut short"),
        (at2(count="35"), {}, ", line 4: the header announces 35 values, the file holds 40: longer than it says"),
        (at2(), {"column": "ns"}, ": the key column does not apply to AT2 files"),
        (at2(), {"time_step": 0.01}, ": the key time_step does not apply to AT2 files"),
        (esm(NDATA="41"), {}, ", line 3: the header announces 41 values, the file holds 40: cut short"),
        (esm(SAMPLING_INTERVAL_S="0"), {}, ", line 2: the time step SAMPLING_INTERVAL_S must be above zero, got 0"),
        (esm(DATA_TYPE="SA"), {}, ", line 6: a record of sa, where one of acceleration is needed"),
        (esm(NDATA="1e308"), {}, ", line 3: the header announces 1e+308 values, the file holds 40: cut short"),
        (at2(count="1e300"), {}, ", line 4: the header announces 1e+300 values"),
        (at2(), {"layout": "series"}, ": the key layout does not apply to AT2 files"),
        (replace_line(esm(), 12, "0.1O"), {}, ', line 12: "0.1O" where a number belongs'),
        (table(), {}, ": several components; say which by the key column; columns: ns_m_s2, up_m_s2"),
        (table(), {"column": "we"}, ': no column "we"'),
        (table(), {"column": "ns_m_s"}, ': no column "ns_m_s" (did you mean "ns_m_s2"?); columns: ns_m_s2, up_m_s2'),
        (table(), {"column": 0}, ": column 0 is the time; columns: ns_m_s2, up_m_s2"),
        (table(), {"column": 7}, ": column 7 is not there"),
        (table(), {"column": "ns", "time_step": 0.01}, ': the key time_step is given, but the file has a column "time_s"'),
        (replace_line(table(), 9, "noise"), {"column": 2}, ', line 9: "noise" where a number belongs'),
        (table("time_s,ns_m_s2,ns_m_s2"), {"column": "ns"}, ': several columns are called "ns"; give the place of one'),
        (table("when,ns_m_s2,up_m_s2"), {"column": "ns"}, ": no time column; give the key time_step, in seconds"),
        (table("time_h,ns_m_s2,up_m_s2"), {"column": "ns"}, ': the time column "time_h" is in no known unit; known: s, sec'),
        (table("time [min],ns_m_s2,up_m_s2"), {"column": "ns"}, ': the time column "time [min]" is in no known unit'),
        (replace_line(table(), 9, "0.07,,0.1"), {"column": "ns"}, ', line 9: "" where a number belongs'),
        (replace_line(table(), 9, "0.07,0.5"), {"column": "ns"}, ", line 9: 2 columns, where the table has 3"),
        (replace_line(table(), 2, "0.00,none,0.1"), {"column": "ns"}, ', line 2: "none" where a number belongs'),
        (replace_line(table(), 9, "0.07,1e999,0"), {"column": "ns"}, ", line 9: 1e999 is not a finite number"),
        (columns(time=UNEVEN), {}, ", line 22: the time step changes from 0.01 to 0.02"),
        (columns(time=STOPPED), {}, ", line 22: the time does not advance: 0.19 then 0.19"),
        (columns(time=0 * TIME), {}, ", line 3: the time does not advance: 0 then 0"),
        (columns(time=TIME[::-1]), {}, ", line 3: the time does not advance"),
        (columns(time=TIME + 0.1 * TIME**2), {}, ": the time step is not constant"),
        ("".join(f"{v}\n" for v in WAVE), {}, ": no time column; give the key time_step"),
        ("time,acc\n", {}, ": not recognised as one of afad, at2, bhrc, columns"),
        ("A letter\nfrom the station\n", {}, ": not recognised"),
        ("0.0 0.1\n", {}, ": 1 rows of numbers are no record"),
        ("\n  \n", {}, ": the file is empty"),
        ("", {}, ": the file is empty"),
    ],
)
def test_bad_files_are_named_with_their_line(tmp_path: Path, text: str, request_: dict, message: str) -> None:
    with pytest.raises(InputError) as failure:
        load(tmp_path, text, **request_)
    assert "loads[0].path: quake.dat" in str(failure.value)
    assert message in str(failure.value)
    assert "\n" not in str(failure.value)


def test_missing_and_binary_files_are_named(tmp_path: Path) -> None:
    (tmp_path / "quake.at2").write_bytes(b"CDF\0\1\2")
    with pytest.raises(InputError, match=r'p: no such file \(did you mean "quake.at2"\?\)'):
        Source.open(tmp_path / "quakes.at2", "p")
    with pytest.raises(InputError, match="p: not a text file"):
        read(Source.open(tmp_path / "quake.at2", "p"), "auto", Request())
    with pytest.raises(InputError, match="p: is a folder"):
        Source.open(tmp_path, "p")


@pytest.mark.parametrize(
    ("text", "size"),
    [("g", 9.80665), ("G", 9.80665), ("m/s2", 1.0), ("M/S^2", 1.0), ("m/s**2", 1.0), ("m/s/s", 1.0), ("m s-2", 1.0), ("cm/s2", 0.01)]
    + [
        ("cm/sec^2", 0.01),
        ("cm/s²", 0.01),
        ("Gal", 0.01),
        ("mm/s2", 0.001),
        ("yd/s2", None),
        ("m/s", None),
        ("count", None),
        ("mg", 9.80665e-3),
    ],
)
def test_units(text: str, size: float | None) -> None:
    assert acceleration_unit(text) == size


@pytest.mark.parametrize(
    ("heading", "name", "unit"),
    [
        ("ns_m_s2", "ns", "m_s2"),
        ("acc [g]", "acc", "g"),
        ("NS(cm/s2)", "NS", "cm/s2"),
        ("time_s", "time", "s"),
        ("t", "t", None),
        ("vel_cm_s", "vel", "cm_s"),
        ("NS, cm/s", "NS", "cm/s"),
        ("disp_m", "disp", "m"),
        ("sensor g", "sensor g", None),
        ("mean", "mean", None),
    ],
)
def test_headings(heading: str, name: str, unit: str | None) -> None:
    assert split_heading(heading) == (name, unit)


def test_exponents_of_fortran_are_numbers(tmp_path: Path) -> None:
    _, plain = load(tmp_path, at2())
    _, double = load(tmp_path, re.sub(r"(\.\d+)E([+-])", r"\1D\2", at2()))
    assert np.array_equal(double.values, plain.values) and double.step == plain.step


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig"])
def test_texts_of_spreadsheets_are_read_by_their_mark(tmp_path: Path, encoding: str) -> None:
    text = "time [s]\tacc [g]\n" + "".join(f"{t:.3f}\t{a:.6f}\n" for t, a in zip(TIME, WAVE, strict=True))
    (tmp_path / "record").write_bytes(text.encode(encoding))
    _, record = read(Source.open(tmp_path / "record", "path"), "auto", Request())
    assert record.values == pytest.approx(WAVE, abs=1e-6) and record.step == pytest.approx(STEP)
