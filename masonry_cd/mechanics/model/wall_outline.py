# SPDX-License-Identifier: GPL-3.0-or-later
"""A wall as a plan and its elevations show it: what structures say of it, and drawings take."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class WallOutline(NamedTuple):
    """A wall as drawn."""

    name: str
    line: np.ndarray  # (P, 2) axis in plan [m]
    thickness: float  # [m]
    top: np.ndarray  # (T, 2) distance along the axis, z [m]
    base: float  # z [m]
    openings: tuple[tuple[str, np.ndarray], ...]  # name, and corners (Q, 2): distance along the axis, z [m]
    reach: tuple[float, float] = (0.0, 0.0)  # by how much it goes on beyond the start and the end of its axis, to far faces [m]
