# SPDX-License-Identifier: GPL-3.0-or-later
"""A seeded random order of contacts."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import borrower, kernel


@kernel(inline="always")
def next_random(state: np.ndarray) -> np.uint64:
    """Next number of a xorshift64* generator (Marsaglia, J. Stat. Softw. 8, 2003; Vigna, ACM Trans. Math. Softw. 42, 2016)."""
    x = state[0]
    x ^= x >> np.uint64(12)
    x ^= x << np.uint64(25)
    x ^= x >> np.uint64(27)
    state[0] = x
    return x * np.uint64(2685821657736338717)


@kernel()
def seeded(seed: int) -> np.ndarray:
    """Generator state for a seed, scrambled so that small seeds differ at once; never zero."""
    state = np.empty(1, dtype=np.uint64)
    state[0] = (np.uint64(seed) + np.uint64(1)) * np.uint64(11400714819323198485) | np.uint64(1)
    for _ in range(4):
        next_random(state)
    return state


@borrower()
def shuffle(order: np.ndarray, state: np.ndarray) -> None:
    """Fisher-Yates shuffle; the 32 high bits times the range replace a division."""
    for i in range(len(order) - 1, 0, -1):
        j = np.int64(((next_random(state) >> np.uint64(32)) * np.uint64(i + 1)) >> np.uint64(32))
        order[i], order[j] = order[j], order[i]
