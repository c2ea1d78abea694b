# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces that are warped beyond what is made flat, cut into triangles.

A quadrilateral is cut along the diagonal that leaves more solid: its ridge then points outwards, and no valley makes the block concave.
A face of more corners becomes a fan.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.polygon import loop_planes
from structures.geometry.checks import FLATNESS
from structures.geometry.convex import size_of


def in_triangles(blocks: Sequence[Block]) -> tuple[list[Block], int]:
    """The blocks with their warped faces in triangles, and how many faces those were. Spheres and blocks with parts stay."""
    out, count = [], 0
    for block in blocks:
        warped = [] if block.radius or block.parts else _warped(block)
        faces = [piece for k, face in enumerate(block.faces) for piece in (_cut(block.vertices, face) if k in warped else [face])]
        out.append(replace(block, faces=tuple(faces)) if warped else block)
        count += len(warped)
    return out, count


def _warped(block: Block) -> list[int]:
    """The faces of which a corner is off their plane."""
    loops = [block.vertices[list(face)] for face in block.faces]
    normals, offsets = loop_planes(loops)
    limit = FLATNESS * size_of(block)
    off = [float(np.abs(loop @ n - c).max()) for loop, n, c in zip(loops, normals, offsets, strict=True)]
    return [k for k, face in enumerate(block.faces) if len(face) > 3 and off[k] > 0.25 * limit]  # of the mean plane: a check has another


def _cut(vertices: np.ndarray, face: Sequence[int]) -> list[tuple[int, ...]]:
    """The triangles of a face."""
    loop = list(face)
    if len(loop) == 4:
        a, b, c, d = (vertices[i] for i in loop)
        if float(np.linalg.det(np.array([b - a, c - a, d - a]))) > 0.0:  # the diagonal a-c lies below b-d, seen from outside
            loop = [*loop[1:], loop[0]]
    return [(loop[0], loop[k], loop[k + 1]) for k in range(1, len(loop) - 1)]
