# SPDX-License-Identifier: GPL-3.0-or-later
r"""Guided blocks, of pushes by displacement and of props: their motion along a direction is given, and their reaction is recorded.

A point of each block, its centre of mass when not given, moves along d by

    s(t) = s_j-1 + (s_j - s_j-1) (10 x^3 - 15 x^4 + 6 x^5),        x = (t - t_j) / T_j,

from target to target, with a rest at each if the table holds it. The velocity of the steps is that by which s is met at their ends. What is
not given, the way across d and the rotation, is free, or the blocks are held from turning. Forces on them keep their own direction.

**How slow.** With D_j = |s_j - s_j-1| the largest speed is 15/8 D_j / T_j and the largest acceleration 5.77 D_j / T_j^2. A body on joints
of friction mu cannot be pushed by more than mu times its weight and what else presses on it; all blocks together, as fast as those that are
pushed, oppose their mass times that acceleration. Where the speed is not given, T_j is such that this is QUIET of mu times the weight.
A speed for which it exceeds LOUD of mu times weight and forces is refused: the force recorded would be that of inertia.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, Field

from loads.acted import Acted, share_of
from loads.bars import PointLoad
from loads.motion import Direction, LoadAction, RunGrid, strict
from loads.supports import Names, select
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import MOST_STEPS, Instant, Numbers, Vector
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.guides import Guide
from masonry_cd.mechanics.model.place_on_block import require_on_block
from masonry_cd.mechanics.model.usual import LENGTHS

QUIET, LOUD = 2e-3, 1e-2  # shares of mu times what presses that inertia may have: chosen, and refused from there on
FEWEST_STEPS, FEW_STEPS = 20, 100  # of the run from target to target: refused, and taken where the speed is not given
PEAK_SPEED, PEAK_ACCELERATION = 1.875, 10.0 / math.sqrt(3.0)  # of the way from 0 to 1 in a time of 1
SMOOTHEST = 0.1  # friction at least, by which the speed is chosen
ON_FACE = 1e-6  # of the extent of the blocks: corners as near to the outermost lie on the face
ACROSS = 1e-9
PUSHED = Usual(0.0, 0.25, "what is pushed by a quarter of its structure's height has long come down", LENGTHS, over="height")
Faces = Literal["x", "+x", "-x", "y", "+y", "-y", "z", "+z", "-z"]


class GuidedKeys(BaseModel):
    """Which points of which blocks are guided."""

    model_config = strict

    blocks: Names = None
    """Names of the blocks or groups that are moved; * stands for any letters."""
    face: Faces | None = None
    """Their outermost face on that side: of those blocks that reach it, its middle is moved, instead of the centre of mass."""
    point: Annotated[Vector | None, Unit("m")] = None
    """Point that is moved, as built, of a single block."""
    rotation: Literal["free", "held"] = "free"
    """Rotation of the blocks: "held" for double bending, or a beam that is kept level."""
    name: str | None = None
    """Name in tables and plots; that of the blocks when not given."""

    def check_place(self) -> None:
        """Refuse two places at once.

        Raises:
            ValueError: for the validator of a table.
        """
        if self.face is not None and self.point is not None:
            raise ValueError("give face or point, not both")


class DrivenKeys(GuidedKeys):
    """How far blocks are moved, and how fast."""

    targets: Annotated[Numbers | None, Unit("m"), PUSHED] = None
    """Displacements along the direction that are reached one after the other, from 0 on: one for a push, several for stages and cycles."""
    speed: Annotated[float, Unit("m/s"), Field(gt=0.0)] | None = None
    """Largest rate of the motion; slow enough for 0.2 % of inertia in the force when not given."""
    hold: Instant = 0.0
    """Rest at each target."""


@dataclass(frozen=True)
class PushPath:
    """The way of a push: J legs."""

    begins: tuple[float, ...]  # when each leg begins [s]
    lengths: tuple[float, ...]  # how long it takes [s]
    ways: tuple[float, ...]  # how far it goes [m]
    end: float  # when the last target has been held [s]

    def at(self, times: np.ndarray) -> np.ndarray:
        """s at times (n,) [m]."""
        way = np.zeros(len(times))
        for begin, length, far in zip(self.begins, self.lengths, self.ways, strict=True):
            x = np.clip((times - begin) / length, 0.0, 1.0)
            way += far * x * x * x * (10.0 + x * (6.0 * x - 15.0))
        return way

    def passed(self, time: float) -> float:
        """The share of the whole way, to and fro, that has been gone at a time [s]."""
        there = replace(self, ways=tuple(abs(way) for way in self.ways))
        return share_of(float(there.at(np.array([time]))[0]), sum(there.ways))

    def velocity(self, grid: RunGrid) -> np.ndarray:
        """(N + 1,) of the steps, whose positions follow the trapezoidal rule [m/s]."""
        half = 0.5 * grid.dt
        return np.asarray((self.at(grid.times + half) - self.at(grid.times - half)) / grid.dt)


def driven(table: DrivenKeys, direction: Direction, start: float, grid: RunGrid, where: str) -> LoadAction:
    """The guide of blocks that are pushed.

    Raises:
        InputError: unknown or fixed blocks, a point off its block, targets beyond the blocks, or a leg that the steps cannot follow.
    """
    path, targets = path_of(table, start, grid, where), table.targets or ()
    guide = guide_of(table, direction, path.velocity(grid), grid, where)
    _check_reach(guide, targets, grid, where)
    legs = f"{len(targets)} targets" if len(targets) > 1 else f"{targets[0]:g} m"
    fastest = max(PEAK_SPEED * abs(far) / length for far, length in zip(path.ways, path.lengths, strict=True))
    turns = "held from turning" if guide.held else "free to turn"
    how = f"{legs}, {start:g} to {path.end:.4g} s, at most {fastest:.3g} m/s, {turns}"
    line = f"{where} push of {counted(guide)} along {direction.label}: {how}"
    summary = {"kind": "push", "control": "displacement", "direction": list(direction.vector), "start": start, "end": path.end}
    summary |= {"targets": list(targets), "speed": fastest, "rotation": table.rotation, **named(guide, grid, where)}
    return LoadAction(forces=(guide,), lines=(line,), summary=summary, acted=Acted(where, "path", path.end, path.passed))


def path_of(table: DrivenKeys, start: float, grid: RunGrid, where: str) -> PushPath:
    """The way of a push.

    Raises:
        InputError: targets that all are where it begins, or a speed that the steps cannot follow.
    """
    targets = table.targets or ()
    ways = np.diff([0.0, *targets]).tolist()
    if not any(ways):
        raise InputError(f"{where}.targets", "none is away from 0")
    begins, lengths, at = [], [], start
    for way in ways:
        length = _length(table, abs(way), grid, where)
        begins.append(at)
        lengths.append(max(length, grid.dt))
        at += length + table.hold
    if at > MOST_STEPS * grid.dt:
        raise InputError(where, f"its way takes {at:.3g} s, more than {MOST_STEPS:g} steps of run.dt {grid.dt:g} s")
    return PushPath(tuple(begins), tuple(lengths), tuple(ways), at)


def _length(table: DrivenKeys, way: float, grid: RunGrid, where: str) -> float:
    """How long a leg takes [s]."""
    if way == 0.0:
        return 0.0
    if table.speed is not None:
        length = PEAK_SPEED * way / table.speed
        if length < FEWEST_STEPS * grid.dt:
            raise InputError(
                f"{where}.speed",
                f"at {table.speed:g} m/s the leg of {way:g} m takes {length / grid.dt:.3g} steps of run.dt {grid.dt:g} s, "
                f"and at least {FEWEST_STEPS} are needed; without a speed the push is as slow as it has to be",
            )
        return length
    gravity = math.hypot(*grid.gravity)
    if gravity == 0.0:
        raise InputError(f"{where}.speed", "missing, and without gravity there is no force from which it could follow")
    return max(FEW_STEPS * grid.dt, math.sqrt(PEAK_ACCELERATION * way / (QUIET * _friction(grid, where) * gravity)))


def check_inertia(guides: Sequence[Guide], points: Sequence[PointLoad], grid: RunGrid, wheres: Sequence[str]) -> None:
    """Refuse pushes so fast that inertia would be more of the force than LOUD, whatever the structure does.

    Raises:
        InputError: names the key, the share and the speed that would do.
    """
    assembly = grid.assembly
    if assembly is None or assembly.laws.apex.any() or not len(guides):  # bonds carry what friction does not
        return
    mass = float(assembly.mass[~assembly.fixed].sum())
    pressed = mass * math.hypot(*grid.gravity) + sum(math.hypot(*load.force) for load in points)
    for guide, where in zip(guides, wheres, strict=True):
        most = float(np.abs(np.diff(guide.velocity)).max(initial=0.0)) / grid.dt
        share = mass * most / (_friction(grid, where) * pressed) if pressed > 0.0 else math.inf if most else 0.0
        if share > LOUD:
            fastest = float(np.abs(guide.velocity).max())
            raise InputError(
                f"{where}.speed",
                f"at {fastest:.3g} m/s the inertia of the blocks is {share:.2g} of what friction lets the push reach, "
                f"and a push is slow up to {LOUD:g}; lower it to {fastest * math.sqrt(LOUD / share):.2g} m/s, or leave the key out",
            )


def _friction(grid: RunGrid, where: str) -> float:
    """The largest coefficient of friction, SMOOTHEST at the least."""
    return max(SMOOTHEST, float(grid.blocks(where).friction.max()))


def guide_of(table: GuidedKeys, direction: Direction, velocity: np.ndarray, grid: RunGrid, where: str) -> Guide:
    """The guide of the blocks of a table."""
    assembly, names = grid.blocks(where), table.blocks or ()
    mask = select(names, assembly, f"{where}.blocks")
    stuck = np.flatnonzero(mask & assembly.fixed)
    if len(stuck):
        raise InputError(f"{where}.blocks", f'"{assembly.names[stuck[0]]}" is fixed; kind = "settlement" moves supports')
    if grid.longest is not None:
        raise InputError(where, 'blocks are guided in steps of one length; run.dt = "auto" has several')
    blocks = np.flatnonzero(mask)
    if table.face is not None:
        blocks, points = _on_face(assembly, blocks, table.face)
    elif table.point is not None:
        if len(blocks) > 1:
            raise InputError(f"{where}.point", f"{len(blocks)} blocks are named, and a point is on one")
        require_on_block(assembly.blocks[blocks[0]], table.point, f"{where}.point")
        points = np.array([table.point])
    else:
        points = assembly.centre[blocks]
    name = table.name or ", ".join(names)
    return Guide(blocks, points - assembly.centre[blocks], np.array(direction.vector), velocity, table.rotation == "held", name)


def _on_face(assembly: Assembly, blocks: np.ndarray, face: str) -> tuple[np.ndarray, np.ndarray]:
    """Which of some blocks have corners on their outermost face, and the middles of the boxes of these corners (K, 3) [m]."""
    axis, sign = "xyz".index(face[-1]), -1.0 if face[0] == "-" else 1.0
    corners = [assembly.blocks[b].vertices for b in blocks]
    farthest = np.array([(sign * own[:, axis]).max() for own in corners])
    near = ON_FACE * max(float(np.ptp(own, axis=0).max()) for own in corners)
    reach = farthest >= farthest.max() - near
    points = []
    for own, far in zip([c for c, on in zip(corners, reach, strict=True) if on], farthest[reach], strict=True):
        on = own[sign * own[:, axis] >= far - near]
        points.append(0.5 * (on.min(axis=0) + on.max(axis=0)))
    return blocks[reach], np.array(points)


def _check_reach(guide: Guide, targets: Sequence[float], grid: RunGrid, where: str) -> None:
    """Refuse targets beyond the size of what is moved: whatever it stood on, it would be off it.

    Raises:
        InputError: names the target and the size.
    """
    assembly = grid.blocks(where)
    along = np.concatenate([np.sum(assembly.blocks[b].vertices * guide.direction, axis=1) for b in guide.blocks])
    size, farthest = float(np.ptp(along)), max(targets, key=abs)
    if abs(farthest) > size:
        raise InputError(
            f"{where}.targets", f"{farthest:g} m is beyond the blocks that are moved, which are {size:.4g} m long along the way"
        )


def check_together(guides: Sequence[Guide], assembly: Assembly, wheres: Sequence[str]) -> None:
    """Refuse guides that give one block two motions.

    Raises:
        InputError: names the block and both tables.
    """
    for i, (one, where) in enumerate(zip(guides, wheres, strict=True)):
        for other, there in zip(guides[:i], wheres[:i], strict=True):
            both = np.intersect1d(one.blocks, other.blocks)
            if len(both) and abs(float(np.sum(one.direction * other.direction))) > ACROSS:
                name = assembly.names[int(both[0])]
                raise InputError(f"{where}.direction", f'"{name}" is already guided by {there}, and not at right angles to this')


def counted(guide: Guide) -> str:
    """How many blocks a guide moves, as text."""
    return f'"{guide.name}"' if len(guide.blocks) == 1 else f'"{guide.name}" ({len(guide.blocks)} blocks)'


def named(guide: Guide, grid: RunGrid, where: str) -> dict[str, object]:
    """Return the name of a guide and those of its blocks, for summary.json."""
    return {"name": guide.name, "blocks": [grid.blocks(where).names[b] for b in guide.blocks]}
