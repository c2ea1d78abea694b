# SPDX-License-Identifier: GPL-3.0-or-later
"""Beds: the heights that walls of one height of course share.

Feet, tops and the corners of gables come first, then sills, springings and lintels, then crowns of arches, those that more openings have
before the others. One that is closer to another than LEAST_COURSE has no bed of its own: its courses are cut there. Walls of different
courses that meet share beds where one of them begins, or ends, at their junction.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from structures import size
from structures.building.frames import Frame

LEAST_COURSE = 0.4  # height of the lowest course between two given levels, in courses
UNEVEN = 0.25  # by how much the courses of rubble vary
SAME = 1e-9  # [m]
DIGITS = 9  # to which heights [m] are one


def beds(
    walls: Iterable[float], frames: Iterable[Frame], course: float, seed: int | None = None, shared: Iterable[float] = ()
) -> np.ndarray:
    """Heights of the beds (N + 1,), ascending [m].

    Args:
        walls: heights of feet, tops and corners of gables [m].
        frames: of all openings.
        course: height aimed at [m].
        seed: of courses that vary; None for even ones.
        shared: heights at which walls of other courses need a bed as well, however near to another [m].
    """
    frames = list(frames)
    levels = [*walls], [z for frame in frames for z in frame.levels], [z for frame in frames for z in frame.hull.bounds[1::2]]
    exact = {round(z, DIGITS): z for own in reversed(levels) for z in own}
    counts = [Counter(round(z, DIGITS) for z in own) for own in levels]
    low, high = min(counts[0]), max(counts[0])
    size.check_size((high - low) / course, "course_height")
    exact |= {round(z, DIGITS): z for z in shared}
    kept = [low, high, *sorted({z for z in exact if low < z < high} & {round(z, DIGITS) for z in shared})]
    for z in (z for count in counts for z in sorted(count, key=lambda z: (-count[z], z))):
        if low < z < high and min(abs(z - other) for other in kept) > LEAST_COURSE * course - SAME:
            kept.append(z)
    return _even([exact[z] for z in sorted(kept)], course, None if seed is None else np.random.default_rng(seed))


def _even(levels: Sequence[float], course: float, random: np.random.Generator | None = None) -> np.ndarray:
    """Beds (N + 1,) of courses of nearly one height between levels, ascending; a generator makes them vary [m]."""
    found = [levels[0]]
    for a, b in pairwise(levels):
        count = max(1, round((b - a) / course))
        rise = (b - a) * np.arange(1, count) / count
        if random is not None:
            rise += (b - a) * UNEVEN / count * (random.random(count - 1) - 0.5)
        found += [*(a + rise).tolist(), b]
    return np.array(found)


def course_range(levels: Sequence[float] | np.ndarray, low: float, high: float) -> range:
    """The courses of which anything lies between two heights."""
    z = np.asarray(levels)
    return range(int(np.searchsorted(z, low + SAME, side="right")) - 1, int(np.searchsorted(z, high - SAME, side="left")))
