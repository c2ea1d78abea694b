# SPDX-License-Identifier: GPL-3.0-or-later
r"""The intensity that the next runs of a fragility should have: that from which most is learnt about theta and beta.

The method Psi of Kontsevich & Tyler (Vision Research 39(16), 1999): the posterior of ln theta and ln beta on a grid, from a flat prior, and
the level at which its entropy is expected to fall most. The fall is the mutual information of the outcome and the parameters (Lindley, Ann.
Math. Stat. 27(4), 1956),

    I(x) = h(E[P(x)]) - E[h(P(x))],        h(p) = -p ln p - (1 - p) ln(1 - p)

Runs that are made at once are chosen one after another, each in expectation over all outcomes that those before it may have; this greedy
choice learns at least 63 % of what the best batch does (Krause & Guestrin, UAI, 2005).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import entr, xlog1py, xlogy

from masonry_cd.analysis.fragility.fragility import Lognormal

MEDIANS, BETAS = 161, 49  # points of the grid
BEYOND = 2.0  # times the lowest and the highest level, between which the median is sought
SCATTER = (0.1, 1.5)  # between which beta is sought
NOTHING = 1e-6  # of the likeliest point: what is less likely is not looked at


@dataclass(frozen=True, eq=False)
class Grid:
    """Lognormal fragilities, as many medians as there are times as many betas, at levels of the intensity."""

    theta: np.ndarray  # (G,)
    beta: np.ndarray  # (G,)
    chance: np.ndarray  # (G, K) of exceedance at each level

    @classmethod
    def over(cls, levels: np.ndarray) -> Grid:
        """The grid for levels (K,), positive, in any order."""
        medians = np.geomspace(levels.min() / BEYOND, BEYOND * levels.max(), MEDIANS)
        theta, beta = (each.ravel() for each in np.meshgrid(medians, np.geomspace(*SCATTER, BETAS)))
        return cls(theta, beta, Lognormal(theta, beta, np.empty(0)).probability(levels))

    def posterior(self, exceeded: np.ndarray, runs: np.ndarray) -> np.ndarray:
        """(G,) weights that sum to 1, given how many of as many runs (K,) exceeded the limit state at each level."""
        log = (xlogy(exceeded, self.chance) + xlog1py(runs - exceeded, -self.chance)).sum(axis=1)
        weights = np.exp(log - log.max())
        return np.asarray(weights / weights.sum())

    def spread(self, weights: np.ndarray) -> tuple[float, float]:
        """The standard deviations of ln theta and of ln beta."""
        theta, beta = (np.log(each) for each in (self.theta, self.beta))
        first, second = (float(np.sqrt(weights @ (each - weights @ each) ** 2)) for each in (theta, beta))
        return first, second

    def most_telling(self, weights: np.ndarray, free: np.ndarray, count: int) -> list[int]:
        """The levels of the next runs.

        Args:
            weights: (G,) the posterior.
            free: (K,) how many runs each level may still have.
            count: of runs; the time doubles with each.
        """
        likely = weights > NOTHING * weights.max()
        chance, left, chosen = self.chance[likely], free.copy(), list[int]()
        joint = weights[likely][None]  # (outcomes, points), of the runs chosen so far
        doubt = entr(chance) + entr(1.0 - chance)
        while len(chosen) < count and left.any():
            outcome = joint.sum(axis=1, keepdims=True)
            mean = np.clip(joint @ chance / np.maximum(outcome, np.finfo(float).tiny), 0.0, 1.0)
            gain = (outcome * (entr(mean) + entr(1.0 - mean)) - joint @ doubt).sum(axis=0)
            best = int(np.argmax(np.where(left > 0, gain, -np.inf)))
            chosen.append(best)
            left[best] -= 1
            joint = np.concatenate([joint * chance[:, best], joint * (1.0 - chance[:, best])])
        return chosen
