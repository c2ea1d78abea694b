# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.signal.filters: what passes the filters is left as it is, what does not is gone, nothing folds back and no phase is shifted."""

from __future__ import annotations

import numpy as np
import pytest

from loads.signal.filters import band_pass, resample, taper_factors


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
