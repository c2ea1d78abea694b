# SPDX-License-Identifier: GPL-3.0-or-later
r"""Slow loads that find the capacity of a structure: a tilt test and a push.

**Tilt.** The base is turned slowly about a horizontal axis; the run stays in the frame of the base, where gravity turns the other way,

    g(t) = |g| (cos(phi) e + sin(phi) d),        phi = initial + rate (t - start), at most angle,

with e the direction of gravity and d that to which the structure leans. On a rigid base this is the same as a horizontal force of
lambda = tan(phi) times the weight, the weight itself being less by cos(phi): rigid blocks with dry friction have no other force to compare
it with, so the angle at which they give way is the same. The turning itself (centrifugal and Euler forces) is left out: at 1 degree/s
and 10 m it is 3e-3 m/s2.

**Push.** A body force on every block that grows linearly,  a(t) = lambda |g| d,  lambda = initial + rate (t - start), at most peak. One by
displacement, as laboratories push, is in ``driven.py``.

In both the structure needs time to fall: lambda has grown by rate times that time when the fall is seen. Push slowly where it matters.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from loads.acted import Acted, over_time, without_end
from loads.kinds.driven import DrivenKeys, driven, path_of
from loads.motion import Direction, DirectionKey, LoadKind, LoadTable, Part, RunGrid, parse_direction
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Instant
from masonry_cd.foundation.units import Unit

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
BY_FORCE = ("rate", "initial", "peak")
INSTEAD = {"rate": "speed", "initial": "targets", "peak": "targets", "targets": "peak", "speed": "rate"}  # of the other control


class TiltTable(LoadTable):
    """Keys of ``kind = "tilt"``."""

    kind: Literal["tilt"] = "tilt"
    direction: DirectionKey | None = None
    """To which the structure leans."""
    axis: DirectionKey | None = None
    """Or: about which gravity turns, by the right-hand rule."""
    rate: Annotated[Positive, Unit("degrees/s")]
    """Of the angle."""
    initial: Annotated[float, Unit("degrees"), Field(ge=0.0, lt=90.0)] = 0.0
    """Angle from the first step on."""
    angle: Annotated[float, Unit("degrees"), Field(gt=0.0, le=90.0)] | None = None
    """At which it stops."""
    start: Instant = 0.0
    """When it begins."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if (self.direction is None) == (self.axis is None):
            raise ValueError("give exactly one of direction and axis")
        if self.angle is not None and self.angle < self.initial:
            raise ValueError(f"angle: {self.angle:g} degrees lie below initial, {self.initial:g}")
        return self


class PushTable(DrivenKeys, LoadTable):
    """Keys of ``kind = "push"``: those of its control by force, then those of its control by displacement."""

    kind: Literal["push"] = "push"
    direction: DirectionKey
    """Axis or vector along which the body force acts, or the blocks are moved."""
    control: Literal["force", "displacement"] = "force"
    """A body force that grows, or blocks that are moved and whose reaction is recorded."""
    rate: Annotated[Positive, Unit("1/s")] | None = None
    """By force: of lambda, the share of the weight."""
    initial: NotNegative = 0.0
    """By force: lambda from the first step on."""
    peak: Positive | None = None
    """By force: lambda at which it stops."""
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
            why = f'of no use with control = "{self.control}"{instead}; its keys: {", ".join(mine)}'
            raise ValueError(f'{astray}: {why}; control = "{there}" takes {astray}')
        missing = next((key for key in needed if key not in self.model_fields_set), "")
        if missing:
            raise ValueError(f'{missing}: missing, control = "{self.control}" needs it')
        if self.control == "displacement":
            self.check_place()
        if self.peak is not None and self.peak < self.initial:
            raise ValueError(f"peak: {self.peak:g} lies below initial, {self.initial:g}")
        return self


def tilt(table: TiltTable, grid: RunGrid, where: str) -> Part:
    """What the tilt adds to gravity at the run's times, (N + 1, 3) [m/s2].

    Raises:
        InputError: no gravity to turn, or a direction that is not level.
    """
    down, size = _gravity(grid, where)
    lean = _lean(table, down, where)
    limit = 90.0 if table.angle is None else table.angle
    degrees = np.minimum(table.initial + table.rate * np.maximum(grid.times - table.start, 0.0), limit)
    phi = np.deg2rad(degrees)
    added = size * (np.outer(libm.cos(phi) - 1.0, down) + np.outer(libm.sin(phi), lean.vector))
    line = f"{where} tilt towards {lean.label}: {degrees[0]:g} to {degrees[-1]:.4g} degrees at {table.rate:g} degrees/s"
    return Part(
        acceleration=added,
        lines=(f"{line}, lambda = tan(angle) up to {math.tan(phi[-1]):.4g}",),
        summary={
            "kind": "tilt",
            "direction": list(lean.vector),
            "start": table.start,
            "initial": table.initial,
            "rate": table.rate,
            "angle": float(degrees[-1]),
        },
        acted=_growing(where, "angle", table, table.rate, table.angle),
    )


