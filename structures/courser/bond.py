# SPDX-License-Identifier: GPL-3.0-or-later
"""Running bond: head joints of one course lie over the middles of the stones below.

A course between two ends that are given is divided evenly; one of a wall that goes on beyond is counted from where its bond begins. Its end
stones are not too short, and its head joints keep clear of those of the courses below and above: a short overlap is no bond.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

SAME = 1e-9  # [m]
LEAST_HEAD = 0.35  # between a head joint and the end of its course, in blocks
LEAST_BOND = 0.12  # between head joints of successive courses, in blocks


def even(low: float, high: float, count: int, odd: bool) -> list[float]:
    """Head joints of a course of ``count`` blocks between two places [m]; an odd course has half a block at each end."""
    shift = 0.5 if odd else 0.0
    return [low + (high - low) * (i + shift) / count for i in range(0 if odd else 1, count)]


def running(low: float, high: float, unit: float, start: float) -> list[float]:
    """Head joints of a course between two places, whole blocks from where its bond begins [m]."""
    first, last = math.ceil((low - start - SAME) / unit), math.floor((high - start + SAME) / unit)
    return [start + k * unit for k in range(first, last + 1)]


def cleared(x: float, met: Sequence[float], least: float, ends: tuple[float, float]) -> float:
    """A head joint that nearly meets one of the next course, moved to the least distance from it where there is space for that [m].

    Args:
        x: its place [m].
        met: those of the courses below and above [m].
        least: distance from each [m].
        ends: between which it may move [m].
    """
    near = [t for t in met if abs(t - x) < least - SAME]
    moved = [m for t in near for m in (t - least, t + least) if ends[0] <= m <= ends[1]]
    free = [m for m in moved if all(abs(m - t) >= least - SAME for t in met)]
    return min(free or [x], key=lambda m: abs(m - x))
