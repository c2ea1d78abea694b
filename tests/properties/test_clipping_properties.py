# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces on faces: the contact points of two prisms are the corners of the overlap of their faces, wherever they lie."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.manifold import SLIVER, SNAP
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import JointLaw
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.mechanics.model.state import State, rotation_matrices

HEIGHT = 0.5  # of both prisms [m]
ELASTIC = JointLaw(normal_stiffness=1e9, tangential_stiffness=4e8)
ANGLE = st.floats(-np.pi, np.pi)


def prism(name: str, polygon: np.ndarray, low: float, turn: np.ndarray, fixed: bool) -> Block:
    """An upright prism on a counter-clockwise polygon (k, 2) from the height ``low`` on, turned about the origin."""
    k = len(polygon)
    corners = np.concatenate([np.column_stack([polygon, np.full(k, z)]) for z in (low, low + HEIGHT)])
    sides = tuple((i, (i + 1) % k, k + (i + 1) % k, k + i) for i in range(k))
    return Block(
        name, corners @ turn.T, (tuple(range(k))[::-1], tuple(range(k, 2 * k)), *sides), 2000.0, "base" if fixed else "block", fixed
    )


def contacts(lower: np.ndarray, upper: np.ndarray, turn: np.ndarray, elastic: bool) -> ContactSet:
    """Return the contacts that the detector finds between the top of a prism on one polygon and the bottom of one on the other."""
    blocks = [prism("lower", lower, -HEIGHT, turn, True), prism("upper", upper, 0.0, turn, False)]
    assembly = Assembly.from_blocks(blocks, Material(friction=0.6, joints={"default": ELASTIC} if elastic else {}))
    state = State.at_rest(assembly)
    rotation = rotation_matrices(state.orientation)
    return Detector(assembly).detect(state.position, rotation, np.zeros((2, 6)), 1e-3, 0.0, np.zeros(3))


def half_planes(polygon: np.ndarray) -> np.ndarray:
    """Rows (a, b, c) with a x + b y + c <= 0 inside, (a, b) of length one."""
    edge = np.roll(polygon, -1, axis=0) - polygon
    normal = np.column_stack([edge[:, 1], -edge[:, 0]]) / np.linalg.norm(edge, axis=1)[:, None]
    return np.column_stack([normal, -(normal * polygon).sum(axis=1)])


def overlap(first: np.ndarray, second: np.ndarray) -> tuple[float, np.ndarray]:
    """Radius of the largest circle in both polygons, and the corners of their overlap (none where there is no circle)."""
    planes = np.concatenate([half_planes(first), half_planes(second)])
    widened = np.column_stack([planes[:, :2], np.ones(len(planes))])
    found = linprog([0.0, 0.0, -1.0], A_ub=widened, b_ub=-planes[:, 2], bounds=[(None, None)] * 3)
    x, y, radius = found.x
    if radius <= 1e-6:
        return radius, np.empty((0, 2))
    corners = HalfspaceIntersection(planes, np.array([x, y])).intersections
    return radius, corners[ConvexHull(corners).vertices]


@st.composite
def polygons(draw: st.DrawFn) -> np.ndarray:
    """A convex polygon (k, 2) of 3 to 7 corners on an ellipse, anywhere near the origin, not thin."""
    k = draw(st.integers(3, 7))
    steps = np.array([draw(st.floats(0.5, 1.5)) for _ in range(k)])
    angle = 2.0 * np.pi * np.cumsum(steps) / steps.sum()
    turn, wide, narrow = draw(ANGLE), draw(st.floats(0.5, 2.0)), draw(st.floats(0.5, 1.0))
    c, s = np.cos(turn), np.sin(turn)
    shift = np.array([draw(st.floats(-1.5, 1.5)), draw(st.floats(-1.5, 1.5))])
    return np.column_stack([wide * np.cos(angle), narrow * np.sin(angle)]) @ np.array([[c, s], [-s, c]]) + shift


@st.composite
def turns(draw: st.DrawFn) -> np.ndarray:
    """A rotation matrix (3, 3)."""
    quaternion = np.array([draw(st.floats(-1.0, 1.0)) for _ in range(4)])
    assume(np.linalg.norm(quaternion) > 0.1)
    return rotation_matrices(quaternion[None] / np.linalg.norm(quaternion))[0]


