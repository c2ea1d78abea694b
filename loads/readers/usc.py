# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume 1 of strong-motion processing as of 1970: USC, old CSMIP/CDMG, RENADIC (Chile), BHRC (Iran).

For each channel 13 lines of text, 7 of integers (16I5), 7 of reals (8F10.3); then (time, value) pairs, five a line in fields of seven,
or, in BHRC files, values alone, ten a line in fields of thirteen. Of the text:

    line 7    CHAN  1:  90 DEG  |  COMP  UP
    line 11   NO. OF POINTS =  11999  RECORD LENGTH = 59.998 SEC  |  NO. OF POINTS = 7070  DURATION = 30.034 SEC
    line 12   UNITS OF UNCOR ACCEL ARE SEC AND G/10.
"""

from __future__ import annotations

import re
from functools import partial

import numpy as np

from loads.readers.channels import Channel, component, read_channel
from loads.readers.fixed import Fields
from loads.readers.quantity import of_format
from loads.readers.source import RawRecord, Reader, Request, Source, begins

COUNT = re.compile(r"\bNO\.? OF POINTS\s*[=:]?\s*([\d.]+).*?(?:DURATION|RECORD LENGTH)\s*[=:]?\s*([\d.]+)", re.IGNORECASE)
UNIT = re.compile(r"\bUNITS\b.*?\bSEC\w*\.?\s+AND\s+([^\s,]+)", re.IGNORECASE)
NAME = re.compile(r"(?:CHAN(?:NEL)?\.?\s*\d+\s*:|COMP(?:ONENTE?)?\.?)\s*[:=]?\s*(\S+(?:\s+DEG)?)", re.IGNORECASE)
TEXT, HEADERS = 13, 14  # lines of text; of integers and reals
COUNT_LINE, NAME_LINE, UNIT_LINE = 10, 6, 11  # of a channel, counted from 0
PAIRS, ALONE = 7, Fields(10, 13)  # width of a field of pairs; fields of BHRC
FULL = 70  # characters of a line of five pairs, without blanks in front


def read_volume(source: Source, request: Request, kind: str, pairs: bool = True) -> RawRecord:
    """Read one channel of a file of a kind; ``pairs`` where a time stands before each value.

    Raises:
        InputError: no such channel, text among the numbers, a wrong count, times that do not advance.
    """
    return read_channel(source, request, _channels(source, kind, pairs))


def _channels(source: Source, kind: str, pairs: bool) -> list[Channel]:
    """All of them, by the lines that give their number of points."""
    found = []
    for index, line in enumerate(source.lines):
        match, start = COUNT.search(line), index - COUNT_LINE
        if match is None or start < 0 or index + 1 >= len(source.lines):
            continue
        count = source.whole(match[1], index, "NO. OF POINTS")
        step = _step(count, source.positive(match[2], index, "the duration"))
        name, unit = NAME.search(source.lines[start + NAME_LINE]), UNIT.search(source.lines[start + UNIT_LINE])
        written = component(name[1] if name else source.lines[start + NAME_LINE])
        first = start + TEXT + HEADERS
        lead = max(0, len(source.lines[first].rstrip()) - FULL) if first < len(source.lines) else 0
        fields = Fields(10, PAIRS, lead) if pairs else ALONE
        found.append(Channel(written, first, count, step, unit[1].rstrip(".") if unit else None, of_format(kind), fields, timed=pairs))
    return found


def _step(points: int, duration: float) -> float:
    """Networks call n h or (n - 1) h the duration: the one that is nearer to a whole number of samples a second."""
    rates = np.array([points, points - 1]) / duration
    return 1.0 / float(rates[np.argmin(np.abs(rates - np.round(rates)))])


MARK = begins("OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME")
READ, BY = partial(read_volume, kind="USC"), "University of Southern California"
FORMATS = {"usc": Reader(MARK, READ, about="Volume 1 of film, uneven times", by=BY, takes=("column",))}
