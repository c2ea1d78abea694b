# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks as block files have them."""

from __future__ import annotations


def cuboid(low: tuple[float, float, float], high: tuple[float, float, float]) -> dict[str, list]:
    """Vertices and faces of a cuboid, as a block file has them."""
    vertices = [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return {"vertices": vertices, "faces": faces}
