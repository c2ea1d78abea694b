# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults of record files are one line each that names the file, and the line of it that is at fault."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import record_files as files
from records import STEP, TIME, WAVE, at2, columns, esm, knet, table, wrapped

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
BAD: list[tuple[str | bytes, dict[str, Any], int | str]] = [  # file, keys, and the line, or the key, column or channel that is named
    (with_line(at2(), 6, " 0.1 abc 0.2"), {}, 6),
    (with_line(at2(), 6, " 0.1 nan 0.2"), {}, 6),
    (at2(step="0.0"), {}, 4),
    (at2(step="-.02"), {}, 4),
    (at2(count="many"), {}, 4),
    (at2(count="45"), {}, 4),
    (at2(count="35"), {}, 4),
    (at2(count="1e300"), {}, 4),
    *[(at2(), {key: value}, key) for key, value in (NS | SERIES).items()],
    *[(text, {"calibration": 0.1}, "calibration") for text in (knet(), files.csmip2(), "0.00 1\n0.01 2\n")],
    (files.csmip2(), {"time_step": 0.01}, "time_step"),
    (esm(NDATA="41"), {}, 3),
    (esm(NDATA="1e308"), {}, 3),
    (esm(SAMPLING_INTERVAL_S="0"), {}, 2),
    (esm(DATA_TYPE="SA"), {}, 6),
    (with_line(esm(), 12, "0.1O"), {}, 12),
    (table(), {}, "column"),
    (table(), {"column": "we"}, "we"),
    (table(), {"column": "ns_m_s"}, "ns_m_s"),
    (table(), {"column": 0}, "column 0"),
    (table(), {"column": 7}, "column 7"),
    (table("time_s,ns_m_s2,ns_m_s2"), NS, "ns"),
    (table("when,ns_m_s2,up_m_s2"), NS, "time_step"),
    (table("time_h,ns_m_s2,up_m_s2"), NS, "time_h"),
    (table("time [min],ns_m_s2,up_m_s2"), NS, "time [min]"),
    (with_line(table(), 9, "noise"), {"column": 2}, 9),
    (with_line(table(), 9, "0.07,,0.1"), NS, 9),
    (with_line(table(), 9, "0.07,0.5"), NS, 9),
    (with_line(table(), 2, "0.00,none,0.1"), NS, 2),
    (with_line(table(), 9, "0.07,1e999,0"), NS, 9),
    (columns(time=UNEVEN), {}, 22),
    (columns(time=STOPPED), {}, 22),
    (columns(time=0 * TIME), {}, 3),
    (columns(time=TIME[::-1]), {}, 3),
    (columns(time=TIME + 0.1 * TIME**2), {}, 21),
    ("".join(f"{v}\n" for v in WAVE), {}, "time_step"),
    ("time,acc\n", {}, "format"),
    ("A letter\nfrom the station\n", {}, "format"),
    ("0.0 0.1\n", {}, ""),
    ("\n  \n", {}, ""),
    ("", {}, ""),
    (wrapped(WAVE, 8), {"layout": "series"}, "time_step"),
    (wrapped(WAVE, 8), SERIES | {"column": 0}, "column"),
    (wrapped(WAVE, 8).replace("\n", "\n0.1 abc\n", 1), SERIES, 2),
    (wrapped(WAVE, 8).partition("  ")[2], SERIES, 2),
    (wrapped(WAVE, 8), PAIRS, ""),
    (wrapped(WAVE, 3), PAIRS, 1),
    (knet(**{"Duration Time(s)": "0.5"}), {}, 5),
    (knet(**{"Duration Time(s)": "inf"}), {}, 5),
    (knet(**{"Duration Time(s)": None}), {}, "Duration Time(s)"),
    (knet(**{"Sampling Freq(Hz)": "1e300Hz"}), {}, 4),
    (knet(**{"Sampling Freq(Hz)": "0Hz"}), {}, 4),
    (knet(**{"Scale Factor": "2000/8388608"}), {}, 7),
    (knet(**{"Scale Factor": "2000(gal)/0"}), {}, 7),
    (knet().replace("     -500", "      nan", 1), {}, 10),
    (knet().replace("     -500", "     -5OO", 1), {}, 10),
    (files.cosmos(unit="g"), {}, 45),
    (files.cosmos(kind=2), {}, 45),
    (cut(files.cosmos(), 50), {}, 45),
    (files.cosmos() + files.cosmos(), {"column": "340"}, "340"),
    (files.cosmos() + files.cosmos(azimuth=70), {}, "column"),
    (files.csmip2(), {"column": "90"}, "90"),
    (cut(files.csmip2(), 50), {}, 46),
    (files.csmip2().replace(f"{files.COUNT} points of accel", "90 points of accel"), {}, 58),
    (cut(files.geonet(), 30), {"column": 0}, 26),
    (cut(files.smc(), 35), {}, 29),
    (files.afad().replace(f": {files.COUNT}", ": 99"), {"column": 0}, 4),
    (files.unam().replace("N00E/N90E", "N00E"), {"column": 1}, 12),
    (files.cwb(100), {"column": 0}, 3),
    (files.sac(count=50), {}, ""),
    (files.sac()[:-40], {}, ""),
    (files.sac(scale=2.0), {}, "calibration"),
    (FILM.replace("  0.010", "  0.001", 1), {}, 28),
    (ANNOUNCED.replace(f", {files.COUNT} ", f", {files.COUNT + 1} "), {}, 1),
    (ANNOUNCED.replace("0.", "O.", 1), {}, 2),
    (ANNOUNCED.replace("200 sps", "0 sps"), {}, 1),
    (ANNOUNCED.replace("SLIST", "SLIT"), {}, 1),
    (ANNOUNCED.replace(files.START, "yesterday"), {}, 1),
    (files.tspair(step=0.01), {}, 3),
    (ANNOUNCED.replace("SLIST", "TSPAIR"), {}, 2),
]


@pytest.mark.parametrize(("content", "request_", "named"), BAD, ids=[f"{k}-{row[2]}" for k, row in enumerate(BAD)])
def test_it_is_one_line_that_names_file_and_line(tmp_path: Path, content: str | bytes, request_: dict[str, Any], named: int | str) -> None:
    file = tmp_path / "quake.dat"
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(InputError) as failure:
        read(Source.open(file, "loads[0].path: quake.dat"), "auto", Request(**request_))
    (fault,) = failure.value.faults
    assert fault.place.startswith("loads[0].path: quake.dat") and "\n" not in str(fault)
    if isinstance(named, int):
        assert fault.place.endswith(f", line {named}")
    else:
        assert named in fault.text


@pytest.mark.parametrize(("name", "place"), [("quakes.at2", "p"), ("quake.at2", "p"), ("", "p")])
def test_missing_and_binary_files_and_folders_are_named(tmp_path: Path, name: str, place: str) -> None:
    (tmp_path / "quake.at2").write_bytes(b"CDF\0\1\2")
    with pytest.raises(InputError) as failure:
        read(Source.open(tmp_path / name, place), "auto", Request())
    assert failure.value.place == place
