# SPDX-License-Identifier: GPL-3.0-or-later
"""GeoNet (GNS Science, New Zealand): V1A (uncorrected) and V2A (corrected), three components.

For each component 16 lines of text, 40 integers (10I8), 60 reals (10F8.0), then accelerations [mm/s2], velocities and displacements, ten a
line. Integers 34 to 36 count them, real 26 is their interval [s]; line 13 of the text names the component. Velocities and displacements
follow from the accelerations and are passed over. Source: GNS Science, "Accelerogram Data Files, Standard Format", 2008.
"""

from __future__ import annotations

import re

import numpy as np

from loads.readers.channels import Channel, component, read_channel
from loads.readers.fixed import Fields, fixed
from loads.readers.quantity import of_format
from loads.readers.source import RawRecord, Reader, Request, Source

TEXT, INTEGERS, REALS = 16, 40, 60
FIELDS = Fields(10, 8)
NAME_LINE = 12  # counted from 0, like the places below
COUNTS, INTERVAL = slice(33, 36), 25
AXIS = re.compile(r"(?<=\S)\s{2,}.*")  # of the instrument, behind the name: "Up    Vertical Accelerometer Axis"
UNIT = "mm/s2"  # of all files, by the description of the format
MOST = 12  # components looked for: a file has three


def recognises(source: Source) -> bool:
    """True when the first line names GNS Science and an accelerogram."""
    first = source.lines[0] if source.lines else ""
    return "GNS Science" in first and bool(re.search(r"\b(?:un)?corrected accelerogram", first, re.IGNORECASE))


def read(source: Source, request: Request) -> RawRecord:
    """Read the accelerations of one component."""
    return read_channel(source, request, _components(source))


def _components(source: Source) -> list[Channel]:
    """Those of the file, each behind the series of the one before."""
    found, at = list[Channel](), 0
    while len(found) < MOST and any(line.strip() for line in source.lines[at : at + TEXT]):
        integers, after = fixed(source, at + TEXT, INTEGERS, FIELDS)
        reals, first = fixed(source, after, REALS, FIELDS)
        counts, step = integers[COUNTS].astype(np.int64), float(reals[INTERVAL])
        if counts[0] < 2 or (counts < 0).any():
            raise source.error(f"{counts[0]} accelerations are announced, which is not a record", at + TEXT + 3)
        if step <= 0.0:
            raise source.error(f"the interval of the samples must be above zero, got {step:g}", after + 2)
        name = component(AXIS.sub("", source.lines[at + NAME_LINE].partition("omponent")[2]))
        found.append(Channel(name, first, int(counts[0]), step, UNIT, of_format("GeoNet"), FIELDS, last=False))
        at = first + int(sum(-(-int(count) // FIELDS.each) for count in counts))
    return found


FORMATS = {"geonet": Reader(recognises, read, about="V1A, V2A, three components", by="GeoNet, GNS Science, New Zealand", takes=("column",))}
