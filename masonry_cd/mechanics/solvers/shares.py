# SPDX-License-Identifier: GPL-3.0-or-later
"""Shares of the threads of a team in the passes over contacts and bodies of the methods that linearise the law.

All threads run the whole method. Each takes its share of every pass, decides by itself from the same numbers, and waits where it needs what
the others compute: a kernel that reads what is not its own begins with a wait. Sums over contacts are taken over chunks of CHUNK of them,
and then over the chunks in order, whoever did them: so the number of threads changes no bit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.threads import ThreadTeam, share_of, take, wait

CHUNK = 32  # contacts whose sum is one number
LANES = 2  # numbers that are added up at once


class Shares(NamedTuple):
    """The shares of a thread, each as its first and its end."""

    team: ThreadTeam
    chunks: tuple[int, int]  # of the contacts
    contacts: tuple[int, int]
    rows: tuple[int, int]  # of velocities, and columns of the matrix, to be assembled
    sums: np.ndarray  # (2, LANES, K) shared: a number for each chunk, or for each body, by turns
    turn: np.ndarray  # (1,) where the last were; of each thread its own


@kernel()
def allocate_sums(arena, contacts, bodies):
    """Memory for the sums of :class:`Shares`."""
    return take(arena, (2, LANES, max(-(-contacts // CHUNK), bodies)))


@kernel()
def shares_of(team, contacts, bodies, sums):
    """The :class:`Shares` of a thread."""
    first, end = share_of(team, 0, -(-contacts // CHUNK))
    own = CHUNK * first, min(CHUNK * end, contacts)
    return Shares(team, (first, end), own, share_of(team, 0, bodies), sums, np.zeros(1, dtype=np.int64))


@borrower(forceinline=True)
def chunk_of(k, contacts):
    """First and end of the contacts of chunk k."""
    return CHUNK * k, min(CHUNK * (k + 1), contacts)


@borrower()
def begin_sums(shares):
    """Where in ``sums`` the next numbers go: not where a thread may still be reading the last."""
    shares.turn[0] = 1 - shares.turn[0]
    return shares.turn[0]


@borrower()
def sum_of(shares, lane, count):
    """After a wait, the sum of a given list of numbers that went last to a lane."""
    sums, turn, total = shares.sums, shares.turn[0], 0.0
    for k in range(count):
        total += sums[turn, lane, k]
    return total


@borrower()
def sum_of_chunks(shares, lane, contacts):
    """:func:`sum_of` one number for each chunk of a given number of contacts."""
    return sum_of(shares, lane, -(-contacts // CHUNK))


@borrower()
def least_of_chunks(shares, contacts):
    """After a wait, the least of the numbers that went last to the first lane, and the first chunk that has it.

    Infinity and -1 where no number is less.
    """
    sums, turn, best, which = shares.sums, shares.turn[0], np.inf, -1
    for k in range(-(-contacts // CHUNK)):
        if sums[turn, 0, k] < best:
            best, which = sums[turn, 0, k], k
    return best, which


@borrower()
def any_of(shares, own, contacts):
    """Return True if something holds for any of the threads that have contacts, when all threads are here."""
    turn, (first, end) = begin_sums(shares), shares.chunks
    for k in range(first, end):
        shares.sums[turn, 0, k] = 1.0 if own else 0.0
    wait(shares.team)
    return sum_of_chunks(shares, 0, contacts) > 0.0


@borrower()
def copy_share(share, source, target):
    """The thread's share of target = source, both contiguous and of one shape."""
    first, end = share
    copy_flat(source[first:end], target[first:end])


@borrower()
def add_share(share, x, step, change, out):
    """The thread's share of out = x + step change, all contiguous and of one shape but for the length."""
    size = out.size // len(out)
    x, change, out = x.reshape(x.size), change.reshape(change.size), out.reshape(out.size)
    for i in range(share[0] * size, share[1] * size):
        out[i] = x[i] + step * change[i]
