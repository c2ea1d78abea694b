# SPDX-License-Identifier: GPL-3.0-or-later
"""The height at which a mechanism is held: Z of the centroid of its constraint lines, as C8A.4.2.3 of Circolare 617/2009 has it."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from masonry_cd.analysis.limit.mechanism import STATES, Mechanism
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints

DIGITS = 9  # of metres; what is below is the rounding of corners


def held_at(moves: Mechanism, assembly: Assembly, joints: Joints) -> float:
    """The z at which a mechanism is held [m]: the centroid of the lines that constrain it, its hinges with what does not move.

    A line is as long as its joint along the axis of the hinge. A mechanism without such a hinge, which slides, is held at its lowest point.
    """
    moving = moves.moving & ~assembly.fixed
    hinged = moves.state == STATES.index("hinge")
    lines = np.flatnonzero(hinged & (moving[joints.block_a] != moving[joints.block_b]))
    if not len(lines):
        return lowest_point(assembly, np.flatnonzero(moving))
    axis = moves.velocity[joints.block_b[lines], 3:] - moves.velocity[joints.block_a[lines], 3:]
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    corners = [joints.polygon[joints.polygon_start[j] : joints.polygon_start[j + 1]] for j in lines]
    length = [np.ptp(polygon @ along) for polygon, along in zip(corners, axis, strict=True)]
    return round(float(np.average(moves.hinge[lines, 2], weights=length)), DIGITS) + 0.0


def lowest_point(assembly: Assembly, blocks: Iterable[int]) -> float:
    """The z of the lowest corner of some blocks [m]; zero of none."""
    return min((float(assembly.blocks[b].vertices[:, 2].min()) for b in blocks), default=0.0)
