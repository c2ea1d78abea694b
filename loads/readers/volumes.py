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
from typing import NamedTuple

import numpy as np

from loads.readers.channels import Fields, component, evenly, fixed, only_physical, pick, positive, whole
from loads.readers.quantity import Stated
from loads.readers.source import RawRecord, Reader, Request, Source

COUNT = re.compile(r"\bNO\.? OF POINTS\s*[=:]?\s*([\d.]+).*?(?:DURATION|RECORD LENGTH)\s*[=:]?\s*([\d.]+)", re.IGNORECASE)
UNIT = re.compile(r"\bUNITS\b.*?\bSEC\w*\.?\s+AND\s+([^\s,]+)", re.IGNORECASE)
NAME = re.compile(r"(?:CHAN(?:NEL)?\.?\s*\d+\s*:|COMP(?:ONENTE?)?\.?)\s*[:=]?\s*(\S+(?:\s+DEG)?)", re.IGNORECASE)
TEXT, HEADERS = 13, 14  # lines of text; of integers and reals
COUNT_LINE, NAME_LINE, UNIT_LINE = 10, 6, 11  # of a channel, counted from 0
PAIRS, ALONE = 7, Fields(10, 13)  # width of a field of pairs; fields of BHRC
FULL = 70  # characters of a line of five pairs, without blanks in front
SHOWN = 2  # lines of text that say which network it is


class _Channel(NamedTuple):
    """Where a channel begins, and what its text says."""

    first: int
    name: str
    points: int
    duration: float
    unit: str | None


def read_volume(source: Source, request: Request, kind: str, pairs: bool = True) -> RawRecord:
    """Read one channel.

    Args:
        source: the file.
        request: what the user says of it.
        kind: the format in messages.
        pairs: whether a time stands before each value.

    Raises:
        InputError: no such channel, text among the numbers, a wrong count, times that do not advance.
    """
    only_physical(source, request, kind)
    found = _channels(source)
    channel = found[pick(source, [one.name for one in found], request, kind)]
    start = channel.first + TEXT + HEADERS
    stated = Stated("acceleration", f"the format of {kind} files", firm=True)
    if not pairs:
        values, _ = fixed(source, start, channel.points, ALONE, last=True)
        return RawRecord(values, _step(channel), 0.0, channel.unit, channel.name, stated=stated)
    line = source.lines[start].rstrip() if start < len(source.lines) else ""
    table, _ = fixed(source, start, 2 * channel.points, Fields(10, PAIRS, max(0, len(line) - FULL)), last=True)
    values, step, notes = evenly(source, table[::2], table[1::2], start)
    return RawRecord(values, step, float(table[0]), channel.unit, channel.name, stated=stated, notes=notes)


def _channels(source: Source) -> list[_Channel]:
    """All of them, by the lines that give their number of points."""
    found = []
    for index, line in enumerate(source.lines):
        match = COUNT.search(line)
        first = index - COUNT_LINE
        if match is None or first < 0 or index + 1 >= len(source.lines):
            continue
        count = whole(source, match[1], index, "NO. OF POINTS")
        duration = positive(source, match[2], index, "the duration")
        name, unit = NAME.search(source.lines[first + NAME_LINE]), UNIT.search(source.lines[first + UNIT_LINE])
        written = component(name[1] if name else source.lines[first + NAME_LINE])
        found.append(_Channel(first, written, count, duration, unit[1].rstrip(".") if unit else None))
    return found


def _step(channel: _Channel) -> float:
    """Networks call n h or (n - 1) h the duration: the one that is nearer to a whole number of samples a second."""
    rates = np.array([channel.points, channel.points - 1]) / channel.duration
    return 1.0 / float(rates[np.argmin(np.abs(rates - np.round(rates)))])


def _begins(source: Source, *words: str, lines: int = SHOWN) -> bool:
    """Whether one of the first lines has one of some words."""
    head = [line.upper() for line in source.lines[:lines]]
    return any(word in line for line in head for word in words)


def _recognises_usc(source: Source) -> bool:
    return _begins(source, "OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME", lines=1)


def _recognises_renadic(source: Source) -> bool:
    return _begins(source, "RENADIC", lines=TEXT) and any(COUNT.search(line) for line in source.lines[:TEXT])


def _recognises_bhrc(source: Source) -> bool:
    return _begins(source, "* VOL1DS FILE", lines=1)


def _read_usc(source: Source, request: Request) -> RawRecord:
    return read_volume(source, request, "USC")


def _read_renadic(source: Source, request: Request) -> RawRecord:
    return read_volume(source, request, "RENADIC")


def _read_bhrc(source: Source, request: Request) -> RawRecord:
    return read_volume(source, request, "BHRC", pairs=False)


FORMATS = {
    "usc": Reader(_recognises_usc, _read_usc, about="Volume 1 of film, uneven times", by="University of Southern California"),
    "renadic": Reader(_recognises_renadic, _read_renadic, about="Volume 1, three components", by="RENADIC, Universidad de Chile"),
    "bhrc": Reader(_recognises_bhrc, _read_bhrc, about="Volume 1 (VOL1DS), three components", by="BHRC/ISMN, Iran"),
}
