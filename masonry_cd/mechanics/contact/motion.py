# SPDX-License-Identifier: GPL-3.0-or-later
"""How bodies move, and how far they may go within a step: what the margins of contact detection come from."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.model.geometry import relative_pose

NEAR = 1e-3  # surfaces closer than this share of the smaller part's width are always in the contact set


class BodyMotion(NamedTuple):
    """The configuration of B blocks, how they move, and for how long."""

    position: np.ndarray  # (B, 3) centres of mass [m]
    rotation: np.ndarray  # (B, 3, 3) body to world, with the strain of blocks that deform
    velocity: np.ndarray  # (B, 6) linear [m/s] and angular [rad/s]
    step: float  # [s]
    slack: float  # distance that forces not yet known may add within the step [m]
    affine: tuple[int, ...]  # two zeros where rotations hold strains, else one


@borrower()
def part_reach(motion, block, radius, size):
    """How far a part may go within the step, and its share of what counts as near: half the margin of a pair, or more [m].

    ``radius`` and ``size`` are those of the part (:class:`masonry_cd.mechanics.model.blocks.ConvexShapes`).
    """
    v = motion.velocity[block]
    speed = np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + radius * np.sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5])
    return 2.0 * motion.step * speed + 0.5 * motion.slack + 0.5 * NEAR * size


@borrower()
def pair_margin(motion, block_a, block_b, radius_a, radius_b, width):
    """Gap up to which the points of a pair of parts are contacts, since it may close within the step [m].

    ``width`` is the width of the smaller part [m].
    """
    return motion.slack + NEAR * width + 2.0 * motion.step * _closing_speed(motion.velocity, block_a, block_b, radius_a, radius_b)


@borrower()
def _closing_speed(velocity, a, b, radius_a, radius_b):
    """Bound on the speed at which a point of block a nears a point of block b [m/s]."""
    va, vb = velocity[a], velocity[b]
    dx, dy, dz = vb[0] - va[0], vb[1] - va[1], vb[2] - va[2]
    spin_a = np.sqrt(va[3] * va[3] + va[4] * va[4] + va[5] * va[5])
    spin_b = np.sqrt(vb[3] * vb[3] + vb[4] * vb[4] + vb[5] * vb[5])
    return np.sqrt(dx * dx + dy * dy + dz * dz) + spin_a * radius_a + spin_b * radius_b


@borrower()
def pose_ahead(motion, a, b, position, rotation, pose):
    """Fill ``pose`` (12,) with that of block b in the frame of block a at the end of the step, if both go on as they move.

    ``position`` (2, 3) and ``rotation`` (2, 3, 3) are scratch: where the two are then.
    """
    step = motion.step
    for side in range(2):
        body = a if side == 0 else b
        v, r = motion.velocity[body], motion.rotation[body]
        speed = np.sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5])
        c, s = math.cos(step * speed), math.sin(step * speed)
        scale = 1.0 / speed if speed > 0.0 else 0.0
        x, y, z = scale * v[3], scale * v[4], scale * v[5]
        for d in range(3):
            position[side, d] = motion.position[body, d] + step * v[d]
            px, py, pz = r[0, d], r[1, d], r[2, d]
            along = (1.0 - c) * (x * px + y * py + z * pz)
            rotation[side, 0, d] = c * px + s * (y * pz - z * py) + along * x
            rotation[side, 1, d] = c * py + s * (z * px - x * pz) + along * y
            rotation[side, 2, d] = c * pz + s * (x * py - y * px) + along * z
    relative_pose(position, rotation, motion.affine, 0, 1, pose)


@borrower()
def distance_moved(now, then, radius):
    """Bound on how far any point of b has moved in the frame of a between two relative poses (12,) [m]; ``radius`` of b."""
    shift, turn = 0.0, 0.0
    for i in range(3):
        shift += (now[i] - then[i]) ** 2
    for i in range(3, 12):
        turn += (now[i] - then[i]) ** 2
    return np.sqrt(shift) + radius * np.sqrt(turn)
