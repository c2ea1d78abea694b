r"""The joints as bands: what a crack map draws between the blocks.

A joint seen from the side is a line; to show it, its interface polygon is given a thickness. The band of a joint runs along the
sides of the polygon and fills the space between the two blocks, from the corners as block a carries them to those as block b
does; where they are closer than the line is wide, it is as wide as the line. So a hinge shows as the wedge that it is. The band
stands a little proud of the blocks, or their faces would hide it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.deformed import Pose, Solids, joint_corners
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.polygon import next_in_loop
from reports.drawing.render import Surface

PROUD = 0.5  # how far a band stands out, in line widths
DASH = 3.0  # length of a dash, in line widths


@dataclass(frozen=True, eq=False)
class Bands:
    """The sides of M drawn polygons: S sides with their four corners, and the joint each belongs to."""

    corners: np.ndarray  # (S, 4, 3): first and second on a, second and first on b [m]
    joint: np.ndarray  # (S,)


def joint_bands(joints: Joints, drawn: np.ndarray, solids: Solids, pose: Pose, factor: float, width: float) -> Bands:
    """The bands of the joints drawn (J,) bool, of a least width [m], in the amplified shape."""
    on_a, on_b = band_corners(joints, solids, pose, factor, width)
    return _sides(on_a, on_b, joints, np.repeat(np.arange(joints.count), np.diff(joints.polygon_start)), drawn)


def band_corners(joints: Joints, solids: Solids, pose: Pose, factor: float, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Corners (N, 3) of the bands of all joints, on the side of block a and on that of block b."""
    on_a, on_b = joint_corners(joints, solids, pose, factor)
    normal = np.einsum("jik,jk->ji", pose.rotation[joints.block_a], joints.normal)
    corner_joint = np.repeat(np.arange(joints.count), np.diff(joints.polygon_start))
    n = normal[corner_joint]
    half = 0.5 * np.maximum(((on_b - on_a) * n).sum(axis=1), width)[:, None]
    middle = _grown((on_a + on_b) / 2.0, joints, corner_joint, PROUD * width)
    return middle - half * n, middle + half * n


def face_plates(joints: Joints, drawn: Sequence[np.ndarray], solids: Solids, pose: Pose, factor: float, width: float) -> Bands:
    """Thin bands on faces that have parted: of the joints drawn[0] (J,) on block a, of drawn[1] on block b."""
    corner_joint = np.repeat(np.arange(joints.count), np.diff(joints.polygon_start))
    parts = []
    sides = (joints.block_a, joints.block_b), joint_corners(joints, solids, pose, factor), drawn
    for block, corners, wanted in zip(*sides, strict=True):
        normal = np.einsum("jik,jk->ji", pose.rotation[block], joints.normal)
        middle = _grown(corners, joints, corner_joint, PROUD * width)
        shift = 0.5 * width * normal[corner_joint]
        parts.append(_sides(middle - shift, middle + shift, joints, corner_joint, wanted))
    return Bands(np.concatenate([p.corners for p in parts]), np.concatenate([p.joint for p in parts]))


def dashed(bands: Bands, first: np.ndarray, second: np.ndarray, width: float) -> Surface:
    """A surface of bands, cut into dashes whose colours alternate between first and second (J, 3) uint8."""
    return dashes(bands, first, second, width)[0]


def dashes(bands: Bands, first: np.ndarray, second: np.ndarray, width: float) -> tuple[Surface, np.ndarray]:
    """The surface of :func:`dashed`, and the side (P,) of the bands that each of its polygons is a piece of.

    Every side begins and ends with the first colour, so that short ones show it.
    """
    a0, a1, b1, b0 = (bands.corners[:, k] for k in range(4))
    length = np.maximum(np.linalg.norm(a1 - a0, axis=1), np.linalg.norm(b1 - b0, axis=1))
    plain = (first[bands.joint] == second[bands.joint]).all(axis=1)
    pieces = np.where(plain, 1, 2 * np.round(length / (2 * DASH * width)).astype(np.int64).clip(0, 500) + 1)
    side = np.repeat(np.arange(len(pieces)), pieces)
    k = np.arange(len(side)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    low, high = (k / pieces[side])[:, None], ((k + 1) / pieces[side])[:, None]
    quad = [a0[side] + low * (a1 - a0)[side], a0[side] + high * (a1 - a0)[side]]
    quad += [b0[side] + high * (b1 - b0)[side], b0[side] + low * (b1 - b0)[side]]
    points = np.stack(quad, axis=1).reshape(-1, 3)
    joint = bands.joint[side]
    colours = np.where((k % 2 == 0)[:, None], first[joint], second[joint]).astype(np.uint8)
    return Surface(points, np.arange(len(points)), np.arange(0, len(points) + 1, 4), colours, lit=False), side


def _grown(corners: np.ndarray, joints: Joints, corner_joint: np.ndarray, by: float) -> np.ndarray:
    """Polygons (N, 3) grown away from their centres."""
    centre = np.add.reduceat(corners, joints.polygon_start[:-1]) / np.diff(joints.polygon_start)[:, None]
    arm = corners - centre[corner_joint]
    return corners + by * np.sqrt(2.0) * arm / np.maximum(np.linalg.norm(arm, axis=1, keepdims=True), 1e-30)


def _sides(on_a: np.ndarray, on_b: np.ndarray, joints: Joints, corner_joint: np.ndarray, drawn: np.ndarray) -> Bands:
    """The sides of the prisms between two sets of corners (N, 3), of the joints drawn."""
    following = next_in_loop(joints.polygon_start)
    keep = drawn[corner_joint]
    corners = np.stack([on_a, on_a[following], on_b[following], on_b], axis=1)
    return Bands(corners[keep], corner_joint[keep])
