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
from typing import NamedTuple

import numpy as np

from loads.readers.channels import Fields, fields_of, fixed, only_physical, pick, whole
from loads.readers.quantity import Stated
from loads.readers.source import RawRecord, Reader, Request, Source

BEGIN = re.compile(r"\(format v", re.IGNORECASE)
SERIES = re.compile(r"^\s*(\d+)\s+(?:\w+\s+)?(accel|veloc|displ|count)(?:\w*|\.)\s+pts\b(.*)$", re.IGNORECASE)  # "raw accel.   pts"
HEADER = re.compile(r"^\s*(\d+)\s+(integer|real)-header values follow(.*)$", re.IGNORECASE)
WRITTEN = re.compile(r"units?\s*=\s*([^(,]+)", re.IGNORECASE)
QUANTITIES = {1: "acceleration", 2: "velocity", 3: "displacement"}  # table 1
UNITS = {2: "g", 4: "cm/s2", 5: "cm/s", 6: "cm", 7: "in/s2", 8: "in/s", 9: "in", 10: "gal", 11: "mg"}  # table 2
COUNTS = 50  # of table 2
AZIMUTHS = {400: "Up", 401: "Down", 402: "Vertical", 500: "Radial", 501: "Transverse", 600: "Longitudinal", 601: "Tangential",
            700: "H1", 701: "H2"}  # table 9  # fmt: skip
QUANTITY, UNIT, AZIMUTH, INTERVAL = 1, 2, 53, 61  # places in the headers, counted from 0
USUAL = {"integer": Fields(10, 8), "real": Fields(6, 13), "series": Fields(8, 10)}


class _Set(NamedTuple):
    """A channel: its headers, and the line that announces its series."""

    integers: np.ndarray
    reals: np.ndarray
    line: int
    points: str
    what: str
    rest: str

    @property
    def name(self) -> str:
        """Of its component: an azimuth in degrees, or a direction."""
        code = int(self.integers[AZIMUTH])
        return AZIMUTHS.get(code, str(code) if 0 <= code <= 360 else "?")


def recognises(source: Source) -> bool:
    """True when the first line gives the version of the format."""
    return bool(source.lines) and bool(BEGIN.search(source.lines[0])) and "text lines" in source.lines[0].lower()


def read(source: Source, request: Request) -> RawRecord:
    """Read one channel.

    Raises:
        InputError: no such channel, a header that contradicts itself, text among the numbers, a wrong count.
    """
    found = _sets(source)
    one = found[pick(source, [one.name for one in found], request, "COSMOS")]
    step = 1e-3 * float(one.reals[INTERVAL])
    if step <= 0.0:
        raise source.error(
            f"the interval of the series, real-header value {INTERVAL + 1}, must be above zero, got {1e3 * step:g} ms", one.line
        )
    values, _ = fixed(
        source, one.line + 1, whole(source, one.points, one.line, "the number of points"), fields_of(one.rest, USUAL["series"]), last=True
    )
    if int(one.integers[UNIT]) == COUNTS or one.what == "counts":
        factor = 1.0 if request.calibration is None else request.calibration
        what = QUANTITIES.get(int(one.integers[QUANTITY])) if one.what == "counts" else one.what
        of_counts = Stated(what, f"line {one.line + 1}", firm=True) if what else None
        return RawRecord(factor * values, step, 0.0, None, one.name, stated=of_counts, counts=True)
    only_physical(source, request, "COSMOS")
    stated = Stated(one.what, f"line {one.line + 1}", firm=True)
    announced = QUANTITIES.get(int(one.integers[QUANTITY]))
    if announced not in (None, stated.quantity):
        raise source.error(
            f"a series of {stated.quantity}, but integer-header value {QUANTITY + 1} is that of {announced}: correct the file", one.line
        )
    return RawRecord(values, step, 0.0, _unit(source, one), one.name, stated=stated)


def _unit(source: Source, one: _Set) -> str | None:
    """The unit, in words and by its number, which have to agree."""
    from loads.readers.units import measured_by

    written = WRITTEN.search(one.rest)
    word, coded = written[1].strip() if written else None, UNITS.get(int(one.integers[UNIT]))
    if word and coded and measured_by(word) and measured_by(word) != measured_by(coded):
        raise source.error(f'units "{word}", but integer-header value {UNIT + 1} is that of {coded}: correct the file', one.line)
    return word or coded


def _sets(source: Source) -> list[_Set]:
    """The channels of a file that have a series."""
    found: list[_Set] = []
    headers: dict[str, np.ndarray] = {}
    for index, line in enumerate(source.lines):
        if BEGIN.search(line):
            headers = {}
        elif match := HEADER.match(line):
            kind = match[2].lower()
            headers[kind], _ = fixed(
                source, index + 1, whole(source, match[1], index, "the number of values"), fields_of(match[3], USUAL[kind])
            )
        elif match := SERIES.match(line):
            if len(headers.get("integer", ())) <= AZIMUTH or len(headers.get("real", ())) <= INTERVAL:
                raise source.error("a series without the integer and real headers of a COSMOS file", index)
            what = next(word for word in ("acceleration", "velocity", "displacement", "counts") if word.startswith(match[2].lower()))
            found.append(_Set(headers["integer"], headers["real"], index, match[1], what, match[3]))
    return found


FORMATS = {
    "cosmos": Reader(recognises, read, about="V0 (counts), V1, V2, one or several channels", by="COSMOS; CESMD, USGS, CGS and others")
}
