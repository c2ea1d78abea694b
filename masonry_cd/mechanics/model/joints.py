# SPDX-License-Identifier: GPL-3.0-or-later
r"""Joints: the interfaces that two blocks share at rest, and how far they open, slide and rotate.

A joint keeps its interface polygon, whose corners X_k both blocks carry along. With x_a(X_k) and x_b(X_k) their places on
either block, the gap vector is d_k = x_b(X_k) - x_a(X_k), and with the joint's normal n carried by block a (from a to b):

    opening        max_k d_k . n                           [m]; a hinge opens at its far edge
    sliding        | d_k - (d_k . n) n |                   [m], the largest over the corners that still touch: those whose
                                                           d_k . n is smallest; elsewhere a rotation would pass for sliding
    rotation       angle of the relative rotation          [rad]
    contact area   of the polygon of a, cut by that of b after sliding, and by opening <= CONTACT_WIDTH   [m2]
    gap            min_k d_k . n                           [m]; near zero in a hinge, which still touches along an edge
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.geometry import relative_angle, relative_pose
from masonry_cd.mechanics.model.polygon import clip_in_place, plane_distances
from masonry_cd.mechanics.model.state import State, body_maps

CONTACT_WIDTH = 1e-4  # [m] surfaces farther apart than this count as no longer in contact
OPENED = 1e-4  # [m] a joint that opens this far is said to open for the first time
TOUCHING = 1e-3  # share of the joint's size within which a corner counts as touching, next to the least open one
TOUCHING_SHARE = 0.1  # share of the opening of a hinge within which its corners touch, from the least open one on


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
    """Opening [m], sliding [m], rotation [rad], contact area [m2] and gap [m] of all joints at one time, (J,) each."""

    opening: np.ndarray
    sliding: np.ndarray
    rotation: np.ndarray
    contact_area: np.ndarray
    gap: np.ndarray

    def since(self, rest: JointMeasures, area: np.ndarray) -> JointMeasures:
        """Return the growth over the measures of a state of rest, of joints of some areas (J,) [m2]; closing again does not count."""
        return JointMeasures(
            opening=np.maximum(0.0, self.opening - rest.opening),
            sliding=np.maximum(0.0, self.sliding - rest.sliding),
            rotation=np.maximum(0.0, self.rotation - rest.rotation),
            contact_area=np.minimum(area, self.contact_area + area - rest.contact_area),
            gap=self.gap - np.maximum(0.0, rest.gap),
        )

    def but(self, gone: np.ndarray, area: np.ndarray) -> JointMeasures:
        """The measures where those joints of some areas (J,) [m2] that are gone, (J,) bool, are as built."""
        moved = {name: np.where(gone, 0.0, values) for name, values in vars(self).items()}
        return replace(JointMeasures(**moved), contact_area=np.where(gone, area, self.contact_area))


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
    out = np.empty((5, joints.count))
    maps, affine = body_maps(assembly, state.orientation, state.strain), assembly.affine
    arrays = (joints.block_a, joints.block_b, joints.normal, joints.polygon_start, joints.polygon)
    _measure(arrays, assembly.centre, state.position, maps, affine, out)
    return JointMeasures(*out)


def touching_places(joints: Joints, assembly: Assembly, state: State, chosen: np.ndarray) -> np.ndarray:
    """Where some joints (n,) touch: the mean, at rest, of the corners that are open least, (n, 3) [m].

    Corners whose gap lies within TOUCHING_SHARE of the way from the smallest to the largest count.
    """
    out = np.empty((len(chosen), 3))
    arrays = (joints.block_a, joints.block_b, joints.normal, joints.polygon_start, joints.polygon)
    maps, affine = body_maps(assembly, state.orientation, state.strain), assembly.affine
    _touching_places(arrays, chosen, assembly.centre, state.position, maps, affine, out)
    return out


# The kernels below run over all joints in every step: they index whole arrays, since a view of a row costs more than its arithmetic.


class FlatPolygon(NamedTuple):
    """The polygon of one joint in its plane, and scratch for clipping it; for M corners at most."""

    corner: np.ndarray  # (M, 2) along the axes of the plane, from the first corner [m]
    apart: np.ndarray  # (M,) d_k . n [m]
    shift: np.ndarray  # (M, 2) tangential part of d_k along the axes [m]
    axes: np.ndarray  # (2, 3)
    polygon: np.ndarray  # (4 M + 8, 3) clipped polygon; its third coordinate is d . n, which is linear over it: both blocks are rigid
    other: np.ndarray  # (4 M + 8, 3)
    distance: np.ndarray  # (4 M + 8,)


@entry()
def _measure(joints, centre, position, maps, affine, out):
    """Fill out (5, J) with opening, sliding, rotation, contact area, gap; ``joints`` are (block_a, block_b, normal, start, polygon).

    All vectors are taken into the body frame of a, where the joint's normal and polygon stay what they were at rest.
    """
    block_a, block_b, normal, start, polygon = joints
    flat = flat_polygon(start)
    pose = np.empty(12)
    for j in range(block_a.shape[0]):
        a, b, first, corners = block_a[j], block_b[j], start[j], start[j + 1] - start[j]
        relative_pose(position, maps, affine, a, b, pose)
        out[2, j] = relative_angle(pose)
        plane_axes(polygon, first, normal, j, flat.axes)
        size = flatten(joints, j, centre, pose, flat)
        least, most_open = np.inf, 0.0
        for k in range(corners):
            least, most_open = min(least, flat.apart[k]), max(most_open, flat.apart[k])
        out[0, j] = most_open
        out[1, j] = _largest_shift(flat, corners, least + TOUCHING * size)
        out[3, j] = _contact_area(flat, corners, most_open)
        out[4, j] = least


@entry()
def _touching_places(joints, chosen, centre, position, maps, affine, out):
    """Fill out (n, 3) with the mean corner at rest of each chosen joint (n,) where it touches; ``joints`` as in :func:`_measure`."""
    block_a, block_b, normal, start, polygon = joints
    flat, pose = flat_polygon(start), np.empty(12)
    for i in range(chosen.shape[0]):
        j = chosen[i]
        first, corners = start[j], start[j + 1] - start[j]
        relative_pose(position, maps, affine, block_a[j], block_b[j], pose)
        plane_axes(polygon, first, normal, j, flat.axes)
        flatten(joints, j, centre, pose, flat)
        least, most_open = np.inf, 0.0
        for k in range(corners):
            least, most_open = min(least, flat.apart[k]), max(most_open, flat.apart[k])
        count = 0
        for d in range(3):
            out[i, d] = 0.0
        for k in range(corners):
            if flat.apart[k] <= least + TOUCHING_SHARE * (most_open - least):
                count += 1
                for d in range(3):
                    out[i, d] += polygon[first + k, d]
        for d in range(3):
            out[i, d] /= count


@kernel()
def flat_polygon(start):
    """Room for the polygon with the most corners."""
    most = 0
    for j in range(start.shape[0] - 1):
        most = max(most, start[j + 1] - start[j])
    long = 4 * most + 8
    return FlatPolygon(np.empty((most, 2)), np.empty(most), np.empty((most, 2)), np.empty((2, 3)),
                 np.empty((long, 3)), np.empty((long, 3)), np.empty(long))  # fmt: skip


@borrower()
def flatten(joints, j, centre, pose, flat):
    """Fill ``flat`` with the corners of joint j and how far they are apart in a relative pose; returns the joint's size [m]."""
    block_a, block_b, normal, start, polygon = joints
    a, b, first = block_a[j], block_b[j], start[j]
    axes, square = flat.axes, 0.0
    for k in range(start[j + 1] - first):
        open_by, x, y, shift_x, shift_y = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(3):
            d = pose[i] - (polygon[first + k, i] - centre[a, i])
            for e in range(3):
                d += pose[3 + 3 * i + e] * (polygon[first + k, e] - centre[b, e])
            edge = polygon[first + k, i] - polygon[first, i]
            open_by += d * normal[j, i]
            x, y = x + edge * axes[0, i], y + edge * axes[1, i]
            shift_x, shift_y = shift_x + d * axes[0, i], shift_y + d * axes[1, i]
        flat.apart[k], flat.corner[k, 0], flat.corner[k, 1], flat.shift[k, 0], flat.shift[k, 1] = open_by, x, y, shift_x, shift_y
        square = max(square, x * x + y * y)
    return np.sqrt(square)


