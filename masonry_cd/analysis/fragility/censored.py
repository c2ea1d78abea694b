# SPDX-License-Identifier: GPL-3.0-or-later
r"""Normal regression of what is known exactly, only from below, or only from above, by maximum likelihood.

A latent y = x . c + s e, e standard normal, is seen exactly, or known to lie above or below a bound y. With g = (c / s, 1 / s), u = (x, -y)
and eta = u . g the log-likelihood of all observations with weights w is

    sum_exact w (log(1/s) - eta^2 / 2)  +  sum_above w log Phi(eta)  +  sum_below w log Phi(-eta),

concave in g (Olsen, Econometrica 46(5), 1978), so that Newton's method with halved steps finds its maximum from anywhere. Probit
regression is the case in which nothing is seen exactly: then u = x, and g are the coefficients.

All replicates of a bootstrap are solved at once: they share the observations and differ in their weights.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import log_ndtr

ITERATIONS = 60
ENOUGH = 1e-10  # Newton steps below this share of the coefficients end the iteration
HALVINGS = 30
CHUNK = 1_000_000  # replicates times observations at once: some 10 MB per array
LOG_ROOT_2_PI = 0.5 * np.log(2.0 * np.pi)


class ReplicateWeights(NamedTuple):
    """How often each of N observations counts in each of R replicates, (R, N) each."""

    exact: np.ndarray
    above: np.ndarray
    below: np.ndarray

    def rows(self, chosen: np.ndarray | slice) -> ReplicateWeights:
        """Those of some replicates."""
        return ReplicateWeights(self.exact[chosen], self.above[chosen], self.below[chosen])


def maximise(design: np.ndarray, weights: ReplicateWeights, start: np.ndarray, scaled: bool) -> np.ndarray:
    """Maximise the log-likelihood of the head of this file.

    Args:
        design: (N, q) rows u.
        weights: of the observations, by kind.
        start: (R, q) first guess; its last column positive where ``scaled``.
        scaled: the last coefficient is 1 / s; needed where anything is seen exactly.

    Returns:
        (R, q) coefficients g; nan in a row whose maximum is not finite or was not found.
    """
    rows = max(1, CHUNK // max(1, len(design)))
    parts = [_newton(design, weights.rows(slice(k, k + rows)), start[k : k + rows], scaled) for k in range(0, len(start), rows)]
    return np.concatenate(parts) if parts else start.copy()


def regression(x: np.ndarray, y: np.ndarray, weights: ReplicateWeights) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients c (R, p) and scatter s (R,) of y (N,) over x (N, p); nan where they are not determined."""
    middle = y.mean()
    design = np.column_stack([x, -(y - middle)])
    spread = max(float(y.std()), 1e-6)
    guess = np.linalg.lstsq(x, y - middle, rcond=None)[0] / spread
    found = maximise(design, weights, np.tile([*guess, 1.0 / spread], (len(weights.exact), 1)), scaled=True)
    scatter = 1.0 / found[:, -1]
    c = found[:, :-1] * scatter[:, None]
    c[:, 0] += middle  # the first column of x is of ones
    return c, scatter


