# SPDX-License-Identifier: GPL-3.0-or-later
"""Macro-elements of a building from a plan: its walls, corners, vaults and columns."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.model.polygon import loop_area, loop_normal
from structures.macro_elements import walls
from structures.macro_elements.element import AROUND, HINGES, OVERTURNING, MacroElement, Vector
from structures.macro_elements.layout import BlockLayout

COURSE, COLUMN = re.compile(r"\d+$"), re.compile(r"c\d+$")  # second part of the name of a stone of a wall, and of a column
RESTING = ("roof", "floor")  # groups that load walls and are no part by themselves
END = 0.1  # share of the length of a wall that its end is
LIKE = 0.9  # cosine of the angle between the faces of a stone that count as faces of its wall and the direction across that, at least
ONE = 1e-3  # faces turned by less are alike [rad]
STRAIGHT = 0.8  # share of the faces of a wall that lie alike, at least; with less it is curved and has no plane of its own


def parts(layout: BlockLayout) -> list[MacroElement]:
    """Every wall out of its plane, to both sides, and in it where it is straight; corners; vaults; columns."""
    free = np.flatnonzero(~layout.fixed)
    by_wall: dict[str, list[int]] = {}
    for block in free.tolist():
        if not str(layout.group[block]).startswith(RESTING):
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


def _wall(layout: BlockLayout, name: str, own: np.ndarray) -> list[MacroElement]:
    """A wall by its name."""
    out, straight = _facing(layout, own, _across(layout, own))
    found = walls.out_of_plane(layout, name, own, (out, (-out[0] + 0.0, -out[1] + 0.0, 0.0)), _eaves(layout, own, out), "wall")
    return found + (_in_plane(layout, name, out) if straight else [])


def _in_plane(layout: BlockLayout, name: str, out: Vector) -> list[MacroElement]:
    """A wall in its own plane, which has a normal."""
    along = np.array([-out[1], out[0]])
    if abs(along).max() == 1.0:  # along x or y
        return walls.in_plane(layout, name, name)
    ways = tuple((round(sign * along[0], 9), round(sign * along[1], 9), 0.0) for sign in (1.0, -1.0))
    return [replace(one, directions=ways) for one in walls.in_plane(layout.turned(along), name, name)]


def _facing(layout: BlockLayout, own: np.ndarray, across: Vector) -> tuple[Vector, bool]:
    """The normal of the faces of a wall, near a direction across it, and whether most of them have it."""
    areas, angles = [], []
    for k in own.tolist():
        block = layout.blocks[k]
        for face in block.faces:
            loop = block.vertices[list(face)]
            normal = loop_normal(loop)
            if abs(normal[0] * across[0] + normal[1] * across[1]) > LIKE:
                areas.append(loop_area(loop))
                angles.append(math.atan2(normal[1], normal[0]) % math.pi)
    if not areas:
        return across, False
    area, angle = np.array(areas), np.array(angles)
    _, bins = np.unique(np.round(angle / ONE) % round(math.pi / ONE), return_inverse=True)
    best = int(np.flatnonzero(bins == np.bincount(bins, area).argmax())[0])
    alike = np.abs((angle - angle[best] + 0.5 * math.pi) % math.pi - 0.5 * math.pi) < ONE
    x, y = math.cos(angle[best]), math.sin(angle[best])
    sign = math.copysign(1.0, x * across[0] + y * across[1])
    return (round(sign * x, 9) + 0.0, round(sign * y, 9) + 0.0, 0.0), bool(area[alike].sum() > STRAIGHT * area.sum())


def _across(layout: BlockLayout, own: np.ndarray) -> Vector:
    """Unit vector across a wall: along the shortest axis of inertia of the middles of its stones in plan."""
    middle = layout.middle[own, :2]
    xx, yy, xy = ((middle[:, i] - middle[:, i].mean()) @ (middle[:, j] - middle[:, j].mean()) for i, j in ((0, 0), (1, 1), (0, 1)))
    turn = 0.5 * math.atan2(2.0 * xy, xx - yy)
    x, y = -math.sin(turn), math.cos(turn)
    return (round(x, 9) + 0.0, round(y, 9) + 0.0, 0.0)


def _eaves(layout: BlockLayout, own: np.ndarray, out: Vector) -> float:
    """Up to where a wall has its full length [m]: the lower one of the tops of its two ends."""
    along = layout.middle[own, 0] * out[1] - layout.middle[own, 1] * out[0]
    reach = END * float(np.ptp(along))
    return min(layout.top(own[along <= along.min() + reach]), layout.top(own[along >= along.max() - reach]))


def _columns(layout: BlockLayout, name: str, own: np.ndarray) -> list[MacroElement]:
    """Each column of a row."""
    each = dict.fromkeys(str(layout.piece[b]) for b in own)
    return [MacroElement(f"{name} {piece[1:]}", "column", own[layout.piece[own] == piece], AROUND, (OVERTURNING,)) for piece in each]
