# SPDX-License-Identifier: GPL-3.0-or-later
r"""Forces on single blocks: point loads, and ties as unilateral bars.

A **point load** keeps its direction and acts at a point that moves with its block. It is there at once, grows over ``ramp``, or goes
through stages, shares of it that are reached one after the other over ``ramp`` each and last for ``hold``. A **tie** is a bar between a
point of one block and a point of another, that pulls and never pushes, and yields at a given force if it has one; its law, and how it acts
in the step, are in :mod:`loads.bars`. A run with w h (1 + xi) > 1, where w = sqrt(k / m_e) and xi is the damping ratio, is refused, with
the dt that would do.

Ties that share a block stiffen one another. With g_i the row that maps the velocities of the blocks to L_i', w^2 is the largest
eigenvalue of sqrt(k_i k_j) g_i M^-1 g_j^T over all ties, and the same limit holds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from loads.acted import Acted, share_of
from loads.bars import Forces, PointLoad, Tie
from loads.motion import LoadKind, LoadTable, Part, RunGrid
from loads.supports import select
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import Flag, Instant, Numbers, check_tension, is_number
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.guides import Guide
from masonry_cd.mechanics.model.place_on_block import require_on_block

LONGEST_TIE = 1e6  # [m]
SOFTEST, STIFFEST = 1e-9, 1e18  # [N/m]
LARGEST_PHASE = 1.0  # w h (1 + xi) of a bar, and of all together

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Vector = tuple[float, float, float]


def _vector(value: object) -> Vector | None:
    """Three numbers."""
    if value is None:
        return None
    numbers = list(value) if isinstance(value, (list, tuple)) else []
    if len(numbers) != 3 or not all(map(is_number, numbers)):
        raise ValueError(f"must be three numbers, e.g. [0, 0, -1000]; given: {value}")
    return float(numbers[0]), float(numbers[1]), float(numbers[2])


def _pair(value: object) -> tuple[str, str]:
    """Two names."""
    names = list(value) if isinstance(value, (list, tuple)) else []
    if len(names) != 2 or not all(isinstance(name, str) for name in names) or names[0] == names[1]:
        raise ValueError("must be the names of two blocks")
    return names[0], names[1]


def _points(value: object) -> tuple[Vector, Vector] | None:
    """Two points."""
    points = list(value) if isinstance(value, (list, tuple)) else [] if value is not None else None
    if points is None:
        return None
    if len(points) != 2:
        raise ValueError("must be two points, e.g. [[0, 0, 3], [4, 0, 3]]")
    first, second = _vector(points[0]), _vector(points[1])
    if first is None or second is None:
        raise ValueError("must be two points of three numbers")
    return first, second


VectorKey = Annotated[Vector, BeforeValidator(_vector)]


class PointTable(LoadTable):
    """Keys of ``kind = "point"``."""

    kind: Literal["point"] = "point"
    block: str
    """Its name."""
    force: Annotated[VectorKey, Unit("N")]
    """A vector."""
    point: Annotated[Vector | None, Unit("m"), BeforeValidator(_vector)] = None
    """Of attack, as built, in the world; the centre of mass when not given."""
    start: Instant = 0.0
    """When the force begins."""
    ramp: Instant = 0.0
    """Time in which it grows linearly; with stages from each to the next."""
    stages: Numbers | None = None
    """Shares of the force that are reached one after the other, 1 being all of it, e.g. [0.5, 1, 0, 1.5]."""
    hold: Instant = 0.0
    """How long each stage but the last is held."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.hold and not self.stages:
            raise ValueError("hold: of no use without stages")
        if self.stages is not None and not any(self.stages):
            raise ValueError("stages: none is away from 0")
        if len(self.stages or ()) > 1 and not self.ramp + self.hold > 0.0:
            raise ValueError("stages: ramp and hold are 0, so that all of them would be at one time")
        return self

    @property
    def end(self) -> float:
        """When the last stage is reached [s]."""
        count = len(self.stages or (1.0,))
        return self.start + count * self.ramp + (count - 1) * self.hold

    def factor(self, times: np.ndarray) -> np.ndarray:
        """The share of the force at times (n,) [s]."""
        changes = np.diff([0.0, *(self.stages or (1.0,))])
        return np.asarray(sum(change * done for change, done in zip(changes, self._stages_at(times), strict=True)))

    def reached(self, time: float) -> float:
        """The share of all its changes, up and down, that has been made at a time [s]."""
        changes = np.abs(np.diff([0.0, *(self.stages or (1.0,))]))
        made = [float(done[0]) for done in self._stages_at(np.array([time]))]
        return share_of(float(np.sum(changes * made)), float(changes.sum()))

    def _stages_at(self, times: np.ndarray) -> list[np.ndarray]:
        """How far each stage has been reached at times (n,) [s], 0 to 1."""
        found, since = list[np.ndarray](), times - self.start
        for _ in self.stages or (1.0,):
            found.append(np.clip(since / self.ramp, 0.0, 1.0) if self.ramp > 0.0 else (since >= 0.0).astype(float))
            since = since - self.ramp - self.hold
        return found


