# SPDX-License-Identifier: GPL-3.0-or-later
"""Common pieces of the readers of record files: lines of a text file, numbers with the line they stand on, and what a reader returns."""

from __future__ import annotations

import codecs
import math
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from loads.readers.quantity import Stated
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.files import read_bytes

COMMENTS = ("#", "%", "//")
MOST = 1e9  # values of a channel: 30 days at 400 Hz
FORTRAN = re.compile(r"(\d\.\d*|\.\d+)D([+-]?\d{1,3})(?!\w)", re.IGNORECASE)  # double precision: 1.5D-03


@dataclass(frozen=True)
class Source:
    """A file as lines of text and as bytes, and how to call it in a message (``loads[0].path: quake.csv``); a binary file has no lines."""

    label: str
    lines: tuple[str, ...]
    data: bytes = field(default=b"", repr=False)
    skipped: int = 0  # lines of the file before the first of these

    @classmethod
    def open(cls, path: Path, label: str, skip: int = 0) -> Source:
        """Read a file without its first ``skip`` lines.

        Raises:
            InputError: no such file, not readable, an empty one, or one without lines to skip.
        """
        try:
            data = read_bytes(path, label)
        except FileNotFoundError:
            near = suggest(path.name, (p.name for p in path.parent.iterdir())) if path.parent.is_dir() else ""
            raise InputError(label, f"no such file{near}") from None
        except IsADirectoryError:
            raise InputError(label, "is a folder") from None
        except OSError as failure:
            raise InputError(label, f"cannot be read ({failure.strerror})") from None
        text = _decoded(data)
        if text is None:
            if skip:
                raise InputError(label, "the key skip does not apply to a file that is not text")
            return cls(label, (), data)
        lines = tuple(FORTRAN.sub(r"\1E\2", text).splitlines())
        if not any(line.strip() for line in lines[skip:]):
            raise InputError(label, f"nothing is left of its {len(lines)} lines after the {skip} to skip" if skip else "the file is empty")
        return cls(label, lines[skip:], data, skip)

    def error(self, message: str, index: int | None = None) -> InputError:
        """The error to raise; it names the file and, given the index of a line, its number counted from 1."""
        return InputError(self.label if index is None else f"{self.label}, line {self.skipped + index + 1}", message)

    def number(self, word: str, index: int) -> float:
        """The finite number that a word on a line stands for."""
        try:
            value = float(word.replace("_", "?"))  # Python would read 1_000
        except ValueError:
            raise self.error(f'"{word.strip()[:40]}" where a number belongs', index) from None
        if not math.isfinite(value):
            raise self.error(f"{word.strip()} is not a finite number", index)
        return value

    def stream(self, first: int) -> np.ndarray:
        """All numbers from a line on, separated by blanks."""
        return np.array([self.number(word, i) for i in range(first, len(self.lines)) for word in self.lines[i].split()], dtype=float)

    def positive(self, word: str, index: int, what: str) -> float:
        """A number above zero; ``what`` names it."""
        number = self.number(word, index)
        if number <= 0.0:
            raise self.error(f"{what} must be above zero, got {word.strip()[:40]}", index)
        return number

    def whole(self, word: str, index: int, what: str) -> int:
        """A whole number above one, as a header announces it; ``what`` names it."""
        number = self.number(word, index)
        if number < 2 or number > MOST or number != int(number):
            raise self.error(f"{what} must be a whole number above one, got {word.strip()[:40]}", index)
        return int(number)

    def check_count(self, values: np.ndarray, announced: float, index: int | None = None) -> None:
        """Raise unless there are as many values as the header announces, which may be any number."""
        if abs(len(values) - announced) > 0.5:
            what = "cut short" if len(values) < announced else "longer than it says"
            raise self.error(f"the header announces {announced:.10g} values, the file holds {len(values)}: {what}", index)

    def content(self) -> Iterable[tuple[int, str]]:
        """Index and text of the lines that are neither blank nor comments."""
        return ((i, line) for i, line in enumerate(self.lines) if line.strip() and not line.lstrip().startswith(COMMENTS))


class Request(NamedTuple):
    """Statements of the user about the file."""

    column: str | int | None = None  # a heading, channel or component, or its place counted from 0
    time_step: float | None = None  # [s]
    calibration: float | None = None  # what one count of a digitiser means, in the key units
    layout: str | None = None  # of a table of numbers: "columns", "series" or "pairs"


@dataclass(frozen=True, eq=False)
class RawRecord:
    """Contents of the file, in its own unit."""

    values: np.ndarray  # (n,)
    step: float  # [s]
    origin: float  # time of the first value [s]
    unit: str | None  # as written in the file
    name: str = ""  # of the column or component
    column: int | None = None  # its place in a table, counted from 0
    stated: Stated | None = None  # what the file says the values are, apart from their unit
    counts: bool = False  # of a digitiser, whose meaning the file does not give
    notes: tuple[str, ...] = ()  # what was done to the samples to read them


class Reader(NamedTuple):
    """A format of record files.

    ``read`` raises an InputError, with the line at fault, where a heading lacks something or contradicts itself, a channel is not there or
    not named among several, text stands among the numbers, or there are more or fewer of them than is announced.
    """

    recognises: Callable[[Source], bool]
    read: Callable[[Source, Request], RawRecord]
    loose: bool = False  # recognises much, so that it is asked last
    about: str = ""  # what is read of it
    by: str = ""  # who publishes it
    takes: tuple[str, ...] = Request._fields  # what the user may say: what the format itself fixes, or has not, is refused


def begins(mark: str, lines: int = 1) -> Callable[[Source], bool]:
    """Return a test that recognises files that have some words in capitals in one of their first lines."""
    return lambda source: any(mark in line.upper() for line in source.lines[:lines])


def _decoded(data: bytes) -> str | None:
    """The text of a file; None of a binary one."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):  # as spreadsheets write "Unicode text"
        with suppress(UnicodeDecodeError):
            return data.decode("utf-16")
    if b"\0" in data[:65536]:
        return None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")  # old headers hold accents in this encoding; numbers read the same
