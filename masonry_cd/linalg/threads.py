"""A team of threads that share a solve.

They all run the same kernel on the same arrays. Each takes its share of the subtrees of a :class:`SymbolicFactor` and waits at a barrier
where it needs what the others compute; decisions are taken by all of them alike, from the same numbers. Which thread takes what never
enters a result: a sum over subtrees is taken in their order. So equal inputs give equal bits with any number of threads, and with one the
same code runs without waiting.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.jit import kernel
from masonry_cd.linalg.intrinsics import atomic_add, atomic_load, yield_processor


class ThreadTeam(NamedTuple):
    """What a thread knows of the others."""

    rank: int
    size: int
    gate: np.ndarray  # (3,) of all: how many wait, how often all were through, whether a factorisation failed


@kernel()
def wait(team):
    """Go on when all threads of the team are here."""
    if team.size == 1:
        return
    turn = atomic_load(team.gate, 1)
    if atomic_add(team.gate, 0, 1) == team.size - 1:
        team.gate[0] = 0
        atomic_add(team.gate, 1, 1)
    while atomic_load(team.gate, 1) == turn:
        yield_processor()


@kernel(inline="always")
def share_of(team, first, end):
    """The thread's share of a range."""
    count = end - first
    return first + count * team.rank // team.size, first + count * (team.rank + 1) // team.size
