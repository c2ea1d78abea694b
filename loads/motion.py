# SPDX-License-Identifier: GPL-3.0-or-later
"""Common pieces of every kind of load: what it is given and what it returns.

Supports are driven by a prescribed velocity (not by inertia forces on the blocks), so a load that shakes gives the velocity of
the base as a function of time, which each support may follow later than the first and with a share of its own. A load that pulls on the
blocks gives an acceleration at the times t_k = k dt of the run. Loads add up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

from loads.acted import Acted
from loads.bars import PointLoad, Tie
from loads.turning import Turned
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import is_number
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.fill import Fill
from masonry_cd.mechanics.model.guides import Guide
from masonry_cd.mechanics.model.shocks import Pause, Shock

STANDARD_GRAVITY = 9.80665  # [m/s2], the g in which records are written (CGPM 1901); not the site's gravity
ROUNDING = 1e-10
LEVEL = 1e-9  # sine of the angle to the level at most
STEEP = math.cos(math.radians(45.0))  # of the angle to the vertical up to which something counts as vertical

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True, eq=False)
class RunGrid:
    """Facts on the run for a load: the N + 1 times t_k = k dt, the gravity, the folder of the scene file, and the blocks."""

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

    def blocks(self, where: str) -> Assembly:
        """The blocks that the run is about.

        Raises:
            InputError: there are none yet.
        """
        if self.assembly is None:
            raise InputError(where, "needs a structure, whose blocks it names")
        return self.assembly


MotionOfTime = Callable[[np.ndarray], np.ndarray]
"""Times of the run (n,) [s] -> velocity of the base (n, 3) [m/s]."""


@dataclass(frozen=True, eq=False)
class Turning:
    """How the supports turn that a part moves, next to its motion, which then is that of the point."""

    on: Callable[[RunGrid], Turned]
    about: np.ndarray | None = None  # (3,) the point about which they turn, as built, and which moves with them [m]; None: each its centre


@dataclass(frozen=True, eq=False)
class LoadAction:
    """Action of one table in a run. What is left out is zero."""

    motion: MotionOfTime | None = None
    delay: np.ndarray | None = None  # (B,) by how much a support's motion lags behind [s]
    share: np.ndarray | None = None  # (B,) factor on a support's motion; one when left out
    turning: Turning | None = None  # of the supports that have a share, which then is one
    more: tuple[LoadAction, ...] = ()  # further motions of supports, of each the four before count
    acceleration: np.ndarray | None = None  # (N + 1, 3) of the blocks [m/s2]
    lines: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()  # of what is likely a mistake
    summary: dict[str, Any] = field(default_factory=dict)
    shocks: tuple[Shock, ...] = ()
    pauses: tuple[Pause, ...] = ()
    forces: tuple[PointLoad | Tie | Guide, ...] = ()
    acted: Acted | None = None  # how much of it has acted by a time; None of what acts all along, or does not say


@dataclass(frozen=True, eq=False)
class Static:
    """Action of one table in limit analysis, all of it there. What is left out is nothing."""

    words: str = ""  # what it is called where it is multiplied
    points: tuple[PointLoad, ...] = ()  # constant, or multiplied where limit.live names the table
    ties: tuple[Tie, ...] = ()
    weighs: bool = False  # its force may be the weight of a mass, by limit.masses
    direction: Direction | None = None  # in which a push or a tilt moves all masses
    velocity: np.ndarray | None = None  # (B, 3) of supports that move, (B, 6) where they turn


Positive = Annotated[float, Field(gt=0.0)]
strict = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True)
"""Configuration of every model of keys. Values are taken as they are typed: the text "0.2" is not a number."""


class LoadTable(BaseModel):
    """A [[loads]] table."""

    model_config = strict

    kind: str

    def facts(self, *keys: str) -> dict[str, Any]:
        """The kind and some keys as summary.json has them; a direction is its vector."""
        values = {key: getattr(self, key) for key in keys}
        plain = {key: value.vector if isinstance(value, Direction) else value for key, value in values.items()}
        return {"kind": self.kind} | {key: list(value) if isinstance(value, tuple) else value for key, value in plain.items()}


Pattern = Literal["", "push", "tilt", "settlement", "live"]
"""Pattern that a limit analysis multiplies where ``[limit]`` does not give it; empty: it multiplies nothing of the load."""


class LoadKind(NamedTuple):
    """A kind of load: all that the program knows of it. The first two are needed; what is left out, such a load does not do.

    ``where`` is the place of a table, such as ``loads[0]``, with which the places of all InputErrors begin; ``table`` is one of the model.
    """

    table: type[LoadTable]
    """The model of its keys."""
    part: Callable[[Any, RunGrid, str], LoadAction]
    """Action in a run, (table, grid, where)."""
    end: Callable[[Any, RunGrid, str], float] | None = None
    """When it has done what it does, for a run that states no duration, (table, grid, where) -> [s]; None: when all of it has acted."""
    slow: Callable[[Any], bool] = lambda table: False
    """True if it leaves the structure at rest, so that such a run ends with it."""
    static: Callable[[Any, RunGrid, str], Static | None] | None = None
    """Action in limit analysis, (table, grid, where); None, or a table of which it gives None: it is left out there."""
    pattern: Callable[[Any], Pattern] = lambda table: ""
    """Pattern that a limit analysis of the scene multiplies."""
    places: Callable[[Any, Sequence[Fill], str], Places] | None = None
    """Where it may stand on a bridge, of a load whose worst place a limit analysis looks for, (table, fills, where)."""
    gentle: bool = False
    """True if it neither shakes nor pushes, so that the fill of bridges resists as at rest."""
    grown: Callable[[Mapping[str, Any], float], dict[str, Any]] | None = None
    """The keys of a load that is larger by a factor, by which ensembles differ; None: it has no one size."""
    recorded: Callable[[Mapping[str, Any], Mapping[str, Any], str], list[FromFile]] | None = None
    """The motions that it has from files, (keys, summary, where)."""
    senses: Callable[[Any, np.ndarray, str], Iterator[tuple[str, str]]] | None = None
    """Places of keys that point the wrong way and a line on each, (table, unit vector (3,) of gravity, where)."""
    starter: Mapping[str, Any] = {}
    """Keys of a first load of this kind, on a 4 m arch where it needs a structure."""


class Places(NamedTuple):
    """Between which values of its key ``position`` a load stands on a bridge."""

    low: float  # along the road [m]
    high: float
    words: str  # what the load is


class FromFile(NamedTuple):
    """A motion from files: components that have one size and act at the same time; those without a path are from none."""

    where: str  # of the keys of its size
    keys: Mapping[str, Any]
    factor: float
    begin: float  # of the run [s]
    end: float
    components: tuple[tuple[str, Mapping[str, Any], Mapping[str, Any]], ...]  # place, keys and summary of each


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
    """Read "x", "-y", "+z", a vector of three numbers, which is normalised, or the angle of a level direction from x towards y [degrees].

    Raises:
        ValueError: anything else, a vector of zero length included.
    """
    if isinstance(value, Direction):
        return value
    if isinstance(value, str):
        axis = AXES.get(value.strip().lstrip("+-").lower())
        if axis is None or len(value.strip()) > 2:
            raise ValueError('must be "x", "y", "z", one of these with a sign ("-x"), a vector, or an angle such as "30 deg"')
        sign = -1.0 if value.strip().startswith("-") else 1.0
        return Direction((sign * axis[0] + 0.0, sign * axis[1] + 0.0, sign * axis[2] + 0.0), value.strip())
    if is_number(value):
        angle = math.radians(float(value))  # type: ignore[arg-type]
        return Direction((math.cos(angle), math.sin(angle), 0.0), f"{value:g} degrees from x")
    numbers = list(value) if isinstance(value, (list, tuple)) else []
    if len(numbers) != 3 or not all(map(is_number, numbers)):
        raise ValueError('must be "x", "y", "z", a vector of three numbers such as [1, 0, 0], or an angle such as "30 deg"')
    numbers = [float(n) for n in numbers]
    length = math.hypot(*numbers)
    if not np.isfinite(length) or length == 0.0:
        raise ValueError(f"a vector of finite length above zero is needed, got {numbers}")
    return Direction(
        (float(numbers[0] / length), float(numbers[1] / length), float(numbers[2] / length)),
        "(" + ", ".join(f"{n:g}" for n in numbers) + ")",
    )


def lifts(way: Sequence[float] | np.ndarray, down: np.ndarray) -> bool:
    """Return True if a vector (3,) points upwards, by the unit vector (3,) of gravity."""
    return bool(np.sum(np.asarray(way) * down) < -STEEP * math.hypot(*way))


_AXIS = {"enum": [sign + axis for axis in AXES for sign in ("", "-")]}
_VECTOR: dict[str, Any] = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
DirectionKey = Annotated[
    Direction, Unit("degrees"), BeforeValidator(parse_direction), WithJsonSchema({"anyOf": [_AXIS, _VECTOR, {"type": "number"}]})
]


def smooth_step(x: np.ndarray) -> np.ndarray:
    """3 x^2 - 2 x^3 between 0 and 1, held outside: starts and ends level, so that what it scales has no kink."""
    x = np.clip(x, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def gravity_of(grid: RunGrid, where: str) -> tuple[np.ndarray, float]:
    """Direction (3,) and size [m/s2] of gravity.

    Raises:
        InputError: there is none.
    """
    size = math.hypot(*grid.gravity)
    if size == 0.0:
        raise InputError(where, "needs gravity, but run.gravity is zero")
    return grid.gravity / size, size


def multiplied(pattern: Literal["push", "tilt"], direction: Direction, grid: RunGrid, where: str) -> Static:
    """A push along a direction or a tilt towards it, which has the place ``where``.

    Raises:
        InputError: no gravity, or a tilt that is not level.
    """
    down, _ = gravity_of(grid, where)
    if pattern == "tilt" and abs(float(np.sum(direction.vector * down))) > LEVEL:
        raise InputError(where, "must be level, at right angles to gravity")
    return Static(f"{pattern} {'towards' if pattern == 'tilt' else 'along'} {direction.label}", direction=direction)


def describe(numbers: dict[str, float]) -> str:
    """PGA, PGV, PGD and the end values of a motion on one line; what rounding leaves of a zero is shown as zero."""
    velocity = numbers["end_velocity"] if abs(numbers["end_velocity"]) > ROUNDING * numbers["pgv"] else 0.0
    displacement = numbers["end_displacement"] if abs(numbers["end_displacement"]) > ROUNDING * numbers["pgd"] else 0.0
    return (
        f"PGA {numbers['pga']:.4g} m/s2 ({numbers['pga'] / STANDARD_GRAVITY:.3g} g), PGV {numbers['pgv']:.4g} m/s, "
        f"PGD {numbers['pgd']:.4g} m, end velocity {velocity:.3g} m/s, end displacement {displacement:.3g} m"
    )
