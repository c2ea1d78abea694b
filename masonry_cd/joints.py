r"""Joints: the interfaces that two blocks share at rest, and how far they open, slide and rotate.

A joint keeps its interface polygon, whose corners X_k both blocks carry along. With x_a(X_k) and x_b(X_k) their places on
either block, the gap vector is d_k = x_b(X_k) - x_a(X_k), and with the joint's normal n carried by block a (from a to b):

    opening        max_k d_k . n                           [m]; a hinge opens at its far edge
    sliding        | d_k - (d_k . n) n |                   [m], the largest over the corners that still touch: those whose
                                                           d_k . n is smallest; elsewhere a rotation would pass for sliding
    rotation       angle of the relative rotation          [rad]
    contact area   of the polygon of a, cut by that of b after sliding, and by opening <= CONTACT_WIDTH   [m2]
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from masonry_cd.blocks import Assembly
from masonry_cd.state import State, rotation_matrices

CONTACT_WIDTH = 1e-4  # [m] surfaces farther apart than this count as no longer in contact
TOUCHING = 1e-3  # share of the joint's size within which a corner counts as touching, next to the least open one


@dataclass(frozen=True, eq=False)
class Joints:
    """J joints; polygons of N corners in all."""

    block_a: np.ndarray  # (J,)
    block_b: np.ndarray  # (J,)
    area: np.ndarray  # (J,) [m2]
    normal: np.ndarray  # (J, 3) at rest, from a to b
    polygon_start: np.ndarray  # (J + 1,)
    polygon: np.ndarray  # (N, 3) corners at rest, world frame [m]

    @property
    def count(self) -> int:
        """Number of joints J."""
        return len(self.area)

    def centres(self) -> np.ndarray:
        """Mean corner of each polygon at rest, (J, 3) [m]."""
        sums = np.add.reduceat(self.polygon, self.polygon_start[:-1]) if self.count else np.zeros((0, 3))
        return sums / np.diff(self.polygon_start)[:, None]


@dataclass(frozen=True, eq=False)
class JointMeasures:
    """Opening [m], sliding [m], rotation [rad] and contact area [m2] of all joints at one time, (J,) each."""

    opening: np.ndarray
    sliding: np.ndarray
    rotation: np.ndarray
    contact_area: np.ndarray


def measure_joints(joints: Joints, assembly: Assembly, state: State) -> JointMeasures:
    """Measure all joints in a state; see the head of this file."""
    out = np.empty((4, joints.count))
    rotation = rotation_matrices(state.orientation)
    _measure(
        joints.block_a, joints.block_b, joints.normal, joints.polygon_start, joints.polygon, assembly.centre, state.position, rotation, out
    )
    return JointMeasures(*out)


@njit(cache=True, nogil=True)
def _measure(block_a, block_b, normal, start, polygon, centre, position, rotation, out):  # noqa: PLR0913
    """Fill out (4, J) with opening, sliding, rotation and contact area."""
    most = 0
    for j in range(block_a.shape[0]):
        most = max(most, start[j + 1] - start[j])
    apart = np.empty(most)  # d_k . n
    shift = np.empty((most, 3))  # tangential part of d_k
    flat = np.empty((most, 2))  # polygon in the plane of the joint
    work = np.empty((2, 4 * most + 8, 3))
    for j in range(block_a.shape[0]):
        a, b, first, corners = block_a[j], block_b[j], start[j], start[j + 1] - start[j]
        n_world = rotation[a] @ normal[j]
        for k in range(corners):
            x = polygon[first + k]
            d = (rotation[b] @ (x - centre[b]) + position[b]) - (rotation[a] @ (x - centre[a]) + position[a])
            apart[k] = np.dot(d, n_world)
            shift[k] = d - apart[k] * n_world
        size = _flatten(polygon, first, corners, normal[j], flat)
        out[0, j] = max(0.0, apart[:corners].max())
        out[1, j] = _largest_shift(apart, shift, corners, TOUCHING * size)
        out[2, j] = _relative_angle(rotation[a], rotation[b])
        out[3, j] = _contact_area(flat, apart, shift, corners, rotation[a].T, polygon, first, normal[j], work)


@njit(cache=True, nogil=True)
def _largest_shift(apart, shift, corners, tolerance):
    """Largest tangential displacement among the corners that touch."""
    limit = apart[:corners].min() + tolerance
    largest = 0.0
    for k in range(corners):
        if apart[k] <= limit:
            largest = max(largest, np.sqrt(np.dot(shift[k], shift[k])))
    return largest


@njit(cache=True, nogil=True)
def _relative_angle(ra, rb):
    """Angle of ra^T rb, exact near zero: |skew part| = sin, (trace - 1) / 2 = cos."""
    r = ra.T @ rb
    sine = 0.5 * np.sqrt((r[2, 1] - r[1, 2]) ** 2 + (r[0, 2] - r[2, 0]) ** 2 + (r[1, 0] - r[0, 1]) ** 2)
    return np.arctan2(sine, 0.5 * (r[0, 0] + r[1, 1] + r[2, 2] - 1.0))


@njit(cache=True, nogil=True)
def _axes(polygon, first, corners, n):
    """Two axes in the plane of the joint: along its first edge, and across."""
    along = polygon[first + 1] - polygon[first]
    along = along / np.sqrt(np.dot(along, along))
    return along, np.cross(n, along)


@njit(cache=True, nogil=True)
def _flatten(polygon, first, corners, n, flat):
    """Write the polygon in plane coordinates; return its largest extent [m]."""
    along, across = _axes(polygon, first, corners, n)
    size = 0.0
    for k in range(corners):
        d = polygon[first + k] - polygon[first]
        flat[k, 0], flat[k, 1] = np.dot(d, along), np.dot(d, across)
        size = max(size, np.sqrt(np.dot(d, d)))
    return size


@njit(cache=True, nogil=True)
def _contact_area(flat, apart, shift, corners, world_to_a, polygon, first, n, work):
    """Area of a's polygon inside b's moved polygon, where the joint is open by no more than CONTACT_WIDTH.

    work[.., :, 2] carries d . n, which is linear over the polygon because both blocks are rigid.
    """
    along, across = _axes(polygon, first, corners, n)
    count, source = corners, 0
    for k in range(corners):
        work[0, k, 0], work[0, k, 1], work[0, k, 2] = flat[k, 0], flat[k, 1], apart[k]
    turn = _signed_area(flat, corners)
    for k in range(corners):  # cut by every side of b's polygon
        nxt = (k + 1) % corners
        move, move_next = world_to_a @ shift[k], world_to_a @ shift[nxt]
        x0, y0 = flat[k, 0] + np.dot(move, along), flat[k, 1] + np.dot(move, across)
        x1, y1 = flat[nxt, 0] + np.dot(move_next, along), flat[nxt, 1] + np.dot(move_next, across)
        sign = 1.0 if turn > 0 else -1.0
        count = _cut(work[source], count, -sign * (y1 - y0), sign * (x1 - x0), 0.0, x0, y0, 0.0, work[1 - source])
        source = 1 - source
    count = _cut(work[source], count, 0.0, 0.0, -1.0, 0.0, 0.0, CONTACT_WIDTH, work[1 - source])
    return abs(_signed_area(work[1 - source], count))


@njit(cache=True, nogil=True)
def _cut(points, count, ax, ay, az, x0, y0, z0, kept):
    """Keep the part of a convex polygon where ax (x - x0) + ay (y - y0) + az (z - z0) >= 0."""
    out = 0
    for k in range(count):
        p, q = points[k], points[(k + 1) % count]
        fp = ax * (p[0] - x0) + ay * (p[1] - y0) + az * (p[2] - z0)
        fq = ax * (q[0] - x0) + ay * (q[1] - y0) + az * (q[2] - z0)
        if fp >= 0.0:
            kept[out] = p
            out += 1
        if (fp > 0.0 and fq < 0.0) or (fp < 0.0 and fq > 0.0):
            kept[out] = p + (fp / (fp - fq)) * (q - p)
            out += 1
    return out


@njit(cache=True, nogil=True)
def _signed_area(points, count):
    """Shoelace area of the first count points."""
    area = 0.0
    for k in range(1, count - 1):
        x1, y1 = points[k, 0] - points[0, 0], points[k, 1] - points[0, 1]
        x2, y2 = points[k + 1, 0] - points[0, 0], points[k + 1, 1] - points[0, 1]
        area += 0.5 * (x1 * y2 - x2 * y1)
    return area
