# SPDX-License-Identifier: GPL-3.0-or-later
r"""Incremental dynamic analysis: a curve per record, its capacities, and their quantiles.

The method is that of Vamvatsikos & Cornell (Earthq. Eng. Struct. Dyn. 31(3), 2002). The capacity of a record for a limit state is the
intensity at which its curve first exceeds it. Between the last run below and the first run above it is found on the straight line through
the logarithms of the two, where the quantity has one, and else as their geometric mean. A record that never exceeds the limit state has a
capacity above its highest run; one that always does, below its lowest. Both enter the likelihood as such
(:mod:`masonry_cd.analysis.fragility.censored`):

    theta = exp(mean ln IM_c),      beta = standard deviation of ln IM_c, with n - 1  (Baker 2015, equations 3 and 4)

and where nothing is censored it is just these moments.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from masonry_cd.analysis.fragility.censored import ReplicateWeights, regression
from masonry_cd.analysis.fragility.fragility import ALL, FITTED, NONE, SEPARATED, Lognormal
from masonry_cd.analysis.fragility.limits import LimitState

QUANTILES = (0.16, 0.50, 0.84)
GRID = 60  # intensities at which the quantiles of the demand are taken


class IdaCurve(NamedTuple):
    """Runs of one record (and of one set of what varied), from weak to strong."""

    rows: np.ndarray  # (n,) of the table
    intensity: np.ndarray  # (n,)

    def demands(self, values: np.ndarray, collapsed: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """From (0, 0) on the intensities and demands of the runs before the collapse, and the intensity of that; inf where there is none.

        It lies between two runs; as elsewhere it is put into their geometric mean. ``values`` and ``collapsed`` (N,) are of all rows.
        """
        down = collapsed[self.rows]
        first = int(np.argmax(down)) if down.any() else len(down)
        x, y = np.concatenate([[0.0], self.intensity[:first]]), np.concatenate([[0.0], values[self.rows][:first]])
        if first == len(down):
            return x, y, np.inf
        last, fallen = float(x[-1]), float(self.intensity[first])
        return x, y, float(np.sqrt(last * fallen)) if last > 0 else fallen


class Capacities(NamedTuple):
    """Capacities of C curves."""

    intensity: np.ndarray  # (C,) where the limit state is first exceeded, or the bound that is known
    above: np.ndarray  # (C,) bool: never exceeded, the capacity lies above
    below: np.ndarray  # (C,) bool: exceeded by the weakest run already


def curves_of(rows: np.ndarray, keys: Sequence[tuple[object, ...]], intensity: np.ndarray) -> list[IdaCurve]:
    """The curves of runs ``rows`` (n,), those of equal ``keys`` together; ``intensity`` (n,)."""
    places: dict[tuple[object, ...], list[int]] = {}
    for k, key in enumerate(keys):
        places.setdefault(key, []).append(k)
    curves = []
    for found in places.values():
        order = np.array(found)[np.argsort(intensity[found], kind="stable")]
        curves.append(IdaCurve(rows[order], intensity[order]))
    return curves


def capacities(curves: Sequence[IdaCurve], limit: LimitState, values: np.ndarray, collapsed: np.ndarray) -> Capacities:
    """The capacities of curves for a limit state.

    Args:
        curves: of C records.
        limit: the limit state.
        values: (N,) its quantity in all rows of the table.
        collapsed: (N,) bool.
    """
    found, above, below = [], [], []
    for curve in curves:
        own = values[curve.rows]
        over = limit.exceeded(own)
        first = int(np.argmax(over)) if over.any() else len(own)
        above.append(first == len(own))
        below.append(first == 0)
        if above[-1] or below[-1]:
            found.append(float(curve.intensity[-1 if above[-1] else 0]))
        else:
            low, high = curve.intensity[first - 1], curve.intensity[first]
            usable = limit.is_continuous and own[first - 1] > 0 and not collapsed[curve.rows[first]]
            share = np.log(limit.bound / own[first - 1]) / np.log(own[first] / own[first - 1]) if usable else 0.5
            found.append(float(np.exp(np.log(low) + np.clip(share, 0.0, 1.0) * np.log(high / low))))
    return Capacities(np.array(found), np.array(above, dtype=bool), np.array(below, dtype=bool))


def fit_capacities(found: Capacities, weights: np.ndarray) -> Lognormal:
    """The lognormal distribution of capacities, for each row of the weights (R, C)."""
    theta, beta = np.full(len(weights), np.nan), np.full(len(weights), np.nan)
    state = np.full(len(weights), FITTED, dtype=object)
    exact = weights * ~(found.above | found.below)
    state[exact.sum(axis=1) < 2] = SEPARATED
    state[(weights * ~found.above).sum(axis=1) == 0], state[(weights * ~found.below).sum(axis=1) == 0] = NONE, ALL
    theta[state == NONE], theta[state == ALL] = np.inf, 0.0
    logs, rows = np.log(found.intensity), np.flatnonzero(state == FITTED)
    if not len(rows):
        return Lognormal(theta, beta, state)
    count = exact[rows].sum(axis=1)
    middle = (exact[rows] * logs).sum(axis=1) / count
    scatter = np.sqrt((exact[rows] * (logs - middle[:, None]) ** 2).sum(axis=1) / count)
    censored = (weights[rows] * (found.above | found.below)).sum(axis=1) > 0
    if censored.any():
        chosen = weights[rows[censored]]
        kinds = ReplicateWeights(exact[rows[censored]], chosen * found.above, chosen * found.below)
        c, s = regression(np.ones((len(logs), 1)), logs, kinds)
        middle[censored], scatter[censored] = c[:, 0], s
    total = weights[rows].sum(axis=1)
    theta[rows], beta[rows] = np.exp(middle), scatter * np.sqrt(total / np.maximum(total - 1.0, 1.0))
    return Lognormal(theta, beta, state)


def capacity_quantiles(found: Capacities) -> list[float]:
    """The 16, 50 and 84 % quantiles of the capacities as they are, inf where too many records never exceed the limit state."""
    return quantiles(np.where(found.above, np.inf, found.intensity), QUANTILES)


def quantiles(values: np.ndarray, shares: Sequence[float]) -> list[float]:
    """Order statistics at shares of values (N,), infinite ones included; nan where there are no values."""
    ordered = np.sort(values)
    return [float(ordered[max(0, int(np.ceil(q * len(ordered))) - 1)]) if len(ordered) else np.nan for q in shares]


def demand_quantiles(curves: Sequence[IdaCurve], values: np.ndarray, collapsed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The 16, 50 and 84 % quantiles of a quantity over the records at given intensities.

    Each curve is taken straight between its runs, from nothing at no intensity on; from the first collapse on its demand is infinite, and
    beyond its strongest run, where that still stands, unknown: there the quantiles end.

    Returns:
        intensities (G,), and demands (3, G), inf where a given number of records have collapsed.
    """
    known = [curve.intensity[-1] for curve in curves if not collapsed[curve.rows].any()]
    top = min([max(curve.intensity[-1] for curve in curves), *known])
    grid = top * np.arange(1, GRID + 1) / GRID
    table = np.array([_demand(curve, values, collapsed, grid) for curve in curves])
    table.sort(axis=0)
    places = [max(0, int(np.ceil(q * len(table))) - 1) for q in QUANTILES]
    return grid, table[places]


def _demand(curve: IdaCurve, values: np.ndarray, collapsed: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """The demand of a curve at intensities (G,)."""
    intensity, demand, collapse = curve.demands(values, collapsed)
    return np.where(grid > collapse, np.inf, np.interp(grid, intensity, demand))
