# SPDX-License-Identifier: GPL-3.0-or-later
"""Backing over the supports of a bridge: masonry between the haunches up to a level, one rigid block over each pier and abutment.

It lies on its support and against the extradoses, by joints like any others, and bears the fill above it. Where an arch leans outwards it
leans on the weight, the friction and, behind an abutment, the fill of its backing, in place of the fill that would be there.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.fill import FillFace
from structures.bridge.layout import SAME, BridgeLayout, BridgeSupport
from structures.bridge.masonry import backs, convex_parts, drawn_out, face_of, top_of
from structures.geometry.compound_block import compound_block

GROUP = "backing"


def backings(layout: BridgeLayout, density: float) -> tuple[list[Block], list[FillFace]]:
    """The blocks ``backing.pier1`` ..., as wide as the fill, and what the fill touches of them; none without a table."""
    keys, blocks, faces = layout.keys.backing, list[Block](), list[FillFace]()
    for support in layout.supports if keys is not None else ():
        level, name = layout.backing_level(support), f"{GROUP}.{support.name}"
        outline = _outline(support, level, layout.keys.walls is not None)
        parts = [drawn_out(layout, polygon, -layout.clear, layout.clear) for polygon in convex_parts(outline)]
        blocks.append(compound_block(name, parts, keys.density or density if keys else density, GROUP))
        ends = outline[np.abs(outline[:, 1] - level) <= SAME, 0]
        line = np.array([[ends.min(), level], [ends.max(), level]])
        faces.append(FillFace(name, "top", face_of(layout, line, -layout.clear, layout.clear)))
        faces += backs(layout, support, blocks[-1:])
    return blocks, faces


def _outline(support: BridgeSupport, level: float, walls: bool) -> np.ndarray:
    """The corners (n, 2) of a backing in the x-z plane, counter-clockwise from the left end of what it lies on [m]."""
    right = [(support.right, level)] if support.after is None else _climbed(support.after.extrados, level)
    left = [(support.left, level)] if support.before is None else _climbed(support.before.extrados[::-1], level)
    return np.array([*top_of(support, walls), *right, *left[::-1]])


def _climbed(line: np.ndarray, level: float) -> list[tuple[float, float]]:
    """The points of an extrados (n, 2) above its springing up to a level, the last one there [m]."""
    k = int(np.argmax(line[:, 1] >= level - SAME))
    (x0, z0), (x1, z1) = line[k - 1], line[k]
    return [*map(tuple, line[1:k].tolist()), (float(x0 + (x1 - x0) * (level - z0) / (z1 - z0)), level)]
