# SPDX-License-Identifier: GPL-3.0-or-later
r"""Clouds: unscaled records, and a straight line through the logarithms.

    ln EDP = a + b ln IM + s e,        e standard normal
    P(EDP > c | IM) = Phi( (a + b ln IM - ln c) / s ),      theta = exp((ln c - a) / b),    beta = s / b

(Cornell, Jalayer, Hamburger & Foutch, J. Struct. Eng. 128(4), 2002; Jalayer, De Risi & Manfredi, Bull. Earthq. Eng. 13, 2015.) The
opening of a joint whose block has fallen is not a measurement. Of a run that collapsed all that is known is that it exceeds the limit
states, so that it enters the likelihood as an observation from below (tobit; Jalayer, Ebrahimian, Miano, Manfredi & Sezen, EESD 46,
2017, separate the collapses by a logistic regression instead). In the same way, what is below a thousandth of the smallest limit is an
observation from above: the logarithm of next to nothing must not steer the line. ``least_demand`` of the limit states raises that bound
to where the structure begins to answer as it does at the limit: below, joints hardly open, and the cloud is flatter or steeper there.

Where a cloud bends, one line over all of it has neither the slope nor the scatter that it has at the limit. It is compared with the best
of lines that bend once, at a knot k,

    ln EDP = a + b ln IM + d max(0, ln IM - k) + s e,        2 (log L - log L(d = 0)) > BENDS.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from masonry_cd.analysis.fragility.censored import ReplicateWeights, log_likelihood, regression
from masonry_cd.analysis.fragility.fragility import FALLING, FITTED, Lognormal

NOTHING = 1e-3  # of the smallest limit: less than this of a quantity is none
LEAST = 5  # runs seen exactly, for a line
KNOTS = np.linspace(0.15, 0.85, 29)  # quantiles of the intensities at which a line may bend
TURNS = 6  # of raising the least demand
BENDS = 12.16  # exceeded by one straight cloud in a hundred, at an unknown knot within KNOTS (Andrews, Econometrica 61(4), 1993, table 1)


class Cloud(NamedTuple):
    """Runs as the regression sees them: N runs, in logarithms."""

    measure: np.ndarray  # (N,) ln IM
    demand: np.ndarray  # (N,) ln EDP, or the bound that is known
    above: np.ndarray  # (N,) bool: known to lie above
    below: np.ndarray  # (N,) bool: known to lie below

    @property
    def exact(self) -> np.ndarray:
        """(N,) bool: seen exactly."""
        return ~self.above & ~self.below


class Line(NamedTuple):
    """ln EDP = a + b ln IM + s e, of R replicates; nan where there is none."""

    a: np.ndarray
    b: np.ndarray
    s: np.ndarray

    def fragility(self, limit: float) -> Lognormal:
        """Return the fragility of a limit."""
        rising = self.b > 1e-6
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # of lines that do not rise, which are left out
            theta = np.where(rising, np.exp((np.log(limit) - self.a) / self.b), np.nan)
            beta = np.where(rising, self.s / self.b, np.nan)
        return Lognormal(theta, beta, np.where(rising, FITTED, FALLING).astype(object))


class CloudBend(NamedTuple):
    """Where a cloud bends."""

    measure: float  # IM at the knot
    demand: float  # EDP there
    below: float  # slope below it
    above: float  # and above


def cloud_of(intensity: np.ndarray, demand: np.ndarray, collapsed: np.ndarray, limits: Sequence[float], least: float = 0.0) -> Cloud:
    """The cloud of runs.

    Args:
        intensity: (N,) positive.
        demand: (N,) largest value of a quantity; nan is allowed where blocks fell.
        collapsed: (N,) bool.
        limits: of all limit states of this quantity.
        least: demand from which on the line is to hold; of what is less it is only known that it is.
    """
    floor, most = max(least, NOTHING * min(limits)), max(limits)
    known = np.where(collapsed, np.fmin(np.where(np.isnan(demand), most, demand), most), demand)
    known = np.where(collapsed, np.maximum(known, floor), known)
    below = ~collapsed & (known < floor)
    return Cloud(np.log(intensity), np.log(np.where(below, floor, known)), collapsed, below)


def fit_line(cloud: Cloud, weights: np.ndarray) -> Line:
    """The regression, for each row of the weights (R, N)."""
    exact = weights * cloud.exact
    if not len(cloud.measure):
        return Line(*np.full((3, len(weights)), np.nan))
    x = np.column_stack([np.ones(len(cloud.measure)), cloud.measure])
    c, scatter = regression(x, cloud.demand, ReplicateWeights(exact, weights * cloud.above, weights * cloud.below))
    enough = exact.sum(axis=1) >= LEAST
    a, b, s = (np.where(enough, values, np.nan) for values in (c[:, 0], c[:, 1], scatter))
    return Line(a, b, s)


def bend_of(cloud: Cloud) -> CloudBend | None:
    """Where a cloud bends beyond chance; None of one that is straight, or has too few runs to tell."""
    exact = cloud.measure[cloud.exact]
    if len(exact) < 3 * LEAST or np.ptp(exact) == 0.0:
        return None
    kinds = ReplicateWeights(*(rows[None].astype(float) for rows in (cloud.exact, cloud.above, cloud.below)))
    straight = np.column_stack([np.ones(len(cloud.measure)), cloud.measure])
    best, found = float(log_likelihood(straight, cloud.demand, kinds, regression(straight, cloud.demand, kinds))[0]) + 0.5 * BENDS, None
    for knot in np.unique(np.quantile(exact, KNOTS)):
        bent = np.column_stack([straight, np.maximum(0.0, cloud.measure - knot)])
        fit = regression(bent, cloud.demand, kinds)
        height = float(log_likelihood(bent, cloud.demand, kinds, fit)[0])
        if height > best:
            a, b, d = fit[0][0].tolist()
            best, found = height, CloudBend(float(np.exp(knot)), float(np.exp(a + b * knot)), b, b + d)
    return found


def least_demand(cloud: Cloud, limit: float) -> float | None:
    """The demand from which on a cloud that bends is straight; None where there is none below a limit."""
    demand = 0.0
    for _ in range(TURNS):
        bend = bend_of(cloud)
        if bend is None:
            return demand
        if not demand < bend.demand < limit:
            return None
        demand = bend.demand
        below = cloud.below | (~cloud.above & (cloud.demand < np.log(demand)))
        cloud = cloud._replace(demand=np.maximum(cloud.demand, np.log(demand)), below=below)
    return None
