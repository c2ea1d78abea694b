# SPDX-License-Identifier: GPL-3.0-or-later
"""Forces of the joints over a step, from the impulses of their contacts."""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.dynamics.block_arrays import StepConstants
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows
from masonry_cd.mechanics.dynamics.step_problem import StepProblem
from masonry_cd.mechanics.dynamics.system import System


def joint_forces(
    system: System, made: StepProblem, impulse: np.ndarray, pair_joint: np.ndarray, joints: int
) -> tuple[np.ndarray, np.ndarray]:
    """Normal and shear force of each joint over a step, (2, J) [N], and where it crosses the joint's plane, (J, 3) [m].

    The places are those of q_m, in the middle of the step; NaN where a joint has no force. ``impulse`` (C, m) is that of the step [N s],
    ``pair_joint`` names the joint of each pair of parts or -1.
    """
    force, point = np.empty((2, joints)), np.empty((joints, 3))
    add_up(made.rows, made.found, system.constants, impulse, pair_joint, force, point)
    return force, point


@entry()
def add_up(
    rows: ContactRows,
    found: ContactSet,
    constants: StepConstants,
    impulse: np.ndarray,
    pair_joint: np.ndarray,
    force: np.ndarray,
    at: np.ndarray,
) -> None:
    """Fill normal and shear force [N] of each joint, (2, J), and where their resultant crosses its plane, (J, 3) [m].

    The contacts of a joint lie in its plane, so their tangential parts turn about its normal alone: the point about which the moment in the
    plane vanishes is the mean of the contact points weighted by normal impulse; NaN where there is none.
    """
    step, m = constants.step, impulse.shape[1]
    total = np.zeros((at.shape[0], 4))  # tangential force, normal impulse
    force[:], at[:] = 0.0, 0.0
    for c in range(impulse.shape[0]):
        k, joint = rows.active[c], pair_joint[rows.pair[c]]
        if joint < 0:
            continue
        force[0, joint] += impulse[c, 0] / step
        total[joint, 3] += impulse[c, 0]
        for d in range(3):
            at[joint, d] += impulse[c, 0] * (constants.plane_at if d == constants.plane_axis else found.point[k, d])
            for i in range(1, m):
                total[joint, d] += impulse[c, i] * rows.frame[c, i, d] / step
    for j in range(total.shape[0]):
        force[1, j] = np.sqrt(total[j, 0] ** 2 + total[j, 1] ** 2 + total[j, 2] ** 2)
        for d in range(3):
            at[j, d] = at[j, d] / total[j, 3] if total[j, 3] != 0.0 else np.nan