class TieTable(LoadTable):
    """Keys of ``kind = "tie"``."""

    kind: Literal["tie"] = "tie"
    blocks: Annotated[tuple[str, str], BeforeValidator(_pair)]
    """Names of the two blocks."""
    points: Annotated[tuple[Vector, Vector] | None, Unit("m"), BeforeValidator(_points)] = None
    """Its ends, as built; the centres of mass when not given."""
    diameter: Annotated[Positive, Unit("m")] | None = None
    """Of its section."""
    area: Annotated[Positive, Unit("m2")] | None = None
    """Or the area of its section."""
    modulus: Annotated[Positive, Unit("Pa")] = 2.1e11
    """Young's modulus, by default that of steel."""
    tension: Annotated[NotNegative, Unit("N")] = 0.0
    """At the start."""
    yield_force: Annotated[Positive, Unit("N")] | None = None
    """At which it yields: beyond, it stretches for good and pulls no more than this; it never yields when not given."""
    from_start: Flag = False
    """There while elastic joints take up the weight, so that its stretch then counts; else it keeps its tension meanwhile, as by a jack."""
    name: str | None = None
    """For reports; the names of its blocks when not given."""
    damping: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.02
    """Share of the critical damping."""

    @model_validator(mode="after")
    def _one_section(self) -> Self:
        if (self.diameter is None) == (self.area is None):
            raise ValueError("give exactly one of diameter and area")
        check_tension(self.tension, self.yield_force)
        return self

    @property
    def section(self) -> float:
        """A [m2]."""
        return self.area if self.area is not None else 0.25 * np.pi * (self.diameter or 0.0) ** 2


def point(table: PointTable, grid: RunGrid, where: str) -> Part:
    """A point load.

    Raises:
        InputError: an unknown block, a support, or a point off the block.
    """
    assembly = _blocks(grid, where)
    block = one_block(table.block, assembly, f"{where}.block")
    if assembly.fixed[block]:
        raise InputError(f"{where}.block", f'"{table.block}" is fixed, a force cannot move it')
    if table.point is not None:
        require_on_block(assembly.blocks[block], table.point, f"{where}.point")
    arm = np.zeros(3) if table.point is None else np.array(table.point) - assembly.centre[block]
    load = PointLoad(block, arm, np.array(table.force), table.factor(grid.times))
    size = math.hypot(*load.force)
    weight = assembly.mass[block] * math.hypot(*grid.gravity)
    relation = f", {size / weight:.3g} times its weight" if weight > 0.0 else ""
    stages = f", in {len(table.stages)} stages up to {table.end:.4g} s" if table.stages else ""
    return Part(
        forces=(load,),
        lines=(f'{where} point load of {size:.4g} N on "{table.block}"{relation}{stages}',),
        acted=Acted(where, "force", table.end, table.reached),
        summary={
            "kind": "point",
            "block": table.block,
            "force": list(table.force),
            "point": None if table.point is None else list(table.point),
            "start": table.start,
            "ramp": table.ramp,
            **({"stages": list(table.stages), "hold": table.hold} if table.stages else {}),
        },
    )


