# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.signal.incremental_velocity: the filter against its closed form, the pulses against a motion that is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from loads.signal.baseline import integrate
from loads.signal.incremental_velocity import fiv3, incremental_velocity


def butterworth_step(omega: float, times: np.ndarray) -> np.ndarray:
    """Velocity behind the filter after a step of 1 m/s2, by partial fractions of w^2 / (s^2 (s^2 + sqrt(2) w s + w^2))."""
    at = omega * times / np.sqrt(2.0)
    return times - np.sqrt(2.0) / omega * (1.0 - np.exp(-at) * np.cos(at))


@pytest.mark.parametrize(
    ("step", "period", "error"),
    [(0.01, 0.5, 1e-14), (0.02, 2.0, 1e-14), (0.01, 0.33, 1e-8), (0.05, 0.3, 2e-5), (0.01, 0.0123, 3e-3)],
)
def test_a_step_goes_through_the_filter_as_in_closed_form(step: float, period: float, error: float) -> None:
    """Exact where the window ends at a sample, whatever the step; else within the error of the cubic."""
    motion = integrate(np.full(101, 1.0), step)
    got = incremental_velocity(motion, period)
    times, window = step * np.arange(len(got)), 0.7 * period
    wanted = butterworth_step(2.0 * np.pi * 0.85 / period, np.concatenate([times, times + window]))
    assert got == pytest.approx(wanted[len(got) :] - wanted[: len(got)], rel=0.0, abs=error * window)
    assert len(got) == 101 - int(np.ceil(window / step - 1e-9))


def test_a_window_between_samples_converges_with_the_fourth_power_of_the_step() -> None:
    errors = []
    for count in (100, 200, 400):
        t = np.linspace(0.0, 2.0, count + 1)
        fine = np.linspace(0.0, 2.0, 700 * 16 + 1)  # 0.7 T is whole there
        a = np.interp(fine, t, np.sin(7.0 * t) ** 3)
        coarse = incremental_velocity(integrate(np.sin(7.0 * t) ** 3, t[1]), 0.537)
        exact = incremental_velocity(integrate(a, fine[1]), 0.537)
        at = np.interp(t[: len(coarse)], fine[: len(exact)], exact)
        errors.append(np.abs(coarse - at).max())
    assert errors[-1] < 1e-6
    assert errors[-1] < errors[0] / 30.0


def test_agrees_with_a_digital_filter_at_fine_steps() -> None:
    """scipy's Butterworth of second order is the bilinear image of the analogue one."""
    step, period = 0.001, 0.8
    t = step * np.arange(6001)
    a = np.sin(2 * np.pi * 1.3 * t) * np.exp(-0.3 * t) + 0.5 * np.sin(2 * np.pi * 4.1 * t)
    filtered = signal.lfilter(*signal.butter(2, 0.85 / period, fs=1.0 / step), a)
    velocity = np.concatenate([[0.0], np.cumsum(0.5 * step * (filtered[1:] + filtered[:-1]))])
    window = round(0.7 * period / step)
    gains = velocity[window:] - velocity[:-window]
    assert incremental_velocity(integrate(a, step), period) == pytest.approx(gains, abs=2e-3 * np.abs(gains).max())
    ups, downs = (values[signal.find_peaks(values)[0]] for values in (gains, -gains))
    wanted = max(np.sort(ups)[-3:].sum(), np.sort(downs)[-3:].sum())
    assert fiv3(integrate(a, step), period) == pytest.approx(wanted, rel=2e-3)


def test_pulses_far_apart_add_what_they_gain() -> None:
    """Four rectangular pulses, shorter than the window and slow beside the filter: the three strongest count, of the stronger sign."""
    step, period = 0.01, 1.0
    a = np.zeros(6000)
    for start, size in ((500, 1.0), (1500, 2.0), (2500, 3.0), (3500, 4.0), (4500, -8.0)):
        a[start : start + 20] = size
    motion = integrate(a, step)
    alone = np.zeros(6000)
    alone[500:520] = 1.0
    one = fiv3(integrate(alone, step), period)
    assert one == pytest.approx(0.2, rel=0.1)
    assert fiv3(motion, period) == pytest.approx(9.0 * one, rel=2e-3)
    assert fiv3(motion.scaled(-2.0), period) == pytest.approx(18.0 * one, rel=2e-3)


def test_a_record_shorter_than_the_window_has_none() -> None:
    assert fiv3(integrate(np.ones(10), 0.01), 1.0) == 0.0
    assert fiv3(integrate(np.zeros(1000), 0.01), 1.0) == 0.0
