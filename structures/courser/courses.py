# SPDX-License-Identifier: GPL-3.0-or-later
"""Courses: even beds between two levels, and stretches of a course, upright or slanted at their ends, cut by head joints."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from structures.courser.bond import LEAST_HEAD, running

SAME = 1e-9  # [m]


def divided(low: float, high: float, size: float) -> list[float]:
    """Places that divide a stretch into equal parts of about a size, its ends among them [m]."""
    return [float(place) for place in np.linspace(low, high, max(1, round((high - low) / size)) + 1)]


class CourseStretch(NamedTuple):
    """A stretch of a course: a trapezoid between two levels."""

    low: float
    high: float
    left: tuple[float, float]  # x at the lower and at the upper level [m]
    right: tuple[float, float]

    @property
    def polygon(self) -> np.ndarray:
        """(3 or 4, 2), counter-clockwise."""
        points = [(self.left[0], self.low), (self.right[0], self.low), (self.right[1], self.high), (self.left[1], self.high)]
        return np.array([p for i, p in enumerate(points) if max(abs(p[0] - points[i - 1][0]), abs(p[1] - points[i - 1][1])) > SAME])

    @property
    def mirrored(self) -> CourseStretch:
        """The course mirrored about x = 0."""
        (a, b), (c, d) = self.left, self.right
        return CourseStretch(self.low, self.high, (-c, -d), (-a, -b))


def joined(rows: Sequence[CourseStretch]) -> list[CourseStretch]:
    """Courses with those of the same levels that begin, upright, where they end."""
    out = list[CourseStretch]()
    for row in sorted(rows, key=lambda r: (round(r.low, 6), round(r.high, 6), min(r.left))):
        last = out[-1] if out else None
        if (
            last is not None
            and abs(last.low - row.low) + abs(last.high - row.high) < 1e-7
            and max(abs(last.right[k] - row.left[k]) for k in (0, 1)) < 1e-7
            and abs(row.left[0] - row.left[1]) < 1e-7
        ):
            out[-1] = CourseStretch(last.low, last.high, last.left, row.right)
        else:
            out.append(row)
    return out


def heads_of(row: CourseStretch, unit: float, start: float) -> list[float]:
    """x of the head joints of a course, whole stones from where its bond begins [m]."""
    return running(max(row.left) + LEAST_HEAD * unit, min(row.right) - LEAST_HEAD * unit, unit, start)


def cut(row: CourseStretch, heads: Sequence[float]) -> list[np.ndarray]:
    """The stones (n, 2) of a course between its head joints."""
    ends = [row.left, *((x, x) for x in heads), row.right]
    return [CourseStretch(row.low, row.high, a, b).polygon for a, b in pairwise(ends)]
