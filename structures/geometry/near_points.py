# SPDX-License-Identifier: GPL-3.0-or-later
"""Points that lie so close to each other that they are one."""

from __future__ import annotations

import numpy as np


def first_of_near(points: np.ndarray, distance: float) -> np.ndarray:
    """For each point (n, 3) the number of the first one near it, or near one that is near it, and so on (n,); its own where none is."""
    from scipy.sparse import coo_array  # takes as long to load as a small run
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(distance, output_type="ndarray")
    near = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    _, group = connected_components(near, directed=False)
    return np.unique(group, return_index=True)[1][group]


def numbered(points: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Points closer than a distance once, and the number of each."""
    used, numbers = np.unique(first_of_near(points, distance), return_inverse=True)
    return points[used], numbers.ravel()
