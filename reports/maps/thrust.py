# SPDX-License-Identifier: GPL-3.0-or-later
r"""The line of thrust: ribbons through the blocks, from joint to joint, as wide as the normal force of the joint is large.

A result file holds for each joint its normal force N_j and the point where the resultant of its contact forces crosses the plane of the
joint (``joints/force_point``). In each block the ribbons of its joints meet at the mean of these points weighted by N_j: in a voussoir,
whose two joints carry nearly equal forces, that is a straight line from joint to joint, and the ribbons of an arch are its line of
thrust. Where it comes to the edge of a joint the joint is a hinge. A block with one joint has no ribbon.

The forces are those that the run found. Where a structure is hyperstatic they are one of many possible sets, and so is the line.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.analysis.damage.macro_elements import DamageSnapshot
from masonry_cd.analysis.deformed import Pose, Solids, base_at, frame_index, joint_frame
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.results import Results
from reports.drawing import palette
from reports.drawing.parts import BEFORE, Surface, View, painted, replaced, ribbon

WIDEST = 12.0  # of the largest force [pixels]
WIDEST_OF_BLOCK = 0.3  # ... but no more than this share of a block's smallest extent
THINNEST = 0.08  # forces below this share of the largest are left out


def ribbons(
    results: Results, solids: Solids, pose: Pose, snapshot: DamageSnapshot, frame: int, factor: float, view: View, pixel: float
) -> tuple[Surface, float]:
    """The ribbons at a frame as a surface before everything, and the force of the widest one [N]; a pixel is so large [m].

    What runs in the plane of a cut itself, as in the middle of an arch, stays whole.

    Raises:
        InputError: the file holds no forces, or not where they act.
    """
    if not (results.has_joint_history("normal_force") and results.has_joint_history("force_point")):
        raise InputError("thrust", "the result file lacks the forces of the joints and their points of action; run the scene again")
    joints = results.joints
    force = np.where(snapshot.separated, 0.0, joint_frame(results, "normal_force", frame))
    place = drawn_points(results, solids, pose, frame, factor)
    surface, largest = joint_ribbons((joints.block_a, joints.block_b), place, force, solids, view, pixel)
    return replaced(surface, spared=WIDEST * pixel), largest


def joint_ribbons(
    blocks: tuple[np.ndarray, np.ndarray], place: np.ndarray, force: np.ndarray, solids: Solids, view: View, pixel: float
) -> tuple[Surface, float]:
    """The ribbons of J joints as a surface that faces the viewer, and the force of the widest one [N].

    The joints have blocks a and b, (J,) each, places (J, 3) where their resultants act [m], and normal forces (J,) [N].
    """
    largest = float(force.max(initial=0.0))
    lines, strength, _, _ = thrust_lines(blocks, place, force, solids)
    widest = min(WIDEST * pixel, WIDEST_OF_BLOCK * float(np.median(solids.sizes[~solids.fixed].min(axis=1))))
    width = widest * strength / max(largest, 1e-300)
    long = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > 0.5 * pixel  # a block on a single joint has nowhere to lead its force
    return _facing(lines[long], width[long], view), largest


def thrust_lines(
    blocks: tuple[np.ndarray, np.ndarray], place: np.ndarray, force: np.ndarray, solids: Solids
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The pieces of the line of thrust in free blocks, arguments as of :func:`joint_ribbons`; forces below THINNEST are left out.

    Returns:
        ends (L, 2, 3) [m], normal forces (L,) [N], and the joint and the block (L,) of each piece.
    """
    largest, both, weight = float(force.max(initial=0.0)), np.concatenate(blocks), np.tile(force, 2)
    sums = [np.bincount(both, weight * values, minlength=len(solids.centre)) for values in (*np.tile(place.T, 2), 1.0)]
    hub = np.stack(sums[:3], axis=1) / np.where(sums[3] > 0, sums[3], 1.0)[:, None]  # (B, 3) mean place of a block's joints by force
    ends, strength, joint, inside = [], [], [], []
    for block in blocks:
        drawn = ~solids.fixed[block] & (force >= THINNEST * max(largest, 1e-300))
        ends.append(np.stack([place, hub[block]], axis=1)[drawn])
        strength.append(force[drawn])
        joint.append(np.flatnonzero(drawn))
        inside.append(block[drawn])
    return np.concatenate(ends), np.concatenate(strength), np.concatenate(joint), np.concatenate(inside)


def drawn_points(results: Results, solids: Solids, pose: Pose, frame: int, factor: float) -> np.ndarray:
    """(J, 3) the force points where a picture with amplified displacements has them, halfway between the two blocks; 0 without force."""
    joints = results.joints
    seen = np.nan_to_num(base_at(results, solids, frame_index(results, frame)).seen(joint_frame(results, "force_point", frame)))
    out = np.zeros_like(seen)
    for block in (joints.block_a, joints.block_b):
        at_rest = np.einsum("jki,jk->ji", pose.rotation[block], seen - pose.position[block]) + solids.centre[block]
        out += 0.5 * pose.moved(solids, at_rest, block, factor)
    return out


def _facing(lines: np.ndarray, width: np.ndarray, view: View) -> Surface:
    """Lines (n, 2, 3) as flat ribbons of given widths (n,), turned towards the viewer, with a joint-filling overlap at their ends."""
    along = view.plane(lines[:, 1] - lines[:, 0])
    length = np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    along = along / length
    half = 0.5 * width[:, None]
    across = half * (along[:, 1:] * -view.right + along[:, :1] * view.up)
    ahead = 0.5 * half * (along[:, :1] * view.right + along[:, 1:] * view.up)
    start, end = lines[:, 0] - ahead, lines[:, 1] + ahead
    corners = np.stack([start - across, end - across, end + across, start + across], axis=1)
    return ribbon(corners, painted(palette.THRUST, len(lines)), place=BEFORE)
