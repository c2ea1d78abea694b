# SPDX-License-Identifier: GPL-3.0-or-later
r"""The curve of a bond that softens: its damage D by the separation of a point, and what that has taken of the fracture energy.

With the opening g, the slip s beyond what friction alone bears elastically, and the springs k_n, k_t of the joint,

    lambda^2 = k_n <g>^2 + k_t s^2,      B = k_t s^2 / lambda^2,      s = < |slip| - mu k_n <-g> / k_t >,

are an equivalent separation and the share of shear in it, as of Camanho & Davila (NASA/TM-2002-211737, 2002), but with a stiffness for
each direction. Onset is their quadratic criterion of stress, and what the bond takes in all the power law with the exponent 1:

    1 / Y(B) = (1 - B) 2 k_n / f_t^2 + B 2 k_t / c^2,        1 / G(B) = (1 - B) / G_I + B / G_II.

At a fixed B the stress in the measure of lambda falls from lambda_0 = sqrt(2 Y) as lambda_0 phi(r), lambda = lambda_0 (1 + rho r),

    phi = 1 - r,  rho = G/Y - 1    (linear)        or        phi = exp(-r),  rho = (G/Y - 1) / 2    (exponential, to r = ln 1e4),

so that the area under the curve is G, and 1 - D = phi / (1 + rho r). D only grows, whatever B does, and so does what is lost.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.special import wrightomega

from masonry_cd.foundation import libm
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws

LEFT = 1e-4  # share of the strength at which a curve ends
END = -math.log(LEFT)  # r at which an exponential one does


def opening_at_end(laws: JointLaws) -> np.ndarray:
    """Openings (N,) at which bonds that soften are gone, of the pairs of groups that have one [m]."""
    first, second = np.nonzero(laws.fracture > 0.0)
    curves = Curves.of(laws, np.zeros_like(laws.apex), (first, second))
    rho = (curves.fracture[:, 0] / curves.onset[:, 0] - 1.0) * np.where(curves.exponential, 0.5, 1.0)
    end = np.where(curves.exponential, END, 1.0)
    return laws.tension[first, second] / curves.normal * (1.0 + rho * end)


class Mix(NamedTuple):
    """How far apart points are, (N,) each."""

    r: np.ndarray  # along the curve; 0: below the strength
    rho: np.ndarray  # length of the curve
    energy: np.ndarray  # G [N/m]
    slip: np.ndarray  # s [m]
    held: np.ndarray  # slip that friction bears elastically, mu k_n <-g> / k_t [m]


class Curves(NamedTuple):
    """The curves of N points."""

    normal: np.ndarray  # (N,) k_n [N/m3]
    tangential: np.ndarray  # (N,) k_t [N/m3]
    friction: np.ndarray  # (N,) mu
    onset: np.ndarray  # (N, 2) f_t^2 / 2 k_n and c^2 / 2 k_t [N/m]
    fracture: np.ndarray  # (N, 2) G_I and G_II [N/m]
    exponential: np.ndarray  # (N,) bool
    bound: np.ndarray  # (N,) tip of a cone of slope mu around the strengths in tension and shear [Pa]

    @classmethod
    def of(cls, laws: JointLaws, friction: np.ndarray, groups: tuple[np.ndarray, np.ndarray]) -> Curves:
        """Those between pairs of groups, two of (N,); ``friction`` (G, G)."""
        k_n, k_t, mu, apex, tension = (
            table[groups] for table in (laws.normal_stiffness, laws.tangential_stiffness, friction, laws.apex, laws.tension)
        )
        onset = np.stack([tension**2 / (2.0 * k_n), (mu * apex) ** 2 / (2.0 * k_t)], axis=1)
        fracture = np.stack([laws.fracture[groups], laws.shear_fracture[groups]], axis=1)
        return cls(k_n, k_t, mu, onset, fracture, laws.exponential[groups] > 0.0, np.sqrt(apex**2 + tension**2))

    def some(self, which: np.ndarray) -> Curves:
        """Those of some points, by their indices."""
        return Curves(*[each[which] for each in self])

    def mix(self, stretch: np.ndarray, slip: np.ndarray) -> Mix:
        """Points with openings and sizes of slip (N,) [m]."""
        held = self.friction * self.normal * np.maximum(0.0, -stretch) / self.tangential
        beyond = np.maximum(0.0, slip - held)
        across, along = self.normal * np.maximum(0.0, stretch) ** 2, self.tangential * beyond**2
        square = across + along
        shear = np.divide(along, square, out=np.zeros(len(square)), where=square > 0.0)
        share = np.stack([1.0 - shear, shear], axis=1)
        onset, energy = (1.0 / (share / each).sum(axis=1) for each in (self.onset, self.fracture))
        rho = (energy / onset - 1.0) * np.where(self.exponential, 0.5, 1.0)
        r = np.maximum(0.0, np.sqrt(square / (2.0 * onset)) - 1.0) / rho
        return Mix(r, rho, energy, beyond, held)

    def strength(self, r: np.ndarray) -> np.ndarray:
        """phi (N,), the share of the strength that is left."""
        phi, curved = 1.0 - r, np.flatnonzero(self.exponential & (r > 0.0))
        phi[curved] = libm.exp(-np.minimum(r[curved], 2.0 * END))
        return np.where(phi > LEFT, phi, 0.0)

    def damage(self, r: np.ndarray, rho: np.ndarray) -> np.ndarray:
        """D (N,) at places on the curves."""
        return 1.0 - self.strength(r) / (1.0 + rho * r)

    def place(self, damage: np.ndarray, rho: np.ndarray) -> np.ndarray:
        """r (N,) at a damage below 1; infinite at 1."""
        left = 1.0 - damage
        r = damage / (1.0 + rho * left)
        curved = np.flatnonzero(self.exponential & (damage > 0.0) & (left > 0.0))
        inverse = 1.0 / rho[curved]
        r[curved] = np.maximum(0.0, wrightomega(inverse - libm.log(left[curved] / inverse)) - inverse)
        return np.where(left > 0.0, r, np.inf)

    def taken(self, r: np.ndarray, rho: np.ndarray) -> np.ndarray:
        """Share (N,) of the fracture energy that the bond has taken: the area under the curve less what the spring gives back."""
        phi, finite = self.strength(r), np.minimum(r, 1e3)
        area = 0.5 + rho * np.where(self.exponential, 1.0 - phi, finite - 0.5 * finite**2)
        whole = 0.5 + rho * np.where(self.exponential, 1.0, 0.5)
        return np.where(phi > 0.0, (area - 0.5 * phi * (1.0 + rho * finite)) / whole, 1.0)
