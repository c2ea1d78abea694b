"""Ghost rows: what a subtree leaves to nodes of later subtrees, see symbolic.py."""

from __future__ import annotations

from masonry_cd.jit import kernel
from masonry_cd.linalg.threads import share_of


@kernel()
def nodes_of(plan, q):
    """First node of a part and the one after its last."""
    return plan.first[plan.part[q]], plan.first[plan.part[q + 1]]


@kernel()
def clear_ghosts(plan, q, values):
    """Nothing left by part q to later ones; values (N + 1 + E, ...)."""
    size = len(plan.spread)
    values[size + plan.border[q] : size + plan.border[q + 1]] = 0.0


@kernel()
def add_ghosts(plan, q, values):
    """Add to the nodes of part q what earlier parts left to them."""
    begin, end = nodes_of(plan, q)
    for j in range(begin, end):
        for e in range(plan.spread[j], plan.spread[j + 1]):
            for i in range(values.shape[1]):
                values[j, i] += values[plan.copies[e], i]


@kernel()
def share_of_subtrees(team, plan):
    """The thread's share of all parts."""
    return share_of(team, 0, len(plan.part) - 1)
