# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit states: when a run counts as one that exceeded them.

A limit state names a column of runs.csv and a bound: ``above`` is exceeded by what is larger, ``at_least`` reached by what is as large or
larger. A grade is compared by its number, ``at_least = "D3"``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.analysis.outputs import STUDY, numbers_in
from masonry_cd.analysis.run_row import RunRow
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import Number, Table
from masonry_cd.foundation.units import Usual
from masonry_cd.mechanics.model.usual import LENGTHS

QUANTITIES = tuple(key for key, number in numbers_in(STUDY).items() if number.judges)
OF_PARTS = (".grade_number", ".drift")
WHOLE_NUMBERS = ("collapsed_blocks", "steps_missed", "steps")  # counts: they have no logarithm worth a regression


BOUND = Usual(0.0, 0.5, "openings, slips and displacements of limit states are below half a metre", LENGTHS)  # of quantities in metres


class LimitStateTable(Table):
    """A limit state: exceeded where a quantity of a run is above a value."""

    quantity: str
    """Column of runs.csv."""
    above: Annotated[Number, BOUND] | None = None
    """Exceeded above this."""
    at_least: str | None = None
    """Least value of the quantity "grade", "D3"."""
    least_demand: Annotated[Number, Field(gt=0)] | None = None
    """Smallest value that the regression of a cloud takes in: of runs with less it only knows that they have less."""

    @model_validator(mode="after")
    def _one(self) -> LimitStateTable:
        if self.quantity not in QUANTITIES and not self.quantity.endswith(OF_PARTS):
            raise ValueError(f'quantity: unknown "{self.quantity}"{suggest(self.quantity, QUANTITIES)}; one of {", ".join(QUANTITIES)}')
        graded = self.quantity == "grade"
        if graded and self.at_least not in NAMES:
            raise ValueError(f"at_least: should be a grade, {', '.join(NAMES[1:])}")
        if not graded and (self.above is None or self.at_least is not None):
            raise ValueError("above: missing" if self.above is None else 'at_least: belongs to quantity = "grade"')
        if graded and self.above is not None:
            raise ValueError('above: a grade is compared by at_least = "D3"')
        if self.least_demand is not None and (self.above is None or self.least_demand >= self.above):
            raise ValueError("least_demand: should lie below the value of above")
        return self


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

    @classmethod
    def of(cls, name: str, table: LimitStateTable) -> LimitState:
        """That of a table."""
        if table.at_least is not None:
            return cls(name, table.quantity, "grade_number", float(NAMES.index(table.at_least)), True, table.at_least)
        assert table.above is not None
        return cls(name, table.quantity, table.quantity, table.above, False, f"{table.above:g}", table.least_demand or 0.0)

    def exceeded(self, values: np.ndarray) -> np.ndarray:
        """(N,) bool of the values (N,) of its column; nan exceeds nothing."""
        return values >= self.bound if self.equal else values > self.bound

    def exceeded_by(self, row: RunRow) -> bool | None:
        """Return True if a run exceeded it; None of one that has no result, or whose grade is requested and which is not graded."""
        value = row.number(self.column)
        if not row.done or (value is None and self.equal):
            return None
        return value is not None and bool(self.exceeded(np.array(value)))

    @property
    def is_continuous(self) -> bool:
        """Return True if its quantity is a positive measure with a logarithm, neither a count nor a grade."""
        return self.bound > 0 and self.column not in WHOLE_NUMBERS and not self.column.endswith("grade_number")

    def in_words(self) -> str:
        """``max_opening > 0.001``"""
        return f"{self.quantity} {'≥' if self.equal else '>'} {self.word}"


def limit_states_of(tables: Mapping[str, LimitStateTable], header: Sequence[str]) -> tuple[LimitState, ...]:
    """The limit states of a study whose table of runs has some columns.

    Raises:
        InputError: a limit state of a quantity that it does not have.
    """
    found = tuple(LimitState.of(name, table) for name, table in tables.items())
    for limit in found:
        if limit.column not in header:
            raise InputError(
                f"limit_states.{limit.name}.quantity", f'runs.csv has no column "{limit.column}"{suggest(limit.column, header)}'
            )
    return found
