# SPDX-License-Identifier: GPL-3.0-or-later
"""AFAD/NSMN (Turkey): a heading of ``key: value`` lines, and a table of three components ``N-S E-W U-D``.

Its first line is STRONG GROUND MOTION RECORDS OF TURKIYE. Newer files (TADAS) have the heading of ESM and are read as such.
"""

from __future__ import annotations

import re

from loads.readers.channels import pick
from loads.readers.heading import RecordHeading, columns
from loads.readers.quantity import of_format
from loads.readers.source import RawRecord, Reader, Request, Source, begins

HEADING = 150  # lines in which keys are looked for
PGA_UNIT = re.compile(r"PGA VALUES\s*\(([^)]+)\)", re.IGNORECASE)
TITLES = re.compile(r"\s*N-?S\s+E-?W\s+U-?D\s*$", re.IGNORECASE)


def read(source: Source, request: Request) -> RawRecord:
    """Read one component."""
    heading = RecordHeading.split(source, "AFAD", HEADING)
    step = heading.positive("SAMPLING INTERVAL")
    titles = next((i for i, line in enumerate(source.lines[:HEADING]) if TITLES.match(line)), None)
    if titles is None:
        raise source.error("no line N-S E-W U-D above the numbers of an AFAD file")
    names = source.lines[titles].split()
    column = pick(names, request.column, source.error)
    values = columns(source, titles + 1, [column], len(names))[:, 0]
    heading.check_count("NUMBER OF DATA", values)
    unit = next((found[1] for line in source.lines[:titles] if (found := PGA_UNIT.search(line))), None)
    return RawRecord(values, step, 0.0, unit, names[column], column, of_format("AFAD"))


ABOUT = "text of three components"
FIRST = begins("STRONG GROUND MOTION RECORDS OF TURKIYE")
FORMATS = {"afad": Reader(FIRST, read, about=ABOUT, by="AFAD/NSMN, Turkey (older files; newer ones are esm)", takes=("column",))}
