# SPDX-License-Identifier: GPL-3.0-or-later
"""The integration of Housner's equation that studies are compared with: closed forms of its small motions and of its thresholds."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from rocking_block import G, rock

SIZE = (0.4, 1.6)
ALPHA = np.arctan2(*SIZE)
P = np.sqrt(3.0 * G / (2.0 * np.hypot(*SIZE)))


def test_it_lifts_off_where_the_base_is_stronger_than_its_slenderness():
    pulse = np.full(41, G * np.tan(ALPHA))
    tilt = rock(pulse, 0.005, np.array([-1.01, 0.99, 1.01]), SIZE)
    assert tilt[-1, 1] == 0.0
    assert tilt[-1, 0] > 0 > tilt[-1, 2]
    assert tilt[-1, 0] == pytest.approx(-tilt[-1, 2])


def test_a_constant_push_follows_the_linear_equation():
    """Small tilts of a slender block under a constant a: theta'' = p^2 (theta - alpha - a / g), so theta = -(alpha + a / g)(cosh(p t) - 1).

    Here a = -1.3 g alpha; linear in alpha = 0.245 it is wrong by about its square.
    """
    time = 0.005 * np.arange(21)
    tilt = rock(np.full(21, -1.3 * G * ALPHA), 0.005, np.ones(1), SIZE)[:, 0]
    linear = 0.3 * ALPHA * (np.cosh(P * time) - 1.0)
    assert tilt[-1] == pytest.approx(linear[-1], rel=3 * ALPHA**2)


def test_impacts_take_away_what_housner_says():
    """Free rocking after a pulse: from peak to peak the energy above rest falls by e^2, e = 1 - 3/2 sin^2(alpha)."""
    dt = 0.005
    record = np.concatenate([np.full(20, -1.6 * G * ALPHA), np.zeros(600)])
    tilt = rock(record, dt, np.ones(1), SIZE)[:, 0]
    sign = np.sign(tilt)
    starts = [n for n in range(25, len(tilt)) if sign[n] != 0 and sign[n - 1] != 0 and sign[n] != sign[n - 1]]
    peaks = [float(np.abs(tilt[a:b]).max()) for a, b in pairwise(starts[:5])]
    kept = (1.0 - 1.5 * np.sin(ALPHA) ** 2) ** 2

    def energy(theta: float) -> float:
        return float(np.cos(ALPHA - theta) - np.cos(ALPHA))

    ratios = [energy(b) / energy(a) for a, b in pairwise(peaks)]
    assert ratios == pytest.approx([kept] * len(ratios), rel=2e-3)


def test_a_pulse_that_is_strong_enough_overturns():
    record = np.concatenate([-G * np.sin(2 * np.pi * 1.0 * 0.005 * np.arange(200)), np.zeros(600)])
    tilt = rock(record, 0.005, np.array([0.2, 1.2]), SIZE)
    assert np.abs(tilt[-1, 0]) < ALPHA
    assert np.abs(tilt[-1, 1]) == pytest.approx(0.5 * np.pi)
