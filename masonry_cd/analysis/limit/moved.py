# SPDX-License-Identifier: GPL-3.0-or-later
r"""Blocks that have moved by finite amounts: where they are, and the joints that they have there.

**Motion.** A block with velocity (v, w) at its centre of mass moves along the screw of that velocity, exactly:

    R -> exp(s [w]) R,      x -> x + s V v,      V = 1 + (1 - cos a)/a^2 [s w] + (a - sin a)/a^3 [s w]^2,      a = s |w|.

**Joints** are found again by the contact detection of the dynamics. A point bears where its gap is at most TOUCHING of the smallest width;
a joint that has become a hinge is a joint with the one edge, or corner, on which its blocks still touch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.foundation import libm
from masonry_cd.mechanics.contact.find_joints import built_gap, touching_points
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.polygon import loop_area

TOUCHING = 1e-6  # largest gap of points that touch, as a share of the smallest width of a free block


@dataclass(frozen=True, eq=False)
class Placement:
    """Where B blocks are."""

    position: np.ndarray  # (B, 3) centres of mass [m]
    rotation: np.ndarray  # (B, 3, 3) by which they are turned from where they were built

    @classmethod
    def as_built(cls, assembly: Assembly) -> Placement:
        """Where the assembly was built."""
        return cls(assembly.centre.copy(), np.tile(np.eye(3), (assembly.count, 1, 1)))

    def along(self, velocity: np.ndarray, amount: float) -> Placement:
        """Moved along the screws of velocities (B, 6) by an amount [s, or what the velocities are over]."""
        turn = amount * velocity[:, 3:]
        angle = np.linalg.norm(turn, axis=1)
        first, second, third = _series(angle)
        cross = np.zeros((len(turn), 3, 3))
        cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -turn[:, 2], turn[:, 1], -turn[:, 0]
        cross -= cross.transpose(0, 2, 1)
        square = cross @ cross
        turning = np.eye(3) + first[:, None, None] * cross + second[:, None, None] * square
        moving = np.eye(3) + second[:, None, None] * cross + third[:, None, None] * square
        shift = np.einsum("bij,bj->bi", moving, amount * velocity[:, :3])
        return Placement(self.position + shift, turning @ self.rotation)


def _series(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """sin(a)/a, (1 - cos a)/a^2, (a - sin a)/a^3 of angles (B,), by their series where they are small."""
    small = angle < 1e-2
    a = np.where(small, 1.0, angle)
    square = angle**2
    near = (
        1.0 - square / 6.0 * (1.0 - square / 20.0), 0.5 - square / 24.0 * (1.0 - square / 30.0),
        1.0 / 6.0 - square / 120.0 * (1.0 - square / 42.0),
    )  # fmt: skip
    far = libm.sin(a) / a, 2.0 * libm.sin(0.5 * a) ** 2 / a**2, (a - libm.sin(a)) / a**3
    return tuple(np.where(small, x, y) for x, y in zip(near, far, strict=True))  # type: ignore[return-value]


@dataclass(frozen=True, eq=False)
class MovedJoints:
    """The joints of blocks where they are now; those that touch along a line or in a point have two corners, or one, and no area."""

    joints: Joints
    deepest: float  # overlap of any two blocks [m]


def touching_gap(assembly: Assembly) -> float:
    """Gap up to which points of the blocks of an assembly, as built, touch [m]."""
    return TOUCHING * assembly.width + 1.5 * built_gap(assembly)


def moved_joints(placed: Assembly, gap: float) -> MovedJoints:
    """The joints of blocks as placed, whose points touch that are no farther apart than ``gap`` [m]."""
    contacts, parts = touching_points(placed)
    deepest = -float(contacts.gap.min(initial=0.0))
    near = np.flatnonzero(contacts.gap <= gap)
    starts = np.flatnonzero((np.diff(parts[near], axis=0, prepend=-1) != 0).any(axis=1))
    pieces = np.split(near, starts[1:]) if len(near) else []
    corners = [contacts.point[piece] for piece in pieces]
    first = np.array([piece[0] for piece in pieces], dtype=np.int64)
    joints = Joints(
        block_a=contacts.bodies[first, 1].copy(),
        block_b=contacts.bodies[first, 0].copy(),
        area=np.array([loop_area(loop) if len(loop) > 2 else 0.0 for loop in corners]),
        normal=contacts.normal[first].copy(),
        polygon_start=np.cumsum([0, *map(len, pieces)]),
        polygon=np.concatenate(corners) if corners else np.zeros((0, 3)),
    )
    return MovedJoints(joints, deepest)
