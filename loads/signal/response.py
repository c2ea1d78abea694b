# SPDX-License-Identifier: GPL-3.0-or-later
r"""The response spectrum of an accelerogram, exact for accelerations that are straight between their samples.

Oscillators of period T = 2 pi / w and damping ratio xi on a base with acceleration a(t):

    x'' + 2 xi w x' + w^2 x = -a(t),       Sd = max |x|,   Sv = w Sd,   Sa = w^2 Sd  (pseudo-acceleration).

Over an interval h the solution of this equation for a linear a(t) is known in closed form; it takes (x, x') and the two accelerations
linearly into the next (x, x') (Nigam & Jennings, Bull. Seism. Soc. Am. 59(2), 1969). The eight coefficients are the exponential of one
matrix: with z = (x, x', a, h a'), z' = G z,  so  z(t + h) = exp(G h) z(t).

Peaks between samples: an interval is cut into parts of at most T / 40, where the recursion is still exact; the largest value at the
ends of the parts is then at most 0.3 % below the true peak.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.foundation import libm
from masonry_cd.foundation.jit import entry, kernel

PARTS_PER_PERIOD = 40
TERMS = 14  # of the exponential: (2 pi / 40)^14 / 14! is 7e-23


@dataclass(frozen=True, eq=False)
class ResponseSpectrum:
    """Response spectra over n periods for one damping ratio. Period zero: a rigid oscillator, which moves with the base."""

    period: np.ndarray  # (n,) [s]
    damping: float
    displacement: np.ndarray  # (n,) Sd, relative to the base [m]
    acceleration: np.ndarray  # (n,) Sa = w^2 Sd; the peak ground acceleration at period zero [m/s2]

    @property
    def velocity(self) -> np.ndarray:
        """Sv = w Sd, the pseudo-velocity, (n,) [m/s]."""
        out = np.zeros_like(self.period)
        moving = self.period > 0.0
        out[moving] = 2.0 * np.pi / self.period[moving] * self.displacement[moving]
        return out


def response_spectrum(
    acceleration: np.ndarray, step: float, periods: Sequence[float] | np.ndarray, damping: float = 0.05
) -> ResponseSpectrum:
    """The response spectrum of samples.

    The oscillators start at rest; their free vibration after the last sample is not followed (append zeros to see it).

    Args:
        acceleration: (n,) of the base [m/s2].
        step: [s].
        periods: (m,) zero or more [s].
        damping: ratio xi, 0 <= xi < 1.

    Raises:
        ValueError: a damping or a period outside its range.
    """
    period = np.asarray(periods, dtype=float)
    if not 0.0 <= damping < 1.0:
        raise ValueError(f"the damping ratio must lie between 0 and 1, got {damping:g}")
    if (period < 0.0).any():
        raise ValueError("a period must not be negative")
    a = np.ascontiguousarray(acceleration, dtype=float)
    moving = period > 0.0
    displacement, pseudo = np.zeros_like(period), np.full_like(period, np.abs(a).max())
    displacement[moving] = Oscillators(period[moving], step, damping).peaks(a)
    pseudo[moving] = (2.0 * np.pi / period[moving]) ** 2 * displacement[moving]
    return ResponseSpectrum(period, damping, displacement, pseudo)


class Oscillators:
    """Oscillators of given periods above zero, ready for any number of accelerograms of one time step."""

    def __init__(self, period: np.ndarray, step: float, damping: float) -> None:
        self._parts = np.maximum(1, np.ceil(PARTS_PER_PERIOD * step / period)).astype(np.int64)
        omega = 2.0 * np.pi / period
        self._transitions = np.zeros((len(period), 2, 4))
        for i, (w, parts) in enumerate(zip(omega, self._parts, strict=True)):
            self._transitions[i] = _transition(w, damping, step / parts)

    def peaks(self, acceleration: np.ndarray) -> np.ndarray:
        """Sd of each oscillator under the samples of an acceleration, from rest [m]."""
        out = np.zeros(len(self._parts))
        _peaks(np.ascontiguousarray(acceleration, dtype=float), self._parts, self._transitions, out)
        return out

    def rotated_peaks(self, first: np.ndarray, second: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """Sd of each oscillator along directions in the plane of two components, (periods, angles) [m].

        Args:
            first: (n,) acceleration at angle 0 [m/s2].
            second: (n,) acceleration at a right angle to it [m/s2].
            angles: of the directions [rad].
        """
        out = np.zeros((len(self._parts), len(angles)))
        a, b = (np.ascontiguousarray(component, dtype=float) for component in (first, second))
        _rotated_peaks(a, b, libm.cos(angles), libm.sin(angles), self._parts, self._transitions, out)
        return out

    def history(self, acceleration: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """x [m] and x' [m/s] of the first oscillator at the samples of an acceleration, from rest, each (n,)."""
        a = np.ascontiguousarray(acceleration, dtype=float)
        x, v = np.zeros(len(a)), np.zeros(len(a))
        _history(a, self._parts[0], self._transitions[0], x, v)
        return x, v


