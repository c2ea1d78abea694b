# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers in fields of a fixed width, which may touch, as Fortran programs write them; and one series of them.

``(8F10.3)`` is eight numbers a line, ten characters each. They are cut by their place, not at blanks. One series stands below a heading
that gives the format and the step; what stands behind the fields, such as numbers of lines, is passed over:

    A SHOCK, 8F9.6, DT=0.005 SEC, UNITS G
     0.000389 0.000431 ... 0.000643 0.000683       1
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from loads.readers.quantity import of_comments
from loads.readers.rates import LONGEST, firm, one_step
from loads.readers.source import RawRecord, Reader, Request, Source
from loads.readers.units import one_unit

FORMAT = re.compile(r"(\d+)\s*[FEGDI]\s*(\d+)", re.IGNORECASE)  # eight numbers in fields of ten: 8F10.3


class Fields(NamedTuple):
    """How many numbers stand on a line, in fields of which width, after how many characters."""

    each: int
    width: int
    lead: int = 0


def fields_of(text: str, default: Fields) -> Fields:
    """The fields of a Fortran format within a text; the default where there is none that can be."""
    found = FORMAT.search(text)
    each, width = (int(found[1][:4]), int(found[2][:4])) if found else (0, 0)
    return Fields(each, width) if each and width else default


def full_line(source: Source, index: int, usual: Fields) -> Fields:
    """The usual fields, or as many of another width where a line is as long as these."""
    length = len(source.lines[index].rstrip()) if index < len(source.lines) else 0
    return usual if length % usual.each else usual._replace(width=length // usual.each or usual.width)


def fixed(source: Source, first: int, count: int, fields: Fields, last: bool = False) -> tuple[np.ndarray, int]:
    """Numbers in fields of a fixed width, and the index of the line behind them.

    Args:
        source: the file.
        first: index of their first line.
        count: how many.
        fields: their width, and how many stand on a line.
        last: whether nothing may follow that could be more of them.

    Raises:
        InputError: fewer or more of them, text among them.
    """
    rows = -(-count // fields.each)
    after = first + rows
    if after > len(source.lines):
        held = (len(source.lines) - first) * fields.each
        raise source.error(f"the header announces {count} values, the file has lines for {max(held, 0)}: cut short", max(first - 1, 0))
    values: list[float] = []
    for index in range(first, after):
        line, here = source.lines[index][fields.lead :], min(fields.each, count - len(values))
        words = [line[k * fields.width : (k + 1) * fields.width].strip() for k in range(here)]
        if not all(words):
            raise source.error(f"{sum(map(bool, words))} values on a line where {here} belong: cut short", index)
        values += [source.number(word.upper().replace("D", "E"), index) for word in words]
        if index == after - 1 and line[here * fields.width :].strip():
            raise source.error(f"the header announces {count} values, more follow: longer than it says", index)
    more = next((index for index in range(after, len(source.lines)) if source.lines[index].strip()), None)
    if last and more is not None and has_only_numbers(source.lines[more]):
        raise source.error(f"the header announces {count} values, more follow: longer than it says", more)
    return np.array(values), after


def has_only_numbers(line: str) -> bool:
    """Return True if a line holds numbers and nothing else."""
    try:
        return bool([float(word) for word in line.split()])
    except ValueError:
        return False


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
    """Read the series."""
    found = _found(source)
    if found is None:
        raise source.error("no line above the numbers gives their Fortran format, such as 8F9.6, and their step")
    step = one_step(source, found.steps, found.first - 1)
    each, width, _ = found.fields
    last = max(index for index, line in enumerate(source.lines) if line.strip())
    here = sum(bool(source.lines[last][k * width : (k + 1) * width].strip()) for k in range(each))
    whole = replace(source, lines=tuple(line[: each * width] for line in source.lines[: last + 1]))
    values, _ = fixed(whole, found.first, each * (last - found.first) + here, found.fields)
    heading = [line for line in source.lines[: found.first] if line.strip()]
    return RawRecord(values, step, 0.0, one_unit(heading), stated=of_comments(heading))


def _found(source: Source) -> _Found | None:
    """The format, where the numbers begin, and the steps."""
    lines = [line[:LONGEST] for line in source.lines[:HEADING]]
    index = next((k for k, line in enumerate(lines) if FORMAT.search(line) and not has_only_numbers(line)), None)
    fields = NONE if index is None else fields_of(lines[index], NONE)
    if index is None or fields == NONE:
        return None
    first = next((k for k in range(index + 1, len(source.lines)) if source.lines[k].strip()), None)
    steps = firm(source.lines[:first])
    if first is None or not steps or not has_only_numbers(source.lines[first][: fields.width]):
        return None
    return _Found(fields, first, steps)


FORMATS = {"fixed": Reader(recognises, read, loose=True, about="one series in fields of a Fortran format", by="older programs", takes=())}
