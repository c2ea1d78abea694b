# SPDX-License-Identifier: GPL-3.0-or-later
"""Items sorted by small whole numbers: contacts by their bodies or subtrees, joints by their colours."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import kernel


@kernel()
def sorted_by(key, count):
    """Items in the order of their keys (I,) from 0 to ``count`` - 1, equal ones in order, and where each key begins (count + 1,)."""
    start = np.zeros(count + 1, dtype=np.int64)
    for k in key:
        start[k + 1] += 1
    for k in range(count):
        start[k + 1] += start[k]
    order, at = np.empty(len(key), dtype=np.int64), start[:-1].copy()
    for item in range(len(key)):
        order[at[key[item]]] = item
        at[key[item]] += 1
    return order, start
