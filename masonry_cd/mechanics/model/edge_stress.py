# SPDX-License-Identifier: GPL-3.0-or-later
r"""The largest compression of a joint, from the resultant of its normal forces: linear over its area, without tension.

The points of contact of rigid blocks carry forces; how stress spreads between them the model does not say. Engineers take it linear over
the joint, and zero where it would be tension (Navier; Heyman, The Stone Skeleton, 1995; EN 1996-1-1, 6.2, for the compressed part of a
wall). The stress at a place X of the joint's plane is then

    s(X) = max(0, a + b . X),        int s dA = N,   int s X dA = N X_N,

N the normal force and X_N where it crosses the plane. On a rectangle of depth d and breadth w, X_N halfway along w and u from the nearer
edge of d, the largest compression is

    N / (w d) (1 + 6 e / d)     where e = d/2 - u <= d/6,        2 N / (3 u w)     beyond.

The area is that which both blocks share now, after sliding: the polygon of the joint on block a, cut by that on block b. On any convex
polygon, and for X_N off both axes, a and b follow from the moments of the part that is compressed: Navier's formula on the whole polygon
first, then on the part where it gave compression, until that part stays. A load at u from the edge of a rectangle shortens a compressed
length L to L/2 + L^2 / (12 (L/2 - u)): by a third at most, and at 3 u it stays.

At an edge (u = 0), as in the hinge of rigid blocks, no finite stress carries a force: the value is infinite, and says so. Nearer to it than
1 % of the joint's depth counts as at the edge: no bed is truer than that. Joints that still hold together (cohesion) carry tension: for
them it is Navier's on the whole area.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.geometry import relative_pose
from masonry_cd.mechanics.model.joints import Joints, clip_to_other, flat_polygon, flatten, plane_axes
from masonry_cd.mechanics.model.polygon import clip_into
from masonry_cd.mechanics.model.state import State, body_maps

AT_EDGE = 0.01  # share of a joint's depth, across the nearest side, within which a force is at its edge
UNLOADED = 500.0  # mean pressure up to which a joint counts as unloaded, that of 2 cm of stone [Pa]
STAYS = 1e-12  # change of the compressed area, as a share of it, up to which it stays
MOST = 200  # rounds; each leaves two thirds of a length that is too long


def edge_stresses(
    joints: Joints, assembly: Assembly, state: State, force: np.ndarray, moment: np.ndarray, bonded: np.ndarray
) -> np.ndarray:
    """The largest compression in each joint, (J,) [Pa]; infinite where its force acts at an edge, 0 where it has none.

    Args:
        joints: of the assembly.
        assembly: the blocks.
        state: where they are.
        force: (J,) normal force [N].
        moment: (J, 3) the force times the place where it acts, from the centre of block a in its body frame [N m].
        bonded: (J,) bool, joints that carry tension.
    """
    out = np.zeros(joints.count)
    arrays = (joints.block_a, joints.block_b, joints.normal, joints.polygon_start, joints.polygon)
    maps, affine = body_maps(assembly, state.orientation, state.strain), assembly.affine
    _edge_stresses(arrays, assembly.centre, state.position, maps, affine, force, moment, bonded, out)
    return out


@entry()
def _edge_stresses(joints, centre, position, maps, affine, force, moment, bonded, out):
    """Fill out (J,), see :func:`edge_stresses`; ``joints`` are (block_a, block_b, normal, start, polygon)."""
    block_a, block_b, normal, start, polygon = joints
    flat, pose = flat_polygon(start), np.empty(12)
    for j in range(block_a.shape[0]):
        a, first, corners = block_a[j], start[j], start[j + 1] - start[j]
        relative_pose(position, maps, affine, a, block_b[j], pose)
        plane_axes(polygon, first, normal, j, flat.axes)
        flatten(joints, j, centre, pose, flat)
        count = clip_to_other(flat, corners)
        if not bonded[j] and force[j] <= UNLOADED * _moments(flat.polygon, count)[0]:
            out[j] = 0.0
            continue
        x, y = 0.0, 0.0  # moments about the first corner
        for d in range(3):
            along = moment[j, d] - force[j] * (polygon[first, d] - centre[a, d])
            x, y = x + along * flat.axes[0, d], y + along * flat.axes[1, d]
        out[j] = largest_compression(flat.polygon, count, force[j], x, y, bonded[j], flat.distance, flat.other)


@entry()
def largest_compression(polygon, count, force, x, y, bonded, distance, other):
    """The largest compression [Pa] in a convex polygon, the first ``count`` rows of (N, 3), whose third coordinate does not count.

    The force [N] has the moments x, y [N m]: times its place along either axis. ``bonded``: it carries tension. ``distance`` (N,) and
    ``other`` (N, 3) are scratch; each has room for one corner more than the polygon.
    """
    area, cx, cy, xx, yy, xy = _moments(polygon, count)
    if not bonded and _inside(polygon, count, x / force, y / force) <= AT_EDGE:
        return np.inf
    top = 0.0
    for _ in range(MOST):
        determinant = xx * yy - xy * xy
        if not (area > 0.0 and determinant > 0.0):
            return np.inf
        mx, my = x - force * cx, y - force * cy
        bx, by = (yy * mx - xy * my) / determinant, (xx * my - xy * mx) / determinant
        top = 0.0
        for k in range(count):
            distance[k] = force / area + bx * (polygon[k, 0] - cx) + by * (polygon[k, 1] - cy)
            top = max(top, distance[k])
        if bonded:
            return top
        before = area
        left = clip_into(polygon, count, distance, 0.0, other)
        area, cx, cy, xx, yy, xy = _moments(other, left)
        if abs(area - before) <= STAYS * before:
            return top
    return top


@borrower()
def _moments(polygon, count):
    """Area [m2], centroid [m], and second moments xx, yy, xy about it [m4] of the first ``count`` corners of a polygon."""
    area, sx, sy, xx, yy, xy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    x0, y0 = polygon[0, 0], polygon[0, 1]
    for k in range(1, count - 1):  # triangles from the first corner
        x1, y1, x2, y2 = polygon[k, 0] - x0, polygon[k, 1] - y0, polygon[k + 1, 0] - x0, polygon[k + 1, 1] - y0
        twice = x1 * y2 - x2 * y1
        area += twice / 2.0
        sx, sy = sx + twice * (x1 + x2) / 6.0, sy + twice * (y1 + y2) / 6.0
        xx += twice * (x1 * x1 + x1 * x2 + x2 * x2) / 12.0
        yy += twice * (y1 * y1 + y1 * y2 + y2 * y2) / 12.0
        xy += twice * (2.0 * x1 * y1 + x1 * y2 + x2 * y1 + 2.0 * x2 * y2) / 24.0
    if area == 0.0:
        return 0.0, x0, y0, 0.0, 0.0, 0.0
    sx, sy = sx / area, sy / area
    sign = 1.0 if area > 0.0 else -1.0
    return (
        sign * area, x0 + sx, y0 + sy,
        sign * (xx - area * sx * sx), sign * (yy - area * sy * sy), sign * (xy - area * sx * sy),
    )  # fmt: skip


@borrower()
def _inside(polygon, count, x, y):
    """How far a place lies inside the first ``count`` corners of a convex polygon, from the nearest side as a share of the polygon's depth
    across that side; negative outside."""
    turn, least = 0.0, np.inf
    for k in range(1, count - 1):
        turn += (polygon[k, 0] - polygon[0, 0]) * (polygon[k + 1, 1] - polygon[0, 1])
        turn -= (polygon[k + 1, 0] - polygon[0, 0]) * (polygon[k, 1] - polygon[0, 1])
    sign = 1.0 if turn > 0.0 else -1.0
    for k in range(count):
        j = k + 1 if k + 1 < count else 0
        dx, dy = polygon[j, 0] - polygon[k, 0], polygon[j, 1] - polygon[k, 1]
        deepest = 0.0
        for i in range(count):
            deepest = max(deepest, sign * (dx * (polygon[i, 1] - polygon[k, 1]) - dy * (polygon[i, 0] - polygon[k, 0])))
        if deepest > 0.0:
            least = min(least, sign * (dx * (y - polygon[k, 1]) - dy * (x - polygon[k, 0])) / deepest)
    return least
