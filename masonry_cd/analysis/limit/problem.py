# SPDX-License-Identifier: GPL-3.0-or-later
r"""The problem of a limit analysis, in forces without units.

With r the forces at the P points of the joints, N those of the ties, w_0 the dead loads and w_1 the live ones, the largest factor is

    max lambda     H^T r - G^T N + w_0 + lambda w_1 = 0,      r_k + a_k n in Coulomb's cone,    r_kn >= -f_k,    0 <= N <= N_y     (static)

H maps the velocities of the free blocks to the relative velocities at the points (opening positive), G to the rates at which ties grow
longer. The dual problem speaks of the velocities v of the blocks: with u = H v, and w_1 . v = 1,

    min  -w_0 . v + (work of the bonds and of the ties that yield),     mu |u_t| <= u_n      (kinematic)

which is the associated flow rule: what slides also opens. Livesley, Int. J. Numer. Meth. Engng 12, 1978.

**Units.** Forces are over the mean weight W of the free blocks, lengths over the cube root L of their mean volume: numbers near one.
The unknowns of a block are (v, L omega), six in space and three in a plane.

**Supports that move.** A pattern V of support velocities adds one unknown, its factor: its row of H^T r is the power of the forces on the
supports for V. With w_1 = 1 there, -lambda is what the supports still bear of it when they have moved a little: the least that they can.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, hstack

from masonry_cd.analysis.limit.interfaces import Interfaces, interfaces
from masonry_cd.analysis.limit.sections import Sections
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.middle_plane import middle_plane


@dataclass(frozen=True, eq=False)
class Bars:
    """T ties: bars that pull and do not push."""

    blocks: np.ndarray  # (T, 2)
    points: np.ndarray  # (T, 2, 3) ends, world frame [m]
    strength: np.ndarray  # (T,) force at which they yield [N], inf where it is not known

    @classmethod
    def none(cls) -> Bars:
        """No tie."""
        return cls(np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2, 3)), np.zeros(0))


@dataclass(frozen=True, eq=False)
class Arms:
    """Where the N point loads act whose moments turn with their blocks."""

    block: np.ndarray  # (N,)
    arm: np.ndarray  # (N, 3) from the centre of mass as built [m]
    dead: np.ndarray  # (N, 3) their part of the dead loads [N]
    live: np.ndarray  # (N, 3) and of the live ones

    @classmethod
    def none(cls) -> Arms:
        """No point load."""
        return cls(np.zeros(0, dtype=np.int64), *np.zeros((3, 0, 3)))

    def wrenches(self, forces: np.ndarray, count: int) -> np.ndarray:
        """Forces (N, 3) at these points as forces and moments (B, 6) on a given number of blocks [N, N m]."""
        out = np.zeros((count, 6))
        np.add.at(out, self.block, np.concatenate([forces, np.cross(self.arm, forces)], axis=1))
        return out

    def with_more(self, more: Arms) -> Arms:
        """These and more."""
        return Arms(*(np.concatenate([getattr(self, name), getattr(more, name)]) for name in ("block", "arm", "dead", "live")))


@dataclass(frozen=True, eq=False)
class PointMasses:
    """N masses at points of blocks, which a push moves as it moves the blocks."""

    block: np.ndarray  # (N,)
    arm: np.ndarray  # (N, 3) from the centre of mass as built [m]
    mass: np.ndarray  # (N,) [kg]

    @classmethod
    def none(cls) -> PointMasses:
        """No mass."""
        return cls(np.zeros(0, dtype=np.int64), np.zeros((0, 3)), np.zeros(0))

    def under(self, acceleration: np.ndarray, count: int) -> np.ndarray:
        """Forces and moments (B, 6) on a given number of blocks under an acceleration (3,) [m/s2]."""
        out = np.zeros((count, 6))
        force = self.mass[:, None] * acceleration
        np.add.at(out, self.block, np.concatenate([force, np.cross(self.arm, force)], axis=1))
        return out


@dataclass(frozen=True, eq=False)
class BlockLoads:
    """Loads on the B blocks: forces [N] and moments about the centres of mass [N m], or supports that move."""

    dead: np.ndarray  # (B, 6)
    live: np.ndarray  # (B, 6), multiplied by the factor
    bars: Bars
    support_velocity: np.ndarray | None = None  # (B, 3) of the supports, (B, 6) where they turn; then there are no live forces
    arms: Arms | None = None  # of the point loads among them; without it, moments stay what they are when blocks turn

    def moved(self, centre: np.ndarray, position: np.ndarray, rotation: np.ndarray) -> BlockLoads:
        """These loads [N, N m] on blocks that have moved from ``centre`` (B, 3) to ``position`` and turned by ``rotation`` (B, 3, 3)."""
        bars = self.bars
        local = bars.points - centre[bars.blocks]
        bars = Bars(bars.blocks, position[bars.blocks] + np.einsum("teij,tej->tei", rotation[bars.blocks], local), bars.strength)
        if self.arms is None:
            return replace(self, bars=bars)
        arms, dead, live = self.arms, self.dead.copy(), self.live.copy()
        turned = np.einsum("nij,nj->ni", rotation[arms.block], arms.arm)
        for forces, part in ((dead, arms.dead), (live, arms.live)):
            np.add.at(forces[:, 3:], arms.block, np.cross(turned - arms.arm, part))
        return replace(self, dead=dead, live=live, bars=bars, arms=replace(arms, arm=turned))


@dataclass(frozen=True, eq=False)
class LimitProblem:
    """A limit analysis over F free blocks with n unknowns each, P points with m directions, and T ties. Without units."""

    points: Interfaces
    axis: int | None  # normal of the plane in which it moves; None in space
    free: np.ndarray  # (F,) blocks
    weight: float  # W [N]
    length: float  # L [m]
    jacobian: csr_matrix  # (P m, n F + 1 or + 0) H
    bars: csr_matrix  # (T, ...) G, the cells of joints that crush behind the ties
    dead: np.ndarray  # (n F ...)
    live: np.ndarray  # (n F ...)
    mu: np.ndarray  # (P,)
    apex: np.ndarray  # (P,) a_k
    tension: np.ndarray  # (P,) f_k
    strength: np.ndarray  # (T,) N_y
    moves_support: bool
    sections: Sections | None = None  # of joints that crush; None: there are none

    @property
    def ties(self) -> int:
        """How many of the bars are ties."""
        return len(self.strength) - (0 if self.sections is None else len(self.sections.cells.owner))

    @property
    def rates(self) -> int:
        """How many of the unknowns, the last ones, are closing rates of joints that crush."""
        return 0 if self.sections is None else len(self.sections.joint) * (1 + self.sections.levers)

    def point_velocity(self, v: np.ndarray) -> np.ndarray:
        """(P, m) relative velocities of the blocks at the points, from the unknowns."""
        left = self.unknowns - self.rates
        return np.asarray(self.jacobian[:, :left] @ v[:left]).reshape(self.points.count, self.directions)

    def without_ties(self) -> LimitProblem:
        """The problem of the same joints under the same loads."""
        return replace(self, bars=self.bars[self.ties :], strength=self.strength[self.ties :])

    @property
    def directions(self) -> int:
        """m."""
        return 3 if self.axis is None else 2

    @property
    def unknowns(self) -> int:
        """Number of unknown velocities."""
        return len(self.dead)

    def bond(self) -> np.ndarray:
        """(P m,) the vector a_k n: forces are r = r' - bond with r' in Coulomb's cone."""
        out = np.zeros((self.points.count, self.directions))
        out[:, 0] = self.apex
        return out.ravel()

    def block_velocity(self, v: np.ndarray, count: int) -> np.ndarray:
        """Velocities (B, 6) of all blocks from the unknowns, in the units of v: angular velocities are per metre of v's length."""
        out = np.zeros((count, 6))
        columns = self.columns
        part = v[: len(self.free) * len(columns)].reshape(len(self.free), len(columns)).copy()
        part[:, columns >= 3] /= self.length
        out[self.free[:, None], columns] = part
        return out

    def unknowns_of(self, velocity: np.ndarray) -> np.ndarray:
        """The unknowns of velocities (B, 6) of blocks, without supports that move; no joint crushes."""
        part = velocity[self.free].copy()
        part[:, 3:] *= self.length
        return np.concatenate([part[:, self.columns].ravel(), np.zeros(self.rates)])

    @property
    def columns(self) -> np.ndarray:
        """Which of (vx, vy, vz, wx, wy, wz) are unknowns."""
        return _columns(self.axis)


