# SPDX-License-Identifier: GPL-3.0-or-later
"""Spandrel walls, wing walls and parapets of a bridge, and their faces that the fill presses."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.fill import FillFace
from structures.bridge.layout import BridgeLayout, BridgeSupport
from structures.bridge.masonry import SLAB, drawn_out
from structures.bridge.spandrels import pieces
from structures.courser.courses import CourseStretch, cut, divided, heads_of
from structures.geometry.prism import rectangle

SIDES = (("front", -1.0), ("back", 1.0))


def walls(layout: BridgeLayout, density: float) -> tuple[list[Block], list[FillFace]]:
    """All walls: groups ``spandrel_front``, ``wing1_front`` ..., ``parapet_front`` and those at the back.

    The spandrel walls stand on the edges of the arches, as far as they are thick.
    """
    keys = layout.keys.walls
    if keys is None:
        return [], []
    blocks, faces = list[Block](), list[FillFace]()
    half, inner = 0.5 * layout.keys.width, layout.clear
    found = [("spandrel", pieces(layout), half, inner, False)]
    stretch = list(layout.ends)
    if keys.wing_length is not None:
        for i, support in ((1, layout.supports[0]), (2, layout.supports[-1])):
            outwards = -1.0 if i == 1 else 1.0
            far = (support.left if i == 1 else support.right) + outwards * keys.wing_length
            stretch[i - 1] = far
            found.append((f"wing{i}", _wing(layout, support, far), half, inner, False))
            blocks += _wing_feet(layout, support, far, density, i)
    if keys.parapet_height is not None:
        thick = keys.parapet_thickness or keys.thickness
        found.append(("parapet", _parapet(layout, stretch[0], stretch[1], keys.parapet_height), half, half - thick, True))
    for group, polygons, outer, near, above in found:
        for side, sign in SIDES:
            for number, polygon in enumerate(polygons, start=1):
                name = f"{group}_{side}.{number}"
                blocks.append(Block(name, *drawn_out(layout, polygon, sign * near, sign * outer), density, f"{group}_{side}"))
                if not above:
                    faces.append(FillFace(name, "wall", _inner(layout, polygon, sign * near, sign)))
    return blocks, faces


def _inner(layout: BridgeLayout, polygon: np.ndarray, y: float, sign: float) -> np.ndarray:
    """The inner face of a stone of a wall, whose area points into the fill: (n, 3) [m]."""
    corners = np.stack([polygon[:, 0] + layout.slant * y, np.full(len(polygon), y), polygon[:, 1]], axis=1)
    return corners if sign > 0 else corners[::-1]


def _rows(layout: BridgeLayout, low: float, high: float, start: float, end: float, course: float) -> list[np.ndarray]:
    """The stones of a wall between two levels and two upright ends."""
    assert layout.keys.walls is not None
    unit = layout.keys.walls.unit_length
    found = list[np.ndarray]()
    for number, (below, above) in enumerate(pairwise(divided(low, high, course))):
        row = CourseStretch(below, above, (start, start), (end, end))
        found += cut(row, heads_of(row, unit, start + 0.5 * unit * (number % 2)))
    return found


def _foot(support: BridgeSupport) -> float:
    """Where a wing wall stands: on the level of a fixed abutment, or next to one of blocks on its foot [m]."""
    return support.springing if support.keys.rigid else support.foot


def _wing(layout: BridgeLayout, support: BridgeSupport, far: float) -> list[np.ndarray]:
    assert layout.keys.walls is not None
    near = support.left if support.before is None else support.right
    return _rows(layout, _foot(support), layout.deck, min(near, far), max(near, far), layout.keys.walls.course_height)


def _wing_feet(layout: BridgeLayout, support: BridgeSupport, far: float, density: float, number: int) -> list[Block]:
    """Return the supports of the wing walls behind a fixed abutment; one of blocks has a foot that reaches as far."""
    near = support.left if support.before is None else support.right
    if not support.keys.rigid:
        return []
    level, half = _foot(support), 0.5 * layout.keys.width + SLAB
    polygon = rectangle(min(near, far), max(near, far), level - SLAB, level)
    return [Block(f"foot_wing{number}", *drawn_out(layout, polygon, -half, half), density, "base", fixed=True)]


def _parapet(layout: BridgeLayout, start: float, end: float, height: float) -> list[np.ndarray]:
    assert layout.keys.walls is not None
    return _rows(layout, layout.deck, layout.deck + height, start, end, layout.keys.walls.course_height)
