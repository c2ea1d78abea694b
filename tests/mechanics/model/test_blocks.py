# SPDX-License-Identifier: GPL-3.0-or-later
"""Exact mass properties, the friction table, and the flat arrays that detection reads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from models import box, ground, tower
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components as by_scipy

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly, CarriedLoad
from masonry_cd.mechanics.model.components import connected_components
from masonry_cd.mechanics.model.geometry import mass_properties
from masonry_cd.mechanics.model.polygon import clip, clip_loops, polygon_centroid
from masonry_cd.mechanics.model.state import rotation_matrices


def test_box_has_its_textbook_inertia_wherever_it_stands():
    block = box("b", (100.0, -50.0, 3.0), (102.0, -49.0, 6.0))
    p = mass_properties(block.vertices, block.faces)
    assert p.volume == pytest.approx(6.0, rel=1e-13)
    assert p.centre == pytest.approx([101.0, -49.5, 4.5], rel=1e-13)
    assert np.diag(p.unit_inertia) == pytest.approx([6 / 12 * (1 + 9), 6 / 12 * (4 + 9), 6 / 12 * (4 + 1)], rel=1e-12)
    assert np.abs(p.unit_inertia - np.diag(np.diag(p.unit_inertia))).max() < 1e-11


def test_a_pyramid_has_its_centre_at_a_quarter_and_a_triangle_at_a_third_of_its_height():
    """Neither is the mean of the corners' heights."""
    base = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 3]], dtype=float) + [5.0, -2.0, 1.0]
    p = mass_properties(base, ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)))
    assert p.volume == pytest.approx(1.0)
    assert p.centre == pytest.approx([5.5, -1.5, 1.75])
    cut = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 3.0]])  # a corner in the middle of a side counts for nothing
    assert polygon_centroid(cut + [5.0, -2.0]) == pytest.approx([5.0 + 2.0 / 3.0, -1.0])


def test_tetrahedron_has_the_inertia_of_its_closed_form():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    p = mass_properties(vertices, ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)))
    assert p.volume == pytest.approx(1 / 6, rel=1e-14)
    assert p.centre == pytest.approx([0.25] * 3, rel=1e-14)
    second = 1 / 60 - (1 / 6) / 16  # of x x about the centre
    mixed = 1 / 120 - (1 / 6) / 16
    assert p.unit_inertia == pytest.approx(2 * second * np.eye(3) - mixed * (np.ones((3, 3)) - np.eye(3)), rel=1e-12)


def test_inertia_turns_with_the_block():
    block = box("b", (0, 0, 0), (2.0, 1.0, 3.0))
    turn = rotation_matrices(np.array([[0.8, 0.36, 0.48, 0.0]]))[0]
    straight = mass_properties(block.vertices, block.faces).unit_inertia
    turned = mass_properties(block.vertices @ turn.T, block.faces).unit_inertia
    assert turned == pytest.approx(turn @ straight @ turn.T, abs=1e-12)


def test_a_reversed_shell_has_a_negative_volume():
    block = box("b", (0, 0, 0), (1, 1, 1))
    assert mass_properties(block.vertices, tuple(face[::-1] for face in block.faces)).volume == pytest.approx(-1.0)


def test_every_edge_of_a_box_is_listed_once_with_its_two_faces():
    solids = Assembly.from_blocks(tower(1), 0.6).shapes.solids
    assert np.diff(solids.edge_start).tolist() == [12, 12]
    assert len({tuple(sorted(edge[:2])) for edge in solids.edges.tolist()}) == 24
    direction = solids.vertices[solids.edges[:, 1]] - solids.vertices[solids.edges[:, 0]]
    across = np.cross(solids.normals[solids.edges[:, 2]], solids.normals[solids.edges[:, 3]])
    assert np.abs(np.cross(direction, across)).max() < 1e-12  # an edge runs along both of its faces


def test_two_blocks_of_one_name_are_refused():
    with pytest.raises(InputError, match='block "b"'):
        Assembly.from_blocks([box("b", (0, 0, 0), (1, 1, 1)), box("b", (2, 0, 0), (3, 1, 1))], 0.6)
    with pytest.raises(InputError, match="no free block"):
        Assembly.from_blocks([ground()], 0.6)


def test_polygons_are_clipped_corner_by_corner_and_those_beyond_the_plane_go():
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    points, start = np.concatenate([square, square + [5.0, 0.0], square - [1.5, 0.0]]), np.array([0, 4, 8, 12])
    left, starts, rows = clip_loops(points, start, 1.0 - points[:, 0])  # what lies at x < 1
    assert rows.tolist() == [0, 2]
    assert starts.tolist() == [0, 4, 8]
    assert left[:4].tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]  # the point on a side follows the corner before it
    assert left[4:].tolist() == (square - [1.5, 0.0]).tolist()
    assert clip(square, np.array([1.0, -1e-9, -1e-9, 1.0]), 1e-8).tolist() == square.tolist()  # on the plane


def test_components_are_numbered_by_their_lowest_nodes():
    assert connected_components(np.array([4, 2, 5]), np.array([2, 0, 3]), 7).tolist() == [0, 1, 0, 2, 0, 2, 3]


def test_a_graph_without_links_has_a_component_for_each_node():
    none = np.empty(0, dtype=np.int64)
    assert connected_components(none, none, 3).tolist() == [0, 1, 2]
    assert connected_components(none, none, 0).tolist() == []


def test_components_are_those_of_scipy():
    random = np.random.default_rng(7)
    for _ in range(100):
        nodes, links = int(random.integers(1, 60)), int(random.integers(0, 60))
        first, second = random.integers(0, nodes, links), random.integers(0, nodes, links)
        expected = by_scipy(coo_array((np.ones(links), (first, second)), shape=(nodes, nodes)), directed=False)[1]
        assert connected_components(first, second, nodes).tolist() == expected.tolist()


def test_a_block_that_carries_another_one_has_mass_centre_and_inertia_of_both() -> None:
    """Halves of a box, of which one rides on the other: the box by its closed form."""
    lower, upper, both = (box(name, (0.0, 0.0, low), (1.0, 2.0, high)) for name, low, high in (("a", 0, 1), ("b", 1, 3), ("c", 0, 3)))
    of_upper, whole = upper.mass_properties, both.mass_properties
    load = CarriedLoad(2000.0 * of_upper.volume, of_upper.centre, 2000.0 * of_upper.unit_inertia)
    found = replace(lower, carried=load).mass_properties
    assert found.volume == pytest.approx(whole.volume)
    assert found.centre == pytest.approx(whole.centre)
    assert found.unit_inertia == pytest.approx(whole.unit_inertia)
