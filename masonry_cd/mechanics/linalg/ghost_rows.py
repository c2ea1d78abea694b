# SPDX-License-Identifier: GPL-3.0-or-later
"""Ghost rows: what a subtree adds to nodes of later subtrees, kept apart until these are reached, see symbolic.py.

Arrays with ghost rows have N + 1 + E rows: the nodes, the supports, and the ghosts.
"""

from __future__ import annotations

from masonry_cd.foundation.jit import borrower
from masonry_cd.mechanics.linalg.threads import share_of


@borrower()
def nodes_of(symbolic, q):
    """First node of subtree q and the one after its last."""
    return symbolic.first[symbolic.subtree[q]], symbolic.first[symbolic.subtree[q + 1]]


@borrower()
def clear_ghosts(symbolic, q, values):
    """Set the ghost rows of subtree q to zero in values (N + 1 + E, ...)."""
    size = len(symbolic.node_start)
    values[size + symbolic.ghost_start[q] : size + symbolic.ghost_start[q + 1]] = 0.0


@borrower()
def add_ghosts(symbolic, q, values):
    """Add the ghost rows of earlier subtrees to the nodes of subtree q, in values (N + 1 + E, k)."""
    begin, end = nodes_of(symbolic, q)
    for j in range(begin, end):
        for e in range(symbolic.node_start[j], symbolic.node_start[j + 1]):
            for i in range(values.shape[1]):
                values[j, i] += values[symbolic.node_ghost[e], i]


@borrower()
def share_of_subtrees(team, symbolic):
    """First and end of the thread's share of all subtrees."""
    return share_of(team, 0, len(symbolic.subtree) - 1)
