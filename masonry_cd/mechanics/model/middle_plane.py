# SPDX-License-Identifier: GPL-3.0-or-later
"""The plane about which a structure of prisms is its own mirror image."""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.model.blocks import Assembly

FLAT = 1e-9  # relative to the size of the structure


def middle_plane(assembly: Assembly, axis: int) -> float | None:
    """Where on ``axis`` the common middle plane of blocks lies that are all prisms along it [m], or None if they are not."""
    shapes = assembly.shapes
    tolerance = FLAT * float(np.ptp(np.concatenate([block.vertices for block in assembly.blocks]), axis=0).max())
    slanted = np.abs(shapes.solids.normals[:, axis])
    if np.any((slanted > FLAT) & (slanted < 1.0 - FLAT)):
        return None
    middles = []
    for block in assembly.blocks:
        along = block.vertices[:, axis]
        middle = 0.5 * float(along.min() + along.max())
        if np.any(np.abs(np.abs(along - middle) - 0.5 * np.ptp(along)) > tolerance):
            return None  # a corner between the two end faces
        middles.append(middle)
    return middles[0] if max(middles) - min(middles) <= tolerance else None
