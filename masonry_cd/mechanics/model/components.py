# SPDX-License-Identifier: GPL-3.0-or-later
"""Connected components of a graph, without scipy's graphs, which take longer to load than a small run takes."""

from __future__ import annotations

import numpy as np


def connected_components(first: np.ndarray, second: np.ndarray, count: int) -> np.ndarray:
    """Number of the component (count,) that each node is in, from 0 on in the order of their lowest nodes.

    Args:
        first: (L,) one node of each link.
        second: (L,) the other one.
        count: of the nodes.
    """
    root = np.arange(count)
    while True:
        a, b = root[first], root[second]
        if (a == b).all():
            return np.unique(root, return_inverse=True)[1].reshape(count)
        low = np.minimum(a, b)
        np.minimum.at(root, a, low)
        np.minimum.at(root, b, low)
        while (root != root[root]).any():
            root = root[root]
