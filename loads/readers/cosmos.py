# SPDX-License-Identifier: GPL-3.0-or-later
"""COSMOS strong-motion data format 1.20, Volumes 0 to 2 (V0 counts, V1 uncorrected, V2 corrected), of one or several channels.

Each channel has lines of text, of which the first says ``(Format v01.20 with 13 text lines)``; then, each behind a line that announces it,
integers, reals, comments and the series:

    100 Integer-header values follow on  10 lines, Format= (10I8)      2: quantity, 3: unit, 54: azimuth of the sensor
    100 Real-header values follow on  17 lines, Format= (6F13.6)       62: interval of the series [ms]
    7000  acceleration pts, approx   70 secs, units=cm/sec2(04),Format=(8F10.5)

Places are counted from 1. Source: COSMOS, "Strong-Motion Data Format", version 1.20, tables 1, 2 and 9.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from loads.readers.channels import Channel, read_channel
from loads.readers.fixed import Fields, fields_of, fixed
from loads.readers.quantity import Stated
from loads.readers.source import RawRecord, Reader, Request, Source
from loads.readers.units import measured_by

BEGIN = re.compile(r"\(format v", re.IGNORECASE)
SERIES = re.compile(r"^\s*(\d+)\s+(?:\w+\s+)?(accel|veloc|displ|count)(?:\w*|\.)\s+pts\b(.*)$", re.IGNORECASE)  # "raw accel.   pts"
HEADER = re.compile(r"^\s*(\d+)\s+(integer|real)-header values follow(.*)$", re.IGNORECASE)
WRITTEN = re.compile(r"units?\s*=\s*([^(,]+)", re.IGNORECASE)
WORDS = ("acceleration", "velocity", "displacement", "counts")
QUANTITIES = {1: "acceleration", 2: "velocity", 3: "displacement"}  # table 1
UNITS = {2: "g", 4: "cm/s2", 5: "cm/s", 6: "cm", 7: "in/s2", 8: "in/s", 9: "in", 10: "gal", 11: "mg"}  # table 2
COUNTS = 50  # of table 2
AZIMUTHS = {400: "Up", 401: "Down", 402: "Vertical", 500: "Radial", 501: "Transverse", 600: "Longitudinal", 601: "Tangential",
            700: "H1", 701: "H2"}  # table 9  # fmt: skip
QUANTITY, UNIT, AZIMUTH, INTERVAL = 1, 2, 53, 61  # places in the headers, counted from 0
USUAL = {"integer": Fields(10, 8), "real": Fields(6, 13), "series": Fields(8, 10)}


def recognises(source: Source) -> bool:
    """True when the first line gives the version of the format."""
    return bool(source.lines) and bool(BEGIN.search(source.lines[0])) and "text lines" in source.lines[0].lower()


def read(source: Source, request: Request) -> RawRecord:
    """Read one channel."""
    return read_channel(source, request, _channels(source))


def _channels(source: Source) -> list[Channel]:
    """The channels of a file that have a series."""
    found: list[Channel] = []
    headers: dict[str, np.ndarray] = {}
    for index, line in enumerate(source.lines):
        if BEGIN.search(line):
            headers = {}
        elif match := HEADER.match(line):
            kind, count = match[2].lower(), source.whole(match[1], index, "the number of values")
            headers[kind], _ = fixed(source, index + 1, count, fields_of(match[3], USUAL[kind]))
        elif match := SERIES.match(line):
            if len(headers.get("integer", ())) <= AZIMUTH or len(headers.get("real", ())) <= INTERVAL:
                raise source.error("a series without the integer and real headers of a COSMOS file", index)
            found.append(_channel(source, index, match, headers["integer"].astype(int).tolist(), float(headers["real"][INTERVAL])))
    return found


def _channel(source: Source, index: int, announced: re.Match[str], codes: Sequence[int], interval: float) -> Channel:
    """A channel by the line that announces its series, by the codes of its header, and by its interval [ms]."""
    if interval <= 0.0:
        raise source.error(f"the interval of the series, real-header value {INTERVAL + 1}, must be above zero, got {interval:g} ms", index)
    what, by = next(word for word in WORDS if word.startswith(announced[2].lower())), f"line {index + 1}"
    by_code, azimuth = QUANTITIES.get(codes[QUANTITY]), codes[AZIMUTH]
    counts = codes[UNIT] == COUNTS or what == "counts"
    if not counts and by_code not in (None, what):
        raise source.error(f"a series of {what}, but integer-header value {QUANTITY + 1} is that of {by_code}: correct the file", index)
    quantity = by_code if what == "counts" else what
    return Channel(
        name=AZIMUTHS.get(azimuth, str(azimuth) if 0 <= azimuth <= 360 else "?"),
        first=index + 1,
        points=source.whole(announced[1], index, "the number of points"),
        step=1e-3 * interval,
        unit=None if counts else _unit(source, index, announced[3], UNITS.get(codes[UNIT])),
        stated=Stated(quantity, by, firm=True) if quantity else None,
        fields=fields_of(announced[3], USUAL["series"]),
        counts=counts,
    )


def _unit(source: Source, index: int, text: str, coded: str | None) -> str | None:
    """The unit, as text and by its number, which have to agree."""
    written = WRITTEN.search(text)
    word = written[1].strip() if written else None
    if word and coded and measured_by(word) and measured_by(word) != measured_by(coded):
        raise source.error(f'units "{word}", but integer-header value {UNIT + 1} is that of {coded}: correct the file', index)
    return word or coded


FORMATS = {
    "cosmos": Reader(
        recognises,
        read,
        about="V0 (counts), V1, V2, one or several channels",
        by="COSMOS; CESMD, USGS, CGS and others",
        takes=("column", "calibration"),
    )
}
