# SPDX-License-Identifier: GPL-3.0-or-later
"""The row of one of many runs, as a worker sends it, and as a study keeps it in ``rows/NAME.json``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

DONE, FAILED, TIMEOUT = STATES = ("done", "failed", "timeout")


@dataclass(frozen=True)
class RunRow:
    """A run: how it ended, and its numbers. In JSON the numbers stand next to the other keys."""

    status: str = ""  # one of STATES; empty of a run that is still to be made
    reason: str = ""  # why it has no result
    seconds: float = 0.0  # of the clock
    worker: str = ""
    numbers: Mapping[str, Any] = field(default_factory=dict)  # by the columns of runs.csv or assess.csv; None where it has none
    parts: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # numbers by part of the structure
    timing: Mapping[str, float] = field(default_factory=dict)  # of what its seconds were for [s]
    limit: Mapping[str, Any] | None = None  # a row of limits.csv
    doubt: str = ""  # why it is not graded
    remark: str = ""
    limit_reason: str = ""  # why it has no load factor
    limit_seconds: float = 0.0

    @property
    def done(self) -> bool:
        """True where the run is done, so that its numbers are data."""
        return self.status == DONE

    def number(self, column: str) -> Any:
        """A number by its column, that of a part as ``part.drift``; None where there is none."""
        part, _, name = column.rpartition(".")
        return self.parts.get(part, {}).get(name) if part else self.numbers.get(column)

    def as_dict(self) -> dict[str, Any]:
        """For JSON: without what it does not have."""
        own = {name: getattr(self, name) for name in _FIELDS if name != "numbers"}
        kept = {"status": self.status, "reason": self.reason, "seconds": self.seconds, "worker": self.worker}
        return kept | dict(self.numbers) | {name: value for name, value in own.items() if value}


def row_of(found: Mapping[str, Any], excluded: tuple[str, ...] = ()) -> RunRow:
    """A row from its JSON; the keys ``excluded`` are not part of it.

    Raises:
        TypeError: it is none.
    """
    own = {name: value for name, value in found.items() if name in _FIELDS}
    if own.get("status") not in (*STATES, None) or not isinstance(own.get("reason", ""), str):
        raise TypeError("no row of a run")
    return RunRow(**own, numbers={name: value for name, value in found.items() if name not in (*_FIELDS, *excluded)})


_FIELDS = tuple(one.name for one in fields(RunRow))
