# SPDX-License-Identifier: GPL-3.0-or-later
"""Headings of ``key: value`` lines above the numbers of a file, each value with the line it stands on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from loads.readers.fields import is_number
from loads.readers.source import Source


class RecordHeading(NamedTuple):
    """The keys of a heading, each with the index of its line and its value."""

    source: Source
    kind: str  # of file, in messages
    entries: dict[str, tuple[int, str]]

    @classmethod
    def split(cls, source: Source, kind: str, lines: int, separator: str = ":") -> RecordHeading:
        """Split the first lines that have a separator; keys in capitals."""
        found: dict[str, tuple[int, str]] = {}
        for index, line in enumerate(source.lines[:lines]):
            key, there, value = line.partition(separator)
            if there:
                found.setdefault(" ".join(key.upper().split()), (index, value.strip()))
        return cls(source, kind, found)

    def has(self, *beginnings: str) -> bool:
        """Return True if there are keys that begin so."""
        return all(any(key.startswith(beginning) for key in self.entries) for beginning in beginnings)

    def find(self, beginning: str) -> tuple[int, str]:
        """Index of the line and value of the first key that begins so.

        Raises:
            InputError: there is none.
        """
        found = next((entry for key, entry in self.entries.items() if key.startswith(beginning)), None)
        if found is None:
            raise self.source.error(f"no line {beginning} in the heading of a {self.kind} file")
        return found

    def text(self, key: str) -> str:
        """The value of a key; empty where there is none."""
        return self.entries.get(key, (0, ""))[1]

    def positive(self, beginning: str, place: int | None = None) -> float:
        """A number above zero; where ``place`` is given, one of ``/0.005/0.005/0.005``."""
        index, text = self._entry(beginning, place)
        return self.source.positive(text, index, beginning)

    def check_count(self, beginning: str, values: np.ndarray, times: float = 1.0, place: int | None = None) -> None:
        """Raise unless there are as many values as a key says, or a given number of times them."""
        index, text = self._entry(beginning, place)
        self.source.check_count(values, times * self.source.number(text, index), index)

    def _entry(self, beginning: str, place: int | None) -> tuple[int, str]:
        index, text = self.find(beginning)
        words = [text] if place is None else text.strip("/ ").split("/")
        if (place or 0) >= len(words):
            raise self.source.error(f"{len(words)} entries, and channel {(place or 0) + 1} is required", index)
        return index, words[place or 0]


def first_of_numbers(source: Source, index: int) -> int:
    """The index of the first line from one on that begins with a number; of the one itself where there is none."""
    lines = ((k, source.lines[k].split()) for k in range(index, len(source.lines)))
    return next((k for k, words in lines if words and is_number(words[0])), index)


def columns(source: Source, first: int, wanted: Sequence[int], width: int) -> np.ndarray:
    """Some columns of the lines of numbers from one line on, (n, columns), each line of a width.

    Raises:
        InputError: a line of another width, text among the numbers.
    """
    rows = []
    for index in range(first, len(source.lines)):
        words = source.lines[index].split()
        if words and len(words) != width:
            raise source.error(f"{len(words)} columns, where the table has {width}", index)
        if words:
            rows.append([source.number(words[c], index) for c in wanted])
    if len(rows) < 2:
        raise source.error(f"{len(rows)} rows of numbers are no record")
    return np.array(rows)
