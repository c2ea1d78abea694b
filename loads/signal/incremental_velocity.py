# SPDX-License-Identifier: GPL-3.0-or-later
r"""FIV3, the filtered incremental velocity: what the three strongest pulses of an accelerogram add to the velocity (for collapse).

    V(t) = int_t^{t + alpha T} a_f dt,      0 <= t <= t_end - alpha T
    FIV3 = max(V_max1 + V_max2 + V_max3,  |V_min1 + V_min2 + V_min3|)                     [m/s]

with a_f the acceleration behind a low-pass Butterworth filter of second order with its corner at beta / T, V_max the three largest local
maxima and V_min the three smallest local minima of V; alpha = 0.7, beta = 0.85 (Davalos & Miranda, Earthq. Eng. Struct. Dyn. 48(12),
2019). Maxima below zero and minima above it do not count; an end of V may be one. Of fewer than three, those there are.

The filter is the analogue one, run forwards from rest: an oscillator of period T / beta and damping 1 / sqrt(2),

    a_f'' + sqrt(2) w a_f' + w^2 a_f = w^2 a,     so that     v_f = int a_f dt = v - (a_f' + sqrt(2) w a_f) / w^2,

which ``loads.signal.response`` solves exactly where a is straight between samples; nothing depends on the sampling rate but the
instants t at which V is known. alpha T may end between two samples: v_f is taken there from the cubic with its values and slopes.
"""

from __future__ import annotations

import math

import numpy as np

from loads.signal.baseline import GroundHistory
from loads.signal.response import Oscillators

ALPHA = 0.7
BETA = 0.85
PULSES = 3
ALIKE = 1e-9  # samples: a window that ends so close to one ends at it


def fiv3(history: GroundHistory, period: float, alpha: float = ALPHA, beta: float = BETA) -> float:
    """FIV3 of an accelerogram [m/s]; 0 where it is shorter than a window.

    Args:
        history: the motion.
        period: T of the structure [s].
        alpha: length of the window over T.
        beta: corner of the filter times T.
    """
    gains = incremental_velocity(history, period, alpha, beta)
    return max(_three_largest(gains), _three_largest(-gains))


def incremental_velocity(history: GroundHistory, period: float, alpha: float = ALPHA, beta: float = BETA) -> np.ndarray:
    """V at the samples at which a whole window begins, (m,) [m/s]; empty where the record is shorter than a window."""
    omega = 2.0 * np.pi * beta / period
    x, v = Oscillators(np.array([period / beta]), history.step, math.sqrt(0.5)).history(history.acceleration)
    filtered = -omega * omega * x  # the oscillator moves against the base
    velocity = history.velocity + (v + math.sqrt(2.0) * omega * x)
    return _gains(velocity, history.step * filtered, alpha * period / history.step)


def _gains(velocity: np.ndarray, slope: np.ndarray, window: float) -> np.ndarray:
    """Return the gain of a velocity over a window, given it and its slope per sample at the samples; the window is counted in samples."""
    whole = math.floor(window + ALIKE)
    into = window - whole if window - whole > ALIKE else 0.0
    count = len(velocity) - whole - (1 if into else 0)
    if count <= 0:
        return np.zeros(0)
    end = velocity[whole : whole + count]
    if into:
        after = slice(whole + 1, whole + 1 + count)
        end = _cubic(into, end, slope[whole : whole + count], velocity[after], slope[after])
    return np.asarray(end - velocity[:count])


def _cubic(at: float, p: np.ndarray, m: np.ndarray, q: np.ndarray, n: np.ndarray) -> np.ndarray:
    """Values at 0 <= at <= 1 of the cubics from p with slope m to q with slope n (Hermite)."""
    rest = 1.0 - at
    return np.asarray(rest * rest * ((1.0 + 2.0 * at) * p + at * m) + at * at * ((1.0 + 2.0 * rest) * q - rest * n))


def _three_largest(values: np.ndarray) -> float:
    """The sum of the three largest local maxima above zero; a plateau is one of them."""
    if len(values) == 0:
        return 0.0
    levels = np.concatenate([[-np.inf], values[np.concatenate([[True], np.diff(values) != 0.0])], [-np.inf]])
    middle = levels[1:-1]
    peaks = middle[(middle > levels[:-2]) & (middle > levels[2:]) & (middle > 0.0)]
    return math.fsum(np.sort(peaks)[-PULSES:])
