# SPDX-License-Identifier: GPL-3.0-or-later
r"""NZS 1170.5:2004, 3.1.1: C(T) = C_h(T) Z R N(T, D), the level spectrum in g, with C_h of the modal and time-history methods.

    C_h = s + (p - s) T / 0.1      T   <= 0.1 s          N = 1                                   R <= 0.75, or D > 20 km
          p                        0.1 <= T <= t         N = 1 + (N_max - 1) (20 - D) / 18       2 km <= D <= 20 km
          c (b / T)^0.75           t   <= T <= 1.5 s     N = N_max                               D <= 2 km
          d / T                    1.5 <= T <= 3 s
          3 d / T^2                3 s <= T

with s, p, t, c, b, d by subsoil class, and N_max straight between its values. At the ends of branches the constants, which are rounded,
differ by up to 0.5 %; p is an upper bound. For other dampings p, c and d are taken times the eta of EN 1998-1:2004, and s is left as it is.
Class D by its site period, between C and D, is left out.

Read in NZS1170_Seismic_Coefficient.bas of NZS1170.5-Seismic-Coefficient-functions, after the commentary of the standard, and in sha_calc of
gmhazard (nzs1170p5_spectra); they agree but for 3 d of class E, 9.96 and 9.66, of which the first is continuous. The standard itself was
not read.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from loads.motion import Positive
from loads.signal.spectra.kind import Fact, SiteKeys, SpectrumKind, in_proportion
from loads.signal.spectra.shape import PEAK, USUAL_DAMPING, CodeQuantity, ElasticSpectrum, common_rows, damping_factor
from masonry_cd.foundation import libm
from masonry_cd.foundation.units import Unit

CLASSES = {  # s, p, t [s], c, b [s], d
    "A": (1.0, 2.35, 0.3, 1.6, 0.5, 1.05),
    "B": (1.0, 2.35, 0.3, 1.6, 0.5, 1.05),
    "C": (1.33, 2.93, 0.3, 2.0, 0.5, 1.32),
    "D": (1.12, 3.0, 0.56, 2.4, 0.75, 2.14),
    "E": (1.12, 3.0, 1.0, 3.0, 1.0, 3.32),
}
RISEN, SLOW, SLOWEST = 0.1, 1.5, 3.0  # where branches end [s]
NEAREST, FURTHEST, FREQUENT = 2e3, 2e4, 0.75  # D [m] of N_max and of 1; R up to which N is 1
NEAR = ((1.5, 2.0, 3.0, 4.0, 5.0), (1.0, 1.12, 1.36, 1.60, 1.72))  # T [s], N_max
CLAUSE = "NZS 1170.5, 3.1"
ROWS = {
    "Z": CodeQuantity("", CLAUSE, "hazard factor"),
    "R": CodeQuantity("", CLAUSE, "return period factor"),
    "ag": CodeQuantity("m/s2", CLAUSE, "peak acceleration on rock", "Z R g"),
    "S": CodeQuantity("", CLAUSE, "shape factor at T = 0"),
    "ag S": CodeQuantity("m/s2", CLAUSE, PEAK, "S ag"),
} | common_rows(CLAUSE)


class NzsKeys(SiteKeys):
    """Keys of NZS1170 alone."""

    hazard_factor: Annotated[float, Field(gt=0.0, le=2.0)] | None = None
    """Hazard factor Z, NZS1170 only."""
    return_factor: Annotated[float, Field(gt=0.0, le=5.0)] | None = None
    """Factor R of the return period, NZS1170 only; 1 when not given."""
    fault_distance: Annotated[Positive, Unit("m")] | None = None
    """Distance D to the nearest major fault, NZS1170 only; 20 km and more when not given."""


@dataclass(frozen=True)
class NzsSpectrum(ElasticSpectrum):
    """The spectrum of the head of this file."""

    ag: float  # Z R g [m/s2]
    shape: tuple[float, float, float, float, float, float]  # s, p, t, c, b, d
    near: float  # share of N_max - 1 in N - 1

    def at(self, period: np.ndarray, damping: float = USUAL_DAMPING) -> np.ndarray:
        """Pseudo-acceleration at periods (n,) of zero or more [m/s2]."""
        t, eta, (start, top, end, c, b, d) = np.asarray(period, dtype=float), damping_factor(damping), self.shape
        rise = start + (eta * top - start) * np.minimum(t, RISEN) / RISEN
        medium = np.clip(t, end, SLOW)
        fall = np.minimum(top, c * libm.exp(0.75 * libm.log(b / medium)))
        long = d / np.maximum(t, SLOW) * np.minimum(1.0, SLOWEST / np.maximum(t, SLOWEST))
        shape = np.where(t < end, rise, eta * np.where(t < SLOW, fall, long))
        return np.asarray(self.ag * shape * self._faulted(t))

    def _faulted(self, period: np.ndarray) -> np.ndarray:
        """N(T, D)."""
        return np.asarray(1.0 + self.near * (np.interp(period, *NEAR) - 1.0))

    def formula(self, period: float, of: str, damped: bool) -> str:
        """S_e of the branch on which a period lies, in symbols."""
        (_, top, end, c, b, d), eta = self.shape, "eta " if damped else ""
        near = float(self._faulted(np.array([period]))[0])
        ag = "ag" if near == 1.0 else f"{near:.4g} ag"
        if period < RISEN:
            return f"{ag} (S + ({eta}{top:g} - S) {of} / {RISEN:g})"
        if period < end:
            return f"{ag} {eta}{top:g}"
        if period < SLOW:
            return f"{ag} {eta}min({top:g}, {c:g} ({b:g} / {of})^0.75)"
        return f"{ag} {eta}{d:g} / {of}" if period < SLOWEST else f"{ag} {eta}{SLOWEST * d:g} / {of}^2"


def _made(keys: NzsKeys, vertical: bool, gravity: float) -> NzsSpectrum:
    assert keys.hazard_factor is not None
    often, away = keys.return_factor or 1.0, keys.fault_distance or FURTHEST
    near = min(max((FURTHEST - away) / (FURTHEST - NEAREST), 0.0), 1.0) if often > FREQUENT else 0.0
    return NzsSpectrum(keys.hazard_factor * often * gravity, CLASSES[keys.ground], near)


def _facts(keys: NzsKeys, found: NzsSpectrum) -> Iterator[Fact]:
    assert keys.hazard_factor is not None
    yield "Z", keys.hazard_factor
    yield "R", keys.return_factor or 1.0
    yield "ag", found.ag
    yield "S", found.shape[0]


SPECTRA = {
    "NZS1170": SpectrumKind(
        NzsKeys,
        ("hazard_factor",),
        _made,
        ROWS,
        _facts,
        lambda _, found: found.ag,
        in_proportion("hazard_factor"),
        ("return_factor", "fault_distance"),
        "ABCDE",
        words=lambda keys: f", Z {keys.hazard_factor:g}, R {keys.return_factor or 1.0:g}, subsoil class {keys.ground}",
    )
}
