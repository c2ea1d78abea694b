# SPDX-License-Identifier: GPL-3.0-or-later
"""What every kind of load is given and what it returns, with the small pieces that they share.

Supports are driven by a prescribed velocity (not by inertia forces on the blocks), so a load that shakes gives the velocity of
the base as a function of time, which each support may follow later than the first and with a share of its own. A load that pulls on the
blocks gives an acceleration at the times t_k = k dt of the run. Loads add up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, WithJsonSchema

from loads.acted import Acted
from masonry_cd.foundation.fields import is_number
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.fill import Fill

STANDARD_GRAVITY = 9.80665  # [m/s2], the g in which records are written (CGPM 1901); not the site's gravity
ROUNDING = 1e-10

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, eq=False)
class RunGrid:
    """What a load knows of the run: the N + 1 times t_k = k dt, the gravity, the folder of the scene file, and the blocks."""

    dt: float  # the time step, or the shortest where it adapts [s]
    steps: int  # N
    gravity: np.ndarray  # (3,) [m/s2]
    folder: Path
    assembly: Assembly | None = None  # None: no structure yet; then no load may name a block
    longest: float | None = None  # the longest step where it adapts [s]
    fills: Sequence[Fill] = ()  # of bridges

    @cached_property
    def times(self) -> np.ndarray:
        """t_k, (N + 1,) [s]."""
        return self.dt * np.arange(self.steps + 1)

    @property
    def end(self) -> float:
        """The last time [s]."""
        return self.dt * self.steps


Motion = Callable[[np.ndarray], np.ndarray]
"""Times of the run (n,) [s] -> velocity of the base (n, 3) [m/s]."""


@dataclass(frozen=True, eq=False)
class Part:
    """What one table contributes. What is left out is zero."""

    motion: Motion | None = None
    delay: np.ndarray | None = None  # (B,) by how much a support's motion lags behind [s]
    share: np.ndarray | None = None  # (B,) factor on a support's motion; one when left out
    acceleration: np.ndarray | None = None  # (N + 1, 3) of the blocks [m/s2]
    lines: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()  # of what is likely a mistake
    summary: dict[str, Any] = field(default_factory=dict)
    shocks: tuple[Any, ...] = ()  # loads.kinds.sequence.Shock
    pauses: tuple[Any, ...] = ()  # loads.kinds.sequence.Pause
    forces: tuple[Any, ...] = ()  # loads.bars.PointLoad and Tie, and Guide
    acted: Acted | None = None  # how much of it has acted by a time; None of what acts all along, or does not say


strict = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True)
"""Of every model of keys. Values are taken as they are typed: the text "0.2" is no number."""


class LoadTable(BaseModel):
    """A [[loads]] table."""

    model_config = strict

    kind: str


class LoadKind(NamedTuple):
    """A kind of load: the model of its keys, and what it contributes to a run.

    ``part(table, grid, where)`` raises InputErrors whose places begin with ``where``, that of the table, such as ``loads[0]``.
    """

    table: type[LoadTable]
    part: Callable[[Any, RunGrid, str], Part]
    end: Callable[[Any, RunGrid, str], float] | None = None
    """When the load has done what it does, (table, grid, where) -> [s]; None: it does not say."""


@dataclass(frozen=True)
class Direction:
    """A unit vector and how the user wrote it."""

    vector: tuple[float, float, float]
    label: str

    def along(self, values: np.ndarray) -> np.ndarray:
        """Spread values (N,) along the direction, (N, 3)."""
        return np.outer(values, self.vector)

    def turned(self, degrees: float) -> Direction:
        """The direction turned about the vertical z, counter-clockwise seen from above."""
        if degrees == 0.0:
            return self
        angle = math.radians(degrees)
        (x, y, z), c, s = self.vector, math.cos(angle), math.sin(angle)
        return Direction((c * x - s * y, s * x + c * y, z), f"{self.label} turned by {degrees:g} degrees")


def parse_direction(value: object) -> Direction:
    """Read "x", "-y", "+z" or a vector of three numbers, which is normalised.

    Raises:
        ValueError: anything else, a vector of zero length included.
    """
    if isinstance(value, Direction):
        return value
    if isinstance(value, str):
        axis = AXES.get(value.strip().lstrip("+-").lower())
        if axis is None or len(value.strip()) > 2:
            raise ValueError('must be "x", "y", "z", one of these with a sign ("-x"), or a vector')
        sign = -1.0 if value.strip().startswith("-") else 1.0
        return Direction((sign * axis[0] + 0.0, sign * axis[1] + 0.0, sign * axis[2] + 0.0), value.strip())
    numbers = list(value) if isinstance(value, (list, tuple)) else []
    if len(numbers) != 3 or not all(map(is_number, numbers)):
        raise ValueError('must be "x", "y", "z" or a vector of three numbers such as [1, 0, 0]')
    numbers = [float(n) for n in numbers]
    length = math.hypot(*numbers)
    if not np.isfinite(length) or length == 0.0:
        raise ValueError(f"a vector of finite length above zero is needed, got {numbers}")
    return Direction(
        (float(numbers[0] / length), float(numbers[1] / length), float(numbers[2] / length)),
        "(" + ", ".join(f"{n:g}" for n in numbers) + ")",
    )


_AXIS = {"enum": [sign + axis for axis in AXES for sign in ("", "-")]}
_VECTOR: dict[str, Any] = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
DirectionKey = Annotated[Direction, BeforeValidator(parse_direction), WithJsonSchema({"anyOf": [_AXIS, _VECTOR]})]


def smooth_step(x: np.ndarray) -> np.ndarray:
    """3 x^2 - 2 x^3 between 0 and 1, held outside: starts and ends level, so that what it scales has no kink."""
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def describe(numbers: dict[str, float]) -> str:
    """PGA, PGV, PGD and the end values of a motion on one line; what rounding leaves of a zero is shown as zero."""
    velocity = numbers["end_velocity"] if abs(numbers["end_velocity"]) > ROUNDING * numbers["pgv"] else 0.0
    displacement = numbers["end_displacement"] if abs(numbers["end_displacement"]) > ROUNDING * numbers["pgd"] else 0.0
    return (
        f"PGA {numbers['pga']:.4g} m/s2 ({numbers['pga'] / STANDARD_GRAVITY:.3g} g), PGV {numbers['pgv']:.4g} m/s, "
        f"PGD {numbers['pgd']:.4g} m, end velocity {velocity:.3g} m/s, end displacement {displacement:.3g} m"
    )