def default_periods(count: int) -> np.ndarray:
    """Periods (count,) that are even on a logarithmic axis [s]."""
    return libm.geometric(0.02, 4.0, count)


def _transition(omega: float, damping: float, h: float) -> np.ndarray:
    """The first two rows of exp(G h), (2, 4), for z = (x, x', a, h a')."""
    g = np.zeros((4, 4))
    g[0, 1] = 1.0
    g[1] = -omega * omega, -2.0 * damping * omega, -1.0, 0.0
    g[2, 3] = 1.0 / h
    return _exponential(g * h)[:2].copy()


def _exponential(matrix: np.ndarray) -> np.ndarray:
    """exp of a matrix (n, n) whose powers fall off, as those of G h do: w h is 2 pi / PARTS_PER_PERIOD at most."""
    total = term = np.eye(len(matrix))
    for k in range(1, TERMS + 1):
        term = np.einsum("ij,jk->ik", term, matrix) / k  # no BLAS, which rounds otherwise on another processor
        total = total + term
    return np.asarray(total)


@kernel()
def _advance(m, at, rise, x, v):
    """(x, x') after an interval that begins with the acceleration ``at``, which rises by ``rise`` in it."""
    return (
        m[0, 0] * x + m[0, 1] * v + m[0, 2] * at + m[0, 3] * rise,
        m[1, 0] * x + m[1, 1] * v + m[1, 2] * at + m[1, 3] * rise,
    )


@entry()
def _peaks(a, parts, transitions, out):
    """Largest |x| at the ends of the parts of every interval, for each oscillator."""
    for i in range(len(out)):
        m, n = transitions[i], parts[i]
        x, v, peak = 0.0, 0.0, 0.0
        for k in range(len(a) - 1):
            rise = (a[k + 1] - a[k]) / n
            for j in range(n):
                x, v = _advance(m, a[k] + j * rise, rise, x, v)
                peak = max(peak, abs(x))
        out[i] = peak


@entry()
def _rotated_peaks(a, b, cosines, sines, parts, transitions, out):
    """Largest |x cos + y sin| at the ends of the parts, for each oscillator and angle: out (m, angles). a and b drive x and y.

    No angle sees more than sqrt(x^2 + y^2): where that lies below the peaks of all angles, none is looked at.
    """
    for i in range(len(out)):
        m, n, peaks = transitions[i], parts[i], out[i]
        x, v, y, w, least = 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(len(a) - 1):
            rise, other = (a[k + 1] - a[k]) / n, (b[k + 1] - b[k]) / n
            for j in range(n):
                x, v = _advance(m, a[k] + j * rise, rise, x, v)
                y, w = _advance(m, b[k] + j * other, other, y, w)
                if x * x + y * y > least * least:
                    for angle in range(len(peaks)):
                        peaks[angle] = max(peaks[angle], abs(x * cosines[angle] + y * sines[angle]))
                    least = peaks.min()


@entry()
def _history(a, parts, transition, x, v):
    """x and x' of one oscillator at the samples, from rest."""
    x[0], v[0] = 0.0, 0.0
    at_x, at_v = 0.0, 0.0
    for k in range(len(a) - 1):
        rise = (a[k + 1] - a[k]) / parts
        for j in range(parts):
            at_x, at_v = _advance(transition, a[k] + j * rise, rise, at_x, at_v)
        x[k + 1], v[k + 1] = at_x, at_v
