# SPDX-License-Identifier: GPL-3.0-or-later
"""One series behind a heading that gives the number of its values and their step: any layout, read in reading order.

    TITLE
    1706 0.0200
    five values a line ...

A heading line counts when one of its whole numbers is the number of all values below it, and the step stands beside it: ``DT = .005``,
``200 Hz``, or a second number that a step can be.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from loads.readers.quantity import of_comments
from loads.readers.source import COMMENTS, RawRecord, Reader, Request, Source, refuse_keys
from loads.readers.units import units_in

HEADING = 20  # lines of text above the numbers, at most
FEWEST = 8  # values
STEP = re.compile(r"\b(?:DT|STEP|PASSO|PASO|INTERVALO?|SAMPLING INTERVAL)\b[^\d.+-]*([\d.]+(?:E[+-]?\d+)?)", re.IGNORECASE)
RATE = re.compile(r"([\d.]+)\s*(?:HZ\b|SAMPLES|SPS\b)", re.IGNORECASE)
NUMBER = re.compile(r"(?<![\w.])[+-]?(?:\d+\.?\d*|\.\d+)(?:[Ee][+-]?\d+)?(?![\w.])")
SHORTEST, LONGEST = 1e-4, 0.2  # [s] of a step that has no word beside it


class _Found(NamedTuple):
    step: float
    first: int  # index of the first line of numbers
    values: np.ndarray


def recognises(source: Source) -> bool:
    """True when a heading counts the values below it."""
    return _found(source) is not None


def read(source: Source, request: Request) -> RawRecord:
    """Read the series.

    Raises:
        InputError: no heading that counts the values.
    """
    refuse_keys(source, request, "counted text")
    found = _found(source)
    if found is None:
        raise source.error("no line above the numbers gives how many there are, and their step")
    heading = [line for line in source.lines[: found.first] if line.strip()]
    units = {unit for line in heading for unit in units_in(line)}
    return RawRecord(found.values, found.step, 0.0, units.pop() if len(units) == 1 else None, stated=of_comments(heading))


def _found(source: Source) -> _Found | None:
    """The heading and the values, where one of the heading's lines counts them."""
    rows = [line for line in source.lines if line.strip() and not line.lstrip().startswith(COMMENTS)]
    if len(rows) < 2:
        return None
    words = [line.split() for line in source.lines]
    for index in range(min(HEADING, len(words) - 1)):
        step = _step(source.lines[index])
        if step is None:
            continue
        values = _numbers(words[index + 1 :])
        first = next((i for i in range(index + 1, len(words)) if words[i]), index + 1)
        if values is not None and len(values) >= FEWEST and str(len(values)) in NUMBER.findall(source.lines[index]):
            return _Found(step, first, values)
    return None


def _step(line: str) -> float | None:
    """The step that a line gives [s]; None where it gives none."""
    if found := STEP.search(line):
        step = _float(found[1])
    elif found := RATE.search(line):
        rate = _float(found[1])
        step = 1.0 / rate if rate else None
    else:
        numbers = [_float(word) or 0.0 for word in NUMBER.findall(line)]
        fitting = [number for number in numbers if SHORTEST <= number <= LONGEST]
        step = fitting[0] if len(fitting) == 1 else None
    return step if step is not None and step > 0.0 else None


def _float(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None


def _numbers(lines: list[list[str]]) -> np.ndarray | None:
    """All words as numbers; None where one is none."""
    try:
        values = np.array([float(word) for line in lines for word in line])
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None


FORMATS = {
    "counted": Reader(
        recognises,
        read,
        loose=True,
        about="one series below a line with count and step, any number of values a line",
        by="spectrum-matching and other programs",
    )
}
