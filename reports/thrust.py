r"""The way of the forces: ribbons through the blocks, from joint to joint, as wide as the normal force of the joint is large.

A result file holds the size of the normal force N_j of a joint, not the place where it acts. A joint that is open at one side carries
it at the edge where it still touches, and the ribbon goes through that edge; in a closed joint it goes through the middle, which is
known to lie within the joint and no more. In each block the ribbons of its joints meet at the mean of these points weighted by N_j:
for a voussoir, whose two joints carry nearly equal forces, that makes a straight line from joint to joint. A block with one joint has none.
So in an arch on its hinges this is the line of thrust; elsewhere it shows which way the load goes, and not how eccentric it is.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.errors import InputError
from masonry_cd.results import Results
from reports.deformed import Pose, Solids, joint_corners, joint_frame
from reports.parts import Moment
from reports.render import Surface, View

COLOUR = (90, 20, 110)
WIDEST = 12.0  # of the largest force [pixels]
WIDEST_OF_BLOCK = 0.3  # ... but no more than this share of a block's smallest extent
THINNEST = 0.08  # forces below this share of the largest are left out


def ribbons(
    results: Results, solids: Solids, pose: Pose, moment: Moment, frame: int, factor: float, view: View, pixel: float
) -> tuple[Surface, float]:
    """The ribbons at a frame as a surface that faces the viewer, and the force of the widest one [N].

    Args:
        results: of a run, which must hold the forces of its joints.
        solids: of its blocks.
        pose: of the frame.
        moment: of the frame, for what touches where.
        frame: which.
        factor: amplification of the displacements.
        view: from where.
        pixel: size of a pixel [m].

    Raises:
        InputError: the file holds no forces.
    """
    if "joints/normal_force" not in results.file:
        raise InputError("thrust: this result holds no joint forces")
    joints = results.joints
    force = np.where(moment.separated, 0.0, joint_frame(results, "normal_force", frame))
    largest = float(force.max(initial=0.0))
    place = _places(results, solids, pose, moment, factor)
    ends, strength = [], []
    for block in (joints.block_a, joints.block_b):
        hub = _hubs(joints.block_a, joints.block_b, place, force, len(solids.centre))
        drawn = ~solids.fixed[block] & (force >= THINNEST * max(largest, 1e-300))
        ends.append(np.stack([place, hub[block]], axis=1)[drawn])
        strength.append(force[drawn])
    widest = min(WIDEST * pixel, WIDEST_OF_BLOCK * float(np.median(solids.sizes[~solids.fixed].min(axis=1))))
    lines, width = np.concatenate(ends), widest * np.concatenate(strength) / max(largest, 1e-300)
    long = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > 0.5 * pixel  # a block on a single joint has nowhere to lead its force
    return _facing(lines[long], width[long], view), largest


def _places(results: Results, solids: Solids, pose: Pose, moment: Moment, factor: float) -> np.ndarray:
    """(J, 3) where each joint carries its force: its middle, or the mean of its touching corners."""
    joints = results.joints
    on_a, on_b = joint_corners(joints, solids, pose, factor)
    side = np.repeat(np.arange(joints.count), np.diff(joints.polygon_start))
    used = np.where(moment.hinged[side], moment.touching, True).astype(float)
    out = np.stack([np.bincount(side, used * v, minlength=joints.count) for v in ((on_a + on_b) / 2.0).T], axis=1)
    return out / np.maximum(np.bincount(side, used, minlength=joints.count), 1.0)[:, None]


def _hubs(a: np.ndarray, b: np.ndarray, place: np.ndarray, force: np.ndarray, count: int) -> np.ndarray:
    """(B, 3) mean place of the joints of each block, weighted by force."""
    ends, weight = np.concatenate([a, b]), np.tile(force, 2)
    total = np.bincount(ends, weight, minlength=count)
    sums = [np.bincount(ends, weight * np.tile(v, 2), minlength=count) for v in place.T]
    return np.stack(sums, axis=1) / np.where(total > 0, total, 1.0)[:, None]


def _facing(lines: np.ndarray, width: np.ndarray, view: View) -> Surface:
    """Lines (n, 2, 3) as flat ribbons of given widths (n,), turned towards the viewer, with a joint-filling overlap at their ends."""
    along = view.plane(lines[:, 1] - lines[:, 0])
    length = np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    along = along / length
    half = 0.5 * width[:, None]
    across = half * (along[:, 1:] * -view.right + along[:, :1] * view.up)
    ahead = 0.5 * half * (along[:, :1] * view.right + along[:, 1:] * view.up)
    start, end = lines[:, 0] - ahead, lines[:, 1] + ahead
    points = np.stack([start - across, end - across, end + across, start + across], axis=1).reshape(-1, 3)
    colours = np.tile(np.array(COLOUR, dtype=np.uint8), (len(lines), 1))
    return Surface(points, np.arange(len(points)), np.arange(0, len(points) + 1, 4), colours, lit=False)
