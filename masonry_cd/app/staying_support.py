# SPDX-License-Identifier: GPL-3.0-or-later
"""The support to which displacements are relative."""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.pauses import ALIKE
from masonry_cd.mechanics.model.joints import Joints


def staying_support(stepper: Stepper, joints: Joints, supports: np.ndarray) -> int:
    """The support that the loads move least, the first of those that they move alike; -1 where there is none.

    Supports on which nothing stands, such as a ground between abutments, count only where there are no others. Which blocks are
    ``supports`` (B,) bool to the end of the run is for the caller to say.
    """
    assembly, velocity = stepper.assembly, stepper.system.loads.support_velocity
    fixed = np.flatnonzero(supports)
    if not len(fixed):
        return -1
    bearing = fixed[np.isin(fixed, [joints.block_a, joints.block_b])]
    fixed = bearing if len(bearing) else fixed
    along = assembly.in_metres(np.cumsum(0.5 * stepper.settings.dt * (velocity[1:] + velocity[:-1]), axis=0))
    farthest = np.sqrt((along * along).sum(axis=2)).max(axis=0, initial=0.0)[assembly.support_of[fixed]]
    return int(fixed[np.argmax(farthest <= farthest.min() + ALIKE * farthest.max())])
