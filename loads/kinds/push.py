# SPDX-License-Identifier: GPL-3.0-or-later
"""A push: by force, a body force on every block that grows linearly, or by displacement, as laboratories push.

    a(t) = lambda |g| d,        lambda = initial + rate (t - start), at most peak.

By displacement, see :mod:`loads.kinds.driven`. The structure needs time to fall: lambda has grown by rate times that time when the fall is
seen. Push slowly where it matters.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from loads.acted import growing
from loads.kinds.driven import DrivenKeys, driven
from loads.motion import (
    DirectionKey,
    LoadAction,
    LoadKind,
    LoadTable,
    Pattern,
    Positive,
    RunGrid,
    Static,
    gravity_of,
    lifts,
    multiplied,
)
from masonry_cd.foundation.fields import Instant
from masonry_cd.foundation.units import Unit

BY_FORCE = ("rate", "initial", "peak")
INSTEAD = {"rate": "speed", "initial": "targets", "peak": "targets", "targets": "peak", "speed": "rate"}  # of the other control


class PushTable(DrivenKeys, LoadTable):
    """Keys of ``kind = "push"``: those of its control by force, then those of its control by displacement."""

    kind: Literal["push"] = "push"
    direction: DirectionKey
    """Axis, vector or level angle from x to y along which the body force acts, or the blocks are moved."""
    control: Literal["force", "displacement"] = "force"
    """A body force that grows, or blocks that are moved and whose reaction is recorded."""
    rate: Annotated[Positive, Unit("1/s")] | None = None
    """Rate of lambda, the share of the weight, by force."""
    initial: Annotated[float, Field(ge=0.0)] = 0.0
    """Value of lambda from the first step on, by force."""
    peak: Positive | None = None
    """Value of lambda at which it stops, by force."""
    start: Instant = 0.0
    """When it begins."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        by_way = tuple(DrivenKeys.model_fields)
        mine, other, needed = (BY_FORCE, by_way, ("rate",)) if self.control == "force" else (by_way, BY_FORCE, ("blocks", "targets"))
        astray = next((key for key in other if key in self.model_fields_set), "")
        if astray:
            instead = f", which takes {INSTEAD[astray]} instead" if astray in INSTEAD else ""
            there = "displacement" if self.control == "force" else "force"
            why = f'does not apply with control = "{self.control}"{instead}; its keys: {", ".join(mine)}'
            raise ValueError(f'{astray}: {why}; control = "{there}" takes {astray}')
        missing = next((key for key in needed if key not in self.model_fields_set), "")
        if missing:
            raise ValueError(f'{missing}: missing, control = "{self.control}" needs it')
        if self.control == "displacement":
            self.check_place()
        if self.peak is not None and self.peak < self.initial:
            raise ValueError(f"peak: {self.peak:g} lies below initial, {self.initial:g}")
        return self


def push(table: PushTable, grid: RunGrid, where: str) -> LoadAction:
    """The body force at the run's times, (N + 1, 3) [m/s2], or the guide of blocks that are moved.

    Raises:
        InputError: no gravity that would give it its size; see :func:`loads.kinds.driven.driven`.
    """
    if table.control == "displacement":
        return driven(table, table.direction, table.start, grid, where)
    rate = table.rate or 0.0
    _, size = gravity_of(grid, where)
    limit = np.inf if table.peak is None else table.peak
    factor = np.minimum(table.initial + rate * np.maximum(grid.times - table.start, 0.0), limit)
    return LoadAction(
        acceleration=size * table.direction.along(factor),
        lines=(f"{where} push along {table.direction.label}: lambda {factor[0]:g} to {factor[-1]:.4g} at {rate:g} per second",),
        summary=table.facts("direction", "start", "initial", "rate") | {"peak": float(factor[-1])},
        acted=growing(where, "peak", table.start, table.initial, rate, table.peak),
    )


def _static(table: PushTable, grid: RunGrid, where: str) -> Static | None:
    return multiplied("push", table.direction, grid, where) if _pattern(table) else None


def _pattern(table: PushTable) -> Pattern:
    """Blocks that are moved are no load that could be multiplied."""
    return "push" if table.control == "force" else ""


def _senses(table: PushTable, down: np.ndarray, where: str) -> Iterator[tuple[str, str]]:
    if lifts(table.direction.vector, down):
        yield f"{where}.direction", f"{where}.direction lifts what is pushed: it acts against gravity"


KINDS = {
    "push": LoadKind(
        PushTable,
        push,
        slow=lambda table: table.control == "displacement",
        static=_static,
        pattern=_pattern,
        senses=_senses,
        starter={"direction": "x", "rate": 0.05, "peak": 0.1},
    )
}
