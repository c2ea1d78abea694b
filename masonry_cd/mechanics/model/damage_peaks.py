# SPDX-License-Identifier: GPL-3.0-or-later
r"""The damage of one step that peaks are kept of: which blocks have fallen, which joints are hinges, how far each part drifts.

What the words mean, say :mod:`masonry_cd.analysis.damage.definitions` and :mod:`masonry_cd.analysis.damage.macro_elements`;
:mod:`masonry_cd.analysis.damage.step_peaks` fills the tables here. A part is cut into levels by the height of its blocks at rest. With
volumes V, displacements w relative to a support, and heights z at rest of the part's standing blocks at level k,

    u_k = sum V w / sum V,  z_k = sum V z / sum V          in plan [m]; level 0 is the foot of a part that stands on supports
    drift of a level    | u_k - u_j | / (z_k - z_j),       j the next level below by ``least`` or more
    drift of the part   max_k | u_k - u_0 | / height
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel


class PartTables(NamedTuple):
    """P parts of B blocks over L levels: what does not change in a run. Empty arrays have a length of zero."""

    start: np.ndarray  # (B + 1,) where the parts of each block begin in ``part``; supports belong to none
    part: np.ndarray  # (M,)
    level: np.ndarray  # (B,) of each block's centre
    volume: np.ndarray  # (B,) [m3]
    centre: np.ndarray  # (B, 3) at rest [m]
    foot: np.ndarray  # (P,) height at which a part stands on supports [m]; NaN where it stands on none
    footing_start: np.ndarray  # (P + 1,) where these supports begin in ``footing``
    footing: np.ndarray  # (K,)
    height: np.ndarray  # (P,) from the lowest to the highest corner [m]
    least: float  # height by which levels that are compared are apart [m]
    support: int  # to which displacements are relative; -1: to the ground where it was


class FallTables(NamedTuple):
    """When a joint is separated and a free block has fallen."""

    block_a: np.ndarray  # (J,)
    block_b: np.ndarray  # (J,)
    least_area: np.ndarray  # (J,) contact area up to which a joint is without contact [m2]
    apart: np.ndarray  # (J,) gap or sliding from which it is separated then [m]
    fixed: np.ndarray  # (B,) bool
    drop: np.ndarray  # (B,) by which a block has fallen [m]
    cosine: float  # of the turn from which it has
    hinged: float  # share of the opening up to which the smallest gap of a hinge reaches


class StepMeasures(NamedTuple):
    """Where B blocks are after a step, and J joints."""

    position: np.ndarray  # (B, 3) [m]
    orientation: np.ndarray  # (B, 4)
    opening: np.ndarray  # (J,) largest gap of the corners [m]
    gap: np.ndarray  # (J,) smallest [m]
    sliding: np.ndarray  # (J,) [m]
    contact_area: np.ndarray  # (J,) [m2]


class Peaks(NamedTuple):
    """The largest values so far; they grow in place."""

    displacement: np.ndarray  # (B,) of the centre of mass, relative to the support [m]
    drift: np.ndarray  # (P,) of the part
    level_displacement: np.ndarray  # (P, L + 1) in plan, the foot first [m]
    level_drift: np.ndarray  # (P, L + 1)
    hinge_opening: np.ndarray  # (J,) opening while it was a hinge [m]


class _Levels(NamedTuple):
    """Scratch: the levels of a part that hold blocks."""

    number: np.ndarray  # (L + 1,) 0 is the foot
    height: np.ndarray  # (L + 1,) [m]
    shift: np.ndarray  # (L + 1, 2) [m]


@entry()
def take_step(parts: PartTables, falls: FallTables, now: StepMeasures, peaks: Peaks, wider: np.ndarray) -> int:
    """Take a step into the peaks; ``wider`` (J,) says which joints are hinges, and wider open than before. Returns how many they are."""
    down = np.zeros(parts.level.shape[0], np.bool_)
    separated = np.zeros(falls.apart.shape[0], np.bool_)
    _mark_fallen(parts, falls, now, separated, down)
    _look_at_parts(parts, now, down, peaks)
    found = 0
    for j in range(separated.shape[0]):
        live = not (separated[j] or down[falls.block_a[j]] or down[falls.block_b[j]])
        wider[j] = live and now.gap[j] <= falls.hinged * now.opening[j] and now.opening[j] > peaks.hinge_opening[j]
        if wider[j]:
            peaks.hinge_opening[j] = now.opening[j]
            found += 1
    return found


@borrower()
def _base(parts, position, d):
    """Component d of the displacement of the support that all others are relative to [m]."""
    return position[parts.support, d] - parts.centre[parts.support, d] if parts.support >= 0 else 0.0


@borrower()
def _mark_fallen(parts, falls, now, separated, down):
    """Mark the joints (J,) that are separated and the blocks (B,) that have fallen; a block whose joints are all separated has."""
    for j in range(separated.shape[0]):
        away = now.gap[j] >= falls.apart[j] or now.sliding[j] >= falls.apart[j]
        separated[j] = away and now.contact_area[j] <= falls.least_area[j]
        if separated[j]:
            down[falls.block_a[j]] = True
            down[falls.block_b[j]] = True
    for j in range(separated.shape[0]):
        if not separated[j]:
            down[falls.block_a[j]] = False
            down[falls.block_b[j]] = False
    base = _base(parts, now.position, 2)
    for b in range(down.shape[0]):
        dropped = parts.centre[b, 2] - now.position[b, 2] + base
        w = now.orientation[b, 0]  # the cosine of half of the turn
        down[b] = not falls.fixed[b] and (down[b] or dropped > falls.drop[b] or 2.0 * w * w - 1.0 < falls.cosine)


@kernel()
def _look_at_parts(parts, now, down, peaks):
    """Take in the displacements of the blocks, and of the parts level by level."""
    rows, levels = peaks.level_drift.shape
    sums = np.zeros((rows, levels, 4))  # volume, and times the volume: height, displacement along x and y
    x0, y0, z0 = _base(parts, now.position, 0), _base(parts, now.position, 1), _base(parts, now.position, 2)
    for b in range(down.shape[0]):
        x = now.position[b, 0] - parts.centre[b, 0] - x0
        y = now.position[b, 1] - parts.centre[b, 1] - y0
        z = now.position[b, 2] - parts.centre[b, 2] - z0
        peaks.displacement[b] = max(peaks.displacement[b], math.sqrt(x * x + y * y + z * z))
        if not down[b]:
            for k in range(parts.start[b], parts.start[b + 1]):
                p, level, volume = parts.part[k], parts.level[b] + 1, parts.volume[b]
                sums[p, level, 0] += volume
                sums[p, level, 1] += volume * parts.centre[b, 2]
                sums[p, level, 2] += volume * x
                sums[p, level, 3] += volume * y
    kept = _Levels(np.empty(levels, np.int64), np.empty(levels), np.empty((levels, 2)))
    for p in range(rows):
        count = _fill_foot(parts, p, now.position, kept)
        above = count
        for level in range(1, levels):
            if sums[p, level, 0] > 0.0:
                kept.number[above], kept.height[above] = level, sums[p, level, 1] / sums[p, level, 0]
                for d in range(2):
                    kept.shift[above, d] = sums[p, level, 2 + d] / sums[p, level, 0]
                above += 1
        _take_levels(parts, p, kept, above, above - count > 1, peaks)


@borrower()
def _fill_foot(parts, p, position, kept):
    """Put the foot of part p first into the levels; returns how many they are then, 0 for a part that stands on no support."""
    if not np.isfinite(parts.foot[p]):
        return 0
    first, last = parts.footing_start[p], parts.footing_start[p + 1]
    kept.number[0], kept.height[0] = 0, parts.foot[p]
    for d in range(2):
        total = 0.0
        for k in range(first, last):
            b = parts.footing[k]
            total += position[b, d] - parts.centre[b, d] - _base(parts, position, d)
        kept.shift[0, d] = total / (last - first)
    return 1


@borrower()
def _take_levels(parts, p, kept, count, several, peaks):
    """Take the levels of part p into the peaks; ``several``: two or more of them hold blocks."""
    for k in range(count):
        level, x, y = kept.number[k], kept.shift[k, 0], kept.shift[k, 1]
        peaks.level_displacement[p, level] = max(peaks.level_displacement[p, level], math.sqrt(x * x + y * y))
        if several:
            x, y = x - kept.shift[0, 0], y - kept.shift[0, 1]
            peaks.drift[p] = max(peaks.drift[p], math.sqrt(x * x + y * y) / parts.height[p])
        below = k - 1
        while below >= 0 and kept.height[below] > kept.height[k] - parts.least:
            below -= 1
        if below >= 0:
            x, y = kept.shift[k, 0] - kept.shift[below, 0], kept.shift[k, 1] - kept.shift[below, 1]
            drift = math.sqrt(x * x + y * y) / (kept.height[k] - kept.height[below])
            peaks.level_drift[p, level] = max(peaks.level_drift[p, level], drift)
