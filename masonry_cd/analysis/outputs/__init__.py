# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers that a run comes to: each one declaration, which all that shows it reads.

A module here lists its own in ``NUMBERS``, by the key that files call them by. summary.json, runs.csv and its limit states, assess.csv and
its answers, comparisons, the page, axes of pictures and the reference (docs/outputs.md) take from there which numbers there are, in which
order, what they are called and in which unit; so a new number is one new file here and its test.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from masonry_cd.foundation.extensions import Entries

if TYPE_CHECKING:  # studies are checked before HDF5 is loaded
    from masonry_cd.analysis.outputs.measured import Measured

SUMMARY, STUDY, STUDY_PAGE = "summary.json", "runs.csv", "study.html"
ASSESS, ANSWER = "assess.csv", "assess.html"
COMPARE, PAGE = "comparison.csv", "report.html"
FORMATS = (SUMMARY, STUDY, STUDY_PAGE, ASSESS, ANSWER, COMPARE, PAGE)
LAST = 1000  # place of a number behind those that have one of their own


@dataclass(frozen=True)
class Number:
    """A number of a run."""

    name: str  # as text
    meaning: str  # its line of the reference
    compute: Callable[[Measured], Any]  # None where a run has no such number
    places: Mapping[str, int] = field(default_factory=lambda: dict.fromkeys(FORMATS, LAST))  # by the FORMATS that show it, in what order
    unit: str = ""  # in files; empty of counts, shares and words
    shown: tuple[str, float] = ("", 1.0)  # unit in which people read it, and the factor into it
    whole: bool = False  # a count
    short: str = ""  # heading of a narrow column; the name where there is none
    keys: Mapping[str, str] = field(default_factory=dict)  # by formats that call it by another key
    judges: bool = True  # may be the quantity of a limit state

    @property
    def title(self) -> str:
        """Name and unit, as an axis has them."""
        return f"{self.name} [{self.shown[0]}]" if self.shown[0] else self.name


NUMBERS: Entries[Number] = Entries("masonry_cd.analysis.outputs", "NUMBERS")


def numbers_in(place: str) -> dict[str, Number]:
    """The numbers that a format shows, in its order, by the keys that it calls them by."""
    known = [(number.places[place], number.keys.get(place, key), number) for key, number in NUMBERS.items() if place in number.places]
    return {key: number for _, key, number in sorted(known, key=lambda one: one[0])}


def lengths_in(place: str) -> dict[str, Number]:
    """Those of them that are lengths."""
    return {key: number for key, number in numbers_in(place).items() if number.unit == "m"}


def values_in(place: str, run: Measured) -> dict[str, Any]:
    """Return the values of a run that a format shows."""
    return {key: number.compute(run) for key, number in numbers_in(place).items()}


def units_in(place: str) -> dict[str, str]:
    """The units of its columns that have one."""
    return {key: number.unit for key, number in numbers_in(place).items() if number.unit}
