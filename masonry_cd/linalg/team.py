"""Runs a compiled kernel on several threads that share its work, see "a team of threads" in ``coulomb``.

No thread is started for a plan of one part. The kernels release Python's lock, so its own threads do, and nothing is compiled twice.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from threading import Lock
from typing import Any

import numpy as np

from masonry_cd.linalg.symbolic import SymbolicFactor
from masonry_cd.linalg.threads import ThreadTeam

_ONE_TEAM = Lock()  # at a time: two that wait for the threads that the other one has would wait for ever


def together(kernel: Callable[..., Any], threads: int, plan: SymbolicFactor, *arguments: Any) -> Any:
    """``kernel(team, *arguments)`` on up to so many threads, as far as the first level of a plan has parts for them; what the first
    thread returns."""
    size, gate = min(threads, int(plan.level[1])), np.zeros(3, dtype=np.int64)
    if size <= 1:
        return kernel(ThreadTeam(0, 1, gate), *arguments)
    with _ONE_TEAM:
        others = [_pool(size - 1).submit(kernel, ThreadTeam(rank, size, gate), *arguments) for rank in range(1, size)]
        out = kernel(ThreadTeam(0, size, gate), *arguments)
        for other in others:
            other.result()
    return out


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """So many threads that wait for work."""
    return ThreadPoolExecutor(threads, thread_name_prefix="solver")
