# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensitivity: rank correlations of what varied and of the intensity measures with the quantities of the limit states.

Spearman's rho is the correlation of the ranks, ties by their mean. Its p-value is the chance of one as large where nothing is related, by
Student's t with n - 2 degrees of freedom, as if the runs were independent; the band, by the bootstrap over records, does not assume that.
Where the intensity differs widely it hides all else: ``given_measure`` is the partial correlation, that of the ranks after the study's
measure has been taken out of both.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import rankdata, t

from masonry_cd.analysis.fragility.bootstrap import band, replicates
from masonry_cd.analysis.fragility.folder import StudyResults

LEAST = 8  # runs, for a correlation
SIGNIFICANT = 0.01  # p-values below
COLUMNS = ("variable", "kind", "quantity", "rho", "low", "high", "p", "given_measure", "runs")
CHUNK = 1_000_000  # replicates times runs at once


class RankCorrelation(NamedTuple):
    """A row of sensitivity.csv."""

    variable: str
    kind: str  # varied | intensity
    quantity: str
    rho: float
    low: float  # 95 % band
    high: float
    p: float
    given_measure: float  # nan for the measure itself
    runs: int


def correlations(study: StudyResults) -> list[RankCorrelation]:
    """All of them, quantity by quantity, the strongest first."""
    rows: list[RankCorrelation] = []
    kinds = [(name, "varied") for name in study.spread(study.varied)] + [(name, "intensity") for name in study.spread(study.measures)]
    for quantity in dict.fromkeys(limit.column for limit in study.limit_states):
        if study.spread([quantity]):
            found = [_one(study, name, kind, quantity) for name, kind in kinds]
            rows += sorted((row for row in found if row is not None), key=lambda row: (-abs(row.rho), row.variable))
    return rows


def _one(study: StudyResults, name: str, kind: str, quantity: str) -> RankCorrelation | None:
    """The correlation of a variable with a quantity; None where too few runs have both."""
    x, y = study.numbers(name), study.numbers(quantity)
    rows = np.flatnonzero(study.done & np.isfinite(x) & np.isfinite(y))
    x, y = x[rows], y[rows]
    if len(rows) < LEAST or np.ptp(x) == 0 or np.ptp(y) == 0:
        return None
    rho = _pearson(rankdata(x), rankdata(y))
    low, high = band(_replicated(x, y, np.unique(study.clusters[rows], return_inverse=True)[1].reshape(-1), study.asked.seed))
    return RankCorrelation(name, kind, quantity, rho, low, high, p_value(rho, len(rows)), _partial(study, name, rows, x, y), len(rows))


def p_value(rho: float, count: int) -> float:
    """Chance of a correlation as large where nothing is related."""
    if abs(rho) >= 1.0:
        return 0.0
    return float(2.0 * t.sf(abs(rho) * np.sqrt((count - 2) / (1.0 - rho**2)), count - 2))


def _partial(study: StudyResults, name: str, rows: np.ndarray, x: np.ndarray, y: np.ndarray) -> float:
    """The correlation of the ranks once those of the study's measure have been taken out of both."""
    measure = study.asked.measure
    z = study.numbers(measure)[rows] if measure and measure != name else np.zeros(len(rows))
    if not np.isfinite(z).all() or np.ptp(z) == 0:
        return np.nan
    rx, ry, rz = rankdata(x), rankdata(y), rankdata(z)
    xy, xz, yz = _pearson(rx, ry), _pearson(rx, rz), _pearson(ry, rz)
    below = (1.0 - xz**2) * (1.0 - yz**2)
    return float((xy - xz * yz) / np.sqrt(below)) if below > 1e-12 else np.nan


def _pearson(x: np.ndarray, y: np.ndarray) -> float:
    x, y = x - x.mean(), y - y.mean()
    return float((x * y).sum() / np.sqrt((x * x).sum() * (y * y).sum()))


def _replicated(x: np.ndarray, y: np.ndarray, clusters: np.ndarray, seed: int) -> np.ndarray:
    """(R,) the correlations of the replicates; nan where one of the two does not vary in it."""
    weights = replicates(clusters, seed)
    step = max(1, CHUNK // len(x))
    return np.concatenate([_weighted(x, y, weights[k : k + step]) for k in range(0, len(weights), step)])


def _weighted(x: np.ndarray, y: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """(R,) correlations of ranks among runs that count by weights (R, N)."""
    total = weights.sum(axis=1, keepdims=True)
    ranks = []
    for values in (x, y):
        ordered, place = np.unique(values, return_inverse=True)
        order = np.argsort(place, kind="stable")
        start = np.searchsorted(place[order], np.arange(len(ordered)))
        size = np.add.reduceat(weights[:, order], start, axis=1)
        rank = np.cumsum(size, axis=1) - 0.5 * size
        centred = rank[:, place.reshape(-1)] - 0.5 * total
        ranks.append(centred)
    a, b = ranks
    with np.errstate(invalid="ignore", divide="ignore"):  # 0 / 0 of a quantity that is the same in all runs
        below = np.sqrt((weights * a * a).sum(axis=1) * (weights * b * b).sum(axis=1))
        return np.asarray(np.where(below > 0, (weights * a * b).sum(axis=1) / below, np.nan))
