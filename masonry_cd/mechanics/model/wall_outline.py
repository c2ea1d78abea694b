# SPDX-License-Identifier: GPL-3.0-or-later
"""A wall as a plan and its elevations show it: what structures say of it, and drawings take."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

SPOT = 1e-9  # length of what has no direction [m]


class WallOutline(NamedTuple):
    """A wall as drawn."""

    name: str
    line: np.ndarray  # (P, 2) axis in plan [m]
    thickness: float  # [m]
    top: np.ndarray  # (T, 2) distance along the axis, z [m]
    base: float  # z [m]
    openings: tuple[tuple[str, np.ndarray], ...]  # name, and corners (Q, 2): distance along the axis, z [m]
    reach: tuple[float, float] = (0.0, 0.0)  # by how much it goes on beyond the start and the end of its axis, to far faces [m]
    storey: int = 0  # of several that are drawn by themselves, from 0 on

    @property
    def drawn_out(self) -> np.ndarray:
        """The axis (P, 2) from end to end [m]."""
        (a, b), (y, z) = self.line[:2], self.line[-2:]
        start, end = (by * (q - p) / max(np.hypot(*(q - p)), SPOT) for by, (p, q) in zip(self.reach, ((a, b), (y, z)), strict=True))
        return np.concatenate([[a - start], self.line[1:-1], [z + end]])

    @property
    def ground(self) -> Any:
        """The polygon of shapely that it covers; an empty one of an axis that stays on the spot."""
        import shapely

        return shapely.LineString(self.drawn_out).buffer(0.5 * self.thickness, cap_style="flat", join_style="mitre")
