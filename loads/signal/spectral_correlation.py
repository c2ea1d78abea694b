# SPDX-License-Identifier: GPL-3.0-or-later
r"""The correlation of ln Sa of a motion between two periods (Baker & Jayaram, Earthquake Spectra 24(1), 2008).

With T the shorter and U the longer period, 0.01 s <= T <= U <= 10 s:

    C1 = 1 - cos( pi/2 - 0.366 ln( U / max(T, 0.109) ) )
    C2 = 1 - 0.105 ( 1 - 1 / (1 + exp(100 U - 5)) ) (U - T) / (U - 0.0099)   for U < 0.2 s
    C3 = C2 for U < 0.109 s, else C1
    C4 = C1 + 0.5 ( sqrt(C3) - C3 ) ( 1 + cos(pi T / 0.109) )

    rho = C2 for U <= 0.109 s;  C1 for T > 0.109 s;  else min(C2, C4) for U < 0.2 s, and C4 beyond.
"""

from __future__ import annotations

import math

import numpy as np

from masonry_cd.foundation import libm

SHORTEST, LONGEST = 0.01, 10.0  # periods of the records that it was fitted to [s]
CORNER, SHORT = 0.109, 0.2  # [s]


def correlation(periods: np.ndarray) -> np.ndarray:
    """The matrix (m, m) of coefficients between periods (m,), each from SHORTEST to LONGEST [s]."""
    t, u = np.minimum.outer(periods, periods), np.maximum.outer(periods, periods)
    c1 = 1.0 - libm.cos(math.pi / 2.0 - 0.366 * libm.log(u / np.maximum(t, CORNER)))
    rise = 1.0 - 1.0 / (1.0 + libm.exp(100.0 * np.minimum(u, SHORT) - 5.0))
    c2 = np.where(u < SHORT, 1.0 - 0.105 * rise * (u - t) / (u - 0.0099), np.inf)
    c3 = np.where(u < CORNER, c2, c1)
    c4 = c1 + 0.5 * (np.sqrt(c3) - c3) * (1.0 + libm.cos(math.pi * np.minimum(t, CORNER) / CORNER))
    return np.asarray(np.select([u <= CORNER, t > CORNER], [c2, c1], np.minimum(c2, c4)))
