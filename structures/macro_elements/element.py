# SPDX-License-Identifier: GPL-3.0-or-later
"""A macro-element: blocks that may give way together, where to, and by which mechanisms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

OVERTURNING = "overturning"  # of the part above a bed, alone or with a wedge of the walls that it is bonded with
VERTICAL_BENDING = "vertical bending"  # about a bed at mid-height, where its top is held
HORIZONTAL_BENDING = "horizontal bending"  # about an upright line, its ends held
CORNER = "corner overturning"
PIERS = "rocking and sliding of piers"
IN_PLANE = "in-plane shear"
HINGES = "hinges of an arch"  # by the free least mechanism alone
MECHANISMS = (OVERTURNING, VERTICAL_BENDING, HORIZONTAL_BENDING, CORNER, PIERS, IN_PLANE, HINGES)

Vector = tuple[float, float, float]
EAST, WEST, NORTH, SOUTH = (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0)
AROUND = (EAST, WEST, NORTH, SOUTH)


@dataclass(frozen=True, eq=False)
class MacroElement:
    """A part of a structure."""

    name: str
    kind: str  # facade, side wall, gable, tower ...
    blocks: np.ndarray  # (N,) their numbers
    directions: tuple[Vector, ...]  # of the pushes, level and of length one
    mechanisms: tuple[str, ...]  # in addition to the free least one, which is looked for in each
    levels: tuple[float, float] | None = None  # heights between which the lines lie about which it overturns [m]; None: at its foot only
    piers: tuple[np.ndarray, ...] = ()  # blocks of each pier; the others of the part rest on them
