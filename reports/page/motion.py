# SPDX-License-Identifier: GPL-3.0-or-later
r"""How the blocks and the joints move over the frames that the page shows, in whole numbers of 16 bits.

A block's motion relative to the base is its displacement u (3,) and its rotation vector w (3,), |w| the angle. Each block has its own
unit, the largest component over the run divided by 8191: rounding is 0.006 % of what that block ever does, whatever others do.

Openings and slidings span orders of magnitude, so they are sent as logarithms,

    code = 0 below lowest,  else 1 + floor(log(value / lowest) * per_e),   lowest = threshold / 64,

in steps of 0.1 %. A floor keeps the threshold of damage exact: it is itself the beginning of a step.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds, fallen_in, parted
from masonry_cd.analysis.deformed import Pose, Solids, base_at, joint_frame, smallest_gap
from masonry_cd.io.results import Results

LARGEST = 8191  # whole number of a block's largest component
BELOW = 64.0  # lowest value sent, as a share of the threshold
CODES = 65000  # that a logarithm may take
FINEST = 1000.0  # codes per factor of e: steps of 0.1 %


@dataclass(frozen=True, eq=False)
class PageMotion:
    """Motion of B blocks and J joints over F frames."""

    frames: np.ndarray  # (F,) indices into the result's frames
    time: np.ndarray  # (F,) [s]
    displacement: np.ndarray  # (F, B, 3) relative to the base [m]
    rotation: np.ndarray  # (F, B, 3) rotation vectors [rad]
    opening: np.ndarray  # (F, J) [m]
    sliding: np.ndarray  # (F, J) [m]

    def only(self, frames: np.ndarray) -> PageMotion:
        """Some of the frames, given as indices into these."""
        return PageMotion(**{item.name: getattr(self, item.name)[frames] for item in fields(self)})


def frames_shown(count: int, most: int) -> np.ndarray:
    """At most a number of frames, evenly spread, the first and the last always among them."""
    return np.unique(np.round(np.linspace(0, count - 1, min(count, most))).astype(np.int64))


def read_motion(results: Results, solids: Solids, frames: np.ndarray) -> PageMotion:
    """Read the frames shown, one by one, so that memory holds no more than what is sent."""
    count, blocks, joints = len(frames), len(solids.centre), results.joints.count
    displacement, rotation = np.empty((count, blocks, 3)), np.empty((count, blocks, 3))
    opening, sliding = np.empty((count, joints)), np.empty((count, joints))
    for k, frame in enumerate(frames.tolist()):
        base = base_at(results, solids, frame)
        displacement[k] = base.seen(np.asarray(results.position[frame], dtype=float)) - solids.centre
        rotation[k] = rotation_vectors(base.orientations(np.asarray(results.orientation[frame], dtype=float)))
        opening[k], sliding[k] = joint_frame(results, "opening", frame), joint_frame(results, "sliding", frame)
    return PageMotion(frames, np.asarray(results.time, dtype=float)[frames], displacement, rotation, opening, sliding)


def read_losses(results: Results, solids: Solids, moved: PageMotion, thresholds: Thresholds) -> tuple[np.ndarray, np.ndarray]:
    """Which blocks have fallen (F, B) and which joints are separated (F, J) at the frames of a motion.

    A frame is looked at closely only where a joint has lost its contact, or a block half of what makes it fallen.
    """
    joints = results.joints
    down, apart = np.zeros(moved.displacement.shape[:2], bool), np.zeros(moved.opening.shape, bool)
    dropped = np.any(-moved.displacement[..., 2] > 0.5 * thresholds.drop * solids.sizes[:, 2], axis=1)
    turned = np.any(np.linalg.norm(moved.rotation, axis=2) > np.radians(0.5 * thresholds.tilt), axis=1)
    suspect = np.asarray(dropped | turned)
    for k, frame in enumerate(moved.frames.tolist()):
        area = joint_frame(results, "contact_area", frame)
        if not (suspect[k] or (area <= thresholds.lost * joints.area).any()):
            continue
        pose = Pose.of(results, solids, frame)
        there = results.present(frame)
        apart[k] = parted(joints, smallest_gap(joints, solids, pose), joint_frame(results, "sliding", frame), area, thresholds)
        apart[k] &= there[joints.block_a] & there[joints.block_b]
        down[k] = fallen_in(joints, solids, pose, apart[k], thresholds)
    return down, apart


def rotation_vectors(orientation: np.ndarray) -> np.ndarray:
    """Rotation vectors (B, 3) of unit quaternions (B, 4), w first; angles up to pi, exact near zero."""
    q = np.where(orientation[:, :1] < 0, -orientation, orientation)
    sine = np.linalg.norm(q[:, 1:], axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[:, :1])
    return np.asarray(q[:, 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 2.0))


def whole(motion: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vectors (F, B, 3) as whole numbers (3, B, F) int16, and the unit of each block (B,) float32."""
    unit = (np.abs(motion).max(axis=(0, 2), initial=0.0) / LARGEST).astype(np.float32)
    codes = np.round(motion / np.where(unit > 0, unit, 1.0)[:, None].astype(float))
    return np.ascontiguousarray(codes.transpose(2, 1, 0)).astype(np.int16), unit


def logarithms(values: np.ndarray, threshold: float) -> tuple[np.ndarray, float, float]:
    """Lengths (F, J) [m] as codes (J, F) uint16, with ``lowest`` [m] and ``per_e``; see the head of this file."""
    lowest = threshold / BELOW
    largest = max(float(values.max(initial=0.0)), 2.0 * lowest)
    per_e = min(FINEST, (CODES - 1) / np.log(largest / lowest))
    per_e = np.floor(per_e * np.log(BELOW)) / np.log(BELOW)  # so that the threshold begins a step
    steps = np.floor(np.log(np.maximum(values, lowest) / lowest) * per_e + 1e-9)
    codes = np.where(values < lowest, 0.0, 1.0 + steps)
    return np.ascontiguousarray(codes.T).astype(np.uint16), lowest, float(per_e)


def bits(flags: np.ndarray) -> np.ndarray:
    """Flags (F, N) bool, eight to a byte: (F, ceil(N / 8)) uint8, the first flag in the lowest bit."""
    return np.packbits(flags, axis=1, bitorder="little")
