# SPDX-License-Identifier: GPL-3.0-or-later
"""Constants of a run, as the kernels of the step read them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class BlockArrays(NamedTuple):
    """The blocks as the kernels read them: B blocks, F of them free, with n unknowns each, of which those here are the first."""

    mass: np.ndarray  # (B,) [kg]
    inertia: np.ndarray  # (B, 3, 3) body frame [kg m2]
    inverse_inertia: np.ndarray  # (B, 3, 3)
    free_index: np.ndarray  # (B,) place among the free blocks; -1: a support
    support_of: np.ndarray  # (B,) prescribed motion of a support; -1: a free block
    group_of: np.ndarray  # (B,)
    stone: np.ndarray  # (B,) number of the stone that a block is a piece of; -1: of none
    plane_row: np.ndarray  # (B,) row of the tables of friction and joint laws for the planes within that
    columns: np.ndarray  # (k,) of a rigid block among (vx, vy, vz, wx, wy, wz): all six in space, three in a plane


class StepConstants(NamedTuple):
    """Numbers that the kernels of every step need."""

    step: float  # h [s]
    plane_axis: int  # axis normal to the plane of a planar scene; -1: a scene in space
    plane_at: float  # coordinate of the plane on that axis [m]
    closed: float  # gaps up to this one count as closed [m]
