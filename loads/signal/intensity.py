# SPDX-License-Identifier: GPL-3.0-or-later
r"""Measures of a whole accelerogram: Arias intensity, significant duration, cumulative absolute velocity.

    I(t) = pi / (2 g)  int_0^t a^2 dt,      I_A = I(T)                                  (Arias, 1970)
    D_5-95 = t(I = 0.95 I_A) - t(I = 0.05 I_A)                                          (Trifunac & Brady, 1975)
    CAV = int_0^T |a| dt                                                                (EPRI NP-5930, 1988)

a is straight between samples, so over an interval h the integral of a^2 is h (a^2 + a a' + a'^2) / 3, exactly. That of |a| is
h (|a| + |a'|) / 2 where a keeps its sign; where it passes zero, two triangles are left, h (a^2 + a'^2) / (2 (|a| + |a'|)).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from loads.acted import Acted, share_of
from loads.motion import STANDARD_GRAVITY
from loads.signal.baseline import GroundHistory


def arias(history: GroundHistory) -> np.ndarray:
    """The build-up of the Arias intensity at the samples, (n,) [m/s]."""
    a, b = history.acceleration[:-1], history.acceleration[1:]
    steps = history.step / 3.0 * (a * a + a * b + b * b)
    return np.pi / (2.0 * STANDARD_GRAVITY) * np.concatenate([[0.0], np.cumsum(steps)])


def reached(where: str, histories: Sequence[tuple[float, GroundHistory]]) -> Acted:
    """How much of accelerograms, which begin at a time each [s], has acted: by the Arias intensity of all of them together."""
    built = [(start + one.step * np.arange(len(one.acceleration)), arias(one)) for start, one in histories]
    total = sum(float(energy[-1]) for _, energy in built)
    end = max(float(times[-1]) for times, _ in built)
    return Acted(where, "Arias intensity", end, lambda time: share_of(sum(float(np.interp(time, *one)) for one in built), total))


def significant_window(history: GroundHistory) -> tuple[float, float]:
    """When the Arias intensity passes 5 and 95 % of its end value, times since the first sample [s].

    Linear between samples. (0, 0) for a record that is zero throughout.
    """
    built = arias(history)
    if built[-1] == 0.0:
        return 0.0, 0.0
    times = history.step * np.arange(len(built))
    begin, end = np.interp([0.05 * built[-1], 0.95 * built[-1]], built, times)
    return float(begin), float(end)


def significant_duration(history: GroundHistory) -> float:
    """D5-95, the time in which the Arias intensity grows from 5 to 95 % of its end value [s]."""
    begin, end = significant_window(history)
    return end - begin


def cumulative_absolute_velocity(history: GroundHistory) -> float:
    """CAV, the integral of |a| over the whole record [m/s]."""
    a, b = history.acceleration[:-1], history.acceleration[1:]
    total = np.abs(a) + np.abs(b)
    crossing = np.sign(a) * np.sign(b) < 0.0  # of signs: a product of values may underflow
    share = np.where(crossing, a * a + b * b, 0.0) / np.where(crossing, total, 1.0)
    return float(np.cumsum(0.5 * history.step * np.where(crossing, share, total))[-1])


def intensity(history: GroundHistory) -> dict[str, float]:
    """Arias intensity [m/s], significant duration, 5 to 95 % [s], and cumulative absolute velocity [m/s]."""
    return {
        "arias": float(arias(history)[-1]),
        "significant_duration": significant_duration(history),
        "cav": cumulative_absolute_velocity(history),
    }


def in_words(numbers: dict[str, float]) -> str:
    """These measures, for a line to the user."""
    return (
        f"Arias intensity {numbers['arias']:.4g} m/s, CAV {numbers['cav']:.4g} m/s, "
        f"significant duration {numbers['significant_duration']:.4g} s (5 to 95 %)"
    )