def tie(table: TieTable, grid: RunGrid, where: str) -> Part:
    """A tie whose ends lie on its blocks.

    Raises:
        InputError: an end off its block; see :func:`bar`.
    """
    part, assembly = bar(table, grid, where), _blocks(grid, where)
    for end, (block, place) in enumerate(zip(part.forces[0].blocks, table.points or (), strict=False)):
        require_on_block(assembly.blocks[block], place, f"{where}.points[{end}]")
    return part


def bar(table: TieTable, grid: RunGrid, where: str) -> Part:
    """A tie from anywhere: those that a structure makes of a plate end at the mean of what it covers, which a block may go round.

    Raises:
        InputError: unknown blocks, two supports, ends at one point, or a bar too stiff for the time step.
    """
    assembly = _blocks(grid, where)
    ends = (one_block(table.blocks[0], assembly, f"{where}.blocks"), one_block(table.blocks[1], assembly, f"{where}.blocks"))
    if assembly.fixed[list(ends)].all():
        raise InputError(f"{where}.blocks", "both are fixed, a tie between them does nothing")
    centres = assembly.centre[list(ends)]
    points = centres if table.points is None else np.array(table.points)
    length = math.hypot(*(points[1] - points[0]))
    if length == 0.0:
        raise InputError(f"{where}.points", "both ends are at one point")
    if not length <= LONGEST_TIE:
        raise InputError(f"{where}.points", f"the ends are {length:.3g} m apart, at most {LONGEST_TIE:g} m are taken")
    stiffness = table.modulus * table.section / length
    if not SOFTEST <= stiffness <= STIFFEST:
        raise InputError(where, f"its modulus and section make {stiffness:.3g} N/m, {SOFTEST:g} to {STIFFEST:g} N/m are taken")
    omega = float(np.sqrt(stiffness / felt_mass(assembly, ends, points)))
    _check_phase(omega, table.damping, grid, f"{where}, a bar of {table.section:.3g} m2 between these blocks")
    damping = 2.0 * table.damping * stiffness / omega  # 2 xi sqrt(k m_e)
    limit = math.inf if table.yield_force is None else table.yield_force
    name, early = table.name or "", table.from_start
    made = Tie(ends, points - centres, length, table.section, stiffness, table.tension, damping, limit, name, early)
    yields = "" if table.yield_force is None else f", yields at {limit:g} N"
    about = f"{length:.4g} m, {stiffness:.4g} N/m, {table.tension:g} N{yields}"
    return Part(
        forces=(made,),
        lines=(f'{where} tie from "{table.blocks[0]}" to "{table.blocks[1]}": {about}',),
        summary={
            "kind": "tie",
            "blocks": list(table.blocks),
            "length": length,
            "section": table.section,
            "stiffness": stiffness,
            "tension": table.tension,
            "yield_force": table.yield_force,
        },
    )


def bar_of(assembly: Assembly, ends: tuple[int, int], points: np.ndarray, stiffness: float, limit: float, damping: float, name: str) -> Tie:
    """A bar without first tension, of a stiffness [N/m], that yields at a limit [N]; ``damping`` is a share of the critical one."""
    length, heard = math.hypot(*(points[1] - points[0])), felt_mass(assembly, ends, points)
    dashpot = 2.0 * damping * math.sqrt(stiffness * heard)
    return Tie(ends, points - assembly.centre[list(ends)], length, 1.0, stiffness, 0.0, dashpot, limit, name)


def collect(parts: Sequence[Part], grid: RunGrid) -> Forces | None:
    """The forces of all tables, None where there are none.

    Raises:
        InputError: ties that are too stiff together for the time step.
    """
    every: list[Any] = [force for part in parts for force in part.forces]
    if not every:
        return None
    forces = Forces(
        tuple(f for f in every if isinstance(f, PointLoad)),
        tuple(f for f in every if isinstance(f, Tie)),
        tuple(f for f in every if isinstance(f, Guide)),
    )
    if len(forces.ties) > 1:
        assert grid.assembly is not None
        omega, xi = _highest(forces.ties, grid.assembly)
        _check_phase(omega, xi, grid, "ties on the same blocks")
    return forces


def felt_mass(assembly: Assembly, ends: tuple[int, int], points: np.ndarray) -> float:
    """m_e of the head of this file [kg]; blocks that lean on others feel heavier, so this is the smallest it can be."""
    rows = _rows(assembly, ends, points)
    return 1.0 / sum(float(np.sum(row * _accelerated(assembly, block, row))) for block, row in rows.items())


