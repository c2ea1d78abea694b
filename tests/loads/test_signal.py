# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.signal against closed forms: response spectra and intensity, integration and baselines, filters, incremental velocity."""

from __future__ import annotations

import numpy as np
import pytest
from places import SHARED
from scipy import signal

from loads.motion import STANDARD_GRAVITY
from loads.signal.baseline import ORDERS, correct, integrate
from loads.signal.filters import band_pass, resample, taper_factors
from loads.signal.incremental_velocity import fiv3, incremental_velocity
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


def shaking(seconds: float = 20.0, step: float = 0.01) -> np.ndarray:
    """A burst of waves that starts and ends at rest, by its displacement's second derivative; known motion, no drift."""
    t = np.arange(0.0, seconds + step / 2, step)
    envelope = np.sin(np.pi * t / seconds) ** 4
    displacement = envelope * (0.03 * np.sin(2 * np.pi * 1.1 * t) + 0.01 * np.sin(2 * np.pi * 3.7 * t + 0.4))
    return np.gradient(np.gradient(displacement, step), step)


def test_integration_is_exact_for_straight_lines() -> None:
    t = np.linspace(0.0, 2.0, 9)
    history = integrate(3.0 - 2.0 * t, t[1])
    assert history.velocity == pytest.approx(3.0 * t - t**2)
    assert history.displacement == pytest.approx(1.5 * t**2 - t**3 / 3.0)
    between = np.linspace(0.0, 2.0, 57)
    assert history.velocity_at(between) == pytest.approx(3.0 * between - between**2)
    assert history.velocity_at(np.array([-1.0, 5.0])) == pytest.approx([0.0, history.velocity[-1]])


def test_velocity_between_samples_agrees_with_a_finer_grid() -> None:
    a = shaking()
    coarse = integrate(a, 0.01)
    t = np.arange(len(a)) * 0.01
    fine = np.linspace(0.0, t[-1], 7 * (len(a) - 1) + 1)
    reference = integrate(np.interp(fine, t, a), fine[1])
    assert coarse.velocity_at(fine) == pytest.approx(reference.velocity, abs=1e-12)
    assert coarse.displacement == pytest.approx(reference.displacement[::7], abs=1e-12)


@pytest.mark.parametrize("name", ["linear", "quadratic", "cubic"])
def test_correction_ends_at_rest_where_it_began(name: str) -> None:
    raw = integrate(shaking() + 0.02, 0.01)
    assert abs(raw.displacement[-1]) > 3.0
    corrected = correct(raw, ORDERS[name]).numbers()
    assert abs(corrected["end_velocity"]) < 1e-12
    assert abs(corrected["end_displacement"]) < 1e-11


@pytest.mark.parametrize(("name", "order"), [("linear", 1), ("quadratic", 2), ("cubic", 3)])
def test_a_drift_of_the_polynomial_s_own_order_is_removed(name: str, order: int) -> None:
    clean = correct(integrate(shaking(), 0.01), ORDERS[name])
    t = np.linspace(-1.0, 1.0, len(clean.acceleration))
    drifting = integrate(clean.acceleration + 0.05 * t**order - 0.02, 0.01)
    restored = correct(drifting, ORDERS[name])
    assert restored.displacement == pytest.approx(clean.displacement, abs=1e-9)
    assert abs(drifting.displacement - clean.displacement).max() > 0.3


def test_linear_is_the_smallest_change_of_acceleration_that_meets_both_ends() -> None:
    raw = integrate(shaking() + 0.02 * (np.arange(2001) > 700), 0.01)
    change = raw.acceleration - correct(raw, 1).acceleration
    for order in (2, 3):
        assert (change**2).sum() < 0.98 * ((raw.acceleration - correct(raw, order).acceleration) ** 2).sum()


def test_quadratic_is_the_least_velocity_of_its_family() -> None:
    raw = integrate(shaking() + 0.01 * np.sin(np.linspace(0.0, 2.0, 2001)), 0.01)
    best = correct(raw, 2)
    t = np.linspace(0.0, 1.0, len(raw.acceleration))
    wiggle = correct(integrate(t**2, 0.01), 1)  # a quadratic that leaves both ends alone
    for factor in (-0.01, 0.01):
        assert (best.velocity**2).sum() < ((best.velocity + factor * wiggle.velocity) ** 2).sum()


