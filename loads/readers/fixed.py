# SPDX-License-Identifier: GPL-3.0-or-later
"""One series in fields of a fixed width, which may touch, below a heading that gives their Fortran format and the step.

    A SHOCK, 8F9.6, DT=0.005 SEC, UNITS G
     0.000389 0.000431 ... 0.000643 0.000683       1

What stands behind the fields, such as numbers of lines, is passed over.
"""

from __future__ import annotations

from typing import NamedTuple

from loads.readers.channels import FORMAT, Fields, fields_of, fixed, numbers_alone
from loads.readers.quantity import of_comments
from loads.readers.rates import LONGEST, agree, firm
from loads.readers.source import RawRecord, Reader, Request, Source, refuse_keys
from loads.readers.units import declared_unit, units_in

HEADING = 20  # lines in which the format is looked for
NONE = Fields(0, 0)


class _Found(NamedTuple):
    fields: Fields
    first: int  # index of the first line of numbers
    steps: list[float]  # as the heading gives them [s]


def recognises(source: Source) -> bool:
    """True when a heading gives a Fortran format and a step, and the line below it is one of such fields."""
    return _found(source) is not None


def read(source: Source, request: Request) -> RawRecord:
    """Read the series.

    Raises:
        InputError: no such heading, several steps, text among the numbers, a line that is not full before the last.
    """
    refuse_keys(source, request, "fixed-width")
    found = _found(source)
    if found is None:
        raise source.error("no line above the numbers gives their Fortran format, such as 8F9.6, and their step")
    if not agree(found.steps):
        raise source.error(f"the heading gives steps of {min(found.steps):g} and {max(found.steps):g} s: correct the file", found.first - 1)
    each, width, _ = found.fields
    last = max(index for index, line in enumerate(source.lines) if line.strip())
    here = sum(bool(source.lines[last][k * width : (k + 1) * width].strip()) for k in range(each))
    whole = Source(source.label, tuple(line[: each * width] for line in source.lines[: last + 1]))
    values, _ = fixed(whole, found.first, each * (last - found.first) + here, found.fields)
    heading = [line for line in source.lines[: found.first] if line.strip()]
    units = {unit for line in heading for unit in units_in(line)} or {unit for line in heading if (unit := declared_unit(line))}
    unit = units.pop() if len(units) == 1 else None
    return RawRecord(values, found.steps[0], 0.0, unit, stated=of_comments(heading))


def _found(source: Source) -> _Found | None:
    """The format, where the numbers begin, and the steps."""
    lines = [line[:LONGEST] for line in source.lines[:HEADING]]
    index = next((k for k, line in enumerate(lines) if FORMAT.search(line) and not numbers_alone(line)), None)
    fields = NONE if index is None else fields_of(lines[index], NONE)
    if index is None or fields == NONE:
        return None
    first = next((k for k in range(index + 1, len(source.lines)) if source.lines[k].strip()), None)
    steps = firm(source.lines[:first])
    if first is None or not steps or not numbers_alone(source.lines[first][: fields.width]):
        return None
    return _Found(fields, first, steps)


FORMATS = {"fixed": Reader(recognises, read, loose=True, about="one series in fields of a Fortran format", by="older programs")}
