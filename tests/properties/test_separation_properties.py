# SPDX-License-Identifier: GPL-3.0-or-later
"""Convex parts that move past each other: no contact of parts that are apart, none deeper than they are in each other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from separations import parts_in_world, shortfall, signed_distance

from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.flat_contact import EDGE_BIAS
from masonry_cd.mechanics.contact.motion import NEAR
from masonry_cd.mechanics.contact.pair_memory import REUSE
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.state import State, rotation_matrices

STEP = 2e-3  # [s]
ALLOWED = EDGE_BIAS + 2.0 * REUSE  # share of the width: faces come before edges, and a feature is kept while the pair moves a little
SEED = st.integers(0, 2**32 - 1)


def prism(name: str, rng: np.random.Generator, fixed: bool) -> Block:
    """An upright prism on a random polygon: stout, flat, or thin as a web."""
    k = int(rng.integers(3, 8))
    angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, k) if rng.random() < 0.5 else 2.0 * np.pi * (np.arange(k) + rng.uniform(0.0, 0.3, k)) / k)
    if np.diff(np.append(angle, angle[0] + 2.0 * np.pi)).max() > 0.9 * np.pi or np.diff(angle).min() < 0.05:
        angle = 2.0 * np.pi * np.arange(k) / k + rng.uniform(0.0, 6.0)
    size = 10.0 ** rng.uniform(-1.5, 0.0, 3)
    polygon = np.column_stack([np.cos(angle), np.sin(angle)]) * size[:2]
    corners = np.concatenate([np.column_stack([polygon, np.full(k, z)]) for z in (-size[2], size[2])])
    sides = tuple((i, (i + 1) % k, k + (i + 1) % k, k + i) for i in range(k))
    return Block(name, corners, (tuple(range(k))[::-1], tuple(range(k, 2 * k)), *sides), 2000.0, "base" if fixed else "block", fixed)


def stone(name: str, rng: np.random.Generator, fixed: bool) -> Block:
    """The hull of some random points."""
    points = rng.normal(size=(int(rng.integers(5, 11)), 3)) * 10.0 ** rng.uniform(-1.0, -0.3, 3)
    hull = ConvexHull(points)
    corners, index = points[hull.vertices], {int(v): i for i, v in enumerate(hull.vertices)}
    faces = []
    for simplex, equation in zip(hull.simplices, hull.equations, strict=True):
        p = points[simplex]
        inwards = np.cross(p[1] - p[0], p[2] - p[0]) @ equation[:3] < 0.0
        faces.append(tuple(index[int(v)] for v in (simplex[::-1] if inwards else simplex)))
    return Block(name, corners, tuple(faces), 2000.0, "base" if fixed else "block", fixed)


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """The quaternion of a rotation."""
    return np.array([np.cos(0.5 * angle), *(np.sin(0.5 * angle) * axis / np.linalg.norm(axis))])


def times(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The product of two quaternions."""
    v = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *v])


