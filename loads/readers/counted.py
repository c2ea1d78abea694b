# SPDX-License-Identifier: GPL-3.0-or-later
"""One series behind a heading that gives the number of its values and their step: any layout, read in reading order.

    TITLE                           SITE 7, ACCELERATION IN M/S2
    1706 0.0200                     1600 SAMPLES AT 200 HZ
    five values a line ...          values, or pairs of time and value ...

One of the heading's whole numbers is the number of all values below it. The step stands on the same line or on another: ``DT = .005``, a
rate, which is a number of ``HZ``, ``SPS`` or samples per second, or, on the same line alone, a second number that a step can be. A number
is count or rate, never both, and lines that contradict each other give no step.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from loads.readers.quantity import of_comments
from loads.readers.rates import Spacing, one_step, spacings
from loads.readers.source import COMMENTS, RawRecord, Reader, Request, Source
from loads.readers.units import one_unit
from loads.readers.wrapped import advances

HEADING = 20  # lines of text above the numbers, at most
FEWEST = 8  # values
SHORTEST, LONGEST = 1e-4, 0.2  # [s] of a step that has no word next to it
NUMBER = re.compile(r"(?<![\w.])[+-]?(?:\d+\.?\d*|\.\d+)(?:[Ee][+-]?\d+)?(?![\w.])")


class _Found(NamedTuple):
    steps: list[float]  # as the heading gives them [s], at least one
    first: int  # index of the first line of numbers
    origin: float  # time of the first value [s]
    values: np.ndarray
    end: int = 0  # index of the line behind the values


def recognises(source: Source) -> bool:
    """True when a heading counts the values below it and gives their step."""
    return _found(source) is not None


def read(source: Source, request: Request) -> RawRecord:
    """Read the series."""
    found = _found(source)
    if found is None:
        raise source.error("no line above the numbers gives how many there are, and, by another number, one step or rate")
    step = one_step(source, found.steps, found.first - 1)
    heading = [line for line in source.lines[: found.first] if line.strip()]
    if any(float(line[slice(*stated.place)]) == len(found.values) for line in heading for stated in spacings(line)):
        said = f"{len(found.values)} as the number of values and as their rate: correct the file, or leave one out"
        raise source.error(f"the heading gives {said}", found.first - 1)
    left = len(source.lines) - found.end
    notes = (f"{left} lines from line {source.skipped + found.end + 1} on, behind the first series, not read",) if left else ()
    return RawRecord(found.values, step, found.origin, one_unit(heading), stated=of_comments(heading), notes=notes)


def _found(source: Source) -> _Found | None:
    """The heading and the values, where one of the heading's lines counts them."""
    if sum(1 for line in source.lines if line.strip() and not line.lstrip().startswith(COMMENTS)) < 2:
        return None
    words = [line.split() for line in source.lines]
    numbers = [_numbers([line]) is not None for line in words]
    texts = [-1, *(i for i, alone in enumerate(numbers[:HEADING]) if not alone)]
    series = (_below(source, words, numbers, text) for text in texts if text + 1 < len(words) and numbers[text + 1])
    return next((found for found in series if found is not None), None)


def _below(source: Source, words: list[list[str]], numbers: list[bool], text: int) -> _Found | None:
    """The series below one of the lines of text, up to the next one."""
    end = next((i for i in range(text + 1, len(words)) if not numbers[i]), len(words))
    held = _numbers(words[text + 1 : end])
    if held is None:
        return None
    before = 0  # values between the text and the line that is looked at
    for index in range(min(HEADING, end - 1)):
        before += len(words[index]) if index > text else 0
        values, first = held[before:], next((i for i in range(max(index, text) + 1, end) if words[i]), index + 1)
        leads = index <= text or before == len(words[index])  # no numbers above it
        found = _counted(source.lines, index, values, leads) if len(values) >= FEWEST else None
        if found is not None:
            return _Found(found[0], first, *found[1:], end)
    return None


def _counted(lines: Sequence[str], index: int, values: np.ndarray, pairs: bool) -> tuple[list[float], float, np.ndarray] | None:
    """Steps, time of the first value, and the values that a line of the heading counts, alone or as pairs; None where it does not."""
    line, own = lines[index], [*spacings(lines[index])]
    taken = [stated.place for stated in own]
    numbers = [float(word[0]) for word in NUMBER.finditer(line) if not any(a < word.end() and word.start() < b for a, b in taken)]
    pairs = pairs and len(values) % 2 == 0 and len(values) // 2 in numbers and advances(values[::2])
    if len(values) not in numbers and not pairs:
        return None
    steps = _steps(lines, index, own, numbers)
    if not steps or len(values) in numbers:
        return (steps, 0.0, values) if steps else None
    times = values[::2]
    spaced = float(times[-1] - times[0]) / (len(times) - 1)
    return ([*steps, spaced] if abs(spaced - steps[0]) > 0.5 * steps[0] / len(times) else steps, float(times[0]), values[1::2])


def _steps(lines: Sequence[str], index: int, own: Sequence[Spacing], numbers: Sequence[float]) -> list[float]:
    """The steps that the line of the count gives, and those of the lines around it that can be of nothing else; or all that these give."""
    fitting = [number for number in numbers if SHORTEST <= number <= LONGEST]
    others = [stated for k, line in enumerate(lines[:HEADING]) if k != index for stated in spacings(line)]
    here = [stated.step for stated in own] or (fitting if len(fitting) == 1 else [])
    return [*here, *(stated.step for stated in others if stated.firm)] or [stated.step for stated in others]


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
        about="one series below a heading with count and step, any number of values a line",
        by="spectrum-matching and other programs",
        takes=(),
    )
}
