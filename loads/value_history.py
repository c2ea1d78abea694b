# SPDX-License-Identifier: GPL-3.0-or-later
r"""Displacements and rotations by their values at some times: a smooth course through them, and the velocity of the base that follows it.

Between two times a cubic, with a slope at each that never lets the course leave the range of its two values (Fritsch & Carlson, SIAM J.
Numer. Anal. 17, 1980), and with none at the ends, beyond which nothing moves: the base begins and ends at rest. Of velocities, straight
between their times, the course is the integral. A step gets

    v_k = (d(t_k + h/2) - d(t_k - h/2)) / h,

whose trapezoidal rule gives (d(t_k + h/2) + d(t_k - h/2)) / 2: the values themselves where the course rests, elsewhere within h^2 d'' / 8.
A run begins at rest, so in its first half step d is that of its first time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from loads.acted import Acted
from masonry_cd.foundation.errors import InputError


def at_middles(course: Callable[[np.ndarray], np.ndarray], times: np.ndarray, dt: float) -> np.ndarray:
    """A course (n,) -> (n, k) at the middles of the steps, (N + 2, k), from half a step before the first time on, counted from it."""
    found = course(np.concatenate([[times[0], times[0]], times[1:] + 0.5 * dt]))
    return np.asarray(found - found[0])


@dataclass(frozen=True, eq=False)
class ValueHistory:
    """Values over time, counted from the first ones.

    Attributes:
        times: (N,) that increase [s].
        values: (N, k) [m, rad].
        slopes: (N, k) at the times, of columns whose velocities are given; NaN in the others, None where there are none such [m/s, rad/s].
    """

    times: np.ndarray
    values: np.ndarray
    slopes: np.ndarray | None = None

    def at(self, times: np.ndarray) -> np.ndarray:
        """(n, k) at times (n,) [s]."""
        return np.asarray(self._curve(np.clip(times, self.times[0], self.times[-1])) - self.values[0])

    def check_steps(self, dt: float, where: str) -> None:
        """Refuse times that are closer than a step.

        Raises:
            InputError: names the two that are closest.
        """
        closest = int(np.argmin(np.diff(self.times)))
        if self.times[closest + 1] - self.times[closest] < dt * (1.0 - 1e-9):
            two = f"{self.times[closest]:.6g} and {self.times[closest + 1]:.6g} s"
            raise InputError(where, f"has values at {two}, closer than run.dt {dt:g} s: the run does not follow them")

    def acted(self, where: str) -> Acted:
        """How much of the way, to and fro, has been gone by a time; of several columns each counts alike."""
        gone = np.cumsum(np.abs(np.diff(self.values, axis=0, prepend=self.values[:1])), axis=0)
        gone = gone[:, gone[-1] > 0.0]
        share = (gone / gone[-1]).mean(axis=1) if gone.shape[1] else (self.times >= self.times[-1]).astype(float)
        return Acted(where, "path", float(self.times[-1]), lambda time: float(np.interp(time, self.times, share)))

    @cached_property
    def _curve(self) -> Any:
        from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

        slopes = np.zeros_like(self.values)
        if len(self.times) > 2:
            slopes[1:-1] = PchipInterpolator(self.times, self.values).derivative()(self.times[1:-1])
        if self.slopes is not None:
            slopes = np.where(np.isnan(self.slopes), slopes, self.slopes)
        return CubicHermiteSpline(self.times, self.values, slopes)
