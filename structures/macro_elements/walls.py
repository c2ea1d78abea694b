# SPDX-License-Identifier: GPL-3.0-or-later
"""Macro-elements of walls in plan: whole, upper part, gable, piers and spandrels between openings, corners."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from structures.macro_elements.element import (
    AROUND,
    CORNER,
    EAST,
    HINGES,
    HORIZONTAL_BENDING,
    IN_PLANE,
    NORTH,
    OVERTURNING,
    PIERS,
    SOUTH,
    VERTICAL_BENDING,
    WEST,
    MacroElement,
    Vector,
)
from structures.macro_elements.layout import SAME, BlockLayout, Hole

UPPER = 0.5  # share of the height of a wall from which on its upper part begins
BENDS = (OVERTURNING, VERTICAL_BENDING, HORIZONTAL_BENDING)
CORNER_DEPTH = 0.5  # share of the height of a building to which its corners are looked at, from the top


def out_of_plane(
    layout: BlockLayout, name: str, blocks: np.ndarray, ways: tuple[Vector, ...], eaves: float, kind: str
) -> list[MacroElement]:
    """A wall as a whole, its upper part, and its gable above the eaves, where it has one [m]."""
    foot, top = layout.foot(blocks), layout.top(blocks)
    half = foot + UPPER * (min(eaves, top) - foot)
    found = [MacroElement(name, kind, blocks, ways, BENDS)]
    upper = layout.above(blocks, half)
    if len(upper):
        found.append(MacroElement(f"{name}, upper part", kind, upper, ways, (OVERTURNING, HORIZONTAL_BENDING), (half, min(eaves, top))))
    gable = layout.above(blocks, eaves)
    if len(gable):
        both = tuple({*ways, *((-x + 0.0, -y + 0.0, 0.0) for x, y, _ in ways)})
        found.append(MacroElement(f"{name}, gable", "gable", gable, tuple(sorted(both)), (OVERTURNING,), (eaves, top)))
    return found


def in_plane(layout: BlockLayout, wall: str, name: str) -> list[MacroElement]:
    """A wall in its plane: as a whole, its piers storey by storey, the spandrels over its openings."""
    blocks = layout.of_walls(wall)
    axis = layout.axis(blocks)
    ways = (EAST, WEST) if axis == 0 else (NORTH, SOUTH)
    found = [MacroElement(f"{name}, in its plane", "wall in its plane", blocks, ways, (IN_PLANE,))]
    for number, storey in enumerate(storeys(layout.holes(wall)), start=1):
        piers = _piers(layout, blocks, axis, storey)
        above = layout.above(blocks, min(hole.head for hole in storey))
        if len(piers) > 1 and len(above):
            some = np.unique(np.concatenate([*piers, above]))
            found.append(MacroElement(f"{name}, piers {number}", "piers", some, ways, (PIERS,), None, tuple(piers)))
    over = [_over(layout, blocks, axis, hole) for hole in layout.holes(wall)]
    if any(len(some) for some in over):
        found.append(MacroElement(f"{name}, spandrels", "spandrels", np.unique(np.concatenate(over)), ways, (HINGES,)))
    return found


def _over(layout: BlockLayout, blocks: np.ndarray, axis: int, hole: Hole) -> np.ndarray:
    """Blocks of a wall over an opening, those that it holds up."""
    over = layout.above(blocks, hole.head)
    return over[(layout.high[over, axis] > hole.start - SAME) & (layout.low[over, axis] < hole.end + SAME)]


def storeys(holes: Sequence[Hole]) -> list[list[Hole]]:
    """Openings that lie next to one another, from below."""
    rows: list[list[Hole]] = []
    for hole in sorted(holes, key=lambda one: one.sill):
        if rows and hole.sill < min(one.head for one in rows[-1]) - SAME:
            rows[-1].append(hole)
        else:
            rows.append([hole])
    return rows


def _piers(layout: BlockLayout, blocks: np.ndarray, axis: int, storey: Sequence[Hole]) -> list[np.ndarray]:
    """Blocks between the openings of a storey, from the highest of their sills to the lowest of their heads."""
    low, high = max(hole.sill for hole in storey), min(hole.head for hole in storey)
    row = blocks[(layout.low[blocks, 2] >= low - SAME) & (layout.high[blocks, 2] <= high + SAME)]
    middle, cuts = layout.middle[row, axis], sorted(0.5 * (hole.start + hole.end) for hole in storey)
    which = np.searchsorted(np.array(cuts), middle)
    return [row[which == k] for k in range(len(cuts) + 1) if (which == k).any()]


def corners(layout: BlockLayout, blocks: np.ndarray, kind: str = "corner", eaves: float | None = None) -> list[MacroElement]:
    """The corners of walls around a rectangle, each a wedge that widens upwards from a point on the corner's edge."""
    low, high = layout.low[blocks].min(axis=0), layout.high[blocks].max(axis=0)
    top = float(high[2]) if eaves is None else eaves
    from_ = top - CORNER_DEPTH * (top - float(low[2]))
    own = blocks[(layout.high[blocks, 2] <= top + SAME) & (layout.low[blocks, 2] >= from_ - SAME)]
    found = []
    for label, sign in (("south-west", (-1, -1)), ("south-east", (1, -1)), ("north-east", (1, 1)), ("north-west", (-1, 1))):
        edge = np.where(np.array(sign) > 0, high[:2], low[:2])
        away = np.abs(layout.middle[own, :2] - edge).max(axis=1)
        some = own[away <= layout.middle[own, 2] - from_]
        touches = some[(np.abs(np.where(np.array(sign) > 0, layout.high[some, :2], layout.low[some, :2]) - edge) <= SAME).all(axis=1)]
        if len(touches):
            way = (sign[0] * 0.5**0.5, sign[1] * 0.5**0.5, 0.0)
            found.append(MacroElement(f"{kind} {label}", "corner", some, (way,), (CORNER,), (from_, top)))
    return found


def ring(layout: BlockLayout, blocks: np.ndarray, name: str, kind: str, top_of: float | None = None) -> MacroElement:
    """Walls around a rectangle as one body, as a tower or its belfry from a height on [m]."""
    some = blocks if top_of is None else layout.above(blocks, top_of)
    levels = None if top_of is None else (top_of, top_of)
    return MacroElement(name, kind, some, AROUND, (OVERTURNING,), levels)