def limit_problem(assembly: Assembly, joints: Joints, loads: BlockLoads) -> LimitProblem:
    """Set up a limit analysis; it is planar where the structure and its loads are."""
    axis = plane_of(assembly, loads)
    return problem_at(assembly, interfaces(assembly, joints, axis), loads, axis)


def problem_at(assembly: Assembly, points: Interfaces, loads: BlockLoads, axis: int | None) -> LimitProblem:
    """Set up a limit analysis of forces at given points; ``axis`` is the normal of the plane, None in space."""
    free = np.flatnonzero(~assembly.fixed)
    weight = max(float(np.linalg.norm(loads.dead[free, :3], axis=1).mean()), 1e-300)
    length = float(assembly.volume[free].mean()) ** (1.0 / 3.0)
    normal = [points.frame[:, k] for k in range(points.frame.shape[1])]
    rows = [_rows(assembly, points, direction) for direction in normal]
    stacked = np.stack(rows, axis=1).reshape(-1, 2, 6)  # (P m, 2, 6)
    ends = np.repeat(points.bodies, len(normal), axis=0)
    jacobian = _assemble(stacked, ends, assembly, axis, length)
    bars = _assemble(bar_rows(assembly, loads.bars), loads.bars.blocks, assembly, axis, length)
    scale = np.where(_columns(axis) < 3, weight, weight * length)
    dead, live = ((part[free][:, _columns(axis)] / scale).ravel() for part in (loads.dead, loads.live))
    moves = loads.support_velocity is not None
    if moves:
        velocity = np.asarray(loads.support_velocity)
        velocity = np.pad(velocity, ((0, 0), (0, 6 - velocity.shape[1])))
        jacobian = _with_column(jacobian, np.einsum("red,red->r", stacked, velocity[ends]))
        bars = _with_column(bars, np.einsum("red,red->r", bar_rows(assembly, loads.bars), velocity[loads.bars.blocks]))
        dead, live = np.append(dead, 0.0), np.append(live, 1.0)
    return LimitProblem(
        points=points, axis=axis, free=free, weight=weight, length=length, jacobian=jacobian, bars=bars, dead=dead, live=live, mu=points.mu,
        apex=points.apex / weight, tension=points.tension / weight, strength=loads.bars.strength / weight, moves_support=moves,
    )  # fmt: skip


