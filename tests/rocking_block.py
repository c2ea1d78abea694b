# SPDX-License-Identifier: GPL-3.0-or-later
r"""A rigid block that rocks on a shaken base, by Housner's equation (Bull. Seism. Soc. Am. 53(2), 1963), for many amplitudes at once.

    theta'' = -p^2 ( sin(s alpha - theta) + (a / g) cos(s alpha - theta) ),    p^2 = 3 g / (4 R),    s = sign(theta)
    at theta = 0:  theta'+ = (1 - 3/2 sin^2 alpha) theta'-

R is half of the diagonal, tan(alpha) = width / height. A block at rest lifts off where |a| > g tan(alpha), to the side away from a.
"""

from __future__ import annotations

import numpy as np

G = 9.81
STILL = 1e-4  # [rad/s] a block that meets its base slower than this stays there while a is small


def rock(acceleration: np.ndarray, dt: float, scales: np.ndarray, size: tuple[float, float], substeps: int = 20) -> np.ndarray:
    """Rock a block under scaled accelerograms.

    Args:
        acceleration: (N,) of the base [m/s2], straight between its samples.
        dt: between them [s].
        scales: (K,) factors.
        size: width and height of the block [m].
        substeps: of Runge and Kutta's method per sample.

    Returns:
        (N, K) the tilt [rad]; past a quarter turn it stays there: the block has fallen.
    """
    width, height = size
    alpha, p2 = np.arctan2(width, height), 3.0 * G / (2.0 * np.hypot(width, height))
    kept = 1.0 - 1.5 * np.sin(alpha) ** 2
    tilt, speed, side, fallen = np.zeros(len(scales)), np.zeros(len(scales)), np.zeros(len(scales)), np.zeros(len(scales), bool)
    out = np.zeros((len(acceleration), len(scales)))
    h = dt / substeps

    def pull(theta: np.ndarray, a: np.ndarray) -> np.ndarray:
        return np.where(side == 0, 0.0, -p2 * (np.sin(side * alpha - theta) + a / G * np.cos(side * alpha - theta)))

    for n in range(len(acceleration) - 1):
        for k in range(substeps):
            begin, middle, end = (
                scales * ((1.0 - x) * acceleration[n] + x * acceleration[n + 1])
                for x in (k / substeps, (k + 0.5) / substeps, (k + 1) / substeps)
            )
            side = np.where((side == 0) & (np.abs(begin) > G * np.tan(alpha)), -np.sign(begin), side)
            v1, f1 = speed, pull(tilt, begin)
            v2, f2 = speed + 0.5 * h * f1, pull(tilt + 0.5 * h * v1, middle)
            v3, f3 = speed + 0.5 * h * f2, pull(tilt + 0.5 * h * v2, middle)
            v4, f4 = speed + h * f3, pull(tilt + h * v3, end)
            moved = tilt + h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4)
            faster = speed + h / 6.0 * (f1 + 2.0 * f2 + 2.0 * f3 + f4)
            met = (side != 0) & (moved * side < 0)
            share = np.where(met, np.abs(tilt) / np.maximum(np.abs(tilt) + np.abs(moved), 1e-300), 0.0)
            after = kept * (speed + share * (faster - speed))
            rests = met & (np.abs(after) < STILL)
            side = np.where(rests, 0.0, np.where(met, np.sign(after), side))
            # what is left of the step after the impact is gone through from there
            left = (1.0 - share) * h
            pulled = left * np.where(met, pull(np.zeros_like(tilt), end), 0.0)
            tilt = np.where(fallen, tilt, np.where(rests, 0.0, np.where(met, left * (after + 0.5 * pulled), moved)))
            speed = np.where(fallen | rests, 0.0, np.where(met, after + pulled, faster))
            fallen |= np.abs(tilt) >= 0.5 * np.pi
            tilt = np.clip(tilt, -0.5 * np.pi, 0.5 * np.pi)
        out[n + 1] = tilt
    return out
