# SPDX-License-Identifier: GPL-3.0-or-later
"""ESM and ITACA ASCII (DYNA 1.0 to 1.2): a heading of ``KEY: value`` lines, then one acceleration per line.

Needed of the heading: SAMPLING_INTERVAL_S, NDATA, UNITS, and DATA_TYPE where it is given; ITACA 1 names the component COMPONENT instead of
STREAM.
"""

from __future__ import annotations

import re

from loads.readers.heading import RecordHeading
from loads.readers.quantity import Stated, named, of_channel
from loads.readers.source import RawRecord, Reader, Request, Source

PEAK = re.compile(r"PG[AVD]_(.+)$")  # the unit of older files stands in the key of their peak: PGA_CM/S^2
KEY = re.compile(r"[A-Z][A-Z0-9_/^]*:")
HEADING = 100  # lines in which the keys are looked for
STEP, COUNT = "SAMPLING_INTERVAL_S", "NDATA"


def recognises(source: Source) -> bool:
    """True when the heading has the keys of step and count."""
    return _heading(source)[0].has(STEP, COUNT)


def read(source: Source, request: Request) -> RawRecord:
    """Read the record."""
    heading, first = _heading(source)
    step = heading.positive(STEP)
    heading.find(COUNT)
    stated = _stated(heading)
    values = source.stream(first)
    heading.check_count(COUNT, values)
    unit = heading.text("UNITS") or next((found[1] for key in heading.entries if (found := PEAK.match(key))), "")
    return RawRecord(values, step, 0.0, unit or None, heading.text("STREAM") or heading.text("COMPONENT"), stated=stated)


def _stated(heading: RecordHeading) -> Stated | None:
    """Return the quantity of the record by the line DATA_TYPE, or by the channel where there is none."""
    line, text = heading.entries.get("DATA_TYPE", (0, ""))
    if not text:
        return of_channel(heading.text("STREAM"))
    if (quantity := named(text)) and not re.search("SPECTR|RESPONSE", text, re.IGNORECASE):
        return Stated(quantity, f"line {line + 1}, DATA_TYPE", firm=True)
    raise heading.source.error(f"a record of {text.lower()}, where one of acceleration is needed", line)


def _heading(source: Source) -> tuple[RecordHeading, int]:
    """The lines up to the first that is none of it, and its index."""
    first = next((k for k, line in enumerate(source.lines[:HEADING]) if not KEY.match(line)), min(HEADING, len(source.lines)))
    return RecordHeading.split(source, "ESM", first), first


ABOUT = "DYNA 1.0 to 1.2, ITACA 1 and 2, one component"
FORMATS = {"esm": Reader(recognises, read, about=ABOUT, by="ESM, ITACA (INGV), AFAD (TADAS)", takes=())}
