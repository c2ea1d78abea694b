# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed forms of vibrating beams and bars, for the tests of the modal check."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

STATE = {"w": 0, "turn": 1, "moment": 2, "shear": 3}
FREE, CLAMPED, HINGED = ("moment", "shear"), ("w", "turn"), ("w", "moment")  # what vanishes at an end


@dataclass(frozen=True)
class Beam:
    """A Timoshenko beam of rectangular section; the depth is measured in the direction of the motion. SI units."""

    length: float
    depth: float
    width: float
    young: float
    poisson: float
    density: float

    def frequencies(self, first: tuple[str, str], last: tuple[str, str], count: int) -> list[float]:
        """The lowest bending frequencies [Hz] from the transfer matrix of s' = A s, s = (w, turn, moment, shear).

        w' = turn + V/(kappa G A), turn' = M/(E I), M' = -V - rho I om^2 turn, V' = -rho A om^2 w. A frequency makes the determinant
        of the conditions at the far end vanish. Shear coefficient by Cowper, J. Appl. Mech. 33 (1966).
        """
        out: list[float] = []
        step = 0.05 * self.euler(1)
        low, before = 0.5 * step, self._determinant(0.5 * step, first, last)
        while len(out) < count:
            high = low + step
            after = self._determinant(high, first, last)
            if before * after < 0:
                out.append(float(brentq(self._determinant, low, high, (first, last), xtol=1e-10 * high)))
            low, before = high, after
        return out

    def euler(self, mode: int) -> float:
        """Return the frequency of the hinged beam without shear and rotary inertia [Hz]."""
        return np.pi / 2 * mode**2 / self.length**2 * np.sqrt(self.young * self.depth**2 / 12 / self.density)

    def _determinant(self, frequency: float, first: tuple[str, str], last: tuple[str, str]) -> float:
        area, inertia = self.depth * self.width, self.width * self.depth**3 / 12
        kappa = 10 * (1 + self.poisson) / (12 + 11 * self.poisson)
        shear = kappa * area * self.young / (2 * (1 + self.poisson))
        square = (2 * np.pi * frequency) ** 2
        a = np.zeros((4, 4))
        a[0, 1], a[0, 3], a[1, 2] = 1.0, 1.0 / shear, 1.0 / (self.young * inertia)
        a[2, 3], a[2, 1], a[3, 0] = -1.0, -self.density * inertia * square, -self.density * area * square
        scale = np.array([1.0, 1.0 / self.length, self.young * inertia / self.length**2, self.young * inertia / self.length**3])
        transfer = expm(a * self.length) / scale[:, None] * scale[None, :]
        unknown = [k for name, k in STATE.items() if name not in first]
        vanish = [STATE[name] for name in last]
        return float(np.linalg.det(transfer[np.ix_(vanish, unknown)]))


def chain(count: int, stiffness: float, mass: float, half_base: bool) -> np.ndarray:
    """Frequencies [Hz] of n equal masses on equal springs, the far end free; the spring at the base may be twice as stiff.

    Waves of wave number q: om = 2 sqrt(k/m) sin(q/2), q = (2 j - 1) pi / (2 n + 1), or (2 j - 1) pi / (2 n) with the stiff base.
    """
    j = np.arange(1, count + 1)
    q = (2 * j - 1) * np.pi / (2 * count + (0 if half_base else 1))
    return np.sqrt(stiffness / mass) * np.sin(q / 2) / np.pi
