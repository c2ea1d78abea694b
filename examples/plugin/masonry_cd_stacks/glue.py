# SPDX-License-Identifier: GPL-3.0-or-later
"""``mc.Simulation(scene, law="glue")``: joints glued by a soft bond, which breaks for good where it opens or slips by more than LIMIT."""

from __future__ import annotations

import numpy as np

from masonry_cd import JointLaw

STIFFNESS, LIMIT = 1e8, 1e-3  # [Pa/m], [m]


def stresses(opening: np.ndarray, slip: np.ndarray, history: np.ndarray, step: float, stress: np.ndarray) -> None:
    """Fill the stresses (K, 3) of K points [Pa]; their history (K, 1) becomes 1 where the bond is broken."""
    apart = np.sqrt(np.maximum(opening, 0.0) ** 2 + np.sum(slip**2, axis=1))
    history[:, 0] = np.where(apart > LIMIT, 1.0, history[:, 0])
    bound = STIFFNESS * (1.0 - history[:, 0])
    stress[:, 0] = bound * np.maximum(opening, 0.0)
    stress[:, 1:] = bound[:, None] * slip


GLUE = JointLaw(stresses, stiffness=STIFFNESS, history=1)
