# SPDX-License-Identifier: GPL-3.0-or-later
"""SMC, the format of the U.S. Geological Survey's strong-motion CD: one component.

Eleven lines of text, of which the first says what the series is; 48 integers (8I10), 50 reals (5E15.7), comments, values (8E10.4E1, or
5E14.7 in the higher precision). Integer 16 counts the comments, 17 the values; real 2 is the number of samples a second. Of film it is
1.7e38, not known: then each value stands behind its time, and both are counted. Values are in cm/s2, cm/s or cm.
Source: USGS National Strong-Motion Project, "SMC-format data files".
"""

from __future__ import annotations

import re
from dataclasses import replace

from loads.readers.channels import Channel, component, read_channel
from loads.readers.fixed import Fields, fixed
from loads.readers.quantity import Stated
from loads.readers.source import RawRecord, Reader, Request, Source

KINDS = {"1 UNCORRECTED ACCELEROGRAM": "acceleration", "2 CORRECTED ACCELEROGRAM": "acceleration", "3 VELOCITY": "velocity",
         "4 DISPLACEMENT": "displacement"}  # fmt: skip
UNITS = {"acceleration": "cm/s2", "velocity": "cm/s", "displacement": "cm"}
NAME = re.compile(r"component\s*=\s*(\S+)", re.IGNORECASE)
TEXT, INTEGERS, REALS = 11, (48, Fields(8, 10)), (50, Fields(5, 15))
COMMENTS, COUNT, RATE = 15, 16, 1  # places, counted from 0
USUAL, PRECISE = Fields(8, 10), Fields(5, 14)
FASTEST, UNKNOWN = 1e5, 1.6e38  # samples a second; what is larger means that the header does not know


def recognises(source: Source) -> bool:
    """True when the first line is one of the format's."""
    return _kind(source) is not None and len(source.lines) > TEXT


def read(source: Source, request: Request) -> RawRecord:
    """Read the series."""
    quantity = _kind(source)
    if quantity is None:
        raise source.error("no first line of an SMC file, such as 2 CORRECTED ACCELEROGRAM", 0)
    integers, after = fixed(source, TEXT, *INTEGERS)
    reals, first = fixed(source, after, *REALS)
    comments, count, rate = int(integers[COMMENTS]), int(integers[COUNT]), float(reals[RATE])
    timed = rate > UNKNOWN
    if not timed and not 0.0 < rate < FASTEST:
        raise source.error(f"{rate:g} samples a second are not possible", after)
    if timed and count % 2:
        raise source.error(f"{count} numbers are announced, where times and values alternate", TEXT)
    if count < 2 or comments < 0:
        raise source.error(f"{count} values and {comments} comments are announced, which is not a record", TEXT)
    name = next((component(found[1]) for line in source.lines[:TEXT] if (found := NAME.search(line))), "")
    first, stated = first + comments, Stated(quantity, "line 1", firm=True)
    fields = _fields(source, first, count)
    one = Channel(name, first, count // 2 if timed else count, 1.0 / rate, UNITS[quantity], stated, fields, timed, last=not timed)
    record = read_channel(source, request, [one])
    more = sum(1 for line in source.lines[first + -(-count // fields.each) :] if line.strip())
    note = f"{more} line{'s' if more > 1 else ''} behind the {count} numbers announced left out"
    return replace(record, notes=(*record.notes, *([note] if more else [])))


def _kind(source: Source) -> str | None:
    """Return the quantity of the series by the first line."""
    first = source.lines[0].strip().upper() if source.lines else ""
    return next((quantity for words, quantity in KINDS.items() if first.startswith(words)), None)


def _fields(source: Source, first: int, count: int) -> Fields:
    """Eight a line, or five in the higher precision: the one whose number of lines the file has, or one less than it has."""
    lines = sum(1 for line in source.lines[first:] if line.strip())
    usual, precise = (-(-count // fields.each) for fields in (USUAL, PRECISE))
    return PRECISE if precise <= lines <= precise + 1 and precise != usual else USUAL


ABOUT = "accelerations, velocities or displacements, one component"
FORMATS = {"smc": Reader(recognises, read, about=ABOUT, by="U.S. Geological Survey", takes=("column",))}