class Passing:
    """Two random parts, nearly parallel as often as not, that pass each other step after step under the eyes of one detector."""

    def __init__(self, rng: np.random.Generator) -> None:
        make = prism if rng.random() < 0.7 else stone
        self.assembly = Assembly.from_blocks([make("a", rng, True), make("b", rng, False)], 0.6)
        self.detector, self.state = Detector(self.assembly), State.at_rest(self.assembly)
        radius = self.assembly.shapes.radius
        way = rng.normal(size=3) * rng.choice([0.0, 1.0], 3, p=[0.3, 0.7])
        self.state.position[:] = 0.0
        self.state.position[1] = rng.uniform(0.2, 1.2) * radius.sum() * way / max(1e-3, np.linalg.norm(way))
        nearly = 10.0 ** rng.uniform(-7.0, -1.0) if rng.random() < 0.6 else rng.uniform(0.0, np.pi)
        self.state.orientation[1] = turn(rng.normal(size=3), nearly)
        self.nearly, self.phase, self.swaying = nearly, rng.uniform(0.0, 2.0 * np.pi), nearly < 1e-3 and rng.random() < 0.5
        if rng.random() < 0.5:  # the frame of the first part is not that of the world
            tilt = turn(rng.normal(size=3), rng.uniform(0.0, np.pi))
            self.state.orientation[:] = [times(tilt, q) for q in self.state.orientation]
            self.state.position[:] = self.state.position @ rotation_matrices(tilt[None])[0].T
        self.slack = 10.0 ** rng.uniform(-6.0, -1.5)
        self.velocity = np.zeros((2, 6))
        speed = 10.0 ** rng.uniform(-4.0, 1.7)
        self.velocity[1, :3] = speed * rng.normal(size=3) - speed * rng.choice([0.0, 1.0]) * self.state.position[1]
        self.velocity[1, 3:] = 10.0 ** rng.uniform(-4.0, 1.5) * rng.normal(size=3)

    @property
    def margin(self) -> float:
        """Up to which gaps count [m]."""
        shapes, v = self.assembly.shapes, self.velocity[1]
        closing = np.linalg.norm(v[:3]) + np.linalg.norm(v[3:]) * shapes.radius[1]
        return float(self.slack + NEAR * self.width + 2.0 * STEP * closing)

    @property
    def width(self) -> float:
        """Width of the smaller part [m]."""
        return float(self.assembly.shapes.size.min())

    def check(self) -> tuple[bool, bool]:
        """Compare the contacts now with the truth; returns whether there are some, and whether there must not be any."""
        turned = rotation_matrices(self.state.orientation)
        found = self.detector.detect(self.state.position, turned, self.velocity, STEP, self.slack, np.zeros(3))
        corners = parts_in_world(self.assembly.shapes, self.state.position, turned)
        apart, rounding = signed_distance(*corners), 1e-9 * (1.0 + self.margin)
        if apart > self.margin + rounding:
            assert len(found.gap) == 0
        if len(found.gap):
            assert found.gap.min() >= min(0.0, apart) - ALLOWED * self.width
            assert shortfall(found, self.detector, corners).max() <= rounding
        return len(found.gap) > 0, apart > self.margin

    def go_on(self, rng: np.random.Generator) -> None:
        """Move the second part by its velocity for a step; what forces may add, and how fast it is then, may change."""
        v = self.velocity[1]
        self.state.position[1] += STEP * v[:3]
        self.state.orientation[1] = times(turn(v[3:], STEP * np.linalg.norm(v[3:])), self.state.orientation[1])
        if self.swaying:
            self.phase += rng.uniform(0.2, 0.45)
            lean = self.nearly * np.array([np.cos(self.phase), np.sin(self.phase), 0.0])
            self.state.orientation[1] = times(self.state.orientation[0], turn(lean, self.nearly))
        if rng.random() < 0.5:
            self.slack = 10.0 ** rng.uniform(-6.0, 0.0)
            v *= 10.0 ** rng.uniform(-4.0, 0.0)


@given(SEED)
def test_parts_that_pass_each_other_have_the_contacts_of_where_they_are(seed: int) -> None:
    """Apart by more than the margin none, and never a gap below what separates the parts, or deeper than they are in each other."""
    rng = np.random.default_rng(seed)
    pair = Passing(rng)
    for _ in range(10):
        pair.check()
        pair.go_on(rng)


def test_the_random_pairs_are_near_and_far_and_deep_in_each_other() -> None:
    seen, depths = np.zeros(2), []
    for seed in range(60):
        pair = Passing(np.random.default_rng(seed))
        seen += pair.check()
        depths.append(
            signed_distance(*parts_in_world(pair.assembly.shapes, pair.state.position, rotation_matrices(pair.state.orientation)))
        )
    assert seen.min() > 10
    assert (np.array(depths) < -1e-2).sum() > 5


@pytest.mark.parametrize("seen_from", [0.36, 0.39, 0.6])
@pytest.mark.parametrize("angle", [1e-7, 1e-5, 1e-3, 1e-2])
def test_nearly_parallel_edges_far_apart_do_not_touch_however_they_turn(angle: float, seen_from: float) -> None:
    """Upright webs that stand corner to corner, 0.4 m apart, seen first from afar, lean by small angles that change from step to step."""
    rng = np.random.default_rng(5)
    pair = Passing(rng)
    web = np.array([[x, y, z] for z in (0.0, 2.0) for y in (0.0, 0.05) for x in (0.0, 0.5)])
    faces = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5))
    blocks = [Block("a", web, faces, 2000.0, "base", True), Block("b", web + [0.7, 0.4, 0.1], faces, 2000.0)]
    pair.assembly = Assembly.from_blocks(blocks, 0.6)
    pair.detector, pair.state, pair.slack, pair.velocity = Detector(pair.assembly), State.at_rest(pair.assembly), 1e-3, np.zeros((2, 6))
    start = pair.state.copy()
    for k in range(100):
        pair.slack = seen_from if k % 25 == 0 else 1e-3
        pair.state.orientation[1] = turn(np.array([np.cos(0.3 * k), np.sin(0.3 * k), 0.1]), angle)
        pair.state.position[1] = start.position[1] + 1e-6 * rng.normal(size=3)
        touching, far = pair.check()
        assert far != (pair.slack > 0.403)
        assert not (touching and far)