def push(table: PushTable, grid: RunGrid, where: str) -> Part:
    """The body force at the run's times, (N + 1, 3) [m/s2], or the guide of blocks that are moved.

    Raises:
        InputError: no gravity that would give it its size; see :func:`loads.kinds.driven.driven`.
    """
    if table.control == "displacement":
        return driven(table, table.direction, table.start, grid, where)
    rate = table.rate or 0.0
    _, size = _gravity(grid, where)
    limit = np.inf if table.peak is None else table.peak
    factor = np.minimum(table.initial + rate * np.maximum(grid.times - table.start, 0.0), limit)
    return Part(
        acceleration=size * table.direction.along(factor),
        lines=(f"{where} push along {table.direction.label}: lambda {factor[0]:g} to {factor[-1]:.4g} at {rate:g} per second",),
        summary={
            "kind": "push",
            "direction": list(table.direction.vector),
            "start": table.start,
            "initial": table.initial,
            "rate": rate,
            "peak": float(factor[-1]),
        },
        acted=_growing(where, "peak", table, rate, table.peak),
    )


def _growing(where: str, measure: str, table: TiltTable | PushTable, rate: float, most: float | None) -> Acted:
    """By the angle or factor reached, from ``initial`` on; one without an end has acted once it has begun."""
    if most is None:
        return without_end(where, measure, 0.0 if table.initial > 0.0 else table.start)
    begun = table.initial / most
    return over_time(where, measure, table.start, (most - table.initial) / rate, lambda x: begun + (1.0 - begun) * x)


def tilt_end(table: TiltTable, grid: RunGrid, where: str) -> float:
    """When the angle is reached at which it stops [s].

    Raises:
        InputError: it stops at none.
    """
    if table.angle is None:
        raise InputError("run.duration", f"missing, and {where} has no angle at which it stops")
    return table.start + (table.angle - table.initial) / table.rate


def push_end(table: PushTable, grid: RunGrid, where: str) -> float:
    """When the push has come to its peak, or to its last target [s].

    Raises:
        InputError: it has no peak.
    """
    if table.control == "displacement":
        return path_of(table, table.start, grid, where).end
    if table.peak is None:
        raise InputError("run.duration", f"missing, and {where} has no peak at which it stops")
    return table.start + (table.peak - table.initial) / (table.rate or 1.0)


def load_factors(acceleration: np.ndarray, gravity: np.ndarray) -> np.ndarray:
    """lambda at each time (n,): the part of the body force across gravity over the part along it.

    Args:
        acceleration: (n, 3) of the blocks, gravity included [m/s2].
        gravity: (3,) its direction when nothing is tilted [m/s2].
    """
    down = gravity / math.hypot(*gravity)
    along = np.sum(acceleration * down, axis=1)
    across = np.linalg.norm(acceleration - np.outer(along, down), axis=1)
    return np.divide(across, along, out=np.full(len(along), np.inf), where=along > 0.0)


def _gravity(grid: RunGrid, where: str) -> tuple[np.ndarray, float]:
    """Direction and size of gravity."""
    size = math.hypot(*grid.gravity)
    if size == 0.0:
        raise InputError(where, "needs gravity, but run.gravity is zero")
    return grid.gravity / size, size


def _lean(table: TiltTable, down: np.ndarray, where: str) -> Direction:
    """The level direction to which the structure leans."""
    if table.direction is not None:
        key, lean = "direction", table.direction
        slope = abs(float(np.sum(lean.vector * down)))
    else:
        assert table.axis is not None
        key, slope = "axis", abs(float(np.sum(table.axis.vector * down)))
        turned = np.cross(table.axis.vector, down)
        lean = table.axis if slope > 1e-9 else parse_direction([float(n) + 0.0 for n in turned])
    if slope > 1e-9:
        raise InputError(f"{where}.{key}", "must be level, at right angles to gravity")
    return lean


KINDS = {"tilt": LoadKind(TiltTable, tilt, tilt_end), "push": LoadKind(PushTable, push, push_end)}
