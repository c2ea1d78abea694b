# SPDX-License-Identifier: GPL-3.0-or-later
"""Macro-elements of a building from a plan: its walls, corners, vaults and columns."""

from __future__ import annotations

import math
import re

import numpy as np

from structures.macro_elements import walls
from structures.macro_elements.element import AROUND, HINGES, OVERTURNING, MacroElement, Vector
from structures.macro_elements.layout import Layout

COURSE, COLUMN = re.compile(r"\d+$"), re.compile(r"c\d+$")  # second part of the name of a stone of a wall, and of a column
END = 0.1  # share of the length of a wall that its end is
ALIGNED = 0.1  # by how much a wall in the frame of x and y may be out of it, the sine of the angle


def parts(layout: Layout) -> list[MacroElement]:
    """Every wall out of its plane, to both sides, and in it where it lies along x or y; corners; vaults; columns."""
    free = np.flatnonzero(~layout.fixed)
    by_wall: dict[str, list[int]] = {}
    for block in free.tolist():
        by_wall.setdefault(str(layout.wall[block]), []).append(block)
    found, masonry = [], []
    for name, numbers in by_wall.items():
        own = np.array(numbers)
        if any(COURSE.match(layout.piece[b]) for b in numbers):
            masonry += numbers
            found += _wall(layout, name, own)
        elif any(COLUMN.match(layout.piece[b]) for b in numbers):
            found += _columns(layout, name, own)
        else:
            found.append(MacroElement(name, "vault", own, AROUND, (HINGES,)))
    return found + (walls.corners(layout, np.array(masonry)) if masonry else [])


def _wall(layout: Layout, name: str, own: np.ndarray) -> list[MacroElement]:
    """A wall by its name."""
    out = _across(layout, own)
    found = walls.out_of_plane(layout, name, own, (out, (-out[0] + 0.0, -out[1] + 0.0, 0.0)), _eaves(layout, own, out), "wall")
    return found + (walls.in_plane(layout, name, name) if min(abs(out[0]), abs(out[1])) < ALIGNED else [])


def _across(layout: Layout, own: np.ndarray) -> Vector:
    """Unit vector across a wall: along the shortest axis of inertia of the middles of its stones in plan."""
    middle = layout.middle[own, :2]
    xx, yy, xy = ((middle[:, i] - middle[:, i].mean()) @ (middle[:, j] - middle[:, j].mean()) for i, j in ((0, 0), (1, 1), (0, 1)))
    turn = 0.5 * math.atan2(2.0 * xy, xx - yy)
    x, y = -math.sin(turn), math.cos(turn)
    return (round(x, 9) + 0.0, round(y, 9) + 0.0, 0.0)


def _eaves(layout: Layout, own: np.ndarray, out: Vector) -> float:
    """Up to where a wall has its full length [m]: the lower one of the tops of its two ends."""
    along = layout.middle[own, 0] * out[1] - layout.middle[own, 1] * out[0]
    reach = END * float(np.ptp(along))
    return min(layout.top(own[along <= along.min() + reach]), layout.top(own[along >= along.max() - reach]))


def _columns(layout: Layout, name: str, own: np.ndarray) -> list[MacroElement]:
    """Each column of a row."""
    each = dict.fromkeys(str(layout.piece[b]) for b in own)
    return [MacroElement(f"{name} {piece[1:]}", "column", own[layout.piece[own] == piece], AROUND, (OVERTURNING,)) for piece in each]
