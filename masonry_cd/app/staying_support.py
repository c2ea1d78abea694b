# SPDX-License-Identifier: GPL-3.0-or-later
"""The support to which displacements are relative, and gauges that it must not turn under."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.io.gauges import Gauges
from masonry_cd.mechanics.dynamics.pauses import ALIKE
from masonry_cd.mechanics.dynamics.system import WITH_ROTATION
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import Joints


def staying_support(assembly: Assembly, velocity: np.ndarray, tick: float, joints: Joints, supports: np.ndarray) -> int:
    """The support that the loads move least, the first of those that they move alike; -1 where there is none.

    Supports on which nothing stands, such as a ground between abutments, count only where there are no others.

    Args:
        assembly: the blocks.
        velocity: (N + 1, S, 3 or 6) of the motions of supports [m/s, rad/s].
        tick: time between two of them [s].
        joints: as built.
        supports: (B,) bool: blocks that are supports to the end of the run.
    """
    fixed = np.flatnonzero(supports)
    if not len(fixed):
        return -1
    bearing = fixed[np.isin(fixed, [joints.block_a, joints.block_b])]
    fixed = bearing if len(bearing) else fixed
    along = assembly.in_metres(np.cumsum(0.5 * tick * (velocity[1:] + velocity[:-1]), axis=0))
    farthest = np.sqrt((along * along).sum(axis=2)).max(axis=0, initial=0.0)[assembly.support_of[fixed]]
    return int(fixed[np.argmax(farthest <= farthest.min() + ALIKE * farthest.max())])


def refuse_turning(gauges: Gauges, assembly: Assembly, velocity: np.ndarray, tick: float, joints: Joints) -> None:
    """Refuse points whose displacement would be relative to a support that turns: the gauges take its shift off alone.

    Raises:
        InputError: names the first of them.
    """
    first = next((i for i, one in enumerate(gauges.points) if one.relative), None)
    if first is None or velocity.shape[2] != WITH_ROTATION:
        return
    base = staying_support(assembly, velocity, tick, joints, assembly.fixed)
    if base >= 0 and velocity[:, assembly.support_of[base], 3:].any():
        name = assembly.names[base]
        raise InputError(
            f"output.point[{first}].relative", f'is to "{name}", which turns; relative = false gives displacements in the world'
        )
