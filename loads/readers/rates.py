# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps that lines of text give by words: ``DT = .005``, ``SAMPLING INTERVAL 5 MS``, ``200 HZ``, ``200 SPS``, ``SAMPLING RATE (HZ): 200``.

A rate is a number of Hz, sps or samples per second; a number of samples is none, and the Hz of a filter or an instrument are not either.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from loads.readers.source import Source

ALIKE = 1e-3  # statements of one step agree so far: 0.0033 and 300 Hz do not
EVEN = 0.2  # of a step: times whose steps differ by less show it well enough
FEWEST, PARTS = 40, 8  # times that show a rounding; parts of them that are compared
SLACK, SHIFT = 1e-6, 0.3  # of a digit
SHORTEST = 1e-3  # of a record [s]
LONGEST = 400  # characters of a line that are looked at
ANY_CASE = re.IGNORECASE
_VALUE = r"(?P<value>(?:\d+\.?\d*|\.\d+)(?:E[+-]?\d+)?)"
_S = r"(?:S|SEC|SECS|SECONDS?|SEGUNDOS?|SEG|SECONDO)\b"
_SAMPLES = r"(?:SAMPLES?|POINTS?|PTS?|VALUES?|DATA|MUESTRAS|CAMPIONI|PUNTI)"
STEP = re.compile(
    r"\b(?:DT|DELTA[ _-]?T|(?:TIME|SAMPLE|SAMPLING)?[ _-]?(?:STEP|INTERVAL)|PASSO|PASO|INTERVALLO|INTERVALO)\b"
    rf"(?P<between>[^\d.+-]{{0,40}}){_VALUE}\s*(?P<unit>MS\b|MSEC\b|MILLI\w*)?",
    re.IGNORECASE,
)
RATES = (
    re.compile(rf"(?<![\d.]-)(?<!\bTO )(?<!- )(?<![\w.]){_VALUE}\s*(?:HZ\b|HERTZ\b|SPS\b|{_SAMPLES}\s*(?:/|PER|A|AL|POR)\s*{_S})", re.I),
    re.compile(rf"\b{_SAMPLES}\s*/\s*{_S}\s*[=:]\s*{_VALUE}", re.IGNORECASE),
    re.compile(rf"\b(?:RATE|FREQ\w*|FS)\b[^\d.]{{0,40}}\(\s*(?:HZ|SPS|{_SAMPLES}\s*/\s*{_S})\s*\)[^\d.]{{0,20}}{_VALUE}", re.IGNORECASE),
)
FILTERS = re.compile(r"FILT|BAND|PASS\b|CORNER|CUT|NYQUIST|TAPER|NATURAL|RESONAN|INSTR", re.IGNORECASE)  # whose Hz are no rate
SAMPLED = re.compile(r"\bSAMPL\w*[^\d]*$", re.IGNORECASE)


class Spacing(NamedTuple):
    """A step that a line gives [s], the place of its number on the line, and whether it can be of nothing else."""

    step: float
    place: tuple[int, int]
    firm: bool


def agree(steps: Sequence[float]) -> bool:
    """Return True if steps, at least one, are one."""
    return max(steps) - min(steps) <= ALIKE * min(steps)


def one_step(source: Source, steps: Sequence[float], index: int) -> float:
    """The step that a heading gives, which ends at a line [s].

    Raises:
        InputError: it gives several.
    """
    if not agree(steps):
        raise source.error(f"the lines above the numbers give steps of {min(steps):g} and {max(steps):g} s: correct the file", index)
    return steps[0]


def firm(lines: Iterable[str]) -> list[float]:
    """The steps [s] that lines give beyond doubt."""
    return [spacing.step for line in lines for spacing in spacings(line) if spacing.firm]


def spacings(line: str) -> Iterator[Spacing]:
    """The steps that a line gives by words, in its first characters."""
    line = line[:LONGEST]
    for found in STEP.finditer(line):
        size = 1e-3 if found["unit"] or re.search(r"\bMS(?:EC)?\b|\bMILLI", found["between"], re.IGNORECASE) else 1.0
        if value := float(found["value"]):
            yield Spacing(size * value, found.span("value"), firm=True)
    of_filter = bool(FILTERS.search(line))
    for found in chain.from_iterable(pattern.finditer(line) for pattern in RATES):
        value, sampled = float(found["value"]), bool(SAMPLED.search(line[: found.start("value")]))
        if value and (sampled or not of_filter):
            yield Spacing(1.0 / value, found.span("value"), firm=sampled or not found[0].upper().endswith(("HZ", "HERTZ")))


def unrounded(times: np.ndarray) -> float | None:
    """The step [s] of times (n,) that were written with so few digits that some repeat, at a whole number of samples a second.

    Rounded times stay within half a digit of even ones everywhere, and their steps vary everywhere; a line that is missing or there twice
    shifts all that follow.
    """
    steps = np.diff(times)
    digit = float(steps[steps > 0.0].min(initial=np.inf))
    uneven = len(times) >= FEWEST and all(np.ptp(part) > EVEN * np.mean(steps) for part in np.array_split(steps, PARTS))
    if not uneven or not np.isfinite(digit) or (steps < 0.0).any() or not times[-1] - times[0] > SHORTEST:
        return None
    rate = round((len(times) - 1) / float(times[-1] - times[0]))
    if rate < 1:
        return None
    off = times - np.arange(len(times)) / rate
    means = [float(part.mean()) for part in np.array_split(off, PARTS)]
    return 1.0 / rate if np.ptp(off) <= digit * (1.0 + SLACK) and max(means) - min(means) <= SHIFT * digit else None
