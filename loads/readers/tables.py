"""Tables of numbers: CSV (comma, semicolon or tab) and columns separated by blanks, with or without a heading.

The heading names the columns and their units (``time_s,ns_m_s2`` or ``# time [s]  acc [g]``); it may be a comment. The time column is
the one called time or t; without a heading it is the first of several. A single column needs the key time_step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from loads.readers.source import COMMENTS, RawRecord, Reader, Request, Source, refuse_calibration
from loads.readers.units import TIME, split_heading
from masonry_cd.errors import suggest

IRREGULAR = 0.2  # of a step: times written with few digits (1/128 s as 0.008) stay below, a missing line does not
DELIMITERS = (";", "\t", ",")
PROBE = 20  # lines looked at to recognise a table


@dataclass(frozen=True)
class Layout:
    """How the table is to be read."""

    delimiter: str | None  # None: blanks
    first: int  # index of the first line of numbers
    headings: tuple[str, ...]  # empty when there are none
    width: int  # columns

    def split(self, line: str) -> list[str]:
        """The fields of a line."""
        return _split(line, self.delimiter)

    def name(self, column: int) -> str:
        """What to call a column."""
        return split_heading(self.headings[column])[0] if self.headings else f"column {column}"


def recognises_csv(source: Source) -> bool:
    """True when the first lines hold numbers between commas, semicolons or tabs."""
    return _delimiter(source) is not None


def recognises_columns(source: Source) -> bool:
    """True when one of the first two lines starts with a number, and no delimiter stands beside numbers."""
    first = [line for _, (_, line) in zip(range(2), source.content(), strict=False)]
    return _delimiter(source) is None and any(_is_number(line.split()[0]) for line in first)


def read_csv(source: Source, request: Request) -> RawRecord:
    """Read a CSV table, see :func:`_read`."""
    delimiter = _delimiter(source)
    if delimiter is None:
        raise source.error("no comma, semicolon or tab between numbers, as a CSV file has")
    return _read(source, request, delimiter)


def read_columns(source: Source, request: Request) -> RawRecord:
    """Read columns separated by blanks, see :func:`_read`."""
    if _delimiter(source) in (";", ","):
        raise source.error("commas or semicolons between the numbers: this is CSV")
    return _read(source, request, None)


def _read(source: Source, request: Request, delimiter: str | None) -> RawRecord:
    """Read one component of a table.

    Raises:
        InputError: text among the numbers, a row of another width, an unknown column, a time column that does not advance evenly.
    """
    refuse_calibration(source, request, "text")
    layout = _layout(source, delimiter)
    time = _time_column(source, layout, request)
    column = _value_column(source, layout, time, request)
    wanted = [column] if time is None else [column, time]  # the others may hold anything
    rows, places = [], []
    for index, line in source.content():
        if index < layout.first:
            continue
        fields = layout.split(line)
        rows.append([source.number(_decimal(fields[c], delimiter), index) for c in wanted if c < len(fields)])
        if len(fields) != layout.width:
            raise source.error(f"{len(fields)} columns, where the table has {layout.width}", index)
        places.append(index)
    table = np.array(rows, dtype=float)
    if len(table) < 2:
        raise source.error(f"{len(table)} rows of numbers are no record")
    unit = split_heading(layout.headings[column])[1] if layout.headings else None
    if time is None:
        assert request.time_step is not None
        return RawRecord(table[:, 0], request.time_step, 0.0, unit, layout.name(column), column)
    factor = _time_factor(source, layout, time)
    step = factor * _even_step(source, table[:, 1], places)
    return RawRecord(table[:, 0], step, factor * float(table[0, 1]), unit, layout.name(column), column)


def _layout(source: Source, delimiter: str | None) -> Layout:
    """Find the heading, the first line of numbers and the number of columns."""
    content = [line for _, line in zip(range(2), source.content(), strict=False)]
    if not content:
        raise source.error("no line of numbers")
    index, line = content[0]
    fields = _split(line, delimiter)
    if not any(_is_number(_decimal(field, delimiter)) for field in fields):
        if len(content) < 2:
            raise source.error("no line of numbers below the heading")
        width = len(_split(content[1][1], delimiter))
        if width != len(fields):
            raise source.error(f"{width} columns below a heading of {len(fields)}", content[1][0])
        return Layout(delimiter, content[1][0], tuple(fields), width)
    return Layout(delimiter, index, _heading_in_comment(source, index, delimiter, len(fields)), len(fields))


def _heading_in_comment(source: Source, first: int, delimiter: str | None, width: int) -> tuple[str, ...]:
    """The last comment above the numbers, when it names as many columns as there are."""
    for line in reversed(source.lines[:first]):
        text = line.strip()
        if not text.startswith(COMMENTS):
            continue
        fields = _split(text.lstrip("#%/ \t"), delimiter)
        named = width == 1 or any(_names_time(field) for field in fields)
        return tuple(fields) if len(fields) == width and named else ()
    return ()


def _time_column(source: Source, layout: Layout, request: Request) -> int | None:
    """Index of the time column; None when the step is given by key."""
    named = [c for c, heading in enumerate(layout.headings) if _names_time(heading)]
    if request.time_step is not None:
        if named:
            raise source.error(f'the key time_step is given, but the file has a column "{layout.headings[named[0]]}"')
        return None
    if named:
        return named[0]
    if layout.headings or layout.width == 1:
        raise source.error("no time column; give the key time_step, in seconds")
    return 0


def _value_column(source: Source, layout: Layout, time: int | None, request: Request) -> int:
    """Index of the column that the user asks for."""
    choices = [c for c in range(layout.width) if c != time]
    named = [layout.headings[c].strip() if layout.headings else str(c) for c in choices]
    listed = "columns: " + ", ".join(named) if layout.headings else f"columns are counted from 0: {', '.join(named)}"
    asked = request.column
    if asked is None:
        if len(choices) == 1:
            return choices[0]
        raise source.error(f"several components; say which by the key column; {listed}")
    if isinstance(asked, int):
        if asked in choices:
            return asked
        raise source.error(f"column {asked} {'is the time' if asked == time else 'is not there'}; {listed}")
    word = asked.strip().lower()
    whole = [c for c, name in zip(choices, named, strict=True) if name.lower() == word]
    bare = [c for c in choices if layout.name(c).lower() == word]
    if len(whole) == 1 or len(bare) == 1:
        return whole[0] if len(whole) == 1 else bare[0]
    if whole or bare:
        raise source.error(f'several columns are called "{asked}"; give the place of one, counted from 0; {listed}')
    raise source.error(f'no column "{asked}"{suggest(asked, named)}; {listed}')


def _time_factor(source: Source, layout: Layout, time: int) -> float:
    """Seconds in the unit of the time column."""
    if not layout.headings:
        return 1.0
    name, unit = split_heading(layout.headings[time])
    if unit is None and "_" not in name:
        return 1.0
    if unit is None or unit.lower() not in TIME:
        raise source.error(f'the time column "{layout.headings[time]}" is in no known unit; known: {", ".join(TIME)}')
    return TIME[unit.lower()]


def _names_time(heading: str) -> bool:
    """True for ``t``, ``time``, ``Time (s)``, ``time_ms``."""
    name = split_heading(heading)[0].lower()
    return name in ("t", "time") or name.startswith("time_")


def _even_step(source: Source, times: np.ndarray, places: list[int]) -> float:
    """The step of times that advance evenly, in their own unit."""
    steps = np.diff(times)
    if (steps <= 0.0).any():
        worst = int(np.argmax(steps <= 0.0))
        raise source.error(f"the time does not advance: {times[worst]:g} then {times[worst + 1]:g}", places[worst + 1])
    usual = float(np.median(steps))
    odd = np.abs(steps - usual) > IRREGULAR * usual
    if odd.any():
        worst = int(np.argmax(odd))
        raise source.error(f"the time step changes from {usual:g} to {steps[worst]:g}; a constant step is needed", places[worst + 1])
    step = float(times[-1] - times[0]) / len(steps)
    drift = np.abs(times - times[0] - step * np.arange(len(times)))
    if drift.max() > IRREGULAR * step:
        worst = int(np.argmax(drift))
        off = f"{times[worst]:g} is {drift[worst]:.2g} off an even grid of step {step:g}"
        raise source.error(f"the time step is not constant: {off}", places[worst])
    return step


def _delimiter(source: Source) -> str | None:
    """The delimiter of a CSV: the one beside which numbers stand in the first lines."""
    lines = [line for _, (_, line) in zip(range(PROBE), source.content(), strict=False)]
    for delimiter in DELIMITERS:
        rows = [_split(line, delimiter) for line in lines]
        if any(len(row) > 1 and any(_is_number(_decimal(field, delimiter)) for field in row) for row in rows):
            return delimiter
    return None


def _split(line: str, delimiter: str | None) -> list[str]:
    """The fields of a line; with blanks as delimiter a unit in brackets stays with its name."""
    if delimiter is not None:
        return [field.strip().strip('"') for field in line.split(delimiter)]
    fields: list[str] = []
    for word in line.split():
        if fields and word[0] in "[(":
            fields[-1] += " " + word
        else:
            fields.append(word)
    return fields


def _decimal(word: str, delimiter: str | None) -> str:
    """A decimal comma is read where the comma does not separate values."""
    return word.replace(",", ".") if delimiter in (";", "\t") else word


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


FORMATS = {
    "csv": Reader(recognises_csv, read_csv, loose=True),
    "columns": Reader(recognises_columns, read_columns, loose=True),
}
