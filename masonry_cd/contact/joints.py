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

from masonry_cd.contact.detector import ContactSet, Detector
from masonry_cd.jit import entry, kernel
from masonry_cd.model.blocks import Assembly
from masonry_cd.model.state import State, rotation_matrices

CONTACT_WIDTH = 1e-4  # [m] surfaces farther apart than this count as no longer in contact
OPENED = 1e-4  # [m] a joint that opens this far is said to open for the first time
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


def find_joints(assembly: Assembly) -> Joints:
    """The joints of an assembly as built: every pair of parts whose contact points at rest span an area."""
    contacts, pieces, _ = _touching(assembly)
    corners = [contacts.point[piece] for piece in pieces]
    first = np.array([piece[0] for piece in pieces], dtype=np.int64)
    return Joints(
        block_a=contacts.bodies[first, 1].copy(),  # the normal points from the antagonist to the candidate
        block_b=contacts.bodies[first, 0].copy(),
        area=np.array([polygon_area(loop) for loop in corners]),
        normal=contacts.normal[first].copy(),
        polygon_start=np.cumsum([0, *(len(piece) for piece in pieces)]),
        polygon=np.concatenate(corners) if corners else np.zeros((0, 3)),
    )


def joint_parts(assembly: Assembly) -> np.ndarray:
    """The two convex parts (J, 2) of each joint, in the order of :func:`find_joints`: blocks that are bent share several joints."""
    contacts, pieces, pairs = _touching(assembly)
    return pairs[contacts.pair[[piece[0] for piece in pieces]]].reshape(-1, 2)


def _touching(assembly: Assembly) -> tuple[ContactSet, list[np.ndarray], np.ndarray]:
    """The contacts at rest, the contacts of each pair of parts that spans an area, and the pairs of parts (P, 2)."""
    state, detector = State.at_rest(assembly), Detector(assembly, corners_only=True)
    still = np.zeros((assembly.count, 6))
    contacts = detector.detect(state.position, rotation_matrices(state.orientation), still, 0.0, 0.0, np.zeros(3))
    starts = np.flatnonzero(np.diff(contacts.pair, prepend=-1))
    pieces = np.split(np.arange(contacts.count), starts[1:]) if contacts.count else []
    return contacts, [piece for piece in pieces if len(piece) >= 3], detector.pairs


def polygon_area(loop: np.ndarray) -> float:
    """Area of a planar loop (n, 3) [m2]."""
    return float(0.5 * np.linalg.norm(np.cross(loop[1:-1] - loop[0], loop[2:] - loop[0]).sum(axis=0)))


@dataclass(frozen=True, eq=False)
class JointMeasures:
    """Opening [m], sliding [m], rotation [rad] and contact area [m2] of all joints at one time, (J,) each."""

    opening: np.ndarray
    sliding: np.ndarray
    rotation: np.ndarray
    contact_area: np.ndarray


class JointPeaks:
    """The largest measures of each joint so far, over all steps and not only the frames."""

    def __init__(self, joints: Joints) -> None:
        self._area = joints.area
        self.opening = np.zeros(joints.count)
        self.sliding = np.zeros(joints.count)
        self.rotation = np.zeros(joints.count)
        self.contact_area_loss = np.zeros(joints.count)
        self.first_opening_time = np.full(joints.count, np.nan)

    def update(self, now: JointMeasures, time: float) -> None:
        """Take in the measures of one step."""
        for name in ("opening", "sliding", "rotation"):
            np.maximum(getattr(self, name), getattr(now, name), out=getattr(self, name))
        np.maximum(self.contact_area_loss, 1.0 - now.contact_area / self._area, out=self.contact_area_loss)
        self.first_opening_time[np.isnan(self.first_opening_time) & (now.opening >= OPENED)] = time


