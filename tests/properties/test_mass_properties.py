# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume, centre and inertia of random solids: closed forms, motions, mirrors, and cuts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from models import box
from scipy.spatial import ConvexHull

from masonry_cd.mechanics.model.geometry import Faces, MassProperties, mass_properties
from masonry_cd.mechanics.model.state import rotation_matrices

LENGTH = st.floats(1e-3, 1e3)
PLACE = arrays(float, 3, elements=st.floats(-100.0, 100.0))
POINTS = arrays(float, (12, 3), elements=st.floats(-1.0, 1.0))


def hull(points: np.ndarray) -> tuple[np.ndarray, Faces]:
    """Corners and outward triangles of the convex hull of points (k, 3)."""
    found = ConvexHull(points)
    corner = points[found.simplices]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    outward = (normal * found.equations[:, :3]).sum(axis=1) > 0.0
    return points, tuple(tuple(map(int, f if out else f[::-1])) for f, out in zip(found.simplices, outward, strict=True))


@st.composite
def solids(draw: st.DrawFn) -> np.ndarray:
    """Points (12, 3) whose hull is not flat."""
    points = draw(POINTS)
    assume(np.linalg.svd(points - points.mean(axis=0))[1][2] > 0.3)
    assume(ConvexHull(points).volume > 0.05)
    return points


def about(found: MassProperties, point: np.ndarray) -> np.ndarray:
    """Inertia about a point, by the parallel axes (Steiner)."""
    arm = found.centre - point
    return found.unit_inertia + found.volume * (arm @ arm * np.eye(3) - np.outer(arm, arm))


@given(st.tuples(LENGTH, LENGTH, LENGTH), PLACE)
def test_a_box(size: tuple[float, float, float], low: np.ndarray) -> None:
    edges = np.array(size)
    block = box("b", tuple(low), tuple(low + edges))
    edges = np.ptp(block.vertices, axis=0)  # as rounding left them
    found = mass_properties(block.vertices, block.faces)
    assert found.volume == pytest.approx(edges.prod(), rel=1e-11)
    assert found.centre == pytest.approx(low + edges / 2.0, rel=1e-11, abs=1e-11 * edges.max())
    expected = np.diag((edges**2).sum() - edges**2) * edges.prod() / 12.0
    assert found.unit_inertia == pytest.approx(expected, rel=1e-10, abs=1e-10 * expected.max())


@given(arrays(float, (4, 3), elements=st.floats(-1.0, 1.0)))
def test_a_tetrahedron(corners: np.ndarray) -> None:
    """Its second moments about the centroid are those of four masses V / 20 at the corners."""
    volume = np.linalg.det(corners[1:] - corners[0]) / 6.0
    assume(abs(volume) > 1e-3)
    faces = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    found = mass_properties(corners, faces if volume > 0.0 else tuple(face[::-1] for face in faces))
    arm = corners - corners.mean(axis=0)
    second = abs(volume) / 20.0 * arm.T @ arm
    assert found.volume == pytest.approx(abs(volume), rel=1e-11)
    assert found.centre == pytest.approx(corners.mean(axis=0), abs=1e-12)
    assert found.unit_inertia == pytest.approx(np.trace(second) * np.eye(3) - second, abs=1e-12)


