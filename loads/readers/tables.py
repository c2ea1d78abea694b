# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of numbers: CSV (comma, semicolon or tab) and columns separated by blanks, with or without a heading.

The heading names the columns and their units (``time_s,ns_m_s2`` or ``# time [s]  acc [g]``); it may be a comment. The time column is
the one called time or t, of several the nearest to the left of the values; without a heading it is the first of several. A single column
needs the key time_step, which wins over printed times, too. A table that could be one series in reading order is refused, until the key
layout decides.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from loads.readers.fields import DECIMAL_COMMA, decimal, delimiter_of, is_number, split
from loads.readers.quantity import Stated, named, of_comments, of_spoken_channel
from loads.readers.rates import agree, firm, unrounded
from loads.readers.source import COMMENTS, RawRecord, Reader, Request, Source
from loads.readers.units import TIME, declared_unit, measured_by, split_heading
from loads.readers.wrapped import FEWEST_ROWS, advances, filled, is_in_reading_order, paired, times_of
from masonry_cd.foundation.errors import suggest
from masonry_cd.foundation.fields import finite_number

IRREGULAR = 0.2  # of a step: times written with few digits (1/128 s as 0.008) stay below, a missing line does not
TIME_NAMES = ("t", "time", "tempo", "tempi", "tiempo", "temps", "zeit", "zaman")
MOST_NAMED = 30  # columns in a message
PREAMBLE = 40  # lines of text above the headings, at most
PADDED = re.compile(r"[+-]?\d+,0\d+")  # 0,05: no second column is written so


@dataclass(frozen=True)
class ColumnLayout:
    """How the table is to be read."""

    delimiter: str | None  # None: blanks
    first: int  # index of the first line of numbers
    headings: tuple[str, ...]  # empty when there are none
    width: int  # columns
    above: tuple[str, ...] = ()  # lines of text above the headings

    def name(self, column: int) -> str:
        """Return the name of a column in messages."""
        return split_heading(self.headings[column])[0] if self.headings else f"column {column}"


def recognises_csv(source: Source) -> bool:
    """True when the first lines hold numbers between commas, semicolons or tabs."""
    return delimiter_of(source) is not None


def recognises_columns(source: Source) -> bool:
    """True when one of the first two lines starts with a number, and no delimiter stands next to numbers."""
    first = [line for _, (_, line) in zip(range(2), source.content(), strict=False)]
    return delimiter_of(source) is None and any(is_number(decimal(line.split()[0], None)) for line in first)


def read_csv(source: Source, request: Request) -> RawRecord:
    """Read a CSV table, see :func:`_read`."""
    delimiter = delimiter_of(source)
    if delimiter is None:
        raise source.error("no comma, semicolon or tab between numbers, as a CSV file has")
    if delimiter == ",":
        words = [line.strip() for _, line in source.content()]
        padded = [word for word in words if PADDED.fullmatch(word)]
        if padded and all(DECIMAL_COMMA.fullmatch(word) for word in words[1:]):
            raise source.error(f"{padded[0]} is one number with a decimal comma, or two of a CSV file; write it with a decimal point")
    return _read(source, request, delimiter)


def read_columns(source: Source, request: Request) -> RawRecord:
    """Read columns separated by blanks, see :func:`_read`."""
    if delimiter_of(source) in (";", ","):
        raise source.error("commas or semicolons between the numbers: this is CSV")
    return _read(source, request, None)


def _read(source: Source, request: Request, delimiter: str | None) -> RawRecord:
    """Read one component of a table.

    Raises:
        InputError: text among the numbers, a row of another width, an unknown column, a time column that does not advance evenly.
    """
    if request.layout in ("series", "pairs"):
        return _read_wrapped(source, request, delimiter)
    layout = _layout(source, delimiter)
    times = _time_columns(source, layout, request)
    column = _value_column(source, layout, times, request)
    time = max((c for c in times if c < column), default=times[0]) if times else None
    wanted = [column] if time is None else [column, time]  # the others may hold anything
    rows, places = [], []
    for index, fields in _fields(source, delimiter, layout.first):
        rows.append([source.number(fields[c], index) for c in wanted if c < len(fields)])
        if len(fields) != layout.width:
            raise source.error(f"{len(fields)} columns, where the table has {layout.width}", index)
        places.append(index)
    table = np.array(rows, dtype=float)
    if len(table) < 2:
        raise source.error(f"{len(table)} rows of numbers are no record")
    unit = split_heading(layout.headings[column])[1] if layout.headings else None
    stated = _stated(source, layout, column)
    unit = unit or _unit_above(layout)
    if time is None:
        step = _step_above(source, layout) if request.time_step is None else request.time_step
        return RawRecord(table[:, 0], step, 0.0, unit, layout.name(column), column, stated)
    factor = _time_factor(source, layout, time)
    step, notes = _step_of_times(source, factor * table[:, 1], places, request.time_step)
    return RawRecord(table[:, 0], step, factor * float(table[0, 1]), unit, layout.name(column), column, stated, notes=notes)


def _step_of_times(source: Source, times: np.ndarray, places: list[int], asked: float | None) -> tuple[float, tuple[str, ...]]:
    """The step of the times (n,) of a column [s], and how it was found.

    Raises:
        InputError: times that do not advance evenly, and no key time_step.
    """
    if asked is not None:
        return _asked_step(asked, times)
    rounded = unrounded(times)
    if rounded is not None:
        return rounded, (f"times with too few digits for it: taken as {1.0 / rounded:g} samples a second",)
    return _even_step(source, times, places), ()


def _asked_step(asked: float | None, times: np.ndarray) -> tuple[float, tuple[str, ...]]:
    """The step that the key time_step gives, or the mean one of times (n,), and a note where they differ [s]."""
    mean = float(times[-1] - times[0]) / (len(times) - 1)
    if asked is None or (mean > 0.0 and agree([asked, mean])):
        return asked or mean, ()
    return asked, (f"time_step {asked:g} s, as the scene says; the times of the file are {mean:.4g} s apart in the mean",)


def _stated(source: Source, layout: ColumnLayout, column: int) -> Stated | None:
    """Return the quantity of the column by its heading, or else by the comments."""
    heading = layout.headings[column] if layout.headings else ""
    if quantity := named(heading):
        return Stated(quantity, f'the column "{heading}"', firm=True)
    if by_code := of_spoken_channel(heading):
        return by_code
    return of_comments(line for line in source.lines[: layout.first] if line.lstrip().startswith(COMMENTS))


def _read_wrapped(source: Source, request: Request, delimiter: str | None) -> RawRecord:
    """Read one series, or (time, value) pairs, several to a line; lines of text above them are passed over.

    Raises:
        InputError: text among the numbers, keys that do not apply, no step, pairs that are no record.
    """
    if request.column is not None:
        raise source.error(f'the key column does not apply to layout = "{request.layout}", which is one series')
    rows, places, text = _rows(source, delimiter)
    stated = of_comments(text)
    if request.layout == "series":
        table = filled(rows)
        even = [c for c in (0, -1) if len(table) >= FEWEST_ROWS and table.shape[1] > 2 and advances(table[:, c])]
        if even:
            raise source.error(
                f"each line {'ends' if even[0] else 'begins'} with its time or number: such series are not read; write them as time and "
                "value, or as values alone"
            )
        if request.time_step is None:
            raise source.error("no times in the series; give the key time_step, in seconds")
        return RawRecord(np.array([value for row in rows for value in row]), request.time_step, 0.0, None, stated=stated)
    odd = next((place for row, place in zip(rows, places, strict=True) if len(row) % 2), None)
    if odd is not None:
        raise source.error("an odd number of values, where (time, value) pairs belong", odd)
    flat = np.array([value for row in rows for value in row]).reshape(-1, 2)
    found = flat if advances(flat[:, 0]) else paired(filled(rows))
    if found is None:
        raise source.error("the times of the pairs do not advance evenly, neither along the lines nor down the columns")
    step, notes = _asked_step(request.time_step, found[:, 0])
    return RawRecord(found[:, 1], step, float(found[0, 0]), None, stated=stated, notes=notes)


def _fields(source: Source, delimiter: str | None, first: int = 0) -> Iterator[tuple[int, list[str]]]:
    """Index and fields of the lines from one on, with decimal points."""
    for index, line in source.content():
        if index >= first:
            yield index, [decimal(field, delimiter) for field in split(line, delimiter)]


def _rows(source: Source, delimiter: str | None) -> tuple[list[list[float]], list[int], list[str]]:
    """The numbers line by line, the indices of these lines, and the text above them."""
    rows, places = list[list[float]](), list[int]()
    text = [line for line in source.lines if line.lstrip().startswith(COMMENTS)]
    for index, fields in _fields(source, delimiter):
        while delimiter is not None and fields and not fields[-1]:
            fields.pop()  # the line ends with a delimiter
        if not rows and not all(map(is_number, fields)):
            text.append(source.lines[index])
            continue
        rows.append([source.number(field, index) for field in fields])
        places.append(index)
    if sum(map(len, rows)) < 2:
        raise source.error("no lines of numbers")
    for row, place in zip(rows, places, strict=True):
        if len(row) != len(rows[0]) and (row is not rows[-1] or len(row) > len(rows[0])):
            raise source.error(f"{len(row)} values, where the first line has {len(rows[0])}: all but the last line have to be full", place)
    return rows, places, text


def _table(source: Source, layout: ColumnLayout) -> np.ndarray:
    """All numbers of a table (n, w), nan where a field is none; none where a line above the last is of another width."""
    every = _fields(source, layout.delimiter, layout.first)
    rows = [[finite_number(field) or 0.0 if is_number(field) else np.nan for field in fields] for _, fields in every]
    if not rows or any(len(row) != layout.width for row in rows[:-1]) or len(rows[-1]) > layout.width:
        return np.empty((0, layout.width))
    table = filled(rows)
    return table[:, :-1] if np.isnan(table[:, -1]).all() else table  # each line ends with a delimiter


def _refuse_two_ways(source: Source, layout: ColumnLayout, table: np.ndarray, times: list[int], request: Request) -> None:
    """Raise where a table could be read in two ways and the user has not said which."""
    if request.layout is not None:
        return
    by_columns = '"columns" each column by itself'
    if paired(table) is not None:
        raise source.error(
            f'(time, value) pairs side by side that could be one record; the key layout decides: "pairs" reads it as one, {by_columns}'
        )
    titled = [c for c, heading in enumerate(layout.headings) if split_heading(heading)[1] or named(heading) or _names_time(heading)]
    if len(titled) == layout.width or layout.width < 2:  # fewer: a line of text that happens to have as many words
        return
    if not times and is_in_reading_order(table):
        raise source.error(
            f"{table.shape[1]} columns that could be one series, {table.shape[1]} values a line; the key layout decides: "
            f'"series" reads it in reading order, {by_columns}'
        )
    if times in ([0], [table.shape[1] - 1]) and table.shape[1] > 2 and is_in_reading_order(np.delete(table, times[0], axis=1)):
        where = "behind the times" if times == [0] else "before the numbers of the lines"
        what = "its time at the head of each line" if times == [0] else f"{table.shape[1] - 1} values a line"
        raise source.error(
            f"{table.shape[1] - 1} columns {where} that could be one series, {what}; write it as time and value, or as values alone, "
            'or take layout = "columns" where they are columns'
        )


def _layout(source: Source, delimiter: str | None) -> ColumnLayout:
    """Find the heading, the first line of numbers and the number of columns."""
    content = [line for _, line in zip(range(PREAMBLE), source.content(), strict=False)]
    if not content:
        raise source.error("no line of numbers")
    above = _lines_above(content, delimiter)
    content = content[above:]
    text = tuple(line for line in source.lines[: content[0][0]] if line.strip())
    index, line = content[0]
    fields = split(line, delimiter)
    numbers = [is_number(decimal(field, delimiter)) for field in fields]
    width = len(split(content[1][1], delimiter)) if len(content) > 1 else len(fields)
    if not all(numbers) and width != len(fields):
        advice = '; layout = "series" reads one series of several values a line'
        raise source.error(f"{width} columns below a heading of {len(fields)}{advice}", content[1][0])
    if not any(numbers):
        if len(content) < 2:
            raise source.error("no line of numbers below the heading")
        return ColumnLayout(delimiter, content[1][0], tuple(fields), width, text)
    return ColumnLayout(delimiter, index, _heading_in_comment(source, index, delimiter, len(fields)), len(fields), text)


def _lines_above(content: list[tuple[int, str]], delimiter: str | None) -> int:
    """How many lines of text stand above the one above the numbers: those which another line without a number follows."""
    numbered = (any(is_number(decimal(field, delimiter)) for field in split(line, delimiter)) for _, line in content)
    first = next((k for k, found in enumerate(numbered) if found), 0)
    return max(0, first - 1)


def _heading_in_comment(source: Source, first: int, delimiter: str | None, width: int) -> tuple[str, ...]:
    """The last comment above the numbers, when it names as many columns as there are."""
    for line in reversed(source.lines[:first]):
        text = line.strip()
        if not text.startswith(COMMENTS):
            continue
        bare = text.lstrip("#%/ \t")
        fields = next((f for f in (split(bare, delimiter), split(bare, None)) if len(f) == width), [])  # blanks above tabs
        named = width == 1 or any(_names_time(field) for field in fields)
        return tuple(fields) if len(fields) == width and named else ()
    return ()


def _time_columns(source: Source, layout: ColumnLayout, request: Request) -> list[int]:
    """The columns of times; none when the step is given by key."""
    headed = [c for c, heading in enumerate(layout.headings) if _names_time(heading)]
    table = _table(source, layout) if layout.width > 1 and (not headed or len(headed) > 1) else np.empty((0, layout.width))
    even = times_of(table)
    _refuse_two_ways(source, layout, table, even, request)
    if request.time_step is not None and not headed:
        return even if not layout.headings and len(even) < layout.width else []
    if headed:
        return headed
    if layout.headings or layout.width == 1:
        _step_above(source, layout)
        return []
    return [0, *(c for c in even if c > 0)] if len(even) < layout.width else [0]


def _step_above(source: Source, layout: ColumnLayout) -> float:
    """The step that the lines above the headings give [s].

    Raises:
        InputError: there is none, or several.
    """
    steps = firm(layout.above)
    if not steps:
        raise source.error("no time column; give the key time_step, in seconds")
    if not agree(steps):
        raise source.error(f"the lines above the numbers give steps of {min(steps):g} and {max(steps):g} s; the key time_step decides")
    return steps[0]


def _unit_above(layout: ColumnLayout) -> str | None:
    """The one unit that the lines above the headings declare."""
    units = {unit for line in layout.above if layout.headings and (unit := declared_unit(line))}
    return units.pop() if len(units) == 1 else None


def _value_column(source: Source, layout: ColumnLayout, times: list[int], request: Request) -> int:
    """Index of the column that the user asks for."""
    choices = [c for c in range(layout.width) if c not in times]
    named = [layout.headings[c].strip() if layout.headings else str(c) for c in choices]
    some = ", ".join(named[:MOST_NAMED]) + (" ..." if len(named) > MOST_NAMED else "")
    listed = f"columns: {some}" if layout.headings else f"columns are counted from 0: {some}"
    asked = request.column
    if asked is None:
        moving = {c: _quantity(layout.headings[c]) for c in choices} if layout.headings else {}
        first = [c for c, quantity in moving.items() if quantity == "acceleration"]
        if len(choices) == 1 or (len(first) == 1 and all(moving.values())):  # others are its velocity and displacement
            return first[0] if first else choices[0]
        raise source.error(f"several components; say which by the key column; {listed}")
    if isinstance(asked, int):
        if asked in choices:
            return asked
        raise source.error(f"column {asked} {'is the time' if asked in times else 'is not there'}; {listed}")
    word = asked.strip().lower()
    whole = [c for c, name in zip(choices, named, strict=True) if name.lower() == word]
    bare = [c for c in choices if layout.name(c).lower() == word]
    if len(whole) == 1 or len(bare) == 1:
        return whole[0] if len(whole) == 1 else bare[0]
    if whole or bare:
        raise source.error(f'several columns are called "{asked}"; give the place of one, counted from 0; {listed}')
    raise source.error(f'no column "{asked}"{suggest(asked, named)}; {listed}')


def _quantity(heading: str) -> str:
    """Return the quantity of a column by its words or its unit; "" where neither gives it."""
    unit = split_heading(heading)[1]
    by_unit = measured_by(unit) if unit else None
    return named(heading) or (by_unit[0] if by_unit else "")


def _time_factor(source: Source, layout: ColumnLayout, time: int) -> float:
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
    """True for ``t``, ``time``, ``Time (s)``, ``time_ms``, ``Tempo [s]``, ``tiempo``."""
    name = split_heading(heading)[0].lower()
    return name in TIME_NAMES or name.startswith(tuple(f"{word}_" for word in TIME_NAMES if len(word) > 1))


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


TAKES = ("column", "time_step", "layout")
FORMATS = {
    "csv": Reader(recognises_csv, read_csv, loose=True, about="tables with commas, semicolons or tabs", by="anyone", takes=TAKES),
    "columns": Reader(recognises_columns, read_columns, loose=True, about="numbers separated by blanks", by="anyone", takes=TAKES),
}
