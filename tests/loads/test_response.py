# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.signal.response and loads.signal.intensity against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from loads.motion import STANDARD_GRAVITY
from loads.signal.baseline import integrate
from loads.signal.intensity import arias, intensity, significant_window
from loads.signal.response import Oscillators, default_periods, response_spectrum


def sine_response(period: float, damping: float, forcing: float, times: np.ndarray) -> np.ndarray:
    """x(t) from rest of x'' + 2 xi w x' + w^2 x = -sin(W t): the steady state and the free vibration that starts it."""
    w, big = 2.0 * np.pi / period, forcing
    wd = w * np.sqrt(1.0 - damping**2)
    size = -1.0 / ((w * w - big * big) ** 2 + (2.0 * damping * w * big) ** 2)
    in_phase, out_of_phase = (w * w - big * big) * size, -2.0 * damping * w * big * size
    c, d = -out_of_phase, (-in_phase * big - damping * w * out_of_phase) / wd
    steady = in_phase * np.sin(big * times) + out_of_phase * np.cos(big * times)
    return steady + np.exp(-damping * w * times) * (c * np.cos(wd * times) + d * np.sin(wd * times))


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.05, 0.3])
def test_spectrum_of_a_sine(damping: float) -> None:
    step, forcing = 0.01, 2.0 * np.pi * 2.0
    a = np.sin(forcing * step * np.arange(1501))
    periods = np.geomspace(0.03, 4.0, 40)
    got = response_spectrum(a, step, periods, damping)
    fine = np.linspace(0.0, 15.0, 150001)
    wanted = np.array([abs(sine_response(t, damping, forcing, fine)).max() for t in periods])
    assert got.displacement == pytest.approx(wanted, rel=0.01)
    assert got.acceleration == pytest.approx((2.0 * np.pi / periods) ** 2 * got.displacement)
    assert got.velocity == pytest.approx(2.0 * np.pi / periods * got.displacement)


@pytest.mark.parametrize("step", [0.001, 0.02, 0.2])
def test_spectrum_of_a_constant_acceleration_does_not_depend_on_the_sampling(step: float) -> None:
    """A straight line is followed exactly at any step: the peak is (1 + exp(-pi xi / sqrt(1 - xi^2))) a / w^2."""
    periods, xi = np.array([0.1, 0.5, 2.0]), 0.05
    got = response_spectrum(np.full(round(4.0 / step) + 1, 3.0), step, periods, xi)
    peak = 3.0 * (1.0 + np.exp(-np.pi * xi / np.sqrt(1.0 - xi**2)))
    assert got.acceleration == pytest.approx(peak, rel=4e-3)


def test_peaks_all_around_are_those_of_the_rotated_motions() -> None:
    """A circular motion that grows slowly: a direction sees its peak little above those of the others."""
    t = 0.01 * np.arange(1001)
    x, y = np.exp(0.02 * t) * np.cos(9.0 * t), np.exp(0.02 * t) * np.sin(9.0 * t)
    oscillators, angles = Oscillators(np.array([0.05, 0.3, 2.0]), 0.01, 0.05), np.radians(np.arange(0.0, 180.0, 7.0))
    wanted = np.stack([oscillators.peaks(np.cos(angle) * x + np.sin(angle) * y) for angle in angles], axis=1)
    assert oscillators.rotated_peaks(x, y, angles) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("step", [0.02, 0.3])
def test_the_history_of_an_oscillator_under_a_constant_acceleration(step: float) -> None:
    """Samples of x = -a / w^2 (1 - e^(-xi w t) (cos w_d t + xi w / w_d sin w_d t)) and x' = -a / w_d e^(-xi w t) sin w_d t."""
    w, xi, t = 2.0 * np.pi / 0.7, 0.1, step * np.arange(20)
    wd = w * np.sqrt(1.0 - xi**2)
    x, v = Oscillators(np.array([0.7]), step, xi).history(np.full(20, 3.0))
    decay = np.exp(-xi * w * t)
    assert x == pytest.approx(-3.0 / w**2 * (1.0 - decay * (np.cos(wd * t) + xi * w / wd * np.sin(wd * t))), abs=1e-13)
    assert v == pytest.approx(-3.0 / wd * decay * np.sin(wd * t), abs=1e-13)


def test_both_ends_of_the_spectrum_are_those_of_the_ground() -> None:
    t = 0.01 * np.arange(2001)
    motion = integrate(np.sin(2 * np.pi * t) - 0.5 * np.sin(np.pi * t), 0.01)
    got = response_spectrum(motion.acceleration, 0.01, [0.0, 0.01, 300.0], 0.05)
    assert got.acceleration[0] == motion.numbers()["pga"]
    assert got.acceleration[1] == pytest.approx(motion.numbers()["pga"], rel=0.01)
    assert got.displacement[2] == pytest.approx(motion.numbers()["pgd"], rel=0.03)
    assert default_periods(5)[[0, -1]] == pytest.approx([0.02, 4.0])


@pytest.mark.parametrize(("periods", "damping"), [([1.0], 1.0), ([1.0], -0.1), ([-1.0], 0.05)])
def test_impossible_oscillators_are_refused(periods: list, damping: float) -> None:
    with pytest.raises(ValueError, match="must"):
        response_spectrum(np.ones(10), 0.01, periods, damping)


def test_arias_intensity_and_significant_duration_of_a_constant_and_of_a_ramp() -> None:
    flat = integrate(np.full(1001, 2.0), 0.01)
    assert arias(flat)[-1] == pytest.approx(np.pi / (2 * STANDARD_GRAVITY) * 4.0 * 10.0)
    assert significant_window(flat) == pytest.approx((0.5, 9.5))
    ramp = integrate(np.linspace(0.0, 1.0, 11), 1.0)  # int of (t/10)^2 is exact although the samples are coarse
    assert intensity(ramp)["arias"] == pytest.approx(np.pi / (2 * STANDARD_GRAVITY) * 10.0 / 3.0)
    begin, end = significant_window(integrate(np.linspace(0.0, 1.0, 1001), 0.01))
    assert (begin, end) == pytest.approx((10 * 0.05 ** (1 / 3), 10 * 0.95 ** (1 / 3)), rel=1e-3)
    assert significant_window(integrate(np.zeros(10), 0.1)) == (0.0, 0.0)
