# SPDX-License-Identifier: GPL-3.0-or-later
"""Beds: the heights that walls of one height of course share.

Feet, tops and the corners of gables come first, then sills, springings and lintels, those that more openings have before the others. One
that is closer to another than LEAST of a course has no bed of its own: its courses are cut there.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from structures import size
from structures.layout.wall_plan import LEAST_COURSE, even

SAME = 1e-9  # [m]


def beds(walls: Iterable[float], openings: Iterable[float], course: float, seed: int | None = None) -> np.ndarray:
    """Heights of the beds (N + 1,), ascending [m].

    Args:
        walls: heights of feet, tops and corners of gables [m].
        openings: heights of sills, springings and the like [m].
        course: height aimed at [m].
        seed: of courses that vary; None for even ones.
    """
    hard, soft = (Counter(round(z, 9) for z in levels) for levels in (walls, openings))
    low, high = min(hard), max(hard)
    size.within((high - low) / course, "course_height")
    kept = [low, high]
    ordered = [*sorted(hard, key=lambda z: (-hard[z], z)), *sorted(soft, key=lambda z: (-soft[z], z))]
    for z in ordered:
        if low < z < high and min(abs(z - other) for other in kept) > LEAST_COURSE * course - SAME:
            kept.append(z)
    return even(sorted(kept), course, None if seed is None else np.random.default_rng(seed))


def course_range(levels: Sequence[float] | np.ndarray, low: float, high: float) -> range:
    """The courses of which anything lies between two heights."""
    z = np.asarray(levels)
    return range(int(np.searchsorted(z, low + SAME, side="right")) - 1, int(np.searchsorted(z, high - SAME, side="left")))
