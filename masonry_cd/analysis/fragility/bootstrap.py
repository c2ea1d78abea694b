# SPDX-License-Identifier: GPL-3.0-or-later
"""The bootstrap over records (Efron & Tibshirani, An introduction to the bootstrap, 1993): percentile bands of whatever is fitted.

Runs under one record are not independent: a record that is gentle at one level is so at the next. So records are drawn, with replacement,
each with all of its runs; runs without a record are drawn one by one. A replicate is a row of weights, how often each run counts, and all
replicates are fitted at once. The study's seed makes them: equal seeds give equal bands.
"""

from __future__ import annotations

import numpy as np

REPLICATES = 1000
LEVEL = 0.95  # of the bands
FEW = 0.05  # share of replicates that may fail without a word


def replicates(clusters: np.ndarray, seed: int, count: int = REPLICATES) -> np.ndarray:
    """(count, N) how often each run counts in each replicate; ``clusters`` (N,) int, 0 to M - 1, are drawn together."""
    if not len(clusters):
        return np.zeros((count, 0))
    members = int(clusters.max()) + 1
    drawn = np.random.default_rng([seed, members]).integers(0, members, (count, members))
    flat = np.bincount((drawn + members * np.arange(count)[:, None]).ravel(), minlength=count * members)
    return flat.reshape(count, members)[:, clusters].astype(float)


def band(values: np.ndarray, level: float = LEVEL) -> tuple[float, float]:
    """The percentile interval of replicates (R,), infinite ones included, nan left out; nan where nothing is left."""
    left = np.sort(values[~np.isnan(values)])
    if not len(left):
        return np.nan, np.nan
    tail = 0.5 * (1.0 - level)
    low, high = int(np.floor(tail * len(left))), int(np.ceil((1.0 - tail) * len(left))) - 1
    return float(left[min(low, len(left) - 1)]), float(left[max(high, 0)])


def bands(values: np.ndarray, level: float = LEVEL) -> tuple[np.ndarray, np.ndarray]:
    """The percentile intervals of each column of replicates (R, G)."""
    pairs = [band(column, level) for column in values.T]
    return np.array([low for low, _ in pairs]), np.array([high for _, high in pairs])
