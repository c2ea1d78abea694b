# SPDX-License-Identifier: GPL-3.0-or-later
r"""Elastic response spectra, and the shape that most codes have: with eta = sqrt(10 / (5 + 100 xi)) >= 0.55 for the damping xi, a start s
up to T_A and a plateau at P eta,

    S(T) = a s                                                    0   <= T <= T_A
           a (s + (P eta - s) (T - T_A) / (T_B - T_A))            T_A <= T <= T_B
           a P eta                                                T_B <= T <= T_C
           a P eta T_C / T                                        T_C <= T <= T_D
           a P eta T_C T_D / T^2                                  T_D <= T

The displacement of an oscillator is S (T / 2 pi)^2. Where a code has T_E and T_F it is so up to T_E, and from there on comes down to that
of the ground at T_F (EN 1998-1, annex A, type 1; NTC 2018, 3.2.3.2.3):

    S_D(T) = 0.025 a T_C T_D (P eta + (1 - P eta) (T - T_E) / (T_F - T_E)),     T_E <= T <= T_F
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

USUAL_DAMPING = 0.05  # for which code spectra stand
LONG_PERIODS = {"A": (4.5, 10.0), "B": (5.0, 10.0), "C": (6.0, 10.0), "D": (6.0, 10.0), "E": (6.0, 10.0)}  # T_E, T_F of EC8 and NTC
VERTICAL_PERIODS = (0.05, 0.15, 1.0)  # T_B, T_C, T_D of EC8 and NTC
PEAK = "peak acceleration of the ground"


class CodeQuantity(NamedTuple):
    """A row of a code's table: what a symbol stands for."""

    unit: str
    clause: str
    meaning: str
    formula: str = ""  # in symbols of earlier values; empty of what is given, or read from a curve


def common_rows(clause: str) -> dict[str, CodeQuantity]:
    """The quantities that all spectra have, with the clause of a code."""
    return {
        "Se(T)": CodeQuantity("m/s2", clause, "elastic spectrum at that period"),
        "eta": CodeQuantity("", clause, "what the damping makes of the spectrum", "max(0.55, sqrt(10 / (5 + 100 xi)))"),
        "TE": CodeQuantity("s", clause, "from which displacements fall"),
        "TF": CodeQuantity("s", clause, "from which they are that of the ground"),
    }


def damping_factor(damping: float) -> float:
    """eta of a damping ratio: what it makes of a spectrum for 5 %."""
    return float(max(0.55, np.sqrt(10.0 / (5.0 + 100.0 * damping))))


class ElasticSpectrum:
    """Interface of every elastic response spectrum."""

    long: tuple[float, float] | None = None  # T_E, T_F [s]; None where displacements do not come down

    @property
    def longest(self) -> float:
        """The period up to which it is known [s]."""
        return math.inf

    def at(self, period: np.ndarray, damping: float = USUAL_DAMPING) -> np.ndarray:
        """Pseudo-acceleration at periods (n,) of zero or more [m/s2].

        Raises:
            InputError: a period beyond a table.
        """
        raise NotImplementedError

    def displacement(self, period: np.ndarray, damping: float = USUAL_DAMPING) -> np.ndarray:
        """Displacement at periods (n,) of zero or more, relative to the ground [m]."""
        t = np.asarray(period, dtype=float)
        return np.asarray(self.at(t, damping) * (t / (2.0 * np.pi)) ** 2)

    def formula(self, period: float, of: str, damped: bool) -> str:
        """S_e at a period whose symbol is ``of``, in symbols; empty where it is read from a table."""
        return ""

    def falling(self, period: float, of: str, damped: bool) -> str:
        """S_De of a long period in symbols, where it is not S_e (T / 2 pi)^2."""
        return ""

    def scales_by_eta(self, damping: float) -> bool:
        """True where ordinates of that damping are those of another times a factor."""
        return damping != USUAL_DAMPING


@dataclass(frozen=True)
class CodeSpectrum(ElasticSpectrum):
    """An elastic response spectrum of the shape above."""

    size: float  # a [m/s2]
    start: float  # s
    plateau: float  # P
    corners: tuple[float, float, float]  # T_B, T_C, T_D [s]
    long: tuple[float, float] | None = None  # T_E, T_F [s]; None where a code has none
    soil: float = 1.0  # S of EC8, SS of NTC
    hill: float = 1.0  # ST
    stretch: float = 1.0  # CC
    flat: float = 0.0  # T_A [s]

    def at(self, period: np.ndarray, damping: float = USUAL_DAMPING) -> np.ndarray:
        """Pseudo-acceleration at periods (n,) of zero or more [m/s2]."""
        t, (b, c, d) = np.asarray(period, dtype=float), self.corners
        top = self.plateau * damping_factor(damping)
        rise = self.start + (top - self.start) * (np.clip(t, self.flat, b) - self.flat) / (b - self.flat)
        fall = np.minimum(1.0, c / np.maximum(t, c)) * np.minimum(1.0, d / np.maximum(t, d))
        return np.asarray(self.size * rise * fall)

    def displacement(self, period: np.ndarray, damping: float = USUAL_DAMPING) -> np.ndarray:
        """Displacement at periods (n,) of zero or more, relative to the ground [m]."""
        t = np.asarray(period, dtype=float)
        short = super().displacement(t, damping)
        if self.long is None:
            return short
        top, (begin, end) = self.plateau * damping_factor(damping), self.long
        share = np.clip((t - begin) / (end - begin), 0.0, 1.0)
        falling = 0.025 * self.size * self.corners[1] * self.corners[2] * (top + (1.0 - top) * share)
        return np.where(t > begin, falling, short)

    def formula(self, period: float, of: str, damped: bool) -> str:
        """S_e of the branch on which a period lies, in symbols."""
        (begin, end, far), top = self.corners, "eta F0" if damped else "F0"
        if period < self.flat:
            return "ag S"
        if period < begin:
            return f"ag S (1 + ({top} - 1) {f'({of} - TA) / (TB - TA)' if self.flat else f'{of} / TB'})"
        if period < end:
            return f"ag S {top}"
        return f"ag S {top} TC / {of}" if period < far else f"ag S {top} TC TD / {of}^2"

    def falling(self, period: float, of: str, damped: bool) -> str:
        """S_De beyond T_E, in symbols."""
        if self.long is None or period <= self.long[0]:
            return ""
        top = "eta F0" if damped else "F0"
        return f"0.025 ag S TC TD ({top} + (1 - {top}) min(({of} - TE) / (TF - TE), 1))"
