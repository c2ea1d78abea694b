# SPDX-License-Identifier: GPL-3.0-or-later
"""Planar scenes: prismatic blocks along one axis, symmetric about a common middle plane, moved within it.

Such a scene moves in its plane only (its mirror image is the same scene), so half the contacts and three unknowns per block
give the same answer as the full problem.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.mechanics.model.block_forces import BlockForces
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.middle_plane import middle_plane
from masonry_cd.mechanics.model.state import State


@dataclass(frozen=True, eq=False)
class Plane:
    """The middle plane: coordinate ``axis`` equals ``at`` [m]; ``columns`` are the unknowns left of (vx, vy, vz, wx, wy, wz)."""

    axis: int
    at: float

    @property
    def columns(self) -> np.ndarray:
        """Two velocities in the plane and the rotation about its normal."""
        return np.array([d for d in range(3) if d != self.axis] + [3 + self.axis])


def find_plane(
    assembly: Assembly, state: State, support_velocity: np.ndarray, acceleration: np.ndarray, forces: BlockForces | None = None
) -> Plane | None:
    """The plane in which the scene moves, or None if it needs all three dimensions.

    Args:
        assembly: the blocks.
        state: at the start.
        support_velocity: (N + 1, S, 3) [m/s], or (N + 1, S, 6) with [rad/s].
        acceleration: (N + 1, 3) [m/s2].
        forces: on single blocks.
    """
    for axis in range(3):
        turning = [3 + d for d in range(3) if d != axis and support_velocity.shape[-1] > 3]
        if np.any(support_velocity[..., [axis, *turning]]) or np.any(acceleration[..., axis]):
            continue
        if not _moves_in_plane(assembly, state, axis):
            continue
        at = middle_plane(assembly, axis)
        if at is None or any(link.leaves_plane(axis, at) for link in assembly.links):
            continue
        if not (forces is not None and forces.leaves_plane(axis, at, assembly.centre)):
            return Plane(axis, at)
    return None


def _moves_in_plane(assembly: Assembly, state: State, axis: int) -> bool:
    """Return True if a state keeps to the plane: no velocity across it, no shift along its normal, rotations about its normal only."""
    across = [axis, *(3 + d for d in range(3) if d != axis)]
    turned = [1 + d for d in range(3) if d != axis]
    shifted = state.position[:, axis] != assembly.centre[:, axis]
    return not (shifted.any() or state.velocity[:, across].any() or state.orientation[:, turned].any())
