# SPDX-License-Identifier: GPL-3.0-or-later
"""CSMIP, CGS, CDMG: Volume 1 (uncorrected) and Volume 2 (corrected), of one or several channels.

A line announces each series, its unit and the Fortran format of its values:

    Volume 2    7500 points of accel data equally spaced at  .010 sec, in cm/sec2. (8f10.6)
    Volume 1    13200 Accelerogram points at 200 pts/sec in units of g .      Format: (8f9.6)

Of a channel the accelerations are read; its velocities and displacements follow from them. Older files of Volume 1 announce none and hold
(time, value) pairs, see :mod:`.usc`. Source: OSMS 85-03, California Strong Motion Instrumentation Program.
"""

from __future__ import annotations

import re

from loads.readers.channels import Channel, component, read_channel
from loads.readers.fixed import Fields, fields_of, full_line
from loads.readers.quantity import Stated
from loads.readers.source import RawRecord, Reader, Request, Source
from loads.readers.usc import read_volume

MARK = re.compile(r"(?<!\d )\b(?:UN)?CORRECTED ACCELEROGRAM", re.IGNORECASE)  # SMC files number theirs
CORRECTED = re.compile(r"^\s*(\d+)\s+points of acc\w*\s+data\s+equally spaced at\s+(\S+)\s*sec\b(.*)$", re.IGNORECASE)
RAW = re.compile(r"^\s*(\d+)\s+accelerogram points at\s+(\S+)\s+pts/sec(.*)$", re.IGNORECASE)
UNIT = re.compile(r"(?:\bunits?\s*(?:of\b|[:=])?|\bin(?!\s+units?\b))\s*([A-Za-z%][A-Za-z0-9/^*]*)", re.IGNORECASE)
CHANNEL = re.compile(r"\bCHAN(?:NEL)?\s*(\d+)\s*:\s*(.*?)(?:\s+from\b.*|\s{3,}.*)?$", re.IGNORECASE)
COMPONENT = re.compile(r"COMP\s+(\S+)")  # of volume 2 as USC wrote it: IN UNITS CM/SEC/SEC
USUAL = (Fields(8, 10), Fields(8, 9))  # of corrected and raw ones


def recognises(source: Source) -> bool:
    """True when the first lines speak of accelerograms as this programme does."""
    head = source.lines[:2]
    return any(MARK.search(line) for line in head) and "OF VOLUME" not in head[0].upper() and "GNS SCIENCE" not in head[0].upper()


def read(source: Source, request: Request) -> RawRecord:
    """Read the accelerations of one channel."""
    found = _series(source)
    return read_channel(source, request, found) if found else read_volume(source, request, "CSMIP")


def _series(source: Source) -> list[Channel]:
    """The series of accelerations, each with the component that was named last."""
    found, name = list[Channel](), ""
    for index, line in enumerate(source.lines):
        if channel := CHANNEL.search(line.rstrip()):
            name = component(channel[2]) if channel[2].strip() else channel[1]
        elif of_usc := COMPONENT.match(line):
            name = component(of_usc[1])
        for pattern, raw in ((CORRECTED, False), (RAW, True)):
            if match := pattern.match(line):
                count = source.whole(match[1], index, "the number of points")
                step, unit = source.positive(match[2].rstrip(",."), index, "the sampling"), UNIT.search(match[3])
                stated, fields = (
                    Stated("acceleration", f"line {index + 1}", firm=True),
                    fields_of(match[3], full_line(source, index + 1, USUAL[raw])),
                )
                found.append(Channel(name, index + 1, count, 1.0 / step if raw else step, unit[1] if unit else None, stated, fields))
    return found


FORMATS = {
    "csmip": Reader(
        recognises,
        read,
        about="Volumes 1 and 2, one or several channels",
        by="CSMIP, California Geological Survey; CDMG, CESMD",
        takes=("column",),
    )
}
