# SPDX-License-Identifier: GPL-3.0-or-later
"""Check that a place that a scene names lies on its block: within it, or on its surface."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.polygon import loop_planes
from masonry_cd.mechanics.model.sphere import ball_centre

OFF = 0.01  # share of a block's size by which a place may lie outside: coordinates are typed with two or three digits


def require_on_block(block: Block, point: Sequence[float] | np.ndarray, key: str) -> None:
    """Refuse a place (3,) [m] off a block.

    Raises:
        InputError: names the key, the place, the block and its extent.
    """
    place, low, high = np.asarray(point, dtype=float), block.vertices.min(axis=0), block.vertices.max(axis=0)
    outside = float(outside_block(block, place))
    if outside <= OFF * math.hypot(*(high - low)):
        return
    at, extent = (
        (", ".join(f"{x:.6g}" for x in place)),
        (f"{axis} from {a:.4g} to {b:.4g}" for axis, a, b in zip("xyz", low, high, strict=True)),
    )
    raise InputError(key, f'({at}) m lies {outside:.3g} m outside block "{block.name}", which has {", ".join(extent)} m')


def outside_block(block: Block, places: np.ndarray) -> np.ndarray:
    """How far places (..., 3) lie beyond the faces of the nearest convex part of a block, or beyond a sphere (...) [m]; below 0 inside."""
    if block.radius:
        return np.sqrt(np.sum((places - ball_centre(block.vertices)) ** 2, axis=-1)) - block.radius
    planes = [loop_planes([part.vertices[list(face)] for face in part.faces]) for part in block.convex_parts]
    beyond = [(np.sum(normals * places[..., None, :], axis=-1) - offsets).max(axis=-1) for normals, offsets in planes]
    return np.asarray(np.min(beyond, axis=0))
