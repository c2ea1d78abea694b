# SPDX-License-Identifier: GPL-3.0-or-later
r"""Processing of a record's samples before its baseline is corrected: mean, taper, resampling, band-pass.

**Resampling** by a ratio up/down of whole numbers: zeros are put between the samples, a linear-phase low-pass filter of finite length
(Kaiser window, beta 8: 80 dB) is applied, every ``down``-th value is kept (Crochiere & Rabiner, "Multirate Digital Signal
Processing", 1983). It passes up to 0.72 of the lower Nyquist frequency and stops above 0.98 of it, so nothing folds back. The filter is
symmetric: no phase is shifted.

**Band-pass** by a Butterworth filter of order n run forwards and backwards, as is usual for strong motion (Boore & Bommer, Soil Dyn.
Earthq. Eng. 25, 2005):

    |H(f)|^2 = 1 / (1 + (f_low / f)^2n)  *  1 / (1 + (f / f_high)^2n),        phase zero.

At a corner the amplitude is halved (1/sqrt(2) per pass). The filter rings before and after the record, so it is run over the record between
zeros of 1.5 n / f_low seconds (Converse & Brady, USGS OFR 92-296A, 1992) and cut back to it; what the cut leaves of velocity and
displacement goes with the baseline.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from loads.motion import smooth_step

LARGEST_RATIO = 1000  # of whole numbers up / down in a resampling
HALF_LENGTH = 20  # of the anti-aliasing filter, in samples of the slower rate
CUTOFF = 0.85  # of the lower Nyquist frequency
MOST_ZEROS = 1e7  # before and after a record that is filtered: the transient of the high-pass


def taper_factors(count: int, step: float, length: float) -> np.ndarray:
    """Factors (count,) that rise and fall smoothly over a length [s] at both ends.

    Raises:
        ValueError: two tapers do not fit into the record.
    """
    if length == 0.0:
        return np.ones(count)
    since = step * np.arange(count)
    if 2.0 * length > since[-1]:
        raise ValueError(f"{length:g} s at both ends do not fit into the {since[-1]:g} s of the record")
    return np.asarray(smooth_step(since / length) * smooth_step((since[-1] - since) / length))


def resample(values: np.ndarray, step: float, wanted: float) -> np.ndarray:
    """Samples every ``wanted`` seconds of a signal given every ``step``, without aliasing.

    Raises:
        ValueError: the two steps are in no ratio of whole numbers up to 1000.
    """
    ratio = Fraction(step / wanted).limit_denominator(LARGEST_RATIO)
    if ratio.numerator == 0 or ratio.numerator > LARGEST_RATIO or abs(float(ratio) * wanted / step - 1.0) > 1e-6:
        raise ValueError(f"{wanted:g} s and the record's {step:g} s are in no ratio of whole numbers up to {LARGEST_RATIO}")
    up, down = ratio.numerator, ratio.denominator
    if up == down:
        return values
    from scipy import signal  # takes a second to load

    slower = max(up, down)
    low_pass = signal.firwin(2 * HALF_LENGTH * slower + 1, CUTOFF / slower, window=("kaiser", 8.0))
    return np.asarray(signal.resample_poly(values, up, down, window=low_pass, padtype="line"))


def band_pass(values: np.ndarray, step: float, low: float, high: float, order: int) -> np.ndarray:
    """The zero-phase Butterworth band-pass of samples, see the head of this file.

    Args:
        values: (n,).
        step: [s].
        low: corner [Hz].
        high: corner [Hz].
        order: n of each of the two passes.

    Raises:
        ValueError: a corner at or above the Nyquist frequency, or one so low that the zeros at both ends would be beyond MOST_ZEROS.
    """
    from scipy import signal

    nyquist = 0.5 / step
    if high >= nyquist:
        raise ValueError(f"its upper corner {high:g} Hz must lie below {nyquist:g} Hz, half the sampling rate")
    lowest = 1.5 * order / step / MOST_ZEROS
    if low < lowest:
        raise ValueError(f"its lower corner {low:g} Hz must be at least {lowest:.2g} Hz at steps of {step:g} s")
    pad = int(np.ceil(1.5 * order / low / step))
    padded = np.concatenate([np.zeros(pad), values, np.zeros(pad)])
    for corner, kind in ((low, "highpass"), (high, "lowpass")):
        sections = signal.butter(order, corner / nyquist, kind, output="sos")
        padded = signal.sosfiltfilt(sections, padded, padtype=None)
    return np.asarray(padded[pad : pad + len(values)])