def _rows(assembly: Assembly, ends: tuple[int, int], points: np.ndarray) -> dict[int, np.ndarray]:
    """g of the head of this file, (6,) for each free block at the ends of a tie: what its velocity adds to L'."""
    along = (points[1] - points[0]) / math.hypot(*(points[1] - points[0]))
    sides = zip(ends, points, (-1.0, 1.0), strict=True)
    return {
        block: sign * np.concatenate([along, np.cross(place - assembly.centre[block], along)])
        for block, place, sign in sides
        if not assembly.fixed[block]
    }


def _accelerated(assembly: Assembly, block: int, row: np.ndarray) -> np.ndarray:
    """M^-1 g^T of a block, (6,)."""
    a, b, c = assembly.inertia[block]  # Cramer's rule
    beside = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)])
    return np.concatenate([row[:3] / assembly.mass[block], np.sum(beside * row[3:], axis=1) / np.sum(a * beside[0])])


def _highest(ties: Sequence[Tie], assembly: Assembly) -> tuple[float, float]:
    """The largest w of all ties together [rad/s], and the largest damping ratio of one."""
    rows = [_rows(assembly, tie.blocks, assembly.centre[list(tie.blocks)] + tie.arms) for tie in ties]
    fastest, ratios = 0.0, list[float]()
    for members in _sharing(rows):
        coupled = np.zeros((len(members), len(members)))
        for i, first in enumerate(members):
            for block, row in rows[first].items():
                gain = _accelerated(assembly, block, row)
                for j, second in enumerate(members):
                    if block in rows[second]:
                        both = np.sqrt(ties[first].stiffness * ties[second].stiffness)
                        coupled[i, j] += both * float(np.sum(rows[second][block] * gain))
        fastest = max(fastest, float(np.linalg.eigvalsh(coupled)[-1]))
        ratios += [0.5 * ties[t].damping * float(np.sqrt(coupled[i, i])) / ties[t].stiffness for i, t in enumerate(members)]
    return math.sqrt(fastest), max(ratios)


def _sharing(rows: Sequence[Mapping[int, np.ndarray]]) -> list[list[int]]:
    """The ties of each set that hangs together by free blocks."""
    on, seen, found = dict[int, list[int]](), set[int](), list[list[int]]()
    for i, row_of in enumerate(rows):
        for block in row_of:
            on.setdefault(block, []).append(i)
    for i in range(len(rows)):
        members = [] if i in seen else [i]
        seen.add(i)
        for member in members:  # which grows meanwhile
            more = dict.fromkeys(j for block in rows[member] for j in on[block] if j not in seen)
            seen.update(more)
            members += more
        found += [sorted(members)] if members else []
    return found


def _check_phase(omega: float, damping: float, grid: RunGrid, what: str) -> None:
    """Refuse a time step that is too long for bars of angular frequency omega [1/s]; ``what`` names them."""
    key, step = ("run.dt", grid.dt) if grid.longest is None else ("run.dt_max", grid.longest)
    phase = omega * step * (1.0 + damping)
    if phase > LARGEST_PHASE:
        allowed = f"at most {step * LARGEST_PHASE / phase:.2g} s"
        raise InputError(key, f"{step:g} s is too long for the {omega / (2.0 * np.pi):.3g} Hz of {what}; {allowed}")


def _blocks(grid: RunGrid, where: str) -> Assembly:
    if grid.assembly is None:
        raise InputError(where, "needs a structure, whose blocks it names")
    return grid.assembly


def one_block(name: str, assembly: Assembly, where: str) -> int:
    """The index of the one block of a name or pattern."""
    if name in assembly.names:
        return assembly.names.index(name)
    found = np.flatnonzero(select([name], assembly, where))
    if len(found) > 1:
        some = ", ".join(assembly.names[b] for b in found[:4])
        raise InputError(where, f'"{name}" names {len(found)} blocks ({some} ...), one is needed')
    return int(found[0])


KINDS = {
    "point": LoadKind(PointTable, point, lambda table, grid, where: table.end),
    "tie": LoadKind(TieTable, tie, lambda table, grid, where: 0.0),
}
