# SPDX-License-Identifier: GPL-3.0-or-later
"""Running bond: head joints of one course lie over the middles of the stones below.

A course between two ends that are given is divided evenly; one of a wall that goes on beyond is counted from where its bond begins.
"""

from __future__ import annotations

import math

SAME = 1e-9  # [m]


def even(low: float, high: float, count: int, odd: bool) -> list[float]:
    """Head joints of a course of so many blocks between two places, the odd ones with half a block at both ends [m]."""
    shift = 0.5 if odd else 0.0
    return [low + (high - low) * (i + shift) / count for i in range(0 if odd else 1, count)]


def running(low: float, high: float, unit: float, start: float) -> list[float]:
    """Head joints of a course between two places, whole blocks from where its bond begins [m]."""
    first, last = math.ceil((low - start - SAME) / unit), math.floor((high - start + SAME) / unit)
    return [start + k * unit for k in range(first, last + 1)]