def test_quadratic_follows_a_real_drift_closer_than_linear() -> None:
    record = SHARED / "records" / "laquila_2009_AQV.csv"
    if not record.is_file():
        pytest.skip("no recorded accelerograms next to the checkout")
    time, acceleration = np.loadtxt(record, delimiter=",", skiprows=1, usecols=(0, 1)).T
    truth = correct(integrate(acceleration, 0.005), 2)
    drifts = {
        "step": 0.01 * (time > 8.0),
        "slow wave": 0.01 * np.sin(2 * np.pi * time / 60.0),
        "random walk": np.cumsum(np.random.default_rng(0).normal(size=len(time))) * 2e-4,
    }
    for drift in drifts.values():
        raw = integrate(truth.acceleration + drift, 0.005)
        error = {order: abs(correct(raw, order).displacement - truth.displacement).max() for order in (1, 2)}
        assert error[2] < error[1] / 3.0


def sine(frequency: float, step: float, seconds: float = 40.0) -> np.ndarray:
    """A sine that swells from zero and dies, so that the ends do not matter."""
    t = step * np.arange(round(seconds / step) + 1)
    return np.sin(np.pi * t / seconds) ** 2 * np.sin(2.0 * np.pi * frequency * t)


@pytest.mark.parametrize(("step", "wanted"), [(0.005, 0.01), (0.01, 0.004), (0.005, 0.008), (1 / 128, 0.01)])
def test_resampling_keeps_what_both_rates_can_hold(step: float, wanted: float) -> None:
    got = resample(sine(7.0, step), step, wanted)
    n = min(len(got), round(40.0 / wanted))
    assert got[:n] == pytest.approx(sine(7.0, wanted)[:n], abs=2e-4)


def test_resampling_to_a_slower_rate_does_not_fold_back() -> None:
    fast = sine(60.0, 0.005)  # 60 Hz would appear at 40 Hz when every second sample were dropped
    assert abs(fast[::2]).max() > 0.9
    assert abs(resample(fast, 0.005, 0.01)).max() < 1e-3


def test_resampling_to_the_same_step_is_no_change_and_odd_ratios_are_refused() -> None:
    wave = sine(7.0, 0.01)
    assert resample(wave, 0.01, 0.01) is wave
    with pytest.raises(ValueError, match="in no ratio of whole numbers"):
        resample(wave, 0.01, 0.0141421356)


@pytest.mark.parametrize("frequency", [0.25, 0.5, 2.0, 20.0, 40.0])
def test_band_pass_follows_its_formula_without_phase(frequency: float) -> None:
    step, n, low, high = 0.005, 4, 0.5, 20.0
    wave, bent = sine(frequency, step, 160.0), [np.tan(np.pi * f * step) for f in (low, frequency, high)]  # as the digital filter sees it
    gain = 1.0 / (1.0 + (bent[0] / bent[1]) ** (2 * n)) / (1.0 + (bent[1] / bent[2]) ** (2 * n))
    assert band_pass(wave, step, low, high, n) == pytest.approx(gain * wave, abs=0.015)
    if frequency in (low, high):
        assert gain == pytest.approx(0.5, abs=1e-6)


def test_a_band_beyond_the_sampling_is_refused() -> None:
    with pytest.raises(ValueError, match="its upper corner 60 Hz must lie below 50 Hz"):
        band_pass(sine(1.0, 0.01), 0.01, 0.1, 60.0, 4)
    for low in (1e-9, 5e-324):
        with pytest.raises(ValueError, match=f"its lower corner {low:g} Hz must be at least 6e-05 Hz at steps of 0.01 s"):
            band_pass(sine(1.0, 0.01), 0.01, low, 20.0, 4)


def test_taper_is_level_at_both_ends_and_one_between() -> None:
    factors = taper_factors(1001, 0.01, 2.0)
    assert factors[0] == factors[-1] == 0.0
    assert (factors[200:801] == 1.0).all()
    assert factors[100] == pytest.approx(0.5)
    assert factors == pytest.approx(factors[::-1])
    assert (taper_factors(10, 0.01, 0.0) == 1.0).all()


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
    """Four rectangular pulses, shorter than the window and slow against the filter: the three strongest count, of the stronger sign."""
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
