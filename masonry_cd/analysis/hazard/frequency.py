# SPDX-License-Identifier: GPL-3.0-or-later
r"""How often a year a limit state is exceeded: a lognormal fragility over the hazard, in closed form.

    lambda_LS = int P(LS | im) |d lambda(im)|,        P = Phi((x - mu) / beta),    x = ln im,  mu = ln theta

Between two rows lambda = lambda_j e^(-k (x - x_j)). By parts, and with the square of the exponent completed,

    int_a^b lambda(x) phi((x - mu) / beta) dx / beta
        = lambda_j e^(k (x_j - mu) + k^2 beta^2 / 2) [Phi((b - mu) / beta + k beta) - Phi((a - mu) / beta + k beta)],

so that no quadrature is needed; of one power law k0 im^-k all is k0 theta^-k e^(k^2 beta^2 / 2) (Cornell, Proc. 11th ECEE, 1996).
What lies beyond the rows is bounded:

    above the last     Phi(u_n) lambda_n   to  lambda_n,       u = (x - mu) / beta,
    below the first    0                   to  the power law of the first two rows, gone on with: hazard curves are flatter there.

The occurrences are a Poisson process: the probability in t years is 1 - e^(-lambda t).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import log_ndtr, ndtr

from masonry_cd.analysis.hazard.curve import Hazard

SHARPEST = 1e-9  # beta of a fragility that is a step
YEARS = 50.0  # of the probability that is reported


class Frequency(NamedTuple):
    """Mean annual frequencies of R fragilities [1/year]; the truth lies between both if the hazard goes on no steeper below its rows."""

    least: np.ndarray  # (R,)
    most: np.ndarray  # (R,)


def frequency(hazard: Hazard, theta: np.ndarray, beta: np.ndarray) -> Frequency:
    """The mean annual frequencies of fragilities.

    Args:
        hazard: n rows, of the measure of theta.
        theta: (R,) medians; infinite where nothing exceeds, 0 where everything does, nan where there is none.
        beta: (R,) standard deviations of the logarithm.
    """
    with np.errstate(divide="ignore", invalid="ignore"):  # medians of 0, infinity and nan are seen to below
        mu, beta = np.log(theta)[:, None], np.maximum(np.nan_to_num(beta), SHARPEST)[:, None]
        x, logs = np.log(hazard.intensity)[None, :], np.log(hazard.frequency)[None, :]
        u, slope = (x - mu) / beta, -np.diff(logs) / np.diff(x)
        exponent = logs[:, :-1] + slope * (x[:, :-1] - mu) + 0.5 * (slope * beta) ** 2
        shift = slope * beta
        inside = np.exp(exponent + _log_of_difference(u[:, :-1] + shift, u[:, 1:] + shift)).sum(axis=1)
        below = np.exp(exponent[:, 0] + log_ndtr(u[:, 0] + shift[:, 0]))
    first, last = hazard.frequency[0] * ndtr(u[:, 0]), hazard.frequency[-1] * ndtr(-u[:, -1])
    least, most = first + inside, np.maximum(below, first) + inside + last
    for found in (least, most):
        found[np.isposinf(theta)] = 0.0
        found[theta == 0.0] = np.inf
        found[np.isnan(theta)] = np.nan
    return Frequency(least, most)


def _log_of_difference(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """ln(Phi(high) - Phi(low)), by the tail in which both lie."""
    flipped = low > 0.0
    small, large = np.where(flipped, -high, low), np.where(flipped, -low, high)
    top = log_ndtr(large)
    return np.asarray(top + np.log1p(-np.exp(np.minimum(log_ndtr(small) - top, 0.0))))


def probability(frequency: np.ndarray, years: float = YEARS) -> np.ndarray:
    """The probability of at least one occurrence in some years."""
    return np.asarray(-np.expm1(-np.asarray(frequency) * years))
