# SPDX-License-Identifier: GPL-3.0-or-later
r"""A tilt test: the base is turned slowly about a horizontal axis.

The run stays in the frame of the base, where gravity turns the other way,

    g(t) = |g| (cos(phi) e + sin(phi) d),        phi = initial + rate (t - start), at most angle,

with e the direction of gravity and d that to which the structure leans. On a rigid base this is the same as a horizontal force of
lambda = tan(phi) times the weight, the weight itself being less by cos(phi): rigid blocks with dry friction have no other force to compare
it with, so the angle at which they give way is the same. The turning itself (centrifugal and Euler forces) is left out: at 1 degree/s
and 10 m it is 3e-3 m/s2. The structure needs time to fall: lambda has grown by rate times that time when the fall is seen.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from loads.acted import growing
from loads.motion import (
    LEVEL,
    Direction,
    DirectionKey,
    LoadAction,
    LoadKind,
    LoadTable,
    Positive,
    RunGrid,
    Static,
    gravity_of,
    multiplied,
    parse_direction,
)
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Instant
from masonry_cd.foundation.units import Unit


class TiltTable(LoadTable):
    """Keys of ``kind = "tilt"``."""

    kind: Literal["tilt"] = "tilt"
    direction: DirectionKey | None = None
    """Direction in which the structure leans."""
    axis: DirectionKey | None = None
    """Or: about which gravity turns, by the right-hand rule."""
    rate: Annotated[Positive, Unit("degrees/s")]
    """Rate of the angle."""
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


def tilt(table: TiltTable, grid: RunGrid, where: str) -> LoadAction:
    """Return the part that the tilt adds to gravity at the run's times, (N + 1, 3) [m/s2].

    Raises:
        InputError: no gravity to turn, or a direction that is not level.
    """
    down, size = gravity_of(grid, where)
    lean = _lean(table, down, where)
    limit = 90.0 if table.angle is None else table.angle
    degrees = np.minimum(table.initial + table.rate * np.maximum(grid.times - table.start, 0.0), limit)
    phi = np.deg2rad(degrees)
    added = size * (np.outer(libm.cos(phi) - 1.0, down) + np.outer(libm.sin(phi), lean.vector))
    line = f"{where} tilt towards {lean.label}: {degrees[0]:g} to {degrees[-1]:.4g} degrees at {table.rate:g} degrees/s"
    return LoadAction(
        acceleration=added,
        lines=(f"{line}, lambda = tan(angle) up to {math.tan(phi[-1]):.4g}",),
        summary=table.facts("start", "initial", "rate") | {"direction": list(lean.vector), "angle": float(degrees[-1])},
        acted=growing(where, "angle", table.start, table.initial, table.rate, table.angle),
    )


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


def _lean(table: TiltTable, down: np.ndarray, where: str) -> Direction:
    """The level direction to which the structure leans."""
    key, given = ("direction", table.direction) if table.direction is not None else ("axis", table.axis)
    assert given is not None
    if abs(float(np.sum(given.vector * down))) > LEVEL:
        raise InputError(f"{where}.{key}", "must be level, at right angles to gravity")
    return given if table.axis is None else parse_direction([float(n) + 0.0 for n in np.cross(table.axis.vector, down)])


def _static(table: TiltTable, grid: RunGrid, where: str) -> Static:
    return multiplied("tilt", _lean(table, gravity_of(grid, where)[0], where), grid, where)


KINDS = {
    "tilt": LoadKind(TiltTable, tilt, static=_static, pattern=lambda table: "tilt", starter={"direction": "x", "rate": 1.0, "angle": 5.0})
}
