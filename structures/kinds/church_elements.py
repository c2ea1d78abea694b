# SPDX-License-Identifier: GPL-3.0-or-later
"""Macro-elements of a church of :mod:`structures.kinds.church`."""

from __future__ import annotations

import numpy as np

from structures.macro_elements import walls
from structures.macro_elements.element import EAST, HINGES, NORTH, OVERTURNING, SOUTH, WEST, MacroElement
from structures.macro_elements.layout import BlockLayout


def parts(layout: BlockLayout) -> list[MacroElement]:
    """Facade, side walls, arch, vault, apse, tower, belfry, corners; what the church has of them."""
    nave = layout.of_walls("nave_south", "nave_north")
    eaves = layout.top(nave)
    found = walls.out_of_plane(layout, "facade", layout.of_walls("facade"), (WEST,), eaves, "facade")
    found += walls.in_plane(layout, "facade", "facade")
    for name in ("nave_south", "nave_north", "aisle_south", "aisle_north"):
        own = layout.of_walls(name)
        if len(own):  # inwards too: nothing holds a wall on the side of the nave
            found += walls.out_of_plane(layout, name.replace("_", " wall "), own, (SOUTH, NORTH), layout.top(own), "side wall")
            found += walls.in_plane(layout, name, name.replace("_", " wall "))
    for name in ("triumphal_arch", "east_wall"):
        own = layout.of_walls(name)
        if len(own):
            found += _back(layout, name.replace("_", " "), own, eaves)
    vault = layout.of_groups("vault")
    if len(vault):
        found.append(MacroElement("nave vault", "vault", vault, (NORTH, SOUTH), (HINGES,)))
    found += _apse(layout)
    found += _tower(layout)
    outer = layout.of_walls("facade", *(("aisle_south", "aisle_north") if "aisle_south" in layout.wall else ("nave_south", "nave_north")))
    lower = layout.top(layout.of_walls("aisle_south")) if "aisle_south" in layout.wall else eaves
    found += [one for one in walls.corners(layout, outer, "corner", lower) if one.directions[0][0] < 0.0]
    return found


def _back(layout: BlockLayout, name: str, own: np.ndarray, eaves: float) -> list[MacroElement]:
    """The wall of the triumphal arch: in its plane, its arch, and the gable."""
    whole, _, *gable = walls.out_of_plane(layout, name, own, (EAST, WEST), eaves, "triumphal arch")
    plane = walls.in_plane(layout, own_wall(layout, own), name)
    return [whole, *gable, *plane]


def own_wall(layout: BlockLayout, own: np.ndarray) -> str:
    """Name of the wall that blocks belong to."""
    return str(layout.wall[own[0]])


def _apse(layout: BlockLayout) -> list[MacroElement]:
    """The apse with its half dome, and the half dome alone."""
    own, dome = layout.of_groups("apse", "half_dome"), layout.of_groups("half_dome")
    if not len(own):
        return []
    found = [MacroElement("apse", "apse", own, (EAST, NORTH, SOUTH), (OVERTURNING,))]
    return [*found, MacroElement("half dome", "half dome", dome, (EAST, NORTH), (HINGES,))] if len(dome) else found


def _tower(layout: BlockLayout) -> list[MacroElement]:
    """The bell tower where it is clear of the church, and its belfry."""
    own = layout.of_groups("tower")
    if not len(own):
        return []
    found = [walls.ring(layout, own, "bell tower", "bell tower")]
    holes = [hole for name in ("tower_north", "tower_south", "tower_west", "tower_east") for hole in layout.holes(name)]
    high = [name for name in ("tower_west_high", "tower_east_high") if name in layout.wall]
    holes += [hole for name in high for hole in layout.holes(name)]
    if holes:
        sill = max(hole.sill for hole in holes)
        found.append(walls.ring(layout, own, "belfry", "belfry", sill))
        found.append(walls.ring(layout, own, "top of the belfry", "belfry", max(hole.head for hole in holes)))
    clear = layout.above(own, layout.top(layout.of_walls("nave_north")))
    return [*found, *walls.corners(layout, clear, "corner of the tower")] if len(clear) else found
