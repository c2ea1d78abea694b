# SPDX-License-Identifier: GPL-3.0-or-later
"""A team of threads that share a solve.

They all run one kernel on the same arrays. Each takes its share of the subtrees of a :class:`SymbolicFactor` and waits at a barrier where
it needs what the others compute; decisions are taken by all of them alike, from the same numbers. Which thread takes what never enters a
result: a sum over subtrees is taken in their order. So equal inputs give equal bits with any number of threads, and with one the same code
runs without waiting.

The kernels release Python's lock, so Python's own threads run them, and nothing is compiled twice.

A thread that ends with an error never comes to the next barrier. It says so there, and those that wait for it end as well.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from threading import Lock
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.intrinsics import atomic_add, atomic_load, yield_processor

LINE = 8  # entries of an array that begin together on a line of the cache
HERE, PASSED, ABANDONED = 0, 1, 2  # entries of a barrier
_ONE_TEAM = Lock()  # at a time: two teams, each waiting for threads that the other one has, would wait for ever


class ThreadTeam(NamedTuple):
    """Place of a thread in its team."""

    rank: int  # of this thread, from 0
    size: int  # number of threads
    barrier: np.ndarray  # (3,) shared: how many threads wait, how often all have passed, whether one has ended with an error


@kernel()
def alone():
    """A team of one thread."""
    return ThreadTeam(0, 1, np.zeros(3, dtype=np.int64))


class TeamAbandoned(RuntimeError):
    """Another thread of the team has ended with an error, which is the one to report."""


@borrower()
def wait(team):
    """Go on when all threads of the team are here.

    Raises:
        TeamAbandoned: one of them will never be.
    """
    if team.size == 1:
        return
    passed = atomic_load(team.barrier, PASSED)
    if atomic_add(team.barrier, HERE, 1) == team.size - 1:
        team.barrier[HERE] = 0
        atomic_add(team.barrier, PASSED, 1)
    while atomic_load(team.barrier, PASSED) == passed:
        if atomic_load(team.barrier, ABANDONED) != 0:
            raise TeamAbandoned("another thread of the team has ended with an error")
        yield_processor()


@borrower(forceinline=True)
def share_of(team, first, end):
    """First and end of the thread's share of a range."""
    count = end - first
    return first + count * team.rank // team.size, first + count * (team.rank + 1) // team.size


class SharedArena(NamedTuple):
    """Memory of a team, which kernels take piece by piece, see :func:`take`."""

    values: np.ndarray  # (L,) shared, zeros; (0,): what is taken is the thread's own
    used: np.ndarray  # (1,) entries taken so far; of each thread its own


@kernel()
def take(arena, shape):
    """Zeros of a shape, in a tuple. All threads of a team get the same array if each takes the same shapes, one after another."""
    begin, count = arena.used[0], 1
    for length in shape:
        count *= length
    arena.used[0] += (count + LINE - 1) // LINE * LINE
    if len(arena.values) == 0:
        return np.zeros(shape)
    return arena.values[begin : begin + count].reshape(shape)


@kernel()
def own_arena():
    """:class:`SharedArena` of a thread alone; ``used`` tells afterwards how much a team would need."""
    return SharedArena(np.empty(0), np.zeros(1, dtype=np.int64))


def run_by_team(kernel: Callable[..., Any], size: int, *arguments: Any) -> Any:
    """Call ``kernel(team, *arguments)`` on each of ``size`` threads at once, the calling one among them; what the calling one returns.

    Where a thread ends with an error all of them end, and the first such error, in the order of their ranks, is raised.
    """
    barrier = np.zeros(3, dtype=np.int64)
    if size <= 1:
        return kernel(ThreadTeam(0, 1, barrier), *arguments)

    def member(rank: int) -> Any:
        try:
            return kernel(ThreadTeam(rank, size, barrier), *arguments)
        except BaseException:
            barrier[ABANDONED] = 1
            raise

    with _ONE_TEAM:
        out, others, errors = None, [], list[BaseException]()
        try:
            for rank in range(1, size):
                others.append(_pool(size - 1).submit(member, rank))
            out = member(0)
        except BaseException as error:
            barrier[ABANDONED] = 1  # also where a thread could not be had
            errors.append(error)
        errors += [found for found in (other.exception() for other in others) if found is not None]
    for first in sorted(errors, key=lambda found: isinstance(found, TeamAbandoned)):
        raise first
    return out


def in_shares(call: Callable[[int, int, int], Any], threads: int, count: int) -> list[Any]:
    """Return the results of ``call(rank, first, end)`` on each thread's share of a range, for kernels that treat each item on its own."""
    if threads == 1:
        return [call(0, 0, count)]
    shares = [(rank, count * rank // threads, count * (rank + 1) // threads) for rank in range(threads)]
    others = [_pool(threads - 1).submit(call, *share) for share in shares[1:]]
    return [call(*shares[0]), *(other.result() for other in others)]


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads that wait for work."""
    return ThreadPoolExecutor(threads, thread_name_prefix="solver")
