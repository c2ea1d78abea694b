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

import math
from collections.abc import Callable, Iterator
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from loads.acted import Acted, over_time
from loads.motion import Direction, DirectionKey, LoadAction, LoadKind, LoadTable, MotionOfTime, RunGrid, Static, lifts
from loads.supports import Names, NeededNames, bearing, select_supports, structure
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import MOST_STEPS, Instant, Span
from masonry_cd.foundation.quantities import counted, length
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.usual import LENGTHS

FEWEST_STEPS = 10  # of the run in a pulse
SETTLED = Usual(0.0, 0.1, "structures settle by at most a few hundredths of their height", LENGTHS, over="height")
SPREAD = Usual(0.0, 0.25, "few arches survive a quarter of their span", LENGTHS, over="largest extent")
MOVED = (
    Usual(0.0, 1.0, "supports that part by more than the depth of a joint leave what stood on it without a bearing", LENGTHS, "joints"),
    Usual(0.0, 0.5, "supports that move faster than 0.5 m/s strike what stands on them; a longer duration?", over="duration"),
)


class SpreadingTable(LoadTable):
    """Keys of ``kind = "spreading"``."""

    kind: Literal["settlement", "spreading"] = "spreading"
    supports: Names = None
    """Names of fixed blocks or groups; all when not given."""
    direction: DirectionKey
    """Axis, vector or level angle from x to y along which the ground stretches."""
    displacement: Annotated[float, Unit("m"), SPREAD, *MOVED]
    """Displacement by which the outermost supports part."""
    start: Instant = 0.0
    """When they begin to move."""
    duration: Span
    """Duration of the motion."""


class SettlementTable(SpreadingTable):
    """Keys of ``kind = "settlement"``."""

    kind: Literal["settlement"] = "settlement"
    supports: NeededNames
    """Names of fixed blocks or groups; * stands for any letters."""
    direction: Annotated[DirectionKey, Field(json_schema_extra={"default": "-z"})] = Direction((0.0, 0.0, -1.0), "-z")
    """Axis, vector or level angle from x to y along which they move."""
    displacement: Annotated[float, Unit("m"), SETTLED, *MOVED]
    """Displacement of the supports."""


def settlement(table: SettlementTable, grid: RunGrid, where: str) -> LoadAction:
    """The motion of the supports named.

    Raises:
        InputError: names that fit no support, or a pulse that the steps cannot follow.
    """
    moving = _sinking(table, grid, where)
    along = f"{table.displacement:g} m along {table.direction.label}"
    return LoadAction(
        motion=_pulse(table, grid, where),
        share=moving,
        lines=(f"{where} settlement of {counted(int(moving.sum()), 'support')} by {along}, {_when(table)}",),
        warnings=_all_alike(moving > 0.0, grid, where),
        summary=_summary(table, moving, grid),
        acted=_acted(table, where),
    )


def _sinking(table: SettlementTable, grid: RunGrid, where: str) -> np.ndarray:
    """One of each support that moves, zero of the other blocks, (B,)."""
    return select_supports(table.supports, grid, f"{where}.supports").astype(float)


def _all_alike(moving: np.ndarray, grid: RunGrid, where: str) -> tuple[str, ...]:
    """A warning where a settlement leaves no support behind on which something stands, so that the structure moves as a whole."""
    bears = bearing(structure(grid, where))
    count = int(bears.sum())
    if not moving[bears].all():
        return ()
    which = "the only support" if count == 1 else f"all {count} supports alike"
    return (
        f"{where} the settlement moves {which}, so the structure goes down as a whole and is not strained; "
        'structure.foundations divides a base, e.g. foundations = "corners" or { x = 4 }, so that a part of it can be selected',
    )


def spreading(table: SpreadingTable, grid: RunGrid, where: str) -> LoadAction:
    """The motion of the supports named, or of all.

    Raises:
        InputError: names that fit no support, supports that all stand at one place, or a pulse that the steps cannot follow.
    """
    share, extent = _parting(table, grid, where)
    over = f"over {extent:.4g} m along {table.direction.label}"
    moving = select_supports(table.supports, grid, f"{where}.supports")
    return LoadAction(
        motion=_pulse(table, grid, where),
        share=share,
        lines=(f"{where} spreading of {counted(int(moving.sum()), 'support')} by {table.displacement:g} m {over}, {_when(table)}",),
        summary=_summary(table, moving, grid),
        acted=_acted(table, where),
    )


def _parting(table: SpreadingTable, grid: RunGrid, where: str) -> tuple[np.ndarray, float]:
    """D(x) / displacement of the head of this file (B,), and the length of the supports along the direction [m]."""
    moving = select_supports(table.supports, grid, f"{where}.supports")
    place = np.sum(structure(grid, where).centre * table.direction.vector, axis=1)
    low, high = place[moving].min(), place[moving].max()
    if high - low < 1e-9 * max(1.0, abs(high)):
        raise InputError(f"{where}.direction", f"all supports have the same position along {table.direction.label}, so they cannot spread")
    return np.where(moving, (place - 0.5 * (low + high)) / (high - low), 0.0), float(high - low)


def _pulse(table: SpreadingTable, grid: RunGrid, where: str) -> MotionOfTime:
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


def _when(table: SpreadingTable) -> str:
    return f"{table.start:g} to {table.start + table.duration:g} s"


def _acted(table: SpreadingTable, where: str) -> Acted:
    """Return the effect by the displacement reached, d(t) of the head of this file."""
    return over_time(where, "displacement", table.start, table.duration, lambda x: x * x * x * (10.0 + x * (6.0 * x - 15.0)))


def _summary(table: SpreadingTable, moving: np.ndarray, grid: RunGrid) -> dict[str, object]:
    names = grid.blocks(table.kind).names
    return table.facts("direction", "displacement", "start", "duration") | {"supports": [names[b] for b in np.flatnonzero(moving)]}


def _static(table: SpreadingTable, grid: RunGrid, where: str) -> Static:
    """The way of each support, against which it bears what it still bears."""
    share = _sinking(table, grid, where) if isinstance(table, SettlementTable) else _parting(table, grid, where)[0]
    sign = math.copysign(1.0, table.displacement)
    return Static(f"{where} {table.kind} along {table.direction.label}", velocity=np.outer(sign * share, table.direction.vector))


def _senses(table: SettlementTable, down: np.ndarray, where: str) -> Iterator[tuple[str, str]]:
    if lifts(table.displacement * np.asarray(table.direction.vector), down):
        rises = f"these supports rise by {length(abs(table.displacement))}: a settlement is downwards, -z"
        yield f"{where}.displacement", f"{where}.displacement: {rises}"


def _kind(model: type[LoadTable], part: Callable[[Any, RunGrid, str], LoadAction], **more: Any) -> LoadKind:
    return LoadKind(model, part, static=_static, pattern=lambda table: "settlement", gentle=True, **more)


KINDS = {
    "settlement": _kind(
        SettlementTable, settlement, senses=_senses, starter={"supports": "abutment2", "displacement": 0.02, "duration": 2.0}
    ),
    "spreading": _kind(SpreadingTable, spreading, starter={"direction": "x", "displacement": 0.02, "duration": 2.0}),
}
