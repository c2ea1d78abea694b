# SPDX-License-Identifier: GPL-3.0-or-later
r"""The loads of a scene as a limit analysis takes them: what stays constant, and the pattern that is multiplied by the factor.

Constant are gravity, and the point loads at their full size. The pattern is one of

    push          lambda |g| d on every kilogram, along a direction d
    tilt          gravity turned by phi towards d: cos(phi) (g + lambda |g| d) with lambda = tan(phi)
    live          point loads or vehicles of the scene, each times lambda
    settlement    supports that move, by themselves or apart: the force that they still bear

A push or a tilt acts on the masses of the blocks, and on those whose weights ``[limit] masses`` names among the point loads.
It is named in ``[limit]``, or is the one load of kind push, tilt, settlement or spreading of the scene. What shakes is left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, field_validator, model_validator

import loads
from loads import fill
from loads.kinds.forces import PointLoad, PointTable, Tie, TieTable, bar
from loads.kinds.settlement import SettlementTable, SpreadingTable
from loads.kinds.tilt import PushTable, TiltTable
from loads.kinds.vehicle import VehicleTable
from loads.motion import Direction, DirectionKey, LoadTable, RunGrid, parse_direction
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.analysis.limit.problem import Arms, Bars, Loads, PointMasses
from masonry_cd.app.macro_table import MechanismTable
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.fields import Count, Table
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.fill import Fill

NO_STEP = 1e-12  # of a grid that has none [s]: no tie is too stiff for it
NO_LOAD = -1  # number of forces that are of no table of [[loads]]
PULSE = 100.0  # steps that stand for the pulse of a settlement
LEVEL = 1e-9


class CurveTable(Table):
    """The table ``[limit.curve]``: the mechanism followed at finite displacements, and the factor that is left."""

    control: Annotated[str, Field(min_length=1)] | None = None
    """Block whose centre of mass is followed along the load; the one that moves fastest when not given."""
    steps: Annotated[Count, Field(ge=10, le=400)] = 40
    """From start to end, about."""
    displacement: Annotated[float, Unit("m"), Field(gt=0.0)] | None = None
    """Of the control block, at which to stop; where the factor vanishes when not given."""


class LimitTable(Table):
    """The table ``[limit]``: what ``masonry-cd limit`` multiplies, and how it solves."""

    push: DirectionKey | None = None
    """Along this direction a body force of lambda times the weight acts on every block."""
    tilt: DirectionKey | None = None
    """Or: to this level direction the structure is tilted, lambda is the tangent of the angle."""
    live: Annotated[tuple[Annotated[Count, Field(ge=0)], ...], Field(json_schema_extra={"default": []})] = ()
    """Or: numbers of the [[loads]] of kind point or vehicle that are multiplied, from 0; the others are constant."""
    masses: Annotated[tuple[Annotated[Count, Field(ge=0)], ...], Field(json_schema_extra={"default": []})] = ()
    """Numbers of the [[loads]] of kind point that are weights of masses, which a push or a tilt moves as it moves the blocks (Q_k of
    [C8.7.1.1]); the others are forces without mass."""
    sides: Annotated[Count, Field(ge=0, le=64)] = 0
    """Of friction pyramids that replace the circular cones of a structure in space, from inside; 0 for circular ones."""
    starts: Annotated[Count, Field(ge=0, le=1000)] | None = None
    """Of the search for the least factor of sliding without dilation. When not given: 4 in a plane; in space, where a start solves some ten
    cone programmes, 2 to 4, until two agree, with a check of up to 15,000 contact points and none else."""
    positions: Annotated[Count, Field(ge=3, le=2000)] | None = None
    """At which the worst place of a live vehicle without a position is looked for, before those around it; 60 in a plane, 16 in space when
    not given."""
    begin: Annotated[str, Field(min_length=1)] | None = Field(None, alias="from")
    """Folder of a run of these blocks, from that of the scene on: the analysis is of where it left them."""
    time: Annotated[float, Unit("s"), Field(ge=0.0)] | None = None
    """Of that run, the end when not given."""
    check: CheckTable | None = None
    """By the kinematic approach of a code, of the mechanism with the least a0* of those that a push or a tilt sets in motion."""
    curve: CurveTable | None = None
    """The capacity curve: the mechanism at finite displacements."""
    mechanism: Annotated[tuple[MechanismTable, ...], Field(strict=False)] = ()
    """Macro-elements to look at, each with all else held, [[limit.mechanism]] each."""

    @field_validator("live", "masses", mode="before")
    @classmethod
    def _list(cls, value: object) -> object:
        if not isinstance(value, (list, tuple)):
            raise ValueError("should be a list of numbers of [[loads]], e.g. [0]")
        if len(set(map(str, value))) < len(value):
            raise ValueError("should name each of the [[loads]] once")
        return tuple(value)

    @model_validator(mode="after")
    def _one_pattern(self) -> LimitTable:
        named = [name for name in ("push", "tilt", "live") if getattr(self, name)]
        if len(named) > 1:
            raise ValueError(f"{' and '.join(named)} are given; a limit analysis takes one pattern: one direction at a time")
        if self.time is not None and self.begin is None:
            raise ValueError("time: needs from beside it, the folder of a run")
        if 0 < self.sides < 3:
            raise ValueError("sides: a friction pyramid has at least 3")
        return self


@dataclass(frozen=True, eq=False)
class StaticLoads:
    """Loads on B blocks, and which pattern is multiplied."""

    kind: str  # push, tilt, live or settlement
    words: str
    direction: tuple[float, float, float] | None  # of push and tilt
    gravity: np.ndarray  # (B, 6) of blocks and point masses [N, N m]
    constant: np.ndarray  # (B, 6) of the other point loads [N, N m]
    live: np.ndarray  # (B, 6)
    bars: Bars
    tie_names: tuple[str, ...]  # of the bars; those of one name are one tie
    support_velocity: np.ndarray | None
    arms: Arms  # where the point loads act
    notes: tuple[str, ...]
    masses: PointMasses = field(default_factory=PointMasses.none)  # which a push moves beside the blocks

    @property
    def only_gravity(self) -> bool:
        """Whether gravity alone is constant and nothing but friction resists: a tilt is then a push."""
        return not self.constant.any() and not len(self.bars.strength)

    def at(self, cosine: float = 1.0) -> Loads:
        """The loads of a limit analysis; those of a tilt at the cosine of its angle."""
        turned = cosine if self.kind == "tilt" else 1.0
        return Loads(turned * self.gravity + self.constant, turned * self.live, self.bars, self.support_velocity, self.arms)


def static_loads(
    tables: Sequence[Mapping[str, Any]],
    limit: LimitTable,
    gravity: Sequence[float],
    folder: Path,
    assembly: Assembly,
    made: Sequence[tuple[str, Mapping[str, Any]]] = (),
    fills: Sequence[Fill] = (),
) -> StaticLoads:
    """The loads of a scene's tables ``[[loads]]`` and ``[limit]``, and the ties ``made`` by its structure (see :func:`loads.build`).

    Of ``fills``, those of bridges, the pressures are constant, active where they fall as walls move; their resistance is that of ties.

    Raises:
        InputError: no pattern, several, one that needs gravity where there is none, or a bad table.
    """
    asked = [loads.parse_load(table, f"loads[{i}]") for i, table in enumerate(tables)]
    down, free = np.asarray(gravity, dtype=float), ~assembly.fixed
    grid = RunGrid(NO_STEP, 1, down, folder, assembly, fills=fills)
    weight, nothing = np.zeros((assembly.count, 6)), np.zeros((assembly.count, 6))
    weight[free, :3] = assembly.mass[free, None] * down
    parts = {
        i: loads.KINDS[t.kind].part(_standing(t), grid, f"loads[{i}]")
        for i, t in enumerate(asked)
        if isinstance(t, (PointTable, TieTable, VehicleTable))
    }
    wheels = {i: part.forces for i, part in parts.items() if isinstance(asked[i], VehicleTable)}
    points = {i: part.forces[0] for i, part in parts.items() if isinstance(asked[i], PointTable)}
    for key, some in (("live", {**points, **wheels}), ("masses", points)):
        for i in getattr(limit, key):
            if i not in some:
                raise InputError(
                    f"limit.{key}", f"loads[{i}] is no load of kind point{' or vehicle' if key == 'live' else ''} of this scene"
                )
    kind, direction, words, support, at = _pattern(asked, limit, down, grid)
    masses = _masses({i: points[i] for i in limit.masses}, direction, down)
    weight += masses.under(down, assembly.count)
    forces = {i: force for i, force in points.items() if i not in limit.masses}
    filled = [fill.at_collapse(each, grid, direction is not None) for each in fills]
    thrusts = [force for part in filled for force in part.forces if isinstance(force, PointLoad)]
    numbered = list(forces.items()) + [(i, force) for i, each in wheels.items() for force in each]
    constant = sum((_wrench(force, assembly) for i, force in numbered if i not in limit.live), nothing)
    constant = sum((_wrench(force, assembly) for force in thrusts), constant)
    live = sum((_wrench(force, assembly) for i, force in numbered if i in limit.live), nothing)
    if direction is not None:
        live = nothing.copy()
        live[free, :3] = math.hypot(*down) * assembly.mass[free, None] * np.array(direction.vector)
        live += masses.under(math.hypot(*down) * np.array(direction.vector), assembly.count)
    bars = [bar(parse_table(TieTable, table, where), grid, where) for where, table in made]
    ties = [force for part in (*parts.values(), *bars, *filled) for force in part.forces if isinstance(force, Tie)]
    used = (PointTable, TieTable, VehicleTable, PushTable, TiltTable) if support is None else (PointTable, TieTable, VehicleTable)
    left = [
        f"loads[{i}] ({t.kind})"
        for i, t in enumerate(asked)
        if (not isinstance(t, used) or _by_displacement(t)) and i != at and t.kind != "gravity"
    ]
    notes = tuple(line for part in filled for line in part.lines)
    notes += (f"{', '.join(left)}: left out, a limit analysis is static",) if left else ()
    if limit.check is not None:
        notes += _without_mass({i: force for i, force in forces.items() if i not in limit.live}, down)
    vector = None if direction is None else direction.vector
    every = [*numbered, *((NO_LOAD, force) for force in thrusts)]
    arms, names = _arms(every, limit.live, masses, down, vector), tuple(tie.name for tie in ties)
    return StaticLoads(kind, words, vector, weight, constant, live, _bars(ties, assembly), names, support, arms, notes, masses)


def _standing(table: LoadTable) -> LoadTable:
    """A load as a limit analysis takes it: all of it there."""
    return table.model_copy(update={"speed": 0.0, "start": 0.0, "ramp": 0.0}) if isinstance(table, VehicleTable) else table


def _masses(points: Mapping[int, PointLoad], direction: Direction | None, down: np.ndarray) -> PointMasses:
    """The masses whose weights point loads by number are.

    Raises:
        InputError: one that does not act along gravity, or a pattern that moves no masses.
    """
    if not points:
        return PointMasses.none()
    if direction is None:
        raise InputError("limit.masses", "a push or a tilt moves masses; live loads and supports that move do not")
    for i, load in points.items():
        if float(load.force @ down) < (1.0 - LEVEL) * math.hypot(*load.force) * math.hypot(*down) or not load.force.any():
            raise InputError("limit.masses", f"loads[{i}] is no weight: its force {load.force.tolist()} does not act along gravity")
    each = list(points.values())
    mass = np.array([math.hypot(*load.force) for load in each]) / math.hypot(*down)
    return PointMasses(np.array([load.block for load in each]), np.array([load.arm for load in each]), mass)


def _without_mass(points: Mapping[int, PointLoad], down: np.ndarray) -> tuple[str, ...]:
    """A line on constant point loads that press downwards and count as forces without mass."""
    some = [i for i, load in points.items() if float(load.force @ down) > 0.5 * math.hypot(*load.force) * math.hypot(*down)]
    if not some:
        return ()
    which, verb = ", ".join(f"loads[{i}] (point)" for i in some), "act as forces" if len(some) > 1 else "acts as a force"
    return (f"{which} {verb} without mass, which a push does not move; limit.masses = {some} counts what weighs as P and Q of [C8.7.1.1]",)


def _by_displacement(table: LoadTable) -> bool:
    """Whether a load moves blocks, which a limit analysis does not."""
    return isinstance(table, PushTable) and table.control == "displacement"


def _pattern(
    asked: Sequence[LoadTable], limit: LimitTable, down: np.ndarray, grid: RunGrid
) -> tuple[str, Direction | None, str, np.ndarray | None, int | None]:
    """Kind, direction, words, velocity of the supports (B, 3), and the place in [[loads]], of the one pattern."""
    if limit.push is not None:
        return _body_force("push", limit.push, down, "limit.push", None)
    if limit.tilt is not None:
        return _body_force("tilt", limit.tilt, down, "limit.tilt", None)
    if limit.live:
        named = [f"loads[{i}]" + ("" if asked[i].kind == "point" else f" ({asked[i].kind})") for i in limit.live]
        return "live", None, f"live loads: {', '.join(named)}", None, None
    kinds = (PushTable, TiltTable, SettlementTable, SpreadingTable)
    there = [(i, table) for i, table in enumerate(asked) if isinstance(table, kinds) and not _by_displacement(table)]
    if not there:
        raise InputError("limit", 'no load to multiply; give one in [limit], e.g. push = "x", or a load of kind push or tilt')
    if len(there) > 1:
        which = ", ".join(f"loads[{i}] ({table.kind})" for i, table in there)
        raise InputError("limit", f"{which} are several patterns, a limit analysis takes one; name it in [limit]")
    ((at, table),) = there
    if isinstance(table, PushTable):
        return _body_force("push", table.direction, down, f"loads[{at}].direction", at)
    if isinstance(table, TiltTable):
        turned = table.direction or parse_direction([float(n) + 0.0 for n in np.cross(table.axis.vector, down)])  # type: ignore[union-attr]
        return _body_force("tilt", turned, down, f"loads[{at}].direction", at)
    assert isinstance(table, (SettlementTable, SpreadingTable))
    own = RunGrid(table.duration / PULSE, 2 * int(PULSE), grid.gravity, grid.folder, grid.assembly)
    part = loads.KINDS[table.kind].part(table, own, f"loads[{at}]")
    sign = math.copysign(1.0, table.displacement)
    velocity = np.outer(sign * np.asarray(part.share), table.direction.vector)
    return "settlement", None, f"loads[{at}] {table.kind} along {table.direction.label}", velocity, at


def _body_force(
    kind: str, direction: Direction, down: np.ndarray, where: str, at: int | None
) -> tuple[str, Direction, str, None, int | None]:
    """A push or a tilt."""
    size = math.hypot(*down)
    if size == 0.0:
        raise InputError(where, "needs gravity, but run.gravity is zero")
    if kind == "tilt" and abs(float(np.sum(down * direction.vector))) > LEVEL * size:
        raise InputError(where, "must be level, at right angles to gravity")
    return kind, direction, f"{kind} {'towards' if kind == 'tilt' else 'along'} {direction.label}", None, at


def _wrench(force: PointLoad, assembly: Assembly) -> np.ndarray:
    """A point load as forces and moments on all blocks, (B, 6)."""
    out = np.zeros((assembly.count, 6))
    out[force.block] = np.concatenate([force.force, np.cross(force.arm, force.force)])
    return out


def _arms(
    points: Sequence[tuple[int, PointLoad]], live: Sequence[int], masses: PointMasses, down: np.ndarray, way: tuple[float, ...] | None
) -> Arms:
    """Where loads by number act, those that are ``live`` and the others, and masses under gravity (3,) and a push along ``way``."""
    forces = np.array([load.force for _, load in points]).reshape(-1, 3)
    lives = np.isin(np.array([i for i, _ in points], dtype=np.int64), np.array(live, dtype=np.int64))[:, None]
    block = np.array([load.block for _, load in points], dtype=np.int64)
    arm = np.array([load.arm for _, load in points]).reshape(-1, 3)
    weights = masses.mass[:, None] * down
    shaken = masses.mass[:, None] * math.hypot(*down) * np.array(way or (0.0, 0.0, 0.0))
    dead, lively = np.concatenate([np.where(lives, 0.0, forces), weights]), np.concatenate([np.where(lives, forces, 0.0), shaken])
    return Arms(np.concatenate([block, masses.block]), np.concatenate([arm, masses.arm]), dead, lively)


def _bars(ties: Sequence[Tie], assembly: Assembly) -> Bars:
    """The ties, each with the force at which it yields."""
    if not ties:
        return Bars.none()
    blocks = np.array([tie.blocks for tie in ties])
    return Bars(blocks, assembly.centre[blocks] + np.array([tie.arms for tie in ties]), np.array([tie.limit for tie in ties]))


def limit_table(table: Mapping[str, Any]) -> LimitTable:
    """Check a table ``[limit]``.

    Raises:
        InputError: an unknown key, or a value out of range.
    """
    return parse_table(LimitTable, table, "limit")
