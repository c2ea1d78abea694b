# SPDX-License-Identifier: GPL-3.0-or-later
"""Types of the keys of a scene file that several tables share, and the table that all of them build on."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, Strict, WithJsonSchema

from masonry_cd.foundation.quantities import force
from masonry_cd.foundation.units import Unit

Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Count = Annotated[int, Strict()]
Flag = Annotated[bool, Strict()]
LONGEST = 1e6  # time in a scene [s]: eleven days
MOST_STEPS = 2e7  # of a run: some 4 GB of loads
Instant = Annotated[float, Unit("s"), Field(ge=0.0, le=LONGEST)]  # [s]
Span = Annotated[float, Unit("s"), Field(gt=0.0, le=LONGEST)]  # [s]


def finite_number(text: str) -> float | None:
    """The number that a text is, None where it is none or not finite."""
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None


def is_number(value: object) -> bool:
    """Return True if a value is a finite number: no truth value, and no whole number beyond the range of all others."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def check_tension(tension: float, yield_force: float | None) -> None:
    """Refuse a tie that is drawn at the start by what it yields at, or more [N].

    Raises:
        ValueError: for the validator of a table.
    """
    if yield_force is not None and tension >= yield_force:
        raise ValueError(f"the tension at the start, {force(tension)}, must be below yield_force, {force(yield_force)}")


def _three_numbers(value: object) -> object:
    """Say what is expected of a vector before pydantic speaks of tuples."""
    if isinstance(value, Sequence) and not isinstance(value, str) and len(value) == 3:
        return tuple(value)
    raise ValueError("should be three numbers [x, y, z]")


Vector = Annotated[tuple[Number, Number, Number], BeforeValidator(_three_numbers)]


def two_blocks(value: object) -> tuple[str, str]:
    """The names of two blocks, for the validator of a key."""
    names = list(value) if isinstance(value, (list, tuple)) else []
    if len(names) != 2 or not all(isinstance(name, str) for name in names) or names[0] == names[1]:
        raise ValueError("must be the names of two blocks")
    return names[0], names[1]


def _numbers(value: object) -> tuple[float, ...] | None:
    """One number or a list of numbers."""
    if value is None:
        return None
    numbers: list[Any] = [value] if is_number(value) else list(value) if isinstance(value, (list, tuple)) else []
    if not numbers or not all(map(is_number, numbers)):
        raise ValueError("must be a number or a list of numbers, e.g. [0.005, -0.005, 0.01, -0.01]")
    return tuple(float(number) for number in numbers)


_NUMBER: dict[str, Any] = {"type": "number"}
_LIST: dict[str, Any] = {"anyOf": [_NUMBER, {"type": "array", "items": _NUMBER, "minItems": 1}]}
Numbers = Annotated[tuple[float, ...], BeforeValidator(_numbers), WithJsonSchema(_LIST)]  # one, or a list of them


class Table(BaseModel):
    """A table of a scene file: it refuses keys that it does not know, and does not change."""

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)

    @classmethod
    def further_keys(cls) -> tuple[str, ...]:
        """Keys that the table knows without a field for them."""
        return ()
