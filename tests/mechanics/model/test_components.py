# SPDX-License-Identifier: GPL-3.0-or-later
"""Connected components of a graph."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components as by_scipy

from masonry_cd.mechanics.model.components import connected_components


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
