# SPDX-License-Identifier: GPL-3.0-or-later
"""K-NET and KiK-net ASCII: seventeen lines of heading, then counts of the digitiser, eight to a line.

Needed of the heading: ``Sampling Freq(Hz)``, ``Duration Time(s)``, and ``Scale Factor``, which says what one count means, e.g.
``2000(gal)/8388608``. It is applied here, once. The counts stand on an offset of the instrument, which the baseline correction takes away;
the peak that the heading announces is the one about the mean.
"""

from __future__ import annotations

import re

from loads.readers.heading import RecordHeading
from loads.readers.source import RawRecord, Reader, Request, Source

LAST = "Memo"  # the heading's last line begins so
HIGHEST = 1e6  # [Hz]: the shortest step that a record may have is its inverse
KIKNET = {"1": "NS1", "2": "EW1", "3": "UD1", "4": "NS2", "5": "EW2", "6": "UD2"}  # borehole and surface, as its files are called
HEADING = 40  # lines in which it is looked for
RATE, SCALE = "Sampling Freq(Hz)", "Scale Factor"
FACTOR = re.compile(r"^\s*([^\s(]+)\s*\(\s*([^)]+?)\s*\)\s*/\s*(\S+)\s*$")


def recognises(source: Source) -> bool:
    """True when the heading has the scale factor and the sampling frequency of K-NET."""
    return _heading(source).has(SCALE, RATE)


def read(source: Source, request: Request) -> RawRecord:
    """Read the record."""
    heading = _heading(source)
    line, text = heading.find(RATE)
    frequency = source.number(re.sub(r"Hz\s*$", "", text, flags=re.IGNORECASE), line)
    if not 0.0 < frequency <= HIGHEST:
        raise source.error(f"the sampling frequency must be above zero and at most {HIGHEST:g} Hz, got {text}", line)
    factor, unit = _scale(source, *heading.find(SCALE))
    values = source.stream(heading.find(LAST)[0] + 1)
    heading.check_count("Duration Time(s)", values, times=frequency)
    direction = heading.text("Dir.") or heading.text("Dir")
    return RawRecord(factor * values, 1.0 / frequency, 0.0, unit, KIKNET.get(direction, direction))


def _scale(source: Source, line: int, text: str) -> tuple[float, str]:
    """Return the size of one count, and its unit."""
    match = FACTOR.match(text)
    if match is None:
        raise source.error(f'a scale factor such as 2000(gal)/8388608 is needed, got "{text}"', line)
    size, counts = source.number(match[1], line), source.number(match[3], line)
    if size <= 0.0 or counts <= 0.0:
        raise source.error(f"the scale factor must be above zero, got {text}", line)
    return size / counts, match[2]


def _heading(source: Source) -> RecordHeading:
    """The first lines up to the last of the heading. Keys take the first eighteen characters of a line."""
    found: dict[str, tuple[int, str]] = {}
    for index, line in enumerate(source.lines[:HEADING]):
        key = line[:18].strip().rstrip(".") if line.startswith(LAST) else line[:18].strip()
        found.setdefault(key, (index, line[18:].strip()))
        if key == LAST:
            break
    return RecordHeading(source, "K-NET", found)


FORMATS = {"knet": Reader(recognises, read, about="K-NET and KiK-net text, one component", by="NIED, Japan", takes=())}
