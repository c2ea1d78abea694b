# SPDX-License-Identifier: GPL-3.0-or-later
"""Footings: blocks that springs and dashpots in six directions hold to a support below, which moves as the ground does far from them.

Footings touch neither supports nor one another: the soil between them is not modelled. Displacements of a
footing are those of the middle of its base relative to the ground there, and the vector of the rotation by which it is turned against it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True, eq=False)
class Footings:
    """P footings."""

    blocks: np.ndarray  # (P, 2) of each its own block, and the support that stands for the ground
    arms: np.ndarray  # (P, 2, 3) from the centres of mass of both to the middle of the base as built, body frames [m]
    stiffness: np.ndarray  # (P, 6, 6) shifts, then turns, world axes [N/m, N, N m]
    damping: np.ndarray  # (P, 6, 6) [N s/m, N s, N m s]
    bare: np.ndarray  # (P,) bool: the ground below meets nothing

    @property
    def undamped(self) -> Footings:
        """Footings on their springs alone."""
        return replace(self, damping=np.zeros_like(self.damping))

    def arms_in_world(self, rotation: np.ndarray) -> np.ndarray:
        """(P, 2, 3) [m], of rotations (P, 2, 3, 3) of both blocks."""
        return np.asarray(np.matmul(rotation, self.arms[..., None])[..., 0])

    def displacements(self, position: np.ndarray, orientation: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """(P, 6) [m, rad], of positions (B, 3), orientations (B, 4) and arms (P, 2, 3), world frame."""
        place = position[self.blocks] + arms
        out = np.empty((len(place), 6))
        out[:, :3] = place[:, 0] - place[:, 1]
        out[:, 3:] = [_turn(own, ground) for own, ground in orientation[self.blocks].tolist()]
        return out

    def of_blocks(self, mask: np.ndarray) -> np.ndarray:
        """A mask (B,) of blocks, to which the grounds of the footings among them are added."""
        out = mask.copy()
        out[self.blocks[mask[self.blocks[:, 0]], 1]] = True
        return out


def _turn(own: Sequence[float], ground: Sequence[float]) -> tuple[float, float, float]:
    """The vector of the rotation that leads from one orientation, four numbers, to another, own: its axis times its angle [rad]."""
    w, x, y, z = own
    gw, gx, gy, gz = ground
    real = w * gw + x * gx + y * gy + z * gz
    turn = (
        x * gw - w * gx - y * gz + z * gy,
        y * gw - w * gy - z * gx + x * gz,
        z * gw - w * gz - x * gy + y * gx,
    )
    sine = math.hypot(*turn)
    factor = math.copysign(2.0 * math.atan2(sine, abs(real)) / sine if sine > 0.0 else 2.0, real)
    return factor * turn[0], factor * turn[1], factor * turn[2]
