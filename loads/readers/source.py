# SPDX-License-Identifier: GPL-3.0-or-later
"""What the readers of record files share: the lines of a text file, numbers with the line they stand on, and what a reader returns."""

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
FORTRAN = re.compile(r"(\d\.\d*|\.\d+)D([+-]?\d{1,3})(?!\w)", re.IGNORECASE)  # double precision: 1.5D-03


@dataclass(frozen=True)
class Source:
    """A file as lines of text and as bytes, and how to call it in a message (``loads[0].path: quake.csv``); a binary file has no lines."""

    label: str
    lines: tuple[str, ...]
    data: bytes = field(default=b"", repr=False)

    @classmethod
    def open(cls, path: Path, label: str) -> Source:
        """Read a file.

        Raises:
            InputError: no such file, not readable, or an empty one.
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
            return cls(label, (), data)
        lines = tuple(FORTRAN.sub(r"\1E\2", text).splitlines())
        if not any(line.strip() for line in lines):
            raise InputError(label, "the file is empty")
        return cls(label, lines, data)

    def error(self, message: str, index: int | None = None) -> InputError:
        """The error to raise; it names the file and, given the index of a line, its number counted from 1."""
        return InputError(self.label if index is None else f"{self.label}, line {index + 1}", message)

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

    def content(self) -> Iterable[tuple[int, str]]:
        """Index and text of the lines that are neither blank nor comments."""
        return ((i, line) for i, line in enumerate(self.lines) if line.strip() and not line.lstrip().startswith(COMMENTS))


@dataclass(frozen=True)
class Request:
    """What the user says about the file."""

    column: str | int | None = None
    time_step: float | None = None  # [s]
    calibration: float | None = None  # what one count of a digitiser means, in the key units
    layout: str | None = None  # of a table of numbers: "columns", "series" or "pairs"


@dataclass(frozen=True, eq=False)
class RawRecord:
    """What stands in the file, in its own unit."""

    values: np.ndarray  # (n,)
    step: float  # [s]
    origin: float  # time of the first value [s]
    unit: str | None  # as written in the file
    name: str = ""  # of the column or component
    column: int | None = None  # its place in a table, counted from 0
    stated: Stated | None = None  # what the file says the values are, beside their unit
    counts: bool = False  # of a digitiser, whose meaning the file does not give
    notes: tuple[str, ...] = ()  # what was done to the samples to read them


class Reader(NamedTuple):
    """A format of record files."""

    recognises: Callable[[Source], bool]
    read: Callable[[Source, Request], RawRecord]
    loose: bool = False  # recognises much, so that it is asked last
    about: str = ""  # what is read of it
    by: str = ""  # who publishes it


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


def check_count(source: Source, values: np.ndarray, announced: float, index: int | None = None) -> None:
    """Raise unless the file holds as many values as its header announces, which may be any number."""
    if abs(len(values) - announced) > 0.5:
        what = "cut short" if len(values) < announced else "longer than it says"
        raise source.error(f"the header announces {announced:.10g} values, the file holds {len(values)}: {what}", index)


def refuse_keys(source: Source, request: Request, kind: str) -> None:
    """Raise where the user gives a column, a time step or a calibration that the format itself fixes."""
    if request.column is not None:
        raise source.error(f"the key column does not apply to {kind} files, which hold one component")
    refuse_calibration(source, request, kind)
    refuse_layout(source, request, kind)
    if request.time_step is not None:
        raise source.error(f"the key time_step does not apply to {kind} files, whose header gives it")


def refuse_layout(source: Source, request: Request, kind: str) -> None:
    """Raise where the user gives the layout of a table for a format that fixes it."""
    if request.layout is not None:
        raise source.error(f"the key layout does not apply to {kind} files, only to tables of numbers")


def refuse_calibration(source: Source, request: Request, kind: str) -> None:
    """Raise where the user gives a calibration for values that are no counts, or whose header has one: it is applied once."""
    if request.calibration is not None:
        raise source.error(f"the key calibration does not apply to {kind} files, only to those of counts, such as miniSEED")
