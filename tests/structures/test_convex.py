# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks split into convex parts: exactly, in few parts, and only where they need it."""

from __future__ import annotations

import numpy as np
import pytest
from models import box

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.geometry import Faces, mass_properties, triangles
from structures.geometry.checks import check
from structures.geometry.convex import is_convex, split
from structures.geometry.prism import prism_xz

ELL = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
CROSS = [(1, 0), (2, 0), (2, 1), (3, 1), (3, 2), (2, 2), (2, 3), (1, 3), (1, 2), (0, 2), (0, 1), (1, 1)]
ANGLES = np.linspace(0.0, np.pi, 9)
ARCH = [(r * np.cos(a), r * np.sin(a)) for r, turn in ((1.0, 1), (1.3, -1)) for a in ANGLES[::turn]]
STAR = [(r * np.cos(k * np.pi / 5), r * np.sin(k * np.pi / 5)) for k, r in enumerate(5 * (1.0, 0.45))]
TURN = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]


def prism(polygon: object) -> Block:
    """A prism turned out of all planes, far from the origin."""
    vertices, faces = prism_xz(np.array(polygon, dtype=float), 0.0, 0.7)
    turn = TURN * np.sign(np.linalg.det(TURN))
    return Block("b", vertices @ turn + [100.0, 50.0, 3.0], faces, 2000.0)


def fans(faces: Faces) -> Faces:
    """The faces of the L as triangles, those of its ends from the inner corner, which is vertex 3 of either."""
    turns = [next((k for k, vertex in enumerate(face) if len(face) == 6 and vertex % 6 == 3), 0) for face in faces]
    turned = tuple(face[k:] + face[:k] for face, k in zip(faces, turns, strict=True))
    return tuple(tuple(map(int, corners)) for corners in triangles(turned))


def volume(part: object) -> float:
    return mass_properties(part.vertices, part.faces).volume


@pytest.mark.parametrize(
    ("polygon", "parts"),
    [(ELL, 2), (CROSS, 3), (ARCH, 8), (STAR, 6)],
    ids=["ell", "cross", "arch", "star"],
)
def test_the_parts_fill_the_block_and_are_few(polygon: object, parts: int) -> None:
    block = split(prism(polygon))
    check([block])
    assert len(block.parts) == parts
    assert sum(volume(part) for part in block.parts) == pytest.approx(volume(block), rel=1e-12)


@pytest.mark.parametrize("polygon", [ELL, CROSS, ARCH, STAR], ids=["ell", "cross", "arch", "star"])
def test_faces_that_are_not_convex_become_triangles(polygon: object) -> None:
    """Fans of all faces then cover each face once: the sum of their areas is that of the shell, and no triangle is turned over."""
    block = prism(polygon)
    shell = split(block)
    areas = [np.cross(*(block.vertices[[b, c]] - block.vertices[a])) for a, b, c in triangles(shell.faces)]
    flat = 2 * _area(polygon) + 0.7 * np.linalg.norm(np.diff([*polygon, polygon[0]], axis=0), axis=1).sum()
    assert 0.5 * np.linalg.norm(areas, axis=1).sum() == pytest.approx(flat, rel=1e-12)
    assert volume(shell) == pytest.approx(volume(block), rel=1e-12)


def _area(polygon: object) -> float:
    x, y = np.array(polygon, dtype=float).T
    return abs(0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def test_triangles_make_the_same_parts_as_polygons() -> None:
    block = prism(ELL)
    soup = Block("b", block.vertices, fans(block.faces), 2000.0)
    assert [len(part.faces) for part in split(soup).parts] == [6, 6]


def test_parts_of_one_block_do_not_overlap() -> None:
    block = split(prism(CROSS))
    check([Block(f"p{k}", part.vertices, part.faces, 2000.0) for k, part in enumerate(block.parts)])


def test_a_hollow_block_keeps_its_hole() -> None:
    outer, inner = box("b", (0.0, 0.0, 0.0), (3.0, 3.0, 3.0)), box("b", (1.0, 1.0, 1.0), (2.0, 2.0, 2.0))
    faces = (*outer.faces, *(tuple(8 + i for i in reversed(face)) for face in inner.faces))
    block = split(Block("b", np.concatenate([outer.vertices, inner.vertices]), faces, 2000.0))
    check([block])
    assert sum(map(volume, block.parts)) == pytest.approx(26.0, rel=1e-12)


def test_a_convex_block_is_left_alone() -> None:
    block = prism([(0, 0), (2, 0), (2, 1), (0, 1)])
    assert is_convex(block)
    assert split(block) is block