def log_likelihood(x: np.ndarray, y: np.ndarray, weights: ReplicateWeights, found: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """(R,) of coefficients and scatter that :func:`regression` found of y (N,) over x (N, p); nan where they are not determined."""
    c, scatter = found
    return _likelihood(np.column_stack([c, np.ones(len(c))]) / scatter[:, None], np.column_stack([x, -y]), weights, scaled=True)


def _newton(design: np.ndarray, weights: ReplicateWeights, start: np.ndarray, scaled: bool) -> np.ndarray:
    """Newton's method on some replicates, those that have arrived left alone."""
    g, outer = start.astype(float), np.einsum("np,nq->npq", design, design).reshape(len(design), -1)
    height = _likelihood(g, design, weights, scaled)
    moving, lost = np.arange(len(g)), np.zeros(len(g), dtype=bool)
    for _ in range(ITERATIONS):
        if not len(moving):
            break
        now = weights.rows(moving)
        step, singular = _step(g[moving], design, outer, now, scaled)
        shorter, found = _ascend(g[moving], step, height[moving], (design, now, scaled))
        g[moving] += shorter[:, None] * step
        height[moving] = found
        lost[moving[singular]] = True
        arrived = np.abs(step).max(axis=1) <= ENOUGH * (1.0 + np.abs(g[moving]).max(axis=1))
        moving = moving[~arrived & ~singular & (shorter > 0)]
    lost[moving] = True
    g[lost | (np.abs(g).max(axis=1) > 1e8)] = np.nan
    return g


def _step(g: np.ndarray, design: np.ndarray, outer: np.ndarray, weights: ReplicateWeights, scaled: bool) -> tuple[np.ndarray, np.ndarray]:
    """Newton steps (R, q), and the replicates (R,) whose information is singular."""
    eta = np.einsum("nq,rq->rn", design, g)
    up, down = _ratio(eta), _ratio(-eta)  # phi / Phi
    slope = weights.above * up - weights.below * down - weights.exact * eta
    curvature = weights.above * up * (up + eta) + weights.below * down * (down - eta) + weights.exact
    gradient = np.einsum("rn,nq->rq", slope, design)
    information = np.einsum("rn,nk->rk", curvature, outer).reshape(len(g), g.shape[1], g.shape[1])
    if scaled:
        exact = weights.exact.sum(axis=1)
        gradient[:, -1] += exact / g[:, -1]
        information[:, -1, -1] += exact / g[:, -1] ** 2
    size = np.sqrt(np.maximum(np.einsum("rqq->rq", information), 1e-300))
    even = information / (size[:, :, None] * size[:, None, :])
    singular = ~(np.linalg.det(even) > 1e-13)
    even[singular] = np.eye(g.shape[1])
    step = np.linalg.solve(even, (gradient / size)[:, :, None])[:, :, 0] / size
    step[singular] = 0.0
    return step, singular


def _ascend(
    g: np.ndarray, step: np.ndarray, height: np.ndarray, problem: tuple[np.ndarray, ReplicateWeights, bool]
) -> tuple[np.ndarray, np.ndarray]:
    """Which share (R,) of each step climbs, 0 where none does, and how high (R,) that leads."""
    design, weights, scaled = problem
    share = np.ones(len(g))
    found = np.full(len(g), -np.inf)
    wanted = np.arange(len(g))
    for _ in range(HALVINGS):
        found[wanted] = _likelihood(g[wanted] + share[wanted, None] * step[wanted], design, weights.rows(wanted), scaled)
        wanted = wanted[~(found[wanted] >= height[wanted] - 1e-10 * (1.0 + np.abs(height[wanted])))]
        if not len(wanted):
            return share, found
        share[wanted] /= 2.0
    share[wanted], found[wanted] = 0.0, height[wanted]
    return share, found


def _likelihood(g: np.ndarray, design: np.ndarray, weights: ReplicateWeights, scaled: bool) -> np.ndarray:
    """(R,) log-likelihoods, -inf where 1 / s is not positive."""
    eta = np.einsum("nq,rq->rn", design, g)
    sums = (weights.above * log_ndtr(eta) + weights.below * log_ndtr(-eta) - 0.5 * weights.exact * eta**2).sum(axis=1)
    if not scaled:
        return np.asarray(sums)
    positive = g[:, -1] > 0
    logs = np.log(np.where(positive, g[:, -1], 1.0))
    return np.where(positive, sums + weights.exact.sum(axis=1) * logs, -np.inf)


def _ratio(eta: np.ndarray) -> np.ndarray:
    """phi(eta) / Phi(eta), the inverse Mills ratio."""
    return np.asarray(np.exp(-0.5 * eta**2 - LOG_ROOT_2_PI - log_ndtr(eta)))
