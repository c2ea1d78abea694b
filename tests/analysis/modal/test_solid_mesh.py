# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh of the united blocks, and shapes interpolated on it."""

from __future__ import annotations

import numpy as np
import pytest
from models import box, tower, wall
from scipy.spatial.transform import Rotation

from masonry_cd.analysis.modal.shapes import QuadraticShapes, RigidShapes
from masonry_cd.analysis.modal.solid_mesh import CLUSTER, solid_mesh
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block


def moved(block: Block, turn: Rotation) -> Block:
    return Block(block.name, turn.apply(block.vertices) + [3.0, -2.0, 1.0], block.faces, block.density, block.group, block.fixed)


@pytest.mark.parametrize("turned", [False, True])
def test_clusters_of_a_wall_become_one_conforming_mesh(turned: bool) -> None:
    """More blocks than one cluster holds, in any position: the volume is exact, and inner faces have two tetrahedra each."""
    blocks = wall(8, 8)
    if turned:
        blocks = [moved(block, Rotation.from_rotvec([0.3, -0.8, 0.5])) for block in blocks]
    assert len(blocks) > CLUSTER
    mesh = solid_mesh(blocks, np.zeros(len(blocks), dtype=int), 0.4)
    assert mesh.volume == pytest.approx(8 * 8 * 0.4 * 0.2 * 0.2, rel=1e-9)
    sides = np.sort(mesh.tetrahedra[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3), axis=1)
    outer = [tuple(side) for side, times in zip(*np.unique(sides, axis=0, return_counts=True), strict=True) if times == 1]
    a, b, c = mesh.points[np.array(outer)].transpose(1, 0, 2)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    assert area == pytest.approx(2 * (3.2 * 1.6 + 3.2 * 0.2 + 1.6 * 0.2), rel=1e-9)  # no inner face is left open
    held = mesh.points[mesh.triangles]
    footprint = 0.5 * np.linalg.norm(np.cross(held[:, 1] - held[:, 0], held[:, 2] - held[:, 0]), axis=1).sum()
    assert footprint == pytest.approx(3.2 * 0.2, rel=1e-9)
    assert {tuple(sorted(t)) for t in mesh.triangles.tolist()} <= set(outer)


def test_where_the_union_fails_the_blocks_are_glued(monkeypatch: pytest.MonkeyPatch) -> None:
    import gmsh

    blocks = wall(3, 3)

    def fails(*_: object) -> None:
        raise RuntimeError("no union")

    monkeypatch.setattr(gmsh.model.occ, "fuse", fails)
    mesh = solid_mesh(blocks, np.zeros(len(blocks), dtype=int), 0.4)
    assert mesh.volume == pytest.approx(3 * 3 * 0.4 * 0.2 * 0.2, rel=1e-9)
    monkeypatch.setattr(gmsh.model.occ, "addVolume", fails)
    with pytest.raises(InputError, match="modal: gmsh cannot mesh the solid of these blocks: no union"):
        solid_mesh(blocks, np.zeros(len(blocks), dtype=int), 0.4)


def test_kinds_stay_apart_with_a_common_face() -> None:
    blocks = tower(6)
    kinds = np.array([0, 0, 0, 0, 1, 1, 1])
    mesh = solid_mesh(blocks, kinds, 0.5)
    height = mesh.points[mesh.tetrahedra].mean(axis=1)[:, 2]
    assert (mesh.kind == (height > 0.75)).all()
    shared = np.intersect1d(mesh.tetrahedra[mesh.kind == 0], mesh.tetrahedra[mesh.kind == 1])
    assert len(shared) >= 4
    assert mesh.points[shared, 2] == pytest.approx(np.full(len(shared), 0.75))


def test_quadratic_shapes_interpolate_a_quadratic_field_exactly() -> None:
    from skfem import Basis, ElementTetP2, MeshTet

    mesh = solid_mesh(tower(4), np.zeros(5, dtype=int), 0.3)
    basis = Basis(MeshTet(mesh.points.T.copy(), mesh.tetrahedra.T.copy()), ElementTetP2())

    def field(p: np.ndarray) -> np.ndarray:
        x, y, z = p.T
        return np.stack([1 + x * y - z**2, 2 * z + x**2, y * z - 3 * x], axis=1)

    nodes = basis.doflocs.T.copy()
    shapes = QuadraticShapes(nodes, basis.element_dofs.T.copy(), field(nodes)[None])
    points = np.random.default_rng(1).uniform([-0.25, -0.25, 0.0], [0.25, 0.25, 1.0], (200, 3))
    values, outside = shapes.at(points)
    assert values[0] == pytest.approx(field(points), abs=1e-9)
    assert outside.max() < 1e-9
    skin = shapes.skin()
    assert skin.shapes[0] == pytest.approx(field(skin.points), abs=1e-12)
    corners = skin.points[skin.loops].reshape(-1, 3, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.einsum("fi,fi->", corners.mean(axis=1), normals) / 6 == pytest.approx(0.25)  # outward normals: the divergence theorem
    ends = skin.points[skin.edges]
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(8 * 0.5 + 4 * 1.0)  # the twelve edges of the tower


def test_rigid_shapes_turn_about_the_centroid() -> None:
    block = box("b", (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    shapes = RigidShapes([block], np.full((1, 3), 0.5), np.array([[[0.1, 0.0, 0.0]]]), np.array([[[0.0, 0.0, 0.2]]]))
    values, outside = shapes.at(np.array([[1.0, 1.0, 0.5], [2.0, 0.5, 0.5]]))
    assert values[0] == pytest.approx(np.array([[0.0, 0.1, 0.0], [0.1, 0.3, 0.0]]))
    assert outside == pytest.approx([0.0, 1.0])
    assert len(shapes.skin().edges) == 12
