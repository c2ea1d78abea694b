# SPDX-License-Identifier: GPL-3.0-or-later
r"""Weights that make a posterior of samples: adaptive importance sampling with the weights of a deterministic mixture.

A sample is z, a standard normal number for each unknown, so that the prior is p(z) = N(0, 1). Round t draws N_t of N samples from q_t,
and the samples of all rounds share the weights

    w_i ~ p(z_i) L(z_i) / sum_t (N_t / N) q_t(z_i),            effective number (sum w)^2 / sum w^2

(Owen & Zhou 2000, applied again after each round by Cornuet, Marin, Mira & Robert, arXiv:0907.1254; Elvira, Martino, Luengo & Bugallo,
arXiv:1607.02758). The first proposal is the prior, in a Latin hypercube; each further one is fitted to the samples that are there,

    q_t = a N(0, 1) + (1 - a) t_nu(m, C)

with m and C their mean and covariance by weights with a likelihood L^b: b is the largest up to 1 that leaves an effective number n large
enough for C, so that the proposals approach the posterior step by step. The share a of the prior bounds the weights. Kernels on the single
samples, instead of one Student t, would be densest at those samples themselves, take weight from outer ones and so narrow the posterior
(by 6 % of the standard deviation of an unknown that nothing is observed of, with 300 samples of 4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincinv, gammaln, logsumexp, ndtri

from masonry_cd.analysis.distributions import effective

PRIOR_SHARE = 0.1  # a
FREEDOM = 5.0  # degrees of it, nu: its tails are heavier than those of a normal posterior
OF_UNKNOWNS = 5  # n for each unknown, half of the samples at most; a share of all samples would slow the approach as they grow in number
BISECTIONS = 50  # of b
DECIMALS = 9  # of z, so that another processor makes the same runs


@dataclass(frozen=True, eq=False)
class Proposal:
    """The prior, with a Student t about the samples where there is one; d unknowns."""

    centre: np.ndarray  # (d,)
    factor: np.ndarray | None = None  # (d, d) lower triangular, C = factor factor^T; None: the prior alone

    @classmethod
    def prior(cls, unknowns: int) -> Proposal:
        """The prior alone."""
        return cls(np.zeros(unknowns))

    def draw(self, count: int, seed: Sequence[int]) -> np.ndarray:
        """Samples (count, d), stratified by a Latin hypercube."""
        from scipy.stats.qmc import LatinHypercube

        u = LatinHypercube(d=len(self.centre) + 2, rng=np.random.default_rng(seed)).random(count)
        z = ndtri(u[:, 2:])
        if self.factor is not None:
            stretch = np.sqrt(0.5 * FREEDOM / gammaincinv(0.5 * FREEDOM, u[:, 1]))
            z = np.where(u[:, :1] < PRIOR_SHARE, z, self.centre + stretch[:, None] * (z @ self.factor.T))
        return z.round(DECIMALS)

    def log_density(self, z: np.ndarray) -> np.ndarray:
        """The logarithm of its density at samples (N, d), (N,)."""
        prior, d = log_prior(z), len(self.centre)
        if self.factor is None:
            return prior
        away = np.linalg.solve(self.factor, (z - self.centre).T)
        half = 0.5 * (FREEDOM + d)
        scale = gammaln(half) - gammaln(0.5 * FREEDOM) - 0.5 * d * math.log(FREEDOM * math.pi) - np.sum(np.log(np.diag(self.factor)))
        about = scale - half * np.log1p(np.sum(away * away, axis=0) / FREEDOM)
        return np.asarray(np.logaddexp(math.log(PRIOR_SHARE) + prior, math.log1p(-PRIOR_SHARE) + about))


def log_prior(z: np.ndarray) -> np.ndarray:
    """The logarithm of the standard normal density at samples (N, d), (N,)."""
    return np.asarray(-0.5 * np.sum(z * z, axis=1) - 0.5 * z.shape[1] * math.log(2.0 * math.pi))


def log_ratio(z: np.ndarray, proposals: Sequence[Proposal], counts: Sequence[int]) -> np.ndarray:
    """The logarithm of the prior over the mixture of the proposals, of which samples (N, d) were drawn in such numbers, (N,)."""
    shares = np.array(counts, dtype=float) / len(z)
    mixture = logsumexp([one.log_density(z) for one in proposals], axis=0, b=shares[:, None])
    return np.asarray(log_prior(z) - mixture)


def weights(log: np.ndarray) -> np.ndarray:
    """Weights (N,) whose sum is 1 from their logarithms; all are 0 where no sample is possible."""
    top = log.max(initial=-np.inf)
    if not np.isfinite(top):
        return np.zeros(len(log))
    found = np.exp(log - top)
    return np.asarray(found / found.sum())


def next_proposal(z: np.ndarray, ratio: np.ndarray, likelihood: np.ndarray) -> Proposal:
    """The proposal of the next round.

    Args:
        z: samples so far (N, d).
        ratio: logarithm of the prior over the mixture (N,).
        likelihood: its logarithm (N,); -inf where a sample is impossible.
    """
    d = z.shape[1]
    possible = np.isfinite(likelihood)
    if possible.sum() <= d:
        return Proposal.prior(d)
    z, v = z[possible], _tempered(ratio[possible], likelihood[possible], d)
    centre = v @ z
    away = z - centre
    covariance = (v[:, None] * away).T @ away
    covariance += 1e-12 * np.trace(covariance) * np.eye(d)  # samples of d unknowns may lie in a plane
    return Proposal(centre, np.linalg.cholesky(covariance))


def _tempered(ratio: np.ndarray, likelihood: np.ndarray, unknowns: int) -> np.ndarray:
    """The weights (N,) with the largest power of the likelihood that leaves enough of them."""
    enough = min(OF_UNKNOWNS * unknowns, 0.5 * len(ratio))
    full = weights(ratio + likelihood)
    if effective(full) >= enough:
        return full
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if effective(weights(ratio + middle * likelihood)) >= enough else (low, middle)
    return weights(ratio + low * likelihood)
