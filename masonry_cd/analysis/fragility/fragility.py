# SPDX-License-Identifier: GPL-3.0-or-later
r"""Lognormal fragilities by maximum likelihood on counts of runs that exceed a limit state.

    P(exceeded | IM) = Phi( ln(IM / theta) / beta ),        k_j of n_j runs at IM_j exceed it, binomial
    log L = sum_j  k_j log P(IM_j) + (n_j - k_j) log(1 - P(IM_j))

Baker (Earthquake Spectra 31(1), 2015), equations 7 to 11. With a = -ln(theta) / beta and b = 1 / beta it is probit regression on ln IM,
whose likelihood is concave (:mod:`masonry_cd.analysis.fragility.censored`): one maximum, found from anywhere. On stripes the counts are by
level (method ``mle``); where runs have intensities of their own each is a level by itself (``probit``).

Data that separate, all runs up to one intensity below the limit state and all from another above it, put theta between the two and leave
beta free: its estimate falls to 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from masonry_cd.analysis.fragility.censored import ReplicateWeights, maximise

FITTED, NONE, ALL, SEPARATED, FALLING = "fitted", "none", "all", "separated", "falling"


class Lognormal(NamedTuple):
    """Lognormal curves of R replicates.

    ``theta`` is inf where nothing exceeds, 0 where everything does, nan where exceedance falls with intensity; ``beta`` is nan then, and 0
    where the data separate. ``state`` says which.
    """

    theta: np.ndarray  # (R,) median, in the measure's unit
    beta: np.ndarray  # (R,) standard deviation of the logarithm
    state: np.ndarray  # (R,) of FITTED, NONE, ALL, SEPARATED, FALLING

    def probability(self, intensity: np.ndarray) -> np.ndarray:
        """(R, G) probabilities at intensities (G,)."""
        with np.errstate(divide="ignore", invalid="ignore"):  # medians of 0, infinity and nan are seen to below
            ratio = np.log(intensity)[None, :] - np.log(self.theta)[:, None]
            out = ndtr(ratio / np.maximum(np.where(np.isnan(self.beta), 0.0, self.beta), 1e-9)[:, None])
        out[np.isposinf(self.theta)] = 0.0
        out[self.theta == 0.0] = 1.0
        out[np.isnan(self.theta)] = np.nan
        return np.asarray(out)


def fit_counts(intensity: np.ndarray, exceeded: np.ndarray, runs: np.ndarray) -> Lognormal:
    """Fit lognormal fragilities to counts.

    Args:
        intensity: (K,) levels, positive, in any order.
        exceeded: (R, K) how many runs exceeded the limit state at each level, in each replicate.
        runs: (R, K) of how many.
    """
    below = runs - exceeded
    state = _states(intensity, exceeded, below)
    theta, beta = np.full(len(runs), np.nan), np.full(len(runs), np.nan)
    theta[state == NONE], theta[state == ALL] = np.inf, 0.0
    apart = state == SEPARATED
    theta[apart], beta[apart] = np.sqrt(_highest(intensity, below[apart]) * _lowest(intensity, exceeded[apart])), 0.0
    rows = np.flatnonzero(state == FITTED)
    if len(rows):
        logs = np.log(intensity)
        middle = logs.mean()
        design = np.column_stack([np.ones(len(logs)), logs - middle])
        weights = ReplicateWeights(np.zeros((len(rows), len(logs))), exceeded[rows].astype(float), below[rows].astype(float))
        a, b = maximise(design, weights, np.zeros((len(rows), 2)), scaled=False).T
        rising = b > 1e-6
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # of fits that do not rise, which are left out
            theta[rows], beta[rows] = np.where(rising, np.exp(middle - a / b), np.nan), np.where(rising, 1.0 / b, np.nan)
        state[rows[~rising]] = FALLING
    return Lognormal(theta, beta, state)


def _states(intensity: np.ndarray, exceeded: np.ndarray, below: np.ndarray) -> np.ndarray:
    """(R,) whether counts can be fitted, and if not, why."""
    out = np.full(len(exceeded), FITTED, dtype=object)
    out[_highest(intensity, exceeded) <= _lowest(intensity, below)] = FALLING
    out[_highest(intensity, below) <= _lowest(intensity, exceeded)] = SEPARATED
    out[exceeded.sum(axis=1) == 0] = NONE
    out[below.sum(axis=1) == 0] = ALL
    return out


def _highest(intensity: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """(R,) the highest intensity with a count, -inf for none."""
    return np.where(counts > 0, intensity, -np.inf).max(axis=1, initial=-np.inf)


def _lowest(intensity: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """(R,) the lowest intensity with a count, inf for none."""
    return np.where(counts > 0, intensity, np.inf).min(axis=1, initial=np.inf)


def by_level(intensity: np.ndarray, exceeded: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Counts at equal intensities.

    Args:
        intensity: (N,) of each run.
        exceeded: (N,) bool.
        weights: (R, N) how often each run counts.

    Returns:
        levels (K,), exceeded (R, K), runs (R, K).
    """
    levels, place = np.unique(intensity, return_inverse=True)
    order = np.argsort(place, kind="stable")
    start = np.searchsorted(place[order], np.arange(len(levels)))
    if not len(levels):
        return levels, np.zeros((len(weights), 0)), np.zeros((len(weights), 0))
    runs = np.add.reduceat(weights[:, order], start, axis=1)
    return levels, np.add.reduceat((weights * exceeded)[:, order], start, axis=1), runs


def falls(exceeded: np.ndarray, runs: np.ndarray) -> bool:
    """Return True if the share exceeded (K,) falls from one level to the next by more than two standard deviations of chance."""
    share = exceeded / runs
    pooled = (exceeded[1:] + exceeded[:-1]) / (runs[1:] + runs[:-1])
    chance = np.sqrt(pooled * (1.0 - pooled) * (1.0 / runs[1:] + 1.0 / runs[:-1]))
    return bool(((share[:-1] - share[1:]) > 2.0 * chance + 1e-12).any())
