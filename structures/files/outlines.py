# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks drawn as their outlines, as elevations and models in a plane have them, drawn out by a thickness.

An outline that lies flat in the x-y plane of its file is one of an elevation: y of the drawing is up, and the blocks reach backwards. An
outline in another plane is drawn out across that.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from structures.files.foreign import Faces, Refused
from structures.geometry.prism import between

KEY = "structure.thickness"
FLAT = 1e-9  # by how much the direction of a plane may be off the vertical of its file
SAME = 1e-9  # corners this close are one, as a share of the outline's extents


def refuse_without_thickness(name: str, count: int, what: str) -> None:
    """Refuse outlines, which have no third dimension, where the scene gives none."""
    raise Refused(KEY, f"missing; {name} has {count} {what}, blocks of an elevation: say how thick they are, in metres")


def drawn_out(outline: Sequence[Any] | np.ndarray, thickness: float, up: str) -> tuple[np.ndarray, Faces]:
    """Corners (2 n, 3) and faces of a block, in the axes of its file.

    Args:
        outline: (n, 2) or (n, 3) corners, in order round the block; the first may be there twice.
        thickness: in the unit of the file.
        up: the axis of the file that points upwards, "y" or "z".

    Raises:
        ValueError: fewer than three corners, or no area.
    """
    loop = np.array([(*map(float, corner), 0.0)[:3] for corner in outline]).reshape(-1, 3)
    if not len(loop) or not np.isfinite(loop).all():
        raise ValueError("an outline without corners")
    apart = np.abs(loop - np.roll(loop, 1, axis=0)).max(axis=1) > SAME * np.ptp(loop, axis=0).max()
    loop = loop[apart]
    spokes = loop - loop.mean(axis=0) if len(loop) else loop
    area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    size = float(np.linalg.norm(area))
    if len(loop) < 3 or not size > 0.0:
        raise ValueError("an outline without area")
    across = area / size
    if abs(across[2]) > 1.0 - FLAT and up == "z":
        loop, across = loop[:, [0, 2, 1]] * [1.0, -1.0, 1.0], np.array([0.0, 1.0, 0.0])
    back = across if (across @ [0.0, 1.0, 0.0] if up == "z" else -across[2]) >= 0.0 else -across
    return between(loop, loop + thickness * back)
