# SPDX-License-Identifier: GPL-3.0-or-later
"""Links: two blocks, or a block and a support, held together in some of their six relative motions, whichever way these press.

    hinge     a point shared: in a plane a pin, in space a ball joint; with an axis it turns about that alone
    slider    free along an axis, without turning
    rigid     one body

A link stands in the place of whatever joint its two blocks have: they do not touch one another any more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.mechanics.model.components import connected_components

IN_PLANE = 1e-9  # of the largest coordinate, or of a unit vector: rounding of typed numbers


@dataclass(frozen=True, eq=False)
class Link:
    """A link between two blocks as built, world frame."""

    kind: str
    blocks: tuple[int, int]
    point: np.ndarray  # (3,) [m]
    axis: np.ndarray  # (3,) unit vector; zeros: none

    @property
    def frame(self) -> np.ndarray:
        """Three unit vectors as rows (3, 3), of which the first is the axis."""
        if not self.axis.any():
            return np.eye(3)
        second = np.cross(np.eye(3)[int(np.argmin(np.abs(self.axis)))], self.axis)
        second /= np.sqrt(second @ second)
        return np.array([self.axis, second, np.cross(self.axis, second)])

    @property
    def held(self) -> np.ndarray:
        """Which of three shifts along and three turns about the rows of its frame are none, (6,) bool."""
        turned = self.axis.any()
        return np.array(
            {
                "hinge": [True] * 3 + [False, bool(turned), bool(turned)],
                "slider": [False] + [True] * 5,
                "rigid": [True] * 6,
            }[self.kind]
        )

    def leaves_plane(self, axis: int, at: float) -> bool:
        """True when it would move blocks out of the plane where coordinate ``axis`` equals ``at`` [m]."""
        across = abs(float(self.axis[axis]))
        off = self.kind == "hinge" and abs(float(self.point[axis]) - at) > IN_PLANE * max(1.0, float(np.abs(self.point).max()))
        return bool(off or IN_PLANE < across < 1.0 - IN_PLANE)


def clusters(links: Sequence[Link], fixed: np.ndarray) -> np.ndarray:
    """Numbers of the sets of blocks (B,) that links hang together, supports (B,) apart, from 0 on; a block without a link is its own."""
    pairs = np.array([link.blocks for link in links if not fixed[list(link.blocks)].any()], dtype=np.int64).reshape(-1, 2)
    return connected_components(pairs[:, 0], pairs[:, 1], len(fixed))
