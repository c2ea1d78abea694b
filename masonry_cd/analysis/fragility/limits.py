# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit states: when a run counts as one that exceeded them.

A limit state names a column of runs.csv and a bound: ``above`` is exceeded by what is larger, ``at_least`` reached by what is as large or
larger. A grade is compared by its number, ``at_least = "D3"``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import is_number

WHOLE_NUMBERS = ("collapsed_blocks", "steps_missed", "steps")  # counts: they have no logarithm worth a regression


@dataclass(frozen=True)
class LimitState:
    """A limit state.

    Attributes:
        name: as the study calls it.
        quantity: as the study names it.
        column: of runs.csv that is compared.
        bound: with which.
        equal: the bound itself counts, too.
        word: the bound as the study gives it.
        least: demand from which on a regression of a cloud is to hold; 0 for all.
    """

    name: str
    quantity: str
    column: str
    bound: float
    equal: bool
    word: str
    least: float = 0.0

    def exceeded(self, values: np.ndarray) -> np.ndarray:
        """(N,) bool of the values (N,) of its column; nan exceeds nothing."""
        return values >= self.bound if self.equal else values > self.bound

    @property
    def continuous(self) -> bool:
        """Whether its quantity is a positive measure with a logarithm, neither a count nor a grade."""
        return self.bound > 0 and self.column not in WHOLE_NUMBERS and not self.column.endswith("grade_number")

    def in_words(self) -> str:
        """``max_opening > 0.001``"""
        return f"{self.quantity} {'≥' if self.equal else '>'} {self.word}"


def read_limit_states(table: Mapping[str, Any], header: Sequence[str], path: Path) -> tuple[LimitState, ...]:
    """The limit states of a study.

    Raises:
        InputError: a limit state without a quantity that runs.csv has, or without a bound.
    """
    return tuple(_limit_state(name, given, header, f"{path}: limit_states.{name}") for name, given in table.items())


def _limit_state(name: str, given: Any, header: Sequence[str], where: str) -> LimitState:
    """One of them."""
    if not isinstance(given, Mapping) or not isinstance(given.get("quantity"), str):
        raise InputError(where, "quantity: missing")
    quantity = given["quantity"]
    column = f"{quantity}_number" if quantity.split(".")[-1] == "grade" else quantity
    if column not in header:
        raise InputError(where, f'quantity: runs.csv has no column "{column}"{suggest(column, header)}')
    found = [key for key in ("above", "at_least") if given.get(key) is not None]
    if len(found) != 1:
        raise InputError(where, "needs either above or at_least")
    value, equal = given[found[0]], found[0] == "at_least"
    bound = NAMES.index(value) if value in NAMES else value
    if not is_number(bound) and not isinstance(bound, float):
        raise InputError(f"{where}.{found[0]}", f"must be a number, or a grade {NAMES[0]} to {NAMES[-1]}, got {value!r}")
    least = given.get("least_demand")
    if least is not None and not (is_number(least) and 0.0 < least < bound):
        raise InputError(f"{where}.least_demand", f"must lie between 0 and the bound {bound:g}, got {least!r}")
    return LimitState(name, quantity, column, float(bound), equal, str(value) if value in NAMES else f"{value:g}", float(least or 0.0))
