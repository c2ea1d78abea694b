# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.signal.baseline: integration exact for records straight between samples; corrections end at rest where they began."""

from __future__ import annotations

import numpy as np
import pytest
from places import SHARED

from loads.signal.baseline import ORDERS, correct, integrate


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
        pytest.skip("no recorded accelerograms beside the checkout")
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
