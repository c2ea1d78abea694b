# SPDX-License-Identifier: GPL-3.0-or-later
r"""The motions of the supports, from all tables together.

Support s follows the sum over the tables  v_s(t) = sum_i share_is v_i(t - delay_is). Supports whose delays and shares agree in every table
have one motion: it is computed once, and the assembly's ``support_of`` says which block follows which.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from loads.motion import Part, RunGrid
from masonry_cd.foundation.errors import InputError

LARGEST = 4e9  # bytes that the motions of the supports may take


def support_motions(parts: Sequence[Part], grid: RunGrid) -> tuple[np.ndarray, np.ndarray | None]:
    """The distinct motions of the supports and which block follows which.

    Args:
        parts: what the tables contribute.
        grid: the run.

    Returns:
        Velocities (N + 1, S, 3) [m/s], and ``support_of`` (B,), -1 for a free block; None without an assembly.

    Raises:
        InputError: more motions than memory should be asked for.
    """
    moving = [part for part in parts if part.motion is not None]
    delays, shares, support_of = _distinct(moving, grid)
    size = 24.0 * (grid.steps + 1) * len(delays)
    if size > LARGEST:
        many = f"{len(delays)} supports that each move on their own take {size / 1e9:.1f} GB over {grid.steps} steps"
        raise InputError("loads", f"{many}; name fewer groups, or shorten the run")
    velocity = np.zeros((grid.steps + 1, len(delays), 3))
    for i, part in enumerate(moving):
        assert part.motion is not None
        done: dict[float, np.ndarray] = {}
        for s, (delay, share) in enumerate(zip(delays[:, i], shares[:, i], strict=True)):
            if share == 0.0:
                continue
            if delay not in done:
                done = {delay: part.motion(grid.times - delay)}  # only the last is kept: rows are sorted by delay
            velocity[:, s] += share * done[delay]
    return velocity, support_of


def _distinct(parts: Sequence[Part], grid: RunGrid) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Delays and shares of the distinct motions by table, (S, tables) each, and the motion of each block (B,)."""
    assembly, n = grid.assembly, len(parts)
    if assembly is None or not assembly.fixed.any():
        support_of = None if assembly is None else np.full(assembly.count, -1)
        return np.zeros((1, n)), np.ones((1, n)), support_of
    fixed = np.flatnonzero(assembly.fixed)
    table = np.zeros((len(fixed), 2 * n + 1))  # a last column of zeros, for runs in which nothing moves
    for i, part in enumerate(parts):
        table[:, i] = 0.0 if part.delay is None else part.delay[fixed]
        table[:, n + i] = 1.0 if part.share is None else part.share[fixed]
    rows, index = np.unique(table, axis=0, return_inverse=True)
    support_of = np.full(assembly.count, -1)
    support_of[fixed] = index.ravel()
    return rows[:, :n], rows[:, n : 2 * n], support_of
