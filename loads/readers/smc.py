# SPDX-License-Identifier: GPL-3.0-or-later
"""SMC, the format of the U.S. Geological Survey's strong-motion CD: one component.

Eleven lines of text, of which the first says what the series is; 48 integers (8I10), 50 reals (5E15.7), comments, values (8E10.4E1, or
5E14.7 in the higher precision). Integer 16 counts the comments, 17 the values; real 2 is the number of samples a second. Values are in
cm/s2, cm/s or cm. Source: USGS National Strong-Motion Project, "SMC-format data files".
"""

from __future__ import annotations

import re

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
FASTEST = 1e5  # samples a second: beyond it the header means that it does not know


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
    if not 0.0 < rate < FASTEST:
        raise source.error(f"{rate:g} samples a second are not possible", after)
    if count < 2 or comments < 0:
        raise source.error(f"{count} values and {comments} comments are announced, which is no record", TEXT)
    name = next((component(found[1]) for line in source.lines[:TEXT] if (found := NAME.search(line))), "")
    first, stated = first + comments, Stated(quantity, "line 1", firm=True)
    one = Channel(name, first, count, 1.0 / rate, UNITS[quantity], stated, _fields(source, first, count))
    return read_channel(source, request, [one])


def _kind(source: Source) -> str | None:
    """What the series is, by the first line."""
    first = source.lines[0].strip().upper() if source.lines else ""
    return next((quantity for words, quantity in KINDS.items() if first.startswith(words)), None)


def _fields(source: Source, first: int, count: int) -> Fields:
    """Eight a line, or five in the higher precision: the one whose number of lines the file has."""
    lines = sum(1 for line in source.lines[first:] if line.strip())
    return PRECISE if lines == -(-count // PRECISE.each) != -(-count // USUAL.each) else USUAL


ABOUT = "accelerations, velocities or displacements, one component"
FORMATS = {"smc": Reader(recognises, read, about=ABOUT, by="U.S. Geological Survey", takes=("column",))}
