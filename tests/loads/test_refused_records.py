# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with a record file is one line that names the file, and the line of it that is at fault."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import record_files as files
from records import STEP, TIME, WAVE, at2, columns, esm, knet, side_by_side, table, wrapped

from loads.readers import Request, Source, read
from masonry_cd.foundation.errors import InputError


def with_line(text: str, number: int, line: str) -> str:
    lines = text.splitlines()
    return "\n".join([*lines[: number - 1], line, *lines[number:]])


def cut(text: str, lines: int) -> str:
    return "\n".join(text.splitlines()[:lines])


UNEVEN, STOPPED = np.concatenate([TIME[:20], TIME[20:] + 0.01]), np.concatenate([TIME[:20], [TIME[19]], TIME[21:]])
NS, SERIES, PAIRS = {"column": "ns"}, {"layout": "series", "time_step": STEP}, {"layout": "pairs"}
FILM = files.volume("FILE     1 OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME I:", "COMP  UP          9")
ANNOUNCED = files.announced() + "\n".join(f"{v:.6f}" for v in files.WAVE) + "\n"
BAD: list[tuple[str | bytes, dict[str, Any], str]] = [
    (with_line(at2(), 6, " 0.1 abc 0.2"), {}, ', line 6: "abc" where a number belongs'),
    (with_line(at2(), 6, " 0.1 nan 0.2"), {}, ", line 6: nan is not a finite number"),
    (at2(step="0.0"), {}, ", line 4: the time step DT must be above zero"),
    (at2(step="-.02"), {}, ", line 4: the time step DT must be above zero"),
    (at2(count="many"), {}, ', line 4: "many" where a number belongs'),
    (at2(count="45"), {}, ", line 4: the header announces 45 values, the file holds 40: cut short"),
    (at2(count="35"), {}, ", line 4: the header announces 35 values, the file holds 40: longer than it says"),
    (at2(count="1e300"), {}, ", line 4: NPTS must be a whole number above one"),
    *[(at2(), {key: value}, f": the key {key} does not apply to files of format") for key, value in (NS | SERIES).items()],
    *[(text, {"calibration": 0.1}, ": the key calibration does not apply") for text in (knet(), files.csmip2(), "0.00 1\n0.01 2\n")],
    (files.csmip2(), {"time_step": 0.01}, ": the key time_step does not apply"),
    (esm(NDATA="41"), {}, ", line 3: the header announces 41 values, the file holds 40: cut short"),
    (esm(NDATA="1e308"), {}, ", line 3: the header announces 1e+308 values"),
    (esm(SAMPLING_INTERVAL_S="0"), {}, ", line 2: SAMPLING_INTERVAL_S must be above zero"),
    (esm(DATA_TYPE="SA"), {}, ", line 6: a record of sa, where one of acceleration is needed"),
    (with_line(esm(), 12, "0.1O"), {}, ', line 12: "0.1O" where a number belongs'),
    (table(), {}, ": several components; say which by the key column; columns: ns_m_s2, up_m_s2"),
    (table(), {"column": "we"}, ': no column "we"'),
    (table(), {"column": "ns_m_s"}, ': no column "ns_m_s" (did you mean "ns_m_s2"?); columns: ns_m_s2, up_m_s2'),
    (table(), {"column": 0}, ": column 0 is the time; columns: ns_m_s2, up_m_s2"),
    (table(), {"column": 7}, ": column 7 is not there"),
    (table(), NS | {"time_step": 0.01}, ': the key time_step is given, but the file has a column "time_s"'),
    (table("time_s,ns_m_s2,ns_m_s2"), NS, ': several columns are called "ns"'),
    (table("when,ns_m_s2,up_m_s2"), NS, ": no time column; give the key time_step"),
    (table("time_h,ns_m_s2,up_m_s2"), NS, ': the time column "time_h" is in no known unit'),
    (table("time [min],ns_m_s2,up_m_s2"), NS, ': the time column "time [min]" is in no known unit'),
    (with_line(table(), 9, "noise"), {"column": 2}, ', line 9: "noise" where a number belongs'),
    (with_line(table(), 9, "0.07,,0.1"), NS, ', line 9: "" where a number belongs'),
    (with_line(table(), 9, "0.07,0.5"), NS, ", line 9: 2 columns, where the table has 3"),
    (with_line(table(), 2, "0.00,none,0.1"), NS, ', line 2: "none" where a number belongs'),
    (with_line(table(), 9, "0.07,1e999,0"), NS, ", line 9: 1e999 is not a finite number"),
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
    (wrapped(WAVE, 8), {"layout": "series"}, ": no times in the series; give the key time_step"),
    (wrapped(WAVE, 8), SERIES | {"column": 0}, ": the key column does not apply to layout"),
    (wrapped(WAVE, 8).replace("\n", "\n0.1 abc\n", 1), SERIES, ', line 2: "abc" where a number belongs'),
    (wrapped(WAVE, 8).partition("  ")[2], SERIES, ", line 2: 8 values, where the first line has 7"),
    (wrapped(WAVE, 8), PAIRS, ": the times of the pairs do not advance evenly"),
    (wrapped(WAVE, 3), PAIRS, ", line 1: an odd number of values"),
    (
        side_by_side(TIME[::2], WAVE[::2], TIME[1::2], WAVE[1::2]),
        PAIRS | {"time_step": STEP},
        ": the key time_step is given, but the pairs",
    ),
    (knet(**{"Duration Time(s)": "0.5"}), {}, ", line 5: the header announces 50 values, the file holds 40: cut short"),
    (knet(**{"Duration Time(s)": "inf"}), {}, ", line 5: inf is not a finite number"),
    (knet(**{"Duration Time(s)": None}), {}, ": no line Duration Time(s) in the heading of a K-NET file"),
    (knet(**{"Sampling Freq(Hz)": "1e300Hz"}), {}, ", line 4: the sampling frequency must be above zero and at most 1e+06 Hz, got 1e300Hz"),
    (knet(**{"Sampling Freq(Hz)": "0Hz"}), {}, ", line 4: the sampling frequency must be above zero and at most 1e+06 Hz, got 0Hz"),
    (knet(**{"Scale Factor": "2000/8388608"}), {}, ", line 7: a scale factor such as 2000(gal)/8388608 is needed"),
    (knet(**{"Scale Factor": "2000(gal)/0"}), {}, ", line 7: the scale factor must be above zero"),
    (knet().replace("     -500", "      nan", 1), {}, ", line 10: nan is not a finite number"),
    (knet().replace("     -500", "     -5OO", 1), {}, ', line 10: "-5OO" where a number belongs'),
    (files.cosmos(unit="g"), {}, 'units "g", but integer-header value 3 is that of cm/s2'),
    (files.cosmos(kind=2), {}, "a series of acceleration, but integer-header value 2 is that of velocity"),
    (cut(files.cosmos(), 50), {}, "cut short"),
    (files.cosmos() + files.cosmos(), {"column": "340"}, 'several channels are called "340"; give the place of one'),
    (files.cosmos() + files.cosmos(azimuth=70), {}, "several channels; say which by the key column; channels: 340, 70"),
    (files.csmip2(), {"column": "90"}, 'no channel "90"; channels: 360'),
    (cut(files.csmip2(), 50), {}, "cut short"),
    (files.csmip2().replace(f"{files.COUNT} points of accel", "90 points of accel"), {}, "more follow: longer than it says"),
    (cut(files.geonet(), 30), {"column": 0}, "cut short"),
    (cut(files.smc(), 35), {}, "cut short"),
    (files.afad().replace(f": {files.COUNT}", ": 99"), {"column": 0}, "the header announces 99 values, the file holds 103"),
    (files.unam().replace("N00E/N90E", "N00E"), {"column": 1}, "3 columns, where the table has 2"),
    (files.cwb(100), {"column": 0}, "100 samples a second, but the times are 0.005 s apart: correct the file"),
    (files.sac(count=50), {}, "the header announces 50 values, the file holds 103: longer than it says"),
    (files.sac()[:-40], {}, "the header announces 103 values, the file holds 93: cut short"),
    (files.sac(scale=2.0), {}, "SCALE is 2 in its header, which programs apply or not; the key calibration"),
    (FILM.replace("  0.010", "  0.001", 1), {}, "the time does not advance"),
    (ANNOUNCED.replace(f", {files.COUNT} ", f", {files.COUNT + 1} "), {}, f", line 1: the header announces {files.COUNT + 1} values"),
    (ANNOUNCED.replace("0.", "O.", 1), {}, "where a number belongs"),
    (ANNOUNCED.replace("200 sps", "0 sps"), {}, ", line 1: 0 samples a second"),
    (ANNOUNCED.replace("SLIST", "SLIT"), {}, ", line 1: a line such as TIMESERIES"),
    (ANNOUNCED.replace(files.START, "yesterday"), {}, ', line 1: "yesterday" where a time'),
    (files.tspair(step=0.01), {}, ", line 3: 2021-03-04T05:06:07.010000 is not the time of sample 2"),
    (ANNOUNCED.replace("SLIST", "TSPAIR"), {}, ", line 2: a time and a sample belong on a line"),
]


@pytest.mark.parametrize(("content", "request_", "message"), BAD, ids=[f"{k}-{row[2][:40]}" for k, row in enumerate(BAD)])
def test_it_is_one_line_that_names_file_and_line(tmp_path: Path, content: str | bytes, request_: dict[str, Any], message: str) -> None:
    file = tmp_path / "quake.dat"
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(InputError) as failure:
        read(Source.open(file, "loads[0].path: quake.dat"), "auto", Request(**request_))
    assert str(failure.value).startswith("loads[0].path: quake.dat")
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