def measure_joints(joints: Joints, assembly: Assembly, state: State) -> JointMeasures:
    """Measure all joints in a state; see the head of this file."""
    out = np.empty((4, joints.count))
    rotation = rotation_matrices(state.orientation)
    _measure(
        joints.block_a, joints.block_b, joints.normal, joints.polygon_start, joints.polygon, assembly.centre, state.position, rotation, out
    )
    return JointMeasures(*out)


# The kernels below run over all joints in every step: they index whole arrays, since a view of a row costs more than its arithmetic.


@entry()
def _measure(block_a, block_b, normal, start, polygon, centre, position, rotation, out):
    """Fill out (4, J) with opening, sliding, rotation and contact area.

    All vectors are taken into the body frame of a, where the joint's normal and polygon stay what they were at rest.
    """
    most = 0
    for j in range(block_a.shape[0]):
        most = max(most, start[j + 1] - start[j])
    apart = np.empty(most)  # d_k . n
    shift = np.empty((most, 2))  # tangential part of d_k, along the axes of the joint's plane
    flat = np.empty((most, 2))  # polygon in the plane of the joint
    work = np.empty((2, 4 * most + 8, 3))
    axes = np.empty((2, 3))
    turn, move = np.empty((3, 3)), np.empty(3)
    for j in range(block_a.shape[0]):
        a, b, first, corners = block_a[j], block_b[j], start[j], start[j + 1] - start[j]
        out[2, j] = _relative_pose(rotation, position, a, b, turn, move)
        _axes(polygon, first, normal, j, axes)
        square, least, most_open = 0.0, np.inf, 0.0
        for k in range(corners):
            open_by, x, y, shift_x, shift_y = 0.0, 0.0, 0.0, 0.0, 0.0
            for i in range(3):
                d = move[i] - (polygon[first + k, i] - centre[a, i])
                for e in range(3):
                    d += turn[i, e] * (polygon[first + k, e] - centre[b, e])
                edge = polygon[first + k, i] - polygon[first, i]
                open_by += d * normal[j, i]
                x, y = x + edge * axes[0, i], y + edge * axes[1, i]
                shift_x, shift_y = shift_x + d * axes[0, i], shift_y + d * axes[1, i]
            apart[k], flat[k, 0], flat[k, 1], shift[k, 0], shift[k, 1] = open_by, x, y, shift_x, shift_y
            square = max(square, x * x + y * y)
            least, most_open = min(least, open_by), max(most_open, open_by)
        out[0, j] = most_open
        out[1, j] = _largest_shift(apart, shift, corners, least + TOUCHING * np.sqrt(square))
        out[3, j] = _contact_area(flat, apart, shift, corners, most_open, work)


@kernel()
def _relative_pose(rotation, position, a, b, turn, move):
    """Rotation R_a^T R_b and position R_a^T (x_b - x_a) of b in the frame of a; returns the angle, exact near zero."""
    dx, dy, dz = position[b, 0] - position[a, 0], position[b, 1] - position[a, 1], position[b, 2] - position[a, 2]
    for i in range(3):
        x, y, z = rotation[a, 0, i], rotation[a, 1, i], rotation[a, 2, i]
        move[i] = x * dx + y * dy + z * dz
        for j in range(3):
            turn[i, j] = x * rotation[b, 0, j] + y * rotation[b, 1, j] + z * rotation[b, 2, j]
    x, y, z = turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]
    return np.arctan2(0.5 * np.sqrt(x * x + y * y + z * z), 0.5 * (turn[0, 0] + turn[1, 1] + turn[2, 2] - 1.0))


@kernel()
def _axes(polygon, first, normal, j, axes):
    """Two unit vectors in the plane of the joint: along its first edge, and n x that."""
    length = 0.0
    for d in range(3):
        axes[0, d] = polygon[first + 1, d] - polygon[first, d]
        length += axes[0, d] ** 2
    for d in range(3):
        axes[0, d] /= np.sqrt(length)
    axes[1, 0] = normal[j, 1] * axes[0, 2] - normal[j, 2] * axes[0, 1]
    axes[1, 1] = normal[j, 2] * axes[0, 0] - normal[j, 0] * axes[0, 2]
    axes[1, 2] = normal[j, 0] * axes[0, 1] - normal[j, 1] * axes[0, 0]


