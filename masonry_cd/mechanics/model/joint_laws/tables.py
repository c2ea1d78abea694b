# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint laws between groups of blocks as arrays, which kernels and limit analysis read."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np


@dataclass(frozen=True, eq=False)
class JointLaws:
    """The joint laws between G groups, (G, G) symmetric tables; zeros: rigid and dry."""

    normal_stiffness: np.ndarray  # [N/m3]; 0: by the moduli, or else rigid
    tangential_stiffness: np.ndarray  # [N/m3]
    tension: np.ndarray  # tensile strength [Pa]
    apex: np.ndarray  # tension at the tip of the Mohr-Coulomb cone, cohesion / mu [Pa]; 0: no bond
    theta: np.ndarray  # of the spring over the step, 1/2 to 1
    retardation: np.ndarray  # coefficient of the dashpot over the stiffness [s]
    at_first_period: np.ndarray  # share of critical of dashpots whose retardation follows from the first elastic period; 0 elsewhere
    fracture: np.ndarray  # G_I of a bond that softens [N/m]; 0: it breaks at once
    shear_fracture: np.ndarray  # its G_II [N/m]
    exponential: np.ndarray  # 1: its stress falls exponentially; 0: linearly
    crushing: np.ndarray  # compressive strength [Pa]; 0: never crushes
    points: np.ndarray  # over the depth, of elastic joints that open; odd
    moduli: tuple[float, float] | None = None  # E and G of the masonry, whose joints are as stiff as joint_stiffness.py has it [Pa]

    @classmethod
    def none(cls, groups: int, moduli: tuple[float, float] | None = None) -> Self:
        """Tables of zeros, to be filled."""
        tables = (field.name for field in fields(cls) if field.name != "moduli")
        return cls(**{name: np.zeros((groups, groups)) for name in tables}, moduli=moduli)

    @property
    def elastic(self) -> np.ndarray:
        """(G, G) bool: joints that are not rigid."""
        return (self.normal_stiffness > 0.0) | (self.moduli is not None)

    @property
    def by_area(self) -> np.ndarray:
        """(G, G) bool: joints whose law is per area, elastic ones and bonded ones."""
        return self.elastic | (self.apex > 0.0)

    def damped_at(self, frequency: float) -> JointLaws:
        """The laws where the first elastic frequency is known [Hz]."""
        beta = self.at_first_period / (math.pi * frequency)
        return replace(self, retardation=np.where(self.at_first_period > 0.0, beta, self.retardation))

    def unbonded(self) -> JointLaws:
        """The laws of joints whose bonds are broken."""
        return replace(self, **{name: 0.0 * getattr(self, name) for name in ("apex", "tension", "fracture", "shear_fracture")})
