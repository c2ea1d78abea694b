# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.readers: each format read from a file made here; content decides, not the file's name; what is wrong is named with its line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from records import STEP, TIME, WAVE, at2, columns, esm, table

from loads.motion import STANDARD_GRAVITY as G
from loads.readers import RawRecord, Request, Source, read
from loads.readers.units import acceleration_unit, split_heading


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


@pytest.mark.parametrize(
    ("text", "size"),
    [
        *((unit, G) for unit in ("g", "G")), ("mg", 1e-3 * G), ("G/10", 0.1 * G), ("%g", 0.01 * G), ("g%", 0.01 * G), ("in/sec2", 0.0254),
        *((unit, 1.0) for unit in ("m/s2", "M/S^2", "m/s**2", "m/s/s", "m s-2")), ("mm/s2", 0.001),
        *((unit, 0.01) for unit in ("cm/s2", "cm/sec^2", "cm/s²", "Gal", "cm/s/s", "cm/seg2", "cm/sec/sec")),
        *((unit, None) for unit in ("yd/s2", "m/s", "count", "Gallons")),
    ],
)  # fmt: skip
def test_units(text: str, size: float | None) -> None:
    assert acceleration_unit(text) == (None if size is None else pytest.approx(size))


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
