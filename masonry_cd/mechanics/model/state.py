# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of a run: where the blocks are and how they move, at one time and without history."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.model.blocks import Assembly


@dataclass(eq=False)
class State:
    """Positions and velocities of B blocks, in the world frame.

    Attributes:
        time: [s].
        position: (B, 3) centres of mass [m].
        orientation: (B, 4) unit quaternions (w, x, y, z), body to world.
        velocity: (B, 6) linear [m/s] and angular [rad/s] velocity.
        strain: (B, 6) in the principal axes of the blocks, shear strains as angles; (0, 6) where all are rigid.
    """

    time: float
    position: np.ndarray
    orientation: np.ndarray
    velocity: np.ndarray
    strain: np.ndarray = field(default_factory=lambda: np.zeros((0, 6)))

    @classmethod
    def at_rest(cls, assembly: Assembly) -> State:
        """The assembly where it was built, not moving."""
        orientation = np.zeros((assembly.count, 4))
        orientation[:, 0] = 1.0
        strain = np.zeros((0 if assembly.deformation is None else assembly.count, 6))
        return cls(0.0, assembly.centre.copy(), orientation, np.zeros((assembly.count, 6)), strain)

    def copy(self) -> State:
        """An independent copy."""
        return State(self.time, self.position.copy(), self.orientation.copy(), self.velocity.copy(), self.strain.copy())


def body_maps(assembly: Assembly, orientation: np.ndarray, strain: np.ndarray) -> np.ndarray:
    """Return the maps of points of the body frames to the world, (B, 3, 3), with orientations (B, 4) and strains (B, 6); rotations where
    none deforms."""
    rotation = rotation_matrices(orientation)
    return rotation if assembly.deformation is None else assembly.deformation.maps(rotation, strain)


def rotation_matrices(orientation: np.ndarray) -> np.ndarray:
    """Rotation matrices (B, 3, 3), body to world, of unit quaternions (B, 4), w first."""
    out = np.empty((len(orientation), 3, 3))
    fill_rotations(orientation, out)
    return out


@entry()
def fill_rotations(orientation: np.ndarray, out: np.ndarray) -> None:
    """Fill ``out`` (B, 3, 3) with the rotation matrices of unit quaternions (B, 4), see :func:`rotation_matrices`."""
    for b in range(orientation.shape[0]):
        w, x, y, z = orientation[b, 0], orientation[b, 1], orientation[b, 2], orientation[b, 3]
        r = out[b]
        r[0, 0], r[0, 1], r[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
        r[1, 0], r[1, 1], r[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
        r[2, 0], r[2, 1], r[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
