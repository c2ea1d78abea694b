# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of several channels, each a series in fields of a fixed width: where it stands, what is known of it, and how ``column`` picks one.

Samples of film are read at uneven times; they are interpolated, and the record says so.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from loads.readers.fixed import Fields, fixed
from loads.readers.quantity import Stated
from loads.readers.source import RawRecord, Request, Source
from masonry_cd.foundation.errors import InputError, suggest

IRREGULAR = 0.2  # of a step: times with three digits at 200 Hz stay below
REPEATED = 0.01  # of uneven times at most: where the digits of film's times do not tell neighbours apart
DEGREES = re.compile(r"\s*\bDEG(?:REES)?\b\.?", re.IGNORECASE)
LONGEST_NAME = 30  # characters


class Channel(NamedTuple):
    """A channel of a file, and its series as the heading announces it."""

    name: str  # of its component
    first: int  # index of the first line of values
    points: int
    step: float  # [s]
    unit: str | None
    stated: Stated | None
    fields: Fields
    timed: bool = False  # a time stands before each value
    counts: bool = False  # of a digitiser
    last: bool = True  # nothing may follow that could be more of them


def read_channel(source: Source, request: Request, channels: Sequence[Channel]) -> RawRecord:
    """The channel that the user asks for.

    Raises:
        InputError: no such channel, text among the numbers, a wrong count, times that do not advance; a calibration of no counts.
    """
    one = channels[pick([channel.name for channel in channels], request.column, source.error)]
    if request.calibration is not None and not one.counts:
        raise source.error("the key calibration does not apply to values that are no counts", one.first - 1)
    values, _ = fixed(source, one.first, one.points * (2 if one.timed else 1), one.fields, one.last)
    if one.timed:
        even, step, notes = evenly(source, values[::2], values[1::2], one.first)
        return RawRecord(even, step, float(values[0]), one.unit, one.name, stated=one.stated, notes=notes)
    factor = request.calibration or 1.0
    return RawRecord(factor * values, one.step, 0.0, one.unit, one.name, stated=one.stated, counts=one.counts)


def pick(names: Sequence[str], asked: str | int | None, error: Callable[[str], InputError]) -> int:
    """The place of the channel that the user asks for: by its name, by the end of one such as ``IV.AQK..HNE``, or by its place.

    Raises:
        InputError: no channel; several and none named; no such channel, or several of that name.
    """
    listed = f"channels: {', '.join(names)}"
    if not names:
        raise error("no channel found")
    if asked is None:
        if len(names) > 1:
            raise error(f"several channels; say which by the key column; {listed}")
        return 0
    if isinstance(asked, int) and 0 <= asked < len(names):
        return asked
    word = str(asked).strip().upper()
    found = [k for k, name in enumerate(names) if word in (name.upper(), code_of(name).upper())]
    if len(found) > 1:
        raise error(f'several channels are called "{asked}"; give the place of one, counted from 0; {listed}')
    if not found:
        raise error(f'no channel "{asked}"{suggest(word, names)}; {listed}')
    return found[0]


def code_of(name: str) -> str:
    """The code of a channel in its whole name, ``IV.AQK..HNE``."""
    return name.rpartition(".")[2]


def component(text: str) -> str:
    """The name of a component as a line writes it, without the word for degrees: ``360``, ``N90E``, ``UP``."""
    return " ".join(DEGREES.sub("", text).split())[:LONGEST_NAME] or "?"


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
    uneven = np.ptp(steps) > IRREGULAR * np.mean(steps)
    if (steps < 0.0).any() or np.mean(steps == 0.0) > (REPEATED if uneven else 0.0):
        worst = int(np.argmax(steps <= 0.0))
        raise source.error(f"the time does not advance: {times[worst]:g} then {times[worst + 1]:g}", index)
    repeats = int((steps == 0.0).sum())
    if repeats:
        first = np.flatnonzero(np.concatenate([[True], steps > 0.0]))
        values = np.add.reduceat(values, first) / np.diff([*first, len(times)])
        times = times[first]
        steps = np.diff(times)
    mean = float(times[-1] - times[0]) / len(steps)
    if np.abs(times - times[0] - mean * np.arange(len(times))).max() <= IRREGULAR * mean:
        return values, mean, ()
    step = float(np.median(steps))
    grid = times[0] + step * np.arange(int((times[-1] - times[0]) / step + 1e-6) + 1)
    note = f"uneven times, {steps.min():.3g} to {steps.max():.3g} s apart: interpolated linearly to a step of {step:.4g} s"
    more = f"{repeats} times that repeat, written with too few digits: the mean of their values taken"
    return np.interp(grid, times, values), step, (note, *([more] if repeats else []))