@borrower()
def plane_axes(polygon, first, normal, j, axes):
    """Fill ``axes`` (2, 3) with two unit vectors in the plane of joint j: along its first edge, and n x that."""
    length = 0.0
    for d in range(3):
        axes[0, d] = polygon[first + 1, d] - polygon[first, d]
        length += axes[0, d] ** 2
    for d in range(3):
        axes[0, d] /= np.sqrt(length)
    axes[1, 0] = normal[j, 1] * axes[0, 2] - normal[j, 2] * axes[0, 1]
    axes[1, 1] = normal[j, 2] * axes[0, 0] - normal[j, 0] * axes[0, 2]
    axes[1, 2] = normal[j, 0] * axes[0, 1] - normal[j, 1] * axes[0, 0]


@borrower()
def _largest_shift(flat, corners, limit):
    """Largest tangential displacement [m] among the corners that are open by no more than ``limit`` [m]: those that touch."""
    square = 0.0
    for k in range(corners):
        if flat.apart[k] <= limit:
            square = max(square, flat.shift[k, 0] ** 2 + flat.shift[k, 1] ** 2)
    return np.sqrt(square)


@borrower()
def _contact_area(flat, corners, most_open):
    """Area of a's polygon inside b's moved polygon, where the joint is open by no more than CONTACT_WIDTH [m2]."""
    polygon = flat.polygon
    count = clip_to_other(flat, corners)
    if most_open > CONTACT_WIDTH:
        plane_distances(polygon, count, (0.0, 0.0, -1.0), (0.0, 0.0, CONTACT_WIDTH), flat.distance)
        count = clip_in_place(polygon, count, flat.distance, 0.0, flat.other)
    return abs(_signed_area(polygon, count))


