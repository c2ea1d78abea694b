# SPDX-License-Identifier: GPL-3.0-or-later
"""Guided blocks: a point of a block has a given velocity along a direction; what is not given stays free, or is held from turning.

Pushes by displacement of ``loads`` are made of guides, and so are props, whose velocity is zero.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True, eq=False)
class Guide:
    """A guide of one load: K blocks, each at a point of its own, all at one velocity along one direction."""

    blocks: np.ndarray  # (K,)
    arms: np.ndarray  # (K, 3) from the centres of mass to the points, body frames [m]
    direction: np.ndarray  # (3,) unit vector, world frame
    velocity: np.ndarray  # (N + 1,) along it at t_k [m/s]
    held: bool  # the blocks do not turn
    name: str  # for tables
    there: bool = True  # else it guides nothing

    def speed(self, step: int) -> float:
        """The velocity at t_k [m/s]."""
        return float(self.velocity[step])

    def at_rest(self) -> Guide:
        """The guide of a structure that takes up its weight before the run."""
        return replace(self, velocity=np.zeros_like(self.velocity))

    def extended(self, steps: int) -> Guide:
        """The guide with a given number of further steps, at rest."""
        return replace(self, velocity=np.pad(self.velocity, (0, steps)))

    def places(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """Where the points are, (K, 3) [m], of positions (B, 3) and rotations (B, 3, 3)."""
        return np.asarray(position[self.blocks] + self.arms_in_world(rotation))

    def arms_in_world(self, rotation: np.ndarray) -> np.ndarray:
        """(K, 3) [m]."""
        return np.sum(rotation[self.blocks] * self.arms[:, None, :], axis=-1)

    def displacement(self, position: np.ndarray, rotation: np.ndarray, centre: np.ndarray) -> float:
        """Return the mean displacement of the points along the direction, from where they were built with centres (B, 3) [m]."""
        gone = self.places(position, rotation) - centre[self.blocks] - self.arms
        return float(np.sum(gone * self.direction, axis=1).mean())

    def leaves_plane(self, axis: int, at: float, centre: np.ndarray) -> bool:
        """True when it moves blocks out of the plane where coordinate ``axis`` equals ``at``; centres (B, 3) [m]."""
        off = np.abs((centre[self.blocks] + self.arms)[:, axis] - at) > 1e-9 * max(1.0, float(np.abs(centre).max()))
        return bool(self.direction[axis] != 0.0 or (off.any() and not self.held))
