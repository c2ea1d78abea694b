# SPDX-License-Identifier: GPL-3.0-or-later
"""Flaws that instruments, transmission and files leave in a record: spikes, clipped peaks, gaps.

    spike       a sample or two that stand out from their neighbours, |a - median of five|, by SPIKE times what any others do, and that
                set the PGA
    clipped     three samples or more in a row at the largest or the smallest value, which the series leaves by more than the top of a
                smooth wave could: a parabola that stays within q of its top for n > 2 samples is 1.8 q lower one sample on
    gap         one value for GAP seconds while it shakes on both sides, which the series enters or leaves by a leap

Each shows in the samples alone, whatever their scale. Of 124 recorded components, at 50 to 200 Hz, none has a flaw by these bounds: what
stands out most does so at most 2.3 times as far as what does next.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

SPIKE = 3.0  # times as far as all others
SPIKES = 5  # at most: more are noise
LOWER = 0.95  # share of the PGA that is left without the spikes: a spike above does no harm
BROAD = 2  # samples on both sides of a spike that may be of it
FLAT = 3  # samples in a row at a peak
LEVEL = 1e-3  # of the PGA: what counts as one height
LEAVES = 4.0  # times the resolution, or the level: by more than that no smooth wave leaves its top
GAP, FEWEST = 0.1, 8  # [s] and samples of one value
EQUAL = 1e-6  # of the PGA: what counts as one value
SHAKES = 0.05  # of the PGA: root mean square on either side of a gap


def spikes(values: np.ndarray) -> tuple[np.ndarray, float]:
    """Indices of the spikes of accelerations (n,), and the PGA without them; none where there are none."""
    from scipy import ndimage  # takes a while to load

    centred = values - np.median(values)
    peak = float(np.abs(centred).max())
    off = np.abs(centred - ndimage.median_filter(centred, 2 * BROAD + 1, mode="nearest"))
    left, found, height = off.copy(), list[int](), list[float]()
    while len(found) <= SPIKES and left.any():
        worst = int(np.argmax(left))
        found.append(worst)
        height.append(float(left[worst]))
        left[max(0, worst - BROAD) : worst + BROAD + 1] = 0.0
    several = next((n for n in range(len(found) - 1, 0, -1) if height[n - 1] > SPIKE * height[n]), 0)
    sound = np.ones(len(values), dtype=bool)
    for k in found[:several]:
        sound[max(0, k - BROAD) : k + BROAD + 1] = False
    rest = float(np.abs(centred[sound]).max(initial=0.0))
    if not EQUAL * peak < rest < LOWER * peak:
        return np.array([], dtype=np.int64), peak
    return np.sort(np.array(found[:several], dtype=np.int64)), rest


def flat_tops(values: np.ndarray) -> list[int]:
    """Indices at which clipped peaks of accelerations (n,) begin."""
    low, high = float(values.min()), float(values.max())
    if not low < 0.0 < high or len(np.unique(values)) <= FLAT:  # a pulse of one sign, or of steps
        return []
    level = LEVEL * max(high, -low)
    within = LEAVES * max(level, _resolution(values))
    found = []
    for side in (values, -values):
        top = float(side.max())
        for first, last in _runs(side >= top - level):
            neighbours = side[[k for k in (first - 1, last) if 0 <= k < len(side)]]
            if last - first >= FLAT and len(neighbours) == 2 and (top - neighbours > within).all():
                found.append(first)
    return sorted(found)


def gaps(values: np.ndarray, step: float, peak: float) -> list[tuple[int, int]]:
    """First and last + 1 of the samples of accelerations (n,) that keep one value while it shakes on both sides.

    Args:
        values: [m/s2].
        step: [s].
        peak: the PGA, without spikes [m/s2].
    """
    needed = max(FEWEST, round(GAP / step))
    if len(np.unique(values)) <= FLAT:
        return []
    leap, low, high = LEAVES * _resolution(values), float(values.min()), float(values.max())  # at which it would be clipped
    found = []
    for first, last in _runs(np.abs(np.diff(values)) <= EQUAL * peak):
        last += 1
        before, after = values[max(0, first - needed) : first], values[last : last + needed]
        if last - first < needed or not len(before) or not len(after) or not low < values[first] < high:
            continue
        jumps = max(abs(before[-1] - values[first]), abs(after[0] - values[first]))
        if min(_rms(before - values[first]), _rms(after - values[first])) > SHAKES * peak and jumps > leap:
            found.append((first, last))
    return found


def _runs(true: np.ndarray) -> Iterator[tuple[int, int]]:
    """First and last + 1 of each run of a mask (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], true, [False]]).astype(np.int8)))
    return zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _resolution(values: np.ndarray) -> float:
    """The least difference of two samples that differ."""
    steps = np.diff(np.unique(values))
    return float(steps.min(initial=np.inf)) if len(steps) else 0.0


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
