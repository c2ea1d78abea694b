# SPDX-License-Identifier: GPL-3.0-or-later
"""A ground for structures without one: a fixed slab under the whole structure, on which fallen blocks land.

Walls, towers and churches stand on one. Plain abutments of arches and vaults, and the piers of a cross vault, have nothing between them:
they get one unless the scene says ``ground = false``. Blocks of a file get one only where the scene asks for it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from masonry_cd.foundation.errors import InputError, values_in_si
from masonry_cd.foundation.fields import is_number
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Block
from structures.geometry.prism import box

KEY = "ground"
HEIGHT = Unit("m")  # of its top
AROUND = 1.5  # of the height: how far it reaches around a structure
DEPTH = 0.1  # of the slab, as a share of the height above it


def needs_ground(blocks: Sequence[Block]) -> bool:
    """Return True if a structure has supports, but none under the middle of its plan: what falls there falls for ever."""
    points = np.concatenate([block.vertices for block in blocks])
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))[:2]
    supports = [block.vertices[:, :2] for block in blocks if block.fixed]
    under = [(plan.min(axis=0) <= middle).all() and (middle <= plan.max(axis=0)).all() for plan in supports]
    return bool(supports) and not any(under)


def with_ground(blocks: Sequence[Block], asked: object) -> list[Block]:
    """The blocks of a structure with a ground below.

    Args:
        blocks: sound ones.
        asked: the value of ``structure.ground``: true, at the lowest corner; or the height of its top [m]; false for none.

    Raises:
        InputError: no such value, a structure that has a ground already, or a top above the lowest corner.
    """
    asked = values_in_si(asked, lambda: HEIGHT.name, f"structure.{KEY}")
    if asked is False:
        return list(blocks)
    if asked is not True and not is_number(asked):
        raise InputError(f"structure.{KEY}", f"should be true, false or the height of its top [m], got {asked!r}")
    if any(block.name == KEY for block in blocks):
        raise InputError(f"structure.{KEY}", f'the structure has a block "{KEY}" already')
    points = np.concatenate([block.vertices for block in blocks])
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    top = low if asked is True else float(asked)  # type: ignore[arg-type]
    if top > low:
        raise InputError(f"structure.{KEY}", f"its top must be at most the lowest corner, {low:.6g} m, got {top:g}")
    slab = ground(blocks, DEPTH * (high - top), blocks[0].density)
    vertices = slab.vertices + [0.0, 0.0, top - low]
    return [*blocks, Block(KEY, vertices, slab.faces, slab.density, slab.group, fixed=True)]


def ground(blocks: Sequence[Block], depth: float, density: float) -> Block:
    """A fixed slab under all blocks, its top at the lowest of them; so wide that what topples lies on it, and does not roll off at once."""
    low = np.min([block.vertices.min(axis=0) for block in blocks], axis=0)
    high = np.max([block.vertices.max(axis=0) for block in blocks], axis=0)
    margin = AROUND * float(high[2] - low[2])
    vertices, faces = box(
        (float(low[0]) - margin, float(low[1]) - margin, float(low[2]) - depth),
        (float(high[0]) + margin, float(high[1]) + margin, float(low[2])),
    )
    return Block("ground", vertices, faces, density, "base", fixed=True)
