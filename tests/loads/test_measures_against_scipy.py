# SPDX-License-Identifier: GPL-3.0-or-later
"""Intensity measures beside those of an independent library: oscillators and integrals by scipy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid, trapezoid
from scipy.signal import StateSpace, butter, lsim, sosfilt

from loads.motion import STANDARD_GRAVITY
from loads.signal.baseline import History, integrate
from loads.signal.measures import parse

STEP, SAMPLES = 0.005, 3000


@pytest.fixture(scope="module")
def motion() -> History:
    """Noise between 0.3 and 12 Hz that swells and fades, as an earthquake does."""
    random = np.random.Generator(np.random.PCG64(7))
    t = STEP * np.arange(SAMPLES)
    noise = sosfilt(butter(4, [0.3, 12.0], "bandpass", fs=1.0 / STEP, output="sos"), random.standard_normal(SAMPLES))
    return integrate(10.0 * noise * np.exp(-(((t - 5.0) / 3.0) ** 2)), STEP)


def oscillator(motion: History, period: float, damping: float) -> np.ndarray:
    """Displacement of an oscillator on the moving base (N,) [m]; exact between samples that are joined by straight lines."""
    w = 2.0 * math.pi / period
    system = StateSpace([[0.0, 1.0], [-w * w, -2.0 * damping * w]], [[0.0], [-1.0]], [[1.0, 0.0]], [[0.0]])
    _, x, _ = lsim(system, motion.acceleration, STEP * np.arange(len(motion.acceleration)), interp=True)
    return np.asarray(x)


@pytest.mark.parametrize(("period", "damping"), [(0.05, 0.05), (0.3, 0.05), (1.0, 0.02), (2.0, 0.10)])
def test_sa_is_that_of_an_oscillator_of_scipy(motion: History, period: float, damping: float) -> None:
    wanted = (2.0 * math.pi / period) ** 2 * np.abs(oscillator(motion, period, damping)).max()
    assert parse(f"Sa({period},{damping})").value({"x": motion}) == pytest.approx(wanted, rel=1e-8)


def test_the_average_and_the_spectrum_intensity_are_made_of_oscillators_of_scipy(motion: History) -> None:
    periods = np.linspace(0.2, 1.0, 10)
    sa = [(2.0 * math.pi / T) ** 2 * np.abs(oscillator(motion, T, 0.05)).max() for T in periods]
    assert parse("AvgSA(0.2,1.0)").value({"x": motion}) == pytest.approx(float(np.exp(np.mean(np.log(sa)))), rel=1e-8)
    periods = np.linspace(0.1, 2.5, 49)
    sv = [2.0 * math.pi / T * np.abs(oscillator(motion, T, 0.05)).max() for T in periods]
    assert parse("Housner").value({"x": motion}) == pytest.approx(trapezoid(sv, periods), rel=1e-5)  # which looks between samples as well


def test_integrals_over_the_motion_are_those_of_scipy(motion: History) -> None:
    """On samples so fine that the rules of integration do not tell."""
    t = STEP * np.arange(SAMPLES)
    fine = np.linspace(0.0, t[-1], 20 * (SAMPLES - 1) + 1)
    a = np.interp(fine, t, motion.acceleration)
    built = math.pi / (2.0 * STANDARD_GRAVITY) * cumulative_trapezoid(a * a, fine, initial=0.0)
    span = float(np.interp(0.95 * built[-1], built, fine) - np.interp(0.05 * built[-1], built, fine))
    velocity = cumulative_trapezoid(a, fine, initial=0.0)
    wanted = {
        "PGA": np.abs(a).max(),
        "PGV": np.abs(velocity[::20]).max(),
        "PGD": np.abs(cumulative_trapezoid(velocity, fine, initial=0.0)[::20]).max(),
        "Arias": built[-1],
        "CAV": trapezoid(np.abs(a), fine),
        "D5-95": span,
    }
    tolerance = {"Arias": 1e-3, "D5-95": STEP / span} | dict.fromkeys(("PGA", "PGV"), 1e-12)
    for name, value in wanted.items():
        assert parse(name).value({"x": motion}) == pytest.approx(value, rel=tolerance.get(name, 1e-4)), name