@kernel()
def _largest_shift(apart, shift, corners, limit):
    """Largest tangential displacement among the corners that are open by no more than ``limit``: those that touch."""
    square = 0.0
    for k in range(corners):
        if apart[k] <= limit:
            square = max(square, shift[k, 0] ** 2 + shift[k, 1] ** 2)
    return np.sqrt(square)


@kernel()
def _contact_area(flat, apart, shift, corners, most_open, work):
    """Area of a's polygon inside b's moved polygon, where the joint is open by no more than CONTACT_WIDTH.

    work[.., :, 2] carries d . n, which is linear over the polygon because both blocks are rigid.
    """
    count, at = corners, 0
    for k in range(corners):
        work[0, k, 0], work[0, k, 1], work[0, k, 2] = flat[k, 0], flat[k, 1], apart[k]
    sign = 1.0 if _signed_area(work, at, corners) > 0 else -1.0
    for k in range(corners):  # cut by every side of b's polygon
        nxt = k + 1 if k + 1 < corners else 0
        x0, y0 = flat[k, 0] + shift[k, 0], flat[k, 1] + shift[k, 1]
        x1, y1 = flat[nxt, 0] + shift[nxt, 0], flat[nxt, 1] + shift[nxt, 1]
        count, at = _cut(work, at, count, -sign * (y1 - y0), sign * (x1 - x0), 0.0, x0, y0, 0.0)
    if most_open > CONTACT_WIDTH:
        count, at = _cut(work, at, count, 0.0, 0.0, -1.0, 0.0, 0.0, CONTACT_WIDTH)
    return abs(_signed_area(work, at, count))


@kernel()
def _cut(work, at, count, ax, ay, az, x0, y0, z0):
    """Keep the part of the convex polygon work[at] where ax (x - x0) + ay (y - y0) + az (z - z0) >= 0.

    Returns the number of its corners and where it stands: in the other half of ``work``, unless nothing was cut off.
    """
    whole = True
    for k in range(count):
        whole = whole and ax * (work[at, k, 0] - x0) + ay * (work[at, k, 1] - y0) + az * (work[at, k, 2] - z0) >= 0.0
    if whole:
        return count, at
    out, to = 0, 1 - at
    px, py, pz = work[at, count - 1, 0], work[at, count - 1, 1], work[at, count - 1, 2]
    fp = ax * (px - x0) + ay * (py - y0) + az * (pz - z0)
    for k in range(count):
        qx, qy, qz = work[at, k, 0], work[at, k, 1], work[at, k, 2]
        fq = ax * (qx - x0) + ay * (qy - y0) + az * (qz - z0)
        if (fp > 0.0 and fq < 0.0) or (fp < 0.0 and fq > 0.0):
            t = fp / (fp - fq)
            work[to, out, 0], work[to, out, 1], work[to, out, 2] = px + t * (qx - px), py + t * (qy - py), pz + t * (qz - pz)
            out += 1
        if fq >= 0.0:
            work[to, out, 0], work[to, out, 1], work[to, out, 2] = qx, qy, qz
            out += 1
        px, py, pz, fp = qx, qy, qz, fq
    return out, to


@kernel()
def _signed_area(work, at, count):
    """Shoelace area of the first count points of work[at]."""
    area = 0.0
    for k in range(1, count - 1):
        x1, y1 = work[at, k, 0] - work[at, 0, 0], work[at, k, 1] - work[at, 0, 1]
        x2, y2 = work[at, k + 1, 0] - work[at, 0, 0], work[at, k + 1, 1] - work[at, 0, 1]
        area += 0.5 * (x1 * y2 - x2 * y1)
    return area
