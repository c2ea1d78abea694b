# SPDX-License-Identifier: GPL-3.0-or-later
r"""A part of a structure with all other blocks held: the limit analysis of a macro-element.

Free are the blocks of the part and those that rest on them alone; all others are held. Three kinds of contacts join the two:

- where the part rests on what is held, or leans on it sideways, contacts bear as everywhere;
- where a stone of a held wall rests on the part, as in a bonded corner, the held stone would clamp the part for ever: its contact is left
  out, and friction in the bed takes its place. The force is that of the wall above the overlap, N = A sum gamma h, times mu, times 0.8.
  With n courses of height h_b and length of overlap l over a cross wall of thickness t_s these beds add up to the

      F = 0.4 n (n + 1) phi mu l^2 t_s w,      phi = h_b / l,

  of [C8.7.1.2], Circolare 7 of 2019, of which a bonded corner has every second bed here: the others are contacts, on which the part rests;
- where a floor or a roof rests on the part and on others, the share of its weight by area acts on the part, and shakes it (Q_k of
  [C8.7.1.1]).

Friction in a bed is a tie that yields: between the part and a point behind it, against the push.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull

from masonry_cd.analysis.limit.crushing import crushable
from masonry_cd.analysis.limit.interfaces import Interfaces, interfaces
from masonry_cd.analysis.limit.mechanism import BED
from masonry_cd.analysis.limit.problem import Arms, Bars, BlockLoads, LimitProblem, PointMasses, plane_of, problem_at
from masonry_cd.analysis.limit.rigid_groups import some_points
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joints import Joints

INTERLOCK = 0.8  # of the friction of the beds: 0.4 n (n + 1) over the 0.5 n (n + 1) that overburden by courses adds up to
WITHIN = 1e-6  # [m]


@dataclass(frozen=True, eq=False)
class Whole:
    """A structure whose parts are analysed: B blocks, J joints, dead loads and ties."""

    assembly: Assembly
    joints: Joints
    dead: np.ndarray  # (B, 6) [N, N m]
    bars: Bars
    gravity: float  # [m/s2], downwards
    rests: Callable[[str], bool]  # whether a group of blocks rests on walls, as a floor does, and is not bonded with them
    masses: PointMasses = field(default_factory=PointMasses.none)  # in addition to those of the blocks
    arms: Arms = field(default_factory=Arms.none)  # of the point loads among the dead loads

    @cached_property
    def points(self) -> Interfaces:
        """Return the points of all joints, in space."""
        return interfaces(self.assembly, self.joints, None)

    @cached_property
    def upper(self) -> np.ndarray:
        """(J,) the block that rests on the other one, -1 in upright joints."""
        up = self.joints.normal[:, 2]
        return np.where(up > BED, self.joints.block_b, np.where(up < -BED, self.joints.block_a, -1))

    @property
    def lower(self) -> np.ndarray:
        """(J,) the block on which the other one rests, -1 in upright joints."""
        other = self.joints.block_a + self.joints.block_b - self.upper
        return np.where(self.upper < 0, -1, other)

    @cached_property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner of the box around each block, (B, 3) [m]."""
        blocks = self.assembly.blocks
        return np.array([b.vertices.min(axis=0) for b in blocks]), np.array([b.vertices.max(axis=0) for b in blocks])

    @cached_property
    def _corners(self) -> tuple[np.ndarray, np.ndarray]:
        """(N, 3) corners of all blocks [m], and where those of each begin, (B,)."""
        blocks = self.assembly.blocks
        return np.concatenate([b.vertices for b in blocks]), np.cumsum([0, *(len(b.vertices) for b in blocks[:-1])])

    def extents(self, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where each block begins and ends along an axis (3,), (B,) [m]."""
        corners, start = self._corners
        return np.minimum.reduceat(corners @ axis, start), np.maximum.reduceat(corners @ axis, start)

    def prepare(self) -> None:
        """Find what all parts share, so that processes inherit it."""
        assert self.points.count >= 0 and len(self.upper) == self.joints.count and len(self.box[0])

    def overburden(self, joint: int) -> float:
        """Weight of what stands above a bed, over its area [N]; of a floor or a roof, its own weight in this bed."""
        assembly, joints = self.assembly, self.joints
        upper = int(self.upper[joint])
        if self.rests(assembly.groups[assembly.group_of[upper]]):
            beds = np.flatnonzero(self.upper == upper)
            return float(self.gravity * assembly.mass[upper] * joints.area[joint] / joints.area[beds].sum())
        low, high = self.box
        corners = joints.polygon[joints.polygon_start[joint] : joints.polygon_start[joint + 1]]
        x, y, z = corners.mean(axis=0)
        over = (low[:, 0] <= x) & (x <= high[:, 0]) & (low[:, 1] <= y) & (y <= high[:, 1]) & (low[:, 2] >= z - WITHIN) & ~assembly.fixed
        over[over] = [_covers(assembly.blocks[b], x, y) for b in np.flatnonzero(over)]
        height = high[over, 2] - low[over, 2]
        return float(joints.area[joint] * self.gravity * np.sum(assembly.mass[over] / assembly.volume[over] * height))


def _covers(block: Block, x: float, y: float) -> bool:
    """Return True if a place in plan [m] lies within the outline of a block, whose box reaches beyond it where the block is askew."""
    outline = ConvexHull(block.vertices[:, :2]).equations
    return bool((outline @ (x, y, 1.0) <= WITHIN).all())


@dataclass(frozen=True, eq=False)
class FreedPart:
    """Blocks of a structure that are free, and how they are joined to what is held."""

    whole: Whole
    assembly: Assembly  # all else held
    free: np.ndarray  # (B,) bool
    problem: LimitProblem  # of the free blocks, block by block
    push: np.ndarray  # (3,) as large as gravity [m/s2]
    loads: BlockLoads  # with what floors and bonded walls add
    beds: Bars  # friction in the beds of bonded walls, which are among the bars of the loads

    @property
    def interlock(self) -> float:
        """Friction in the beds of bonded walls [N]."""
        return float(self.beds.strength.sum())


def resting(whole: Whole, blocks: np.ndarray) -> np.ndarray:
    """(B,) some blocks and those that rest on them alone, or on what does."""
    free = np.zeros(whole.assembly.count, dtype=bool)
    free[blocks] = True
    lies = np.flatnonzero(whole.upper >= 0)
    upper, lower = whole.upper[lies], whole.lower[lies]
    movable = np.zeros_like(free)
    movable[upper] = True
    movable &= ~whole.assembly.fixed
    while True:
        held = np.zeros_like(free)
        held[upper[~free[lower]]] = True
        on = np.zeros_like(free)
        on[upper[free[lower]]] = True
        more = on & ~held & movable & ~free
        if not more.any():
            return free
        free |= more


def part_of(whole: Whole, free: np.ndarray, direction: np.ndarray) -> FreedPart:
    """The problem of the free blocks (B,) under a push along a direction (3,), all else held."""
    assembly = replace(whole.assembly, fixed=~free)
    joints = whole.joints
    upper, lower = whole.upper, whole.lower
    above = (upper >= 0) & ~free[upper] & free[lower]  # held, and rests on the part
    touches = (free[joints.block_a] | free[joints.block_b]) & ~above
    push = whole.gravity * np.asarray(direction, dtype=float)
    live = whole.masses.under(push, assembly.count)
    live[:, :3] += assembly.mass[:, None] * push
    live[~free] = 0.0
    way = np.asarray(direction, dtype=float)
    dead, beds, floors = _held_above(whole, np.flatnonzero(above), live, way)
    keep = free[whole.bars.blocks].any(axis=1)
    ties = Bars(whole.bars.blocks[keep], whole.bars.points[keep], whole.bars.strength[keep])
    own = replace(whole.arms, live=np.linalg.norm(whole.arms.live, axis=1, keepdims=True) * way)
    loads = BlockLoads(dead, live, _both(ties, beds), None, own.with_more(floors))
    axis = plane_of(assembly, loads)
    if axis is None:
        points = some_points(whole.points, touches[whole.points.joint])
    else:
        planar = interfaces(assembly, joints, axis)
        points = some_points(planar, touches[planar.joint])
    problem = crushable(problem_at(assembly, points, loads, axis), assembly, joints)
    return FreedPart(whole, assembly, free, problem, push, loads, beds)


def _held_above(whole: Whole, above: np.ndarray, live: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, Bars, Arms]:
    """Dead loads (B, 6) with what floors add, friction as ties, and the loads of floors; what floors shake is added to ``live`` (B, 6)."""
    dead, assembly = whole.dead.copy(), whole.assembly
    blocks, points, strength = [], [], []
    loaded: list[tuple[int, np.ndarray, float]] = []
    for j in above:
        upper, lower, weight = int(whole.upper[j]), int(whole.lower[j]), whole.overburden(int(j))
        corners = whole.joints.polygon[whole.joints.polygon_start[j] : whole.joints.polygon_start[j + 1]]
        place = corners.mean(axis=0)
        groups = assembly.group_of[[lower, upper]]
        if whole.rests(assembly.groups[groups[1]]):
            arm = place - assembly.centre[lower]
            loaded.append((lower, arm, weight))
            for forces, pull in ((dead, np.array([0.0, 0.0, -weight])), (live, weight * direction)):
                forces[lower] += np.concatenate([pull, np.cross(arm, pull)])
            continue
        blocks.append((lower, upper))
        points.append((place, place - direction))
        strength.append(INTERLOCK * float(assembly.friction[assembly.rows(lower, upper)]) * weight)
    heavy = np.array([each[2] for each in loaded])[:, None]
    floors = Arms(
        np.array([each[0] for each in loaded], dtype=np.int64), np.array([each[1] for each in loaded]).reshape(-1, 3),
        heavy * np.array([0.0, 0.0, -1.0]), heavy * direction,
    )  # fmt: skip
    return dead, Bars(np.array(blocks), np.array(points), np.array(strength)) if blocks else Bars.none(), floors


def _both(one: Bars, other: Bars) -> Bars:
    return Bars(*(np.concatenate([getattr(one, name), getattr(other, name)]) for name in ("blocks", "points", "strength")))
