# SPDX-License-Identifier: GPL-3.0-or-later
r"""Where the forces of a limit analysis act: the corners of the joints, each with a frame, a friction cone and what the joint's bond adds.

A joint's stress resultant can be anything that forces at the corners of its polygon add up to, so the corners are enough. In a plane they
are the two ends of the joint.

**Bond.** A joint with cohesion c and tensile strength f_t has the area A. Corner k gets the share A_k; the shares add up to A and have the
first moment of the polygon (the mean of its fans of triangles, a third of each triangle to each of its corners). Then

    |t_k| <= mu (n_k + a_k),    n_k >= -f_k,        a_k = A_k c / mu  the tip of Mohr-Coulomb's cone,   f_k = A_k f_t.

A rectangle that opens about an edge bears f_t A b / 2: its bond is spent over the whole area at once. Real bond is brittle, and breaks
corner by corner; what a limit analysis adds for it is an upper bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.polygon import loop_area

SAME = 1e-9  # corners of a joint nearer to one another than this share of its length are one


@dataclass(frozen=True, eq=False)
class Interfaces:
    """P points of J joints; m directions: normal and one tangent in a plane, normal and two tangents in space."""

    joint: np.ndarray  # (P,)
    bodies: np.ndarray  # (P, 2) blocks a and b of the joint; the force acts on b
    point: np.ndarray  # (P, 3) world frame [m]
    frame: np.ndarray  # (P, m, 3) rows n (from a to b), t or t1, t2
    mu: np.ndarray  # (P,)
    apex: np.ndarray  # (P,) a_k [N]
    tension: np.ndarray  # (P,) f_k [N]

    @property
    def count(self) -> int:
        """Number of points P."""
        return len(self.mu)


def interfaces(assembly: Assembly, joints: Joints, axis: int | None) -> Interfaces:
    """The points of all joints.

    Args:
        assembly: the blocks.
        joints: of them, as built.
        axis: normal of the plane of a planar structure, 0 to 2; None in space.
    """
    laws = assembly.laws
    bonded = bool(laws.apex.any() or laws.tension.any())  # only bond asks for the shares of the area
    places, shares, owner = [], [], []
    for j in range(joints.count):
        corners = joints.polygon[joints.polygon_start[j] : joints.polygon_start[j + 1]]
        if axis is None:
            place, share = corners, area_shares(corners) if bonded else np.zeros(len(corners))
        else:
            place, share = _ends(corners, joints.normal[j], joints.area[j], axis)
        places.append(place)
        shares.append(share)
        owner.append(np.full(len(place), j))
    joint = np.concatenate(owner) if owner else np.zeros(0, dtype=np.int64)
    share = np.concatenate(shares) if shares else np.zeros(0)
    bodies = np.stack([joints.block_a[joint], joints.block_b[joint]], axis=1)
    rows = assembly.rows(*bodies.T)
    return Interfaces(
        joint=joint,
        bodies=bodies,
        point=np.concatenate(places) if places else np.zeros((0, 3)),
        frame=_frames(joints.normal, axis)[joint],
        mu=assembly.friction[rows],
        apex=share * laws.apex[rows],
        tension=share * laws.tension[rows],
    )


def area_shares(corners: np.ndarray) -> np.ndarray:
    """A_k of the corners of a polygon (n, 3), (n,) [m2]: see the head of this file."""
    count = len(corners)
    out = np.zeros(count)
    for first in range(count):
        for k in range(1, count - 1):
            triangle = [(first + i) % count for i in (0, k, k + 1)]
            out[triangle] += loop_area(corners[triangle]) / (3.0 * count)
    return out


def _ends(corners: np.ndarray, normal: np.ndarray, area: float, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """The two ends of a joint in the plane (2, 3) and their shares of its area (2,); where blocks touch along a line, its place."""
    along = np.cross(normal, np.eye(3)[axis])
    way = corners @ along
    if np.ptp(way) <= SAME * np.linalg.norm(np.ptp(corners, axis=0)):
        return corners.mean(axis=0)[None], np.array([area])
    ends = []
    for side in (way.min(), way.max()):
        near = np.abs(way - side) <= SAME * max(float(np.ptp(way)), 1e-300)
        ends.append(corners[near].mean(axis=0))
    return np.array(ends), np.array([0.5 * area, 0.5 * area])


def _frames(normal: np.ndarray, axis: int | None) -> np.ndarray:
    """Frames of joints with normals (J, 3): (J, 2, 3) in a plane, (J, 3, 3) in space, t1 level where the joint is not."""
    if axis is not None:
        return np.stack([normal, np.cross(normal, np.eye(3)[axis])], axis=1)
    helper = np.where(np.abs(normal[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(helper, normal)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([normal, first, np.cross(normal, first)], axis=1)
