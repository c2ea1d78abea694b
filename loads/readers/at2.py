# SPDX-License-Identifier: GPL-3.0-or-later
"""PEER AT2: four lines of heading, then the accelerations, several to a line.

The third line names quantity and unit (``ACCELERATION TIME SERIES IN UNITS OF G``, or in other words; VT2 and DT2 files hold velocities,
displacements), the fourth the number of values and the step, either as ``NPTS= 1560, DT= .02000 SEC`` or, in older files, as
``1560 .02000 NPTS, DT``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from loads.readers.orientation import of_name
from loads.readers.quantity import Stated, named
from loads.readers.source import RawRecord, Reader, Request, Source
from loads.readers.units import units_in

COUNT_LINES = (
    re.compile(r"NPTS\s*=\s*([^\s,]+)\s*,?\s*DT\s*=\s*([^\s,]+?)(?:SEC)?(?=[\s,]|$)", re.IGNORECASE),
    re.compile(r"^\s*(\S+)\s+(\S+)\s+NPTS\s*,\s*DT", re.IGNORECASE),
)
QUANTITY = re.compile(r"\b(ACCELERATION|VELOCITY|DISPLACEMENT)\b(?=.*\b(?:TIME|UNITS?|HISTORY|SERIES)\b)", re.IGNORECASE)
HEADING = 10  # lines in which the count is looked for


def recognises(source: Source) -> bool:
    """True when one of the first lines gives NPTS and DT."""
    return _count_line(source) is not None


def read(source: Source, request: Request) -> RawRecord:
    """Read the record."""
    found = _count_line(source)
    if found is None:
        raise source.error("no line with NPTS and DT in the heading of an AT2 file")
    index, count, step = found
    heading = " ".join(source.lines[:index])
    h, points = source.positive(step, index, "the time step DT"), source.whole(count, index, "NPTS")
    values = source.stream(index + 1)
    source.check_count(values, points, index)
    unit = re.search(r"UNITS?\s*(?:\s(?:OF|ARE)\s|[:=])\s*(\S+)", heading, re.IGNORECASE)
    named_unit = unit[1].strip(".,;()[]") if unit else next(iter(units_in(source.lines[index - 1] if index else "")), None)
    return RawRecord(values, h, 0.0, named_unit, _component(source.lines[:index]), stated=_stated(source.lines[:index]))


def _component(heading: Sequence[str]) -> str:
    """The component, which ends the second line: ``..., EL CENTRO, 180`` or ``UP`` or ``NS COMPONENT``; empty where it is none."""
    last = heading[1].rpartition(",")[2].upper().replace("COMPONENT", "").strip() if len(heading) > 1 else ""
    return last if of_name(last) else ""


def _stated(heading: Sequence[str]) -> Stated | None:
    """Return the quantity of the record by the line that names it: ``VELOCITY TIME SERIES IN UNITS OF CM/S``."""
    for number, line in enumerate(heading, start=1):
        found = QUANTITY.search(line)
        if found:
            return Stated(found[1].lower(), f"line {number}", firm=True)
    quantity = named(heading[-1]) if heading else ""
    return Stated(quantity, f"line {len(heading)}", firm=True) if quantity else None


def _count_line(source: Source) -> tuple[int, str, str] | None:
    """Index, NPTS and DT of the line that gives them."""
    for index, line in enumerate(source.lines[:HEADING]):
        for pattern in COUNT_LINES:
            match = pattern.search(line)
            if match:
                return index, match[1], match[2]
    return None


FORMATS = {"at2": Reader(recognises, read, about="AT2, VT2, DT2, one component", by="PEER", takes=())}
