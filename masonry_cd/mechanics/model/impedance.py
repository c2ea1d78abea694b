# SPDX-License-Identifier: GPL-3.0-or-later
r"""Springs and dashpots of a rigid rectangular footing on an elastic half-space, by Pais & Kausel (1988).

With half the sides L >= B, the depth D of embedment, the shear modulus G = rho V_s^2, Poisson's ratio nu, a_0 = omega B / V_s and
psi = sqrt(2 (1 - nu) / (1 - 2 nu)) <= 2.5, stiffness alpha eta K and dashpot C in six directions, x along L:

    direction   K                                                       eta (embedment)
    x           G B   / (2 - nu) (6.8 (L/B)^0.65 + 2.4)                 1 + (0.33 + 1.34 / (1 + L/B)) (D/B)^0.8
    y           G B   / (2 - nu) (6.8 (L/B)^0.65 + 0.8 L/B + 1.6)       as x
    z           G B   / (1 - nu) (3.1 (L/B)^0.75 + 1.6)                 1 + (0.25 + 0.25 / (L/B)) (D/B)^0.8
    about x     G B^3 / (1 - nu) (3.2 L/B + 0.8)                        1 + D/B + 1.6 / (0.35 + L/B) (D/B)^2
    about y     G B^3 / (1 - nu) (3.73 (L/B)^2.4 + 0.27)                1 + D/B + 1.6 / (0.35 + (L/B)^4) (D/B)^2
    about z     G B^3            (4.25 (L/B)^2.45 + 4.06)               1 + (1.3 + 1.32 / (L/B)) (D/B)^0.9

Radiation damping of shifts does not depend on the frequency: rho V_s on what shears the soil, rho psi V_s on what presses it, base and
sides. That of turns does, and vanishes with it: its share of the high-frequency limit is a_0^2 / (q + a_0^2). alpha <= 1 falls with it.
Turns of an embedded footing have the dashpots of one at the surface, which are smaller.

Source: NIST GCR 12-917-21, Soil-Structure Interaction for Building Structures (2012), tables 2-2a (K), 2-2b (eta), 2-3a (alpha, radiation)
and 2-3b (radiation of embedded footings); K and beta of y and of the turn about x, alpha and psi also ASCE/SEI 7-16, eq. 19.3-8 to 19.3-14.
A. Pais, E. Kausel, Soil Dyn. Earthq. Eng. 7(4), 1988.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

LARGEST_PSI = 2.5


@dataclass(frozen=True)
class Soil:
    """An elastic half-space."""

    shear_modulus: float  # G [Pa]
    density: float  # rho [kg/m3]
    poisson: float  # nu
    embedment: float = 0.0  # D [m]

    @property
    def velocity(self) -> float:
        """V_s, of shear waves [m/s]."""
        return math.sqrt(self.shear_modulus / self.density)


def impedance(soil: Soil, length: float, width: float, omega: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness (6,) [N/m, N m] and dashpots (6,) [N s/m, N m s] along and about x, y and z.

    Args:
        soil: below.
        length: 2 L, along x [m].
        width: 2 B, not more [m].
        omega: circular frequency at which both are taken [1/s]; 0: static stiffness, and no dashpots of turns.
    """
    b, nu, r = 0.5 * width, soil.poisson, length / width
    d, a = soil.embedment / b, (omega * 0.5 * width / soil.velocity) ** 2  # D/B, a_0^2
    shift, turn = soil.shear_modulus * b, soil.shear_modulus * b**3
    static = np.array(
        [
            shift / (2.0 - nu) * (6.8 * r**0.65 + 2.4),
            shift / (2.0 - nu) * (6.8 * r**0.65 + 0.8 * r + 1.6),
            shift / (1.0 - nu) * (3.1 * r**0.75 + 1.6),
            turn / (1.0 - nu) * (3.2 * r + 0.8),
            turn / (1.0 - nu) * (3.73 * r**2.4 + 0.27),
            turn * (4.25 * r**2.45 + 4.06),
        ]
    )
    along = 1.0 + (0.33 + 1.34 / (1.0 + r)) * d**0.8
    embedded = np.array(
        [
            along,
            along,
            1.0 + (0.25 + 0.25 / r) * d**0.8,
            1.0 + d + 1.6 / (0.35 + r) * d**2,
            1.0 + d + 1.6 / (0.35 + r**4) * d**2,
            1.0 + (1.3 + 1.32 / r) * d**0.9,
        ]
    )
    at_frequency = 1.0 - a * np.array(
        [
            0.0,
            0.0,
            (0.4 + 0.2 / r) / (10.0 / (1.0 + 3.0 * (r - 1.0)) + a),
            (0.55 + 0.01 * math.sqrt(r - 1.0)) / (2.4 - 0.4 / r**3 + a),
            0.55 / (0.6 + 1.4 / r**3 + a),
            (0.33 - 0.03 * math.sqrt(r - 1.0)) / (0.8 / (1.0 + 0.33 * (r - 1.0)) + a),
        ]
    )
    return static * embedded * at_frequency, _radiation(soil, r, b, d, a)


def _radiation(soil: Soil, r: float, b: float, d: float, a: float) -> np.ndarray:
    """The dashpots (6,), of L/B, B [m], D/B and a_0^2."""
    nu = soil.poisson
    psi = min(math.sqrt(2.0 * (1.0 - nu) / (1.0 - 2.0 * nu)), LARGEST_PSI) if nu < 0.5 else LARGEST_PSI
    wave = soil.density * soil.velocity
    return wave * np.array(
        [
            4.0 * b**2 * (r + d * (psi + r)),
            4.0 * b**2 * (r + d * (1.0 + psi * r)),
            4.0 * b**2 * (psi * r + d * (1.0 + r)),
            4.0 / 3.0 * b**4 * psi * r * a / (2.2 - 0.4 / r**3 + a),
            4.0 / 3.0 * b**4 * psi * r**3 * a / (1.8 / (1.0 + 1.75 * (r - 1.0)) + a),
            4.0 / 3.0 * b**4 * r * (r**2 + 1.0) * a / (1.4 / (1.0 + 3.0 * (r - 1.0) ** 0.7) + a),
        ]
    )
