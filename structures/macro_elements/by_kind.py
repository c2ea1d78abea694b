# SPDX-License-Identifier: GPL-3.0-or-later
"""Which macro-elements a kind of structure has."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from structures.macro_elements import bridges, building, church, walls
from structures.macro_elements.element import AROUND, NORTH, OVERTURNING, SOUTH, MacroElement
from structures.macro_elements.layout import Layout

RESTING = ("roof", "vault")  # groups that rest on walls and load them, with floors
FLOOR = "floor"


def macro_elements(kind: str, blocks: Sequence[Block]) -> list[MacroElement]:
    """The parts of a structure of a kind that practice looks at; of a kind that names none, its groups."""
    layout = Layout.of(blocks)
    free = bridges.parapets(layout)
    named = {one.name for one in free}
    found = [one for one in KINDS.get(kind, _groups)(layout) if one.name not in named]
    return [one for one in (*found, *free) if len(one.blocks)]


def rests(group: str) -> bool:
    """Whether blocks of a group rest on walls, as roofs and floors do, and are not bonded with them."""
    return group in RESTING or group.startswith(FLOOR)


def _wall(layout: Layout) -> list[MacroElement]:
    """A wall on its own: out of its plane to both sides, and in it."""
    own = np.flatnonzero(~layout.fixed)
    holes = layout.holes("wall")
    eaves = _eaves(layout, own)
    found = walls.out_of_plane(layout, "wall", own, (NORTH, SOUTH), eaves, "wall")
    return found + walls.in_plane(layout, "wall", "wall") if holes or len(own) else found


def _eaves(layout: Layout, own: np.ndarray) -> float:
    """Up to where a wall has its full length: above it is a gable [m]."""
    axis = layout.axis(own)
    ends = own[layout.low[own, axis] <= layout.low[own, axis].min() + 1e-6]
    return layout.top(ends)


def _tower(layout: Layout) -> list[MacroElement]:
    """A tower: as a whole, its walls, belfry and corners."""
    own = np.flatnonzero(~layout.fixed & ~np.array([rests(str(group)) for group in layout.group]))
    found = [walls.ring(layout, own, "tower", "tower")]
    for name, way in zip(("south", "north", "west", "east"), (SOUTH, NORTH, (-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)), strict=True):
        wall = layout.of_walls(name)
        if len(wall):
            found += walls.out_of_plane(layout, f"{name} wall", wall, (way,), layout.top(wall), "wall")
            found += walls.in_plane(layout, name, f"{name} wall")
    holes = [hole for name in ("south", "north", "west", "east") for hole in layout.holes(name)]
    high = [hole for hole in holes if hole.sill > layout.foot(own) + 0.5 * (layout.top(own) - layout.foot(own))]
    if high:
        found.append(walls.ring(layout, own, "belfry", "belfry", max(hole.sill for hole in high)))
    return found + walls.corners(layout, own)


def _whole(layout: Layout) -> list[MacroElement]:
    """A structure that is one part."""
    return [MacroElement("whole", "whole", np.flatnonzero(~layout.fixed), AROUND, (OVERTURNING,))]


def _groups(layout: Layout) -> list[MacroElement]:
    """The groups of blocks that no kind has made."""
    names = dict.fromkeys(str(name) for name in layout.group[~layout.fixed])
    return [MacroElement(name, "group", layout.of_groups(name), AROUND, (OVERTURNING,)) for name in names]


KINDS: Mapping[str, Callable[[Layout], list[MacroElement]]] = {
    "church": church.parts, "wall": _wall, "tower": _tower, "arch": bridges.arch, "aqueduct": bridges.aqueduct, "bridge": bridges.bridge,
    "vault": bridges.vault, "column": _whole, "dome": _whole, "building": building.parts,
}  # fmt: skip