@given(st.integers(3, 12), LENGTH, LENGTH)
def test_a_regular_prism(sides: int, radius: float, height: float) -> None:
    """A polygon of area A = k R^2 sin(2 pi / k) / 2 has the polar moment A R^2 (2 + cos(2 pi / k)) / 6."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    corners = np.concatenate([np.column_stack([ring, np.full(sides, z)]) for z in (0.0, height)])
    around = tuple((i, (i + 1) % sides, sides + (i + 1) % sides, sides + i) for i in range(sides))
    found = mass_properties(corners, (tuple(range(sides))[::-1], tuple(range(sides, 2 * sides)), *around))
    area = 0.5 * sides * radius**2 * np.sin(2.0 * np.pi / sides)
    polar = area * radius**2 * (2.0 + np.cos(2.0 * np.pi / sides)) / 6.0
    across = height * polar / 2.0 + area * height**3 / 12.0
    assert found.volume == pytest.approx(area * height, rel=1e-11)
    assert found.centre == pytest.approx([0.0, 0.0, height / 2.0], rel=1e-11, abs=1e-11 * (radius + height))
    assert np.diag(found.unit_inertia) == pytest.approx([across, across, height * polar], rel=1e-10)


@given(solids(), arrays(float, 4, elements=st.floats(-1.0, 1.0)), PLACE)
def test_a_motion_moves_the_centre_and_turns_the_inertia(points: np.ndarray, quaternion: np.ndarray, shift: np.ndarray) -> None:
    assume(np.linalg.norm(quaternion) > 0.1)
    turn = rotation_matrices(quaternion[None] / np.linalg.norm(quaternion))[0]
    corners, faces = hull(points)
    here, there = mass_properties(corners, faces), mass_properties(corners @ turn.T + shift, faces)
    assert there.volume == pytest.approx(here.volume, rel=1e-11)
    assert there.centre == pytest.approx(turn @ here.centre + shift, abs=1e-11)
    assert there.unit_inertia == pytest.approx(turn @ here.unit_inertia @ turn.T, abs=1e-11)


@given(solids(), st.integers(-20, 20))
def test_lengths_come_in_by_their_powers(points: np.ndarray, power: int) -> None:
    corners, faces = hull(points)
    one, other = mass_properties(corners, faces), mass_properties(2.0**power * corners, faces)
    assert other.volume == pytest.approx(8.0**power * one.volume, rel=1e-13)
    assert other.centre == pytest.approx(2.0**power * one.centre, rel=1e-13, abs=1e-14 * 2.0**power)
    assert other.unit_inertia == pytest.approx(32.0**power * one.unit_inertia, rel=1e-13, abs=1e-14 * 32.0**power)


@given(solids(), arrays(float, 3, elements=st.floats(-1.0, 1.0)), st.floats(-0.5, 0.5))
def test_two_halves_make_the_whole(points: np.ndarray, normal: np.ndarray, share: float) -> None:
    """Cut by a plane near the centre: volumes, first moments, and inertias about one point add up."""
    assume(np.linalg.norm(normal) > 0.1)
    normal = normal / np.linalg.norm(normal)
    corners, faces = hull(points)
    whole = mass_properties(corners, faces)
    height = (corners - whole.centre) @ normal
    height = height - share * np.abs(height).min(initial=np.inf, where=np.abs(height) > 0.05)
    below, above = np.flatnonzero(height < -1e-3), np.flatnonzero(height > 1e-3)
    assume(len(below) + len(above) == len(corners))
    i, j = (ends.ravel() for ends in np.meshgrid(below, above))
    weight = (height[j] / (height[j] - height[i]))[:, None]
    section = weight * corners[i] + (1.0 - weight) * corners[j]  # of all segments between the sides: their hull is the section
    halves = [mass_properties(*hull(np.concatenate([corners[side], section]))) for side in (below, above)]
    assert sum(half.volume for half in halves) == pytest.approx(whole.volume, rel=1e-10)
    assert sum(half.volume * half.centre for half in halves) == pytest.approx(whole.volume * whole.centre, abs=1e-10)
    assert sum(about(half, whole.centre) for half in halves) == pytest.approx(whole.unit_inertia, abs=1e-10)


@given(solids())
def test_principal_moments_are_those_of_a_body(points: np.ndarray) -> None:
    """All above zero, none larger than the two others together, and the centre lies inside."""
    corners, faces = hull(points)
    found = mass_properties(corners, faces)
    moments = np.linalg.eigvalsh(found.unit_inertia)
    assert moments[0] > 0.0
    assert moments[2] < moments[0] + moments[1]
    assert (ConvexHull(points).equations @ np.append(found.centre, 1.0)).max() < 0.0
