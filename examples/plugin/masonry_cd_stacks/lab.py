# SPDX-License-Identifier: GPL-3.0-or-later
"""``[[loads]] kind = "record"``, ``format = "lab"``: a heading ``LAB dt=0.005 unit=m/s2``, then a value a line.

Without ``format`` it is found by its heading, after our own formats that have one.
"""

from __future__ import annotations

from loads.readers.source import RawRecord, Reader, Request, Source


def recognises(source: Source) -> bool:
    """Return True if a file is one, by its content."""
    return bool(source.lines) and source.lines[0].startswith("LAB dt=")


def read(source: Source, request: Request) -> RawRecord:
    """Values as they stand in the file, with the unit that it states."""
    about = dict(word.split("=", 1) for word in source.lines[0].split()[1:])
    return RawRecord(values=source.stream(1), step=source.number(about["dt"], 0), origin=0.0, unit=about.get("unit"))


LAB = Reader(recognises, read)
