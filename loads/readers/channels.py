# SPDX-License-Identifier: GPL-3.0-or-later
"""What files of several channels share: how the key ``column`` picks one, and numbers that stand in fields of a fixed width.

Old formats are written by Fortran programs: ``(8F10.3)`` is eight numbers a line, ten characters each, which may touch. They are
therefore cut by their place, not at blanks. Samples of film are read at uneven times; they are interpolated, and the record says so.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from loads.readers.source import Request, Source, refuse_calibration, refuse_layout

FORMAT = re.compile(r"(\d+)\s*[FEGDI]\s*(\d+)", re.IGNORECASE)  # eight numbers in fields of ten: 8F10.3
IRREGULAR = 0.2  # of a step: times with three digits at 200 Hz stay below
DEGREES = re.compile(r"\s*\bDEG(?:REES)?\b\.?", re.IGNORECASE)
LONGEST_NAME = 30  # characters
MOST = 1e9  # values of a channel: 30 days at 400 Hz


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


def pick(source: Source, names: Sequence[str], request: Request, kind: str) -> int:
    """The place of the channel that the user asks for by its name, or by its place counted from 0.

    Raises:
        InputError: several channels and none named, no such channel; keys that do not apply.
    """
    refuse_layout(source, request, kind)
    if request.time_step is not None:
        raise source.error(f"the key time_step does not apply to {kind} files, whose header gives it")
    if not names:
        raise source.error(f"no channel of a {kind} file found")
    asked, listed = request.column, f"channels: {', '.join(names)}"
    if asked is None:
        if len(names) > 1:
            raise source.error(f"several channels; say which by the key column; {listed}")
        return 0
    if isinstance(asked, int) and 0 <= asked < len(names):
        return asked
    word = str(asked).strip().upper()
    found = [k for k, name in enumerate(names) if name.upper() == word]
    if len(found) > 1:
        raise source.error(f'several channels are called "{asked}"; give the place of one, counted from 0; {listed}')
    if not found:
        raise source.error(f'no channel "{asked}"; {listed}')
    return found[0]


def only_physical(source: Source, request: Request, kind: str) -> None:
    """Raise where a calibration is given for values that are no counts."""
    refuse_calibration(source, request, kind)


def component(text: str) -> str:
    """The name of a component as a line writes it, without the word for degrees: ``360``, ``N90E``, ``UP``."""
    return " ".join(DEGREES.sub("", text).split())[:LONGEST_NAME] or "?"


def whole(source: Source, word: str, index: int, what: str) -> int:
    """A whole number above one, as the header announces it.

    Raises:
        InputError: it is none.
    """
    number = source.number(word, index)
    if number < 2 or number > MOST or number != int(number):
        raise source.error(f"{what} must be a whole number above one, got {word.strip()[:40]}", index)
    return int(number)


def positive(source: Source, word: str, index: int, what: str) -> float:
    """A number above zero.

    Raises:
        InputError: it is none.
    """
    number = source.number(word, index)
    if number <= 0.0:
        raise source.error(f"{what} must be above zero, got {word.strip()[:40]}", index)
    return number


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
    if last and more is not None and numbers_alone(source.lines[more]):
        raise source.error(f"the header announces {count} values, more follow: longer than it says", more)
    return np.array(values), after


def numbers_alone(line: str) -> bool:
    """Whether a line holds numbers and nothing else."""
    try:
        return bool([float(word) for word in line.split()])
    except ValueError:
        return False


def evenly(source: Source, times: np.ndarray, values: np.ndarray, index: int) -> tuple[np.ndarray, float, tuple[str, ...]]:
    """Samples at even times, their step [s], and what was done to them.

    Args:
        source: the file.
        times: (n,) [s].
        values: (n,).
        index: of the line where they begin.

    Raises:
        InputError: the times do not advance.
    """
    steps = np.diff(times)
    if (steps <= 0.0).any():
        worst = int(np.argmax(steps <= 0.0))
        raise source.error(f"the time does not advance: {times[worst]:g} then {times[worst + 1]:g}", index)
    mean = float(times[-1] - times[0]) / len(steps)
    if np.abs(times - times[0] - mean * np.arange(len(times))).max() <= IRREGULAR * mean:
        return values, mean, ()
    step = float(np.median(steps))
    grid = times[0] + step * np.arange(int((times[-1] - times[0]) / step + 1e-6) + 1)
    note = f"uneven times, {steps.min():.3g} to {steps.max():.3g} s apart: interpolated linearly to a step of {step:.4g} s"
    return np.interp(grid, times, values), step, (note,)