@kernel(inline="always")
def clip_to_other(flat, corners):
    """Fill ``flat.polygon`` with what of a's polygon lies inside b's moved one; returns the number of its corners."""
    polygon, corner, shift = flat.polygon, flat.corner, flat.shift
    count = corners
    for k in range(corners):
        polygon[k, 0], polygon[k, 1], polygon[k, 2] = corner[k, 0], corner[k, 1], flat.apart[k]
    sign = 1.0 if _signed_area(polygon, corners) > 0 else -1.0
    for k in range(corners):  # clip by every side of b's polygon
        j = k + 1 if k + 1 < corners else 0
        x0, y0 = corner[k, 0] + shift[k, 0], corner[k, 1] + shift[k, 1]
        x1, y1 = corner[j, 0] + shift[j, 0], corner[j, 1] + shift[j, 1]
        plane_distances(polygon, count, (-sign * (y1 - y0), sign * (x1 - x0), 0.0), (x0, y0, 0.0), flat.distance)
        count = clip_in_place(polygon, count, flat.distance, 0.0, flat.other)
    return count


@borrower()
def _signed_area(polygon, count):
    """Shoelace area of the first count points of a polygon, by their first two coordinates [m2]."""
    area = 0.0
    for k in range(1, count - 1):
        x1, y1 = polygon[k, 0] - polygon[0, 0], polygon[k, 1] - polygon[0, 1]
        x2, y2 = polygon[k + 1, 0] - polygon[0, 0], polygon[k + 1, 1] - polygon[0, 1]
        area += 0.5 * (x1 * y2 - x2 * y1)
    return area