def plane_of(assembly: Assembly, loads: BlockLoads) -> int | None:
    """Normal of the plane in which the structure moves under its loads, None where it needs space."""
    for axis in range(3):
        at = middle_plane(assembly, axis)
        if at is None:
            continue
        across = [axis, *(3 + d for d in range(3) if d != axis)]
        forces = np.concatenate([loads.dead, loads.live])
        moved = loads.support_velocity
        still = moved is None or not moved[:, [column for column in across if column < moved.shape[1]]].any()
        size = 1e-9 * float(np.abs(forces).max(initial=0.0))
        if still and not (np.abs(forces[:, across]) > size).any() and _is_in_plane(loads.bars, axis, at):
            return axis
    return None


def _is_in_plane(bars: Bars, axis: int, at: float) -> bool:
    return bool((np.abs(bars.points[..., axis] - at) <= 1e-9 * max(1.0, abs(at))).all())


def _columns(axis: int | None) -> np.ndarray:
    return np.arange(6) if axis is None else np.array([*(d for d in range(3) if d != axis), 3 + axis])


def _rows(assembly: Assembly, points: Interfaces, direction: np.ndarray) -> np.ndarray:
    """Relative velocity of b from a along a direction (P, 3), by the velocities of both: (P, 2, 6)."""
    arms = points.point[:, None] - assembly.centre[points.bodies]
    turning = np.cross(arms, direction[:, None])
    moving = np.broadcast_to(direction[:, None], turning.shape)
    return np.concatenate([moving, turning], axis=2) * np.array([-1.0, 1.0])[:, None]


def bar_rows(assembly: Assembly, bars: Bars) -> np.ndarray:
    """Rate at which each bar grows longer, by the velocities of its two blocks: (T, 2, 6)."""
    if not len(bars.strength):
        return np.zeros((0, 2, 6))
    line = bars.points[:, 1] - bars.points[:, 0]
    along = (line / np.linalg.norm(line, axis=1, keepdims=True))[:, None] * np.array([-1.0, 1.0])[:, None]
    return np.concatenate([along, np.cross(bars.points - assembly.centre[bars.blocks], along)], axis=2)


def _assemble(rows: np.ndarray, ends: np.ndarray, assembly: Assembly, axis: int | None, length: float) -> csr_matrix:
    """Rows (R, 2, 6) over blocks (R, 2) as a matrix over the unknowns of the free blocks."""
    columns = _columns(axis)
    number = np.cumsum(~assembly.fixed) - 1
    values = rows[..., columns] / np.where(columns < 3, 1.0, length)
    place = number[ends][..., None] * len(columns) + np.arange(len(columns))
    moving = np.broadcast_to(~assembly.fixed[ends][..., None], values.shape)
    row = np.broadcast_to(np.arange(len(rows))[:, None, None], values.shape)
    shape = (len(rows), len(columns) * int((~assembly.fixed).sum()))
    return coo_matrix((values[moving], (row[moving], place[moving])), shape).tocsr()


def _with_column(matrix: csr_matrix, column: np.ndarray) -> csr_matrix:
    return hstack([matrix, csr_matrix(column[:, None])], format="csr")