def hull_area(points: np.ndarray) -> float:
    """Area of the convex hull of points (k, 2)."""
    return float(ConvexHull(points).volume)


@given(polygons(), polygons(), turns())
def test_contact_points_are_the_corners_of_the_overlap(lower: np.ndarray, upper: np.ndarray, turn: np.ndarray) -> None:
    radius, corners = overlap(lower, upper)
    assume(abs(radius) > 10.0 * SLIVER)  # a sliver counts as no joint
    nearest = min(abs(half_planes(a)[:, :2] @ b.T + half_planes(a)[:, 2:]).min() for a, b in ((lower, upper), (upper, lower)))
    assume(nearest > 10.0 * SNAP)  # nor a corner that lies on a side: it snaps to it
    found = contacts(lower, upper, turn, elastic=False)
    if radius < 0.0:
        assert len(found.gap) == 0 or found.gap.min() > 0.0
        return
    points = found.point @ turn
    assert found.normal == pytest.approx(np.tile(turn[:, 2], (len(found.gap), 1)), abs=1e-12)
    assert np.abs(points[:, 2]).max() < 1e-12
    assert np.abs(found.gap).max() < 1e-12
    for polygon in (lower, upper):  # none outside of either face
        assert (half_planes(polygon) @ np.column_stack([points[:, :2], np.ones(len(points))]).T).max() < 1e-9
    assert hull_area(points[:, :2]) == pytest.approx(hull_area(corners), rel=1e-9)
    assert len(found.gap) == len(corners)
    distance = np.linalg.norm(points[:, None, :2] - corners[None], axis=2)
    assert distance.min(axis=0).max() < 1e-9  # each corner of the overlap has its point


@given(polygons(), polygons(), turns())
def test_shares_of_an_elastic_joint_add_up_to_its_area(lower: np.ndarray, upper: np.ndarray, turn: np.ndarray) -> None:
    """And they balance about the centroid of the overlap, so that an even pressure has its resultant there."""
    radius, corners = overlap(lower, upper)
    assume(radius > 0.01)
    found = contacts(lower, upper, turn, elastic=True)
    snapped = 4.0 * SNAP * np.abs(corners).max()  # corners near a side are moved onto it
    assert (found.area > 0.0).all()
    assert found.area.sum() == pytest.approx(hull_area(corners), rel=1e-9, abs=snapped)
    fan = [corners[[0, i, i + 1]] for i in range(1, len(corners) - 1)]
    sizes = np.array([hull_area(triangle) for triangle in fan])
    centroid = sizes @ np.array([triangle.mean(axis=0) for triangle in fan]) / sizes.sum()
    resultant = found.area @ (found.point @ turn)[:, :2] / found.area.sum()
    assert resultant == pytest.approx(centroid, abs=1e-9 + snapped / radius)


GRID = st.integers(-8, 8).map(lambda i: i / 4.0)
SIDE = st.integers(1, 8).map(lambda i: i / 4.0)


def rectangle(x: float, y: float, wide: float, deep: float) -> np.ndarray:
    """Corners (4, 2), counter-clockwise."""
    return np.array([[x, y], [x + wide, y], [x + wide, y + deep], [x, y + deep]])


@given(GRID, GRID, SIDE, SIDE, SIDE, SIDE)
def test_boxes_whose_sides_are_flush_touch_over_their_rectangle(x: float, y: float, a: float, b: float, c: float, d: float) -> None:
    """Offsets on a grid, so that sides and corners coincide: the overlap is a rectangle, and an edge or a corner alone is none."""
    lower, upper = rectangle(0.0, 0.0, a, b), rectangle(x, y, c, d)
    low, high = np.maximum([0.0, 0.0], [x, y]), np.minimum([a, b], [x + c, y + d])
    found = contacts(lower, upper, np.eye(3), elastic=False)
    if (high <= low).any():
        assert len(found.gap) == 0
        return
    corners = {(p, q, 0.0) for p in (low[0], high[0]) for q in (low[1], high[1])}
    assert {tuple(point) for point in np.round(found.point + 0.0, 9).tolist()} == corners
    assert len(found.gap) == 4
