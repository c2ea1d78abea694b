# SPDX-License-Identifier: GPL-3.0-or-later
r"""Supports that give way: settlement of some, and spreading of all.

A support moves by D in a smooth pulse of duration T, x = (t - start) / T:

    d(t) = D (10 x^3 - 15 x^4 + 6 x^5),        v(t) = D / T  30 x^2 (1 - x)^2,

so velocity and acceleration are zero at both ends. On the run's steps the pulse is scaled so that the base, which follows the
trapezoidal rule, ends at D exactly.

**Spreading** stretches the ground under the structure along a direction d: a support at x moves by

    D(x) = displacement * (d . x - middle) / length,

middle and length being those of the supports along d. The outermost ones part by the displacement, half of it each.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema

from loads.acted import Acted, over_time
from loads.motion import Direction, DirectionKey, LoadKind, LoadTable, Motion, Part, RunGrid
from loads.supports import select_supports, structure
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import MOST_STEPS, Instant, Span
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Assembly

FEWEST_STEPS = 10  # of the run in a pulse
NEAR = 1e-6  # of the largest extent of a block: boxes closer than this meet


def names_of_blocks(value: object) -> tuple[str, ...] | None:
    """One name or a list of names."""
    names = [value] if isinstance(value, str) else value
    if names is None:
        return None
    if not isinstance(names, (list, tuple)) or not names or not all(isinstance(name, str) for name in names):
        raise ValueError("must be the name of a fixed block or a group, or a list of names")
    return tuple(names)


NAMES_SCHEMA: dict[str, Any] = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1}]}
Names = Annotated[tuple[str, ...] | None, BeforeValidator(names_of_blocks), WithJsonSchema(NAMES_SCHEMA)]


class SettlementTable(LoadTable):
    """Keys of ``kind = "settlement"``."""

    kind: Literal["settlement"] = "settlement"
    supports: Annotated[tuple[str, ...], BeforeValidator(names_of_blocks), WithJsonSchema(NAMES_SCHEMA)]
    """Names of fixed blocks or groups; * stands for any letters."""
    direction: Annotated[DirectionKey, Field(json_schema_extra={"default": "-z"})] = Direction((0.0, 0.0, -1.0), "-z")
    """Axis or vector along which they move."""
    displacement: Annotated[float, Unit("m")]
    """How far they move."""
    start: Instant = 0.0
    """When they begin to move."""
    duration: Span
    """How long they move."""


class SpreadingTable(LoadTable):
    """Keys of ``kind = "spreading"``."""

    kind: Literal["spreading"] = "spreading"
    supports: Names = None
    """Names of fixed blocks or groups; all when not given."""
    direction: DirectionKey
    """Axis or vector along which the ground stretches."""
    displacement: Annotated[float, Unit("m")]
    """By which the outermost supports part."""
    start: Instant = 0.0
    """When they begin to move."""
    duration: Span
    """How long they move."""


def settlement(table: SettlementTable, grid: RunGrid, where: str) -> Part:
    """The motion of the supports named.

    Raises:
        InputError: names that fit no support, or a pulse that the steps cannot follow.
    """
    moving = select_supports(table.supports, grid, f"{where}.supports")
    along = f"{table.displacement:g} m along {table.direction.label}"
    return Part(
        motion=_pulse(table, grid, where),
        share=moving.astype(float),
        lines=(f"{where} settlement of {_count(moving)} by {along}, {_when(table)}",),
        warnings=_all_alike(moving, grid, where),
        summary=_summary(table) | {"supports": _named(moving, grid)},
        acted=_acted(table, where),
    )


def _all_alike(moving: np.ndarray, grid: RunGrid, where: str) -> tuple[str, ...]:
    """A warning where a settlement leaves no support behind on which something stands, so that the structure moves as a whole."""
    bearing = _bearing(structure(grid, where))
    count = int(bearing.sum())
    if not moving[bearing].all():
        return ()
    which = "the only support" if count == 1 else f"all {count} supports alike"
    return (
        f"{where} the settlement moves {which}, so the structure goes down as a whole and is not strained; "
        'structure.foundations divides a base, e.g. foundations = "corners" or { x = 4 }, so that a part of it can be named',
    )


def _bearing(assembly: Assembly) -> np.ndarray:
    """(B,) bool: supports whose box meets that of a free block; all supports where none does."""
    low, high = (np.array([getattr(block.vertices, end)(axis=0) for block in assembly.blocks]) for end in ("min", "max"))
    near = NEAR * float((high - low).max())
    free, fixed = ~assembly.fixed, np.flatnonzero(assembly.fixed)
    meets = [bool(((low[free] <= high[s] + near) & (high[free] >= low[s] - near)).all(axis=1).any()) for s in fixed]
    out = np.zeros(len(low), dtype=bool)
    out[fixed] = meets if any(meets) else True
    return out


def spreading(table: SpreadingTable, grid: RunGrid, where: str) -> Part:
    """The motion of the supports named, or of all.

    Raises:
        InputError: names that fit no support, supports that all stand at one place, or a pulse that the steps cannot follow.
    """
    moving = select_supports(table.supports, grid, f"{where}.supports")
    place = np.sum(structure(grid, where).centre * table.direction.vector, axis=1)
    low, high = place[moving].min(), place[moving].max()
    if high - low < 1e-9 * max(1.0, abs(high)):
        raise InputError(f"{where}.direction", f"the supports all stand at one place along {table.direction.label}, nothing can spread")
    share = np.where(moving, (place - 0.5 * (low + high)) / (high - low), 0.0)
    over = f"over {high - low:.4g} m along {table.direction.label}"
    return Part(
        motion=_pulse(table, grid, where),
        share=share,
        lines=(f"{where} spreading of {_count(moving)} by {table.displacement:g} m {over}, {_when(table)}",),
        summary=_summary(table) | {"supports": _named(moving, grid)},
        acted=_acted(table, where),
    )


def _pulse(table: SettlementTable | SpreadingTable, grid: RunGrid, where: str) -> Motion:
    """The velocity of the whole displacement as a function of time."""
    if table.duration < FEWEST_STEPS * grid.dt:
        raise InputError(f"{where}.duration", f"{table.duration:g} s are less than {FEWEST_STEPS} steps of run.dt {grid.dt:g} s")
    if table.duration > MOST_STEPS * grid.dt:  # the pulse is added up over all of its steps, those beyond the run too
        raise InputError(f"{where}.duration", f"{table.duration:g} s take more than {MOST_STEPS:g} steps of run.dt {grid.dt:g} s")

    def shape(times: np.ndarray) -> np.ndarray:
        x = np.clip((times - table.start) / table.duration, 0.0, 1.0)
        return np.asarray(30.0 * (x * (1.0 - x)) ** 2 / table.duration)

    steps = np.arange(int(np.ceil(table.duration / grid.dt)) + 2) + np.floor(table.start / grid.dt)
    on_steps = grid.dt * float(shape(grid.dt * steps).sum())  # the trapezoidal rule over the whole pulse: one but for rounding to steps
    return lambda times: table.direction.along(table.displacement / on_steps * shape(times))


def _when(table: SettlementTable | SpreadingTable) -> str:
    return f"{table.start:g} to {table.start + table.duration:g} s"


def _acted(table: SettlementTable | SpreadingTable, where: str) -> Acted:
    """By the displacement reached, d(t) of the head of this file."""
    return over_time(where, "displacement", table.start, table.duration, lambda x: x * x * x * (10.0 + x * (6.0 * x - 15.0)))


def _count(moving: np.ndarray) -> str:
    """How many supports a mask has, in words."""
    count = int(moving.sum())
    return f"{count} support{'s' if count > 1 else ''}"


def _named(moving: np.ndarray, grid: RunGrid) -> list[str]:
    """The names of the blocks in a mask."""
    assert grid.assembly is not None
    return [grid.assembly.names[b] for b in np.flatnonzero(moving)]


def _summary(table: SettlementTable | SpreadingTable) -> dict[str, object]:
    return {
        "kind": table.kind,
        "direction": list(table.direction.vector),
        "displacement": table.displacement,
        "start": table.start,
        "duration": table.duration,
    }


def _end(table: SettlementTable | SpreadingTable, grid: RunGrid, where: str) -> float:
    """When the supports have come to their place [s]."""
    return table.start + table.duration


KINDS = {"settlement": LoadKind(SettlementTable, settlement, _end), "spreading": LoadKind(SpreadingTable, spreading, _end)}
