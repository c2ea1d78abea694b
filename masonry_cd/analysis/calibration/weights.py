# SPDX-License-Identifier: GPL-3.0-or-later
r"""Weights that make a posterior of samples: adaptive importance sampling with the weights of a deterministic mixture.

A sample is z, a standard normal number for each unknown, so that the prior is p(z) = N(0, 1). Round t draws N_t of N samples from q_t,
and the samples of all rounds share the weights

    w_i ~ p(z_i) L(z_i) / sum_t (N_t / N) q_t(z_i),            effective number (sum w)^2 / sum w^2

(Owen & Zhou 2000, applied again after each round by Cornuet, Marin, Mira & Robert, arXiv:0907.1254; Elvira, Martino, Luengo & Bugallo,
arXiv:1607.02758). The first proposal is the prior, in a Latin hypercube; each further one is fitted to the samples that are there,

    q_t = a N(0, 1) + (1 - a) sum_i v_i N(z_i, h^2 C),         h = (4 / ((d + 2) n))^(1 / (d + 4))

with C their covariance, n their effective number, and v the weights with a likelihood L^b: b is the largest up to 1 that leaves n large
enough for C, so that the proposals approach the posterior step by step. The share a of the prior bounds the weights.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp, ndtri

PRIOR_SHARE = 0.1  # a
OF_SAMPLES, OF_UNKNOWNS = 0.1, 5  # n is this share of the samples, or as many for each unknown, where half of the samples are more
BISECTIONS = 50  # of b
DECIMALS = 9  # of z, so that another processor makes the same runs


@dataclass(frozen=True, eq=False)
class Proposal:
    """The prior, and K kernels of one shape where there are any; d unknowns."""

    centres: np.ndarray  # (K, d)
    shares: np.ndarray  # (K,) of the kernels, 1 in all
    factor: np.ndarray  # (d, d) lower triangular, h^2 C = factor factor^T

    @classmethod
    def prior(cls, unknowns: int) -> Proposal:
        """The prior alone."""
        return cls(np.zeros((0, unknowns)), np.zeros(0), np.eye(unknowns))

    def draw(self, count: int, seed: Sequence[int]) -> np.ndarray:
        """Samples (count, d), stratified by a Latin hypercube."""
        from scipy.stats.qmc import LatinHypercube

        u = LatinHypercube(d=self.factor.shape[0] + 1, rng=np.random.default_rng(seed)).random(count)
        z = ndtri(u[:, 1:])
        if len(self.shares):
            kernel = np.searchsorted(PRIOR_SHARE + (1.0 - PRIOR_SHARE) * np.cumsum(self.shares), u[:, 0])
            chosen = (u[:, 0] >= PRIOR_SHARE, np.minimum(kernel, len(self.shares) - 1))
            z = np.where(chosen[0][:, None], self.centres[chosen[1]] + z @ self.factor.T, z)
        return z.round(DECIMALS)

    def log_density(self, z: np.ndarray) -> np.ndarray:
        """The logarithm of its density at samples (N, d), (N,)."""
        prior = log_prior(z)
        if not len(self.shares):
            return prior
        away = np.linalg.solve(self.factor, (z[:, None, :] - self.centres).reshape(-1, z.shape[1]).T)
        kernels = log_prior(away.T).reshape(len(z), -1) - float(np.sum(np.log(np.diag(self.factor))))
        mixed = logsumexp(kernels, axis=1, b=(1.0 - PRIOR_SHARE) * self.shares)
        return np.asarray(np.logaddexp(math.log(PRIOR_SHARE) + prior, mixed))


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


def effective(w: np.ndarray) -> float:
    """The effective number of samples of weights (N,) whose sum is 1; 0 where none is possible."""
    return 1.0 / float(np.sum(w * w)) if w.any() else 0.0


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
    n, away = effective(v), z - v @ z
    size = min(1.0, (4.0 / ((d + 2) * n)) ** (1.0 / (d + 4)))  # a kernel is never wider than the samples
    covariance = (v[:, None] * away).T @ away
    covariance += 1e-12 * np.trace(covariance) * np.eye(d)  # samples of d unknowns may lie in a plane
    return Proposal(z, v, size * np.linalg.cholesky(covariance))


def _tempered(ratio: np.ndarray, likelihood: np.ndarray, unknowns: int) -> np.ndarray:
    """The weights (N,) with the largest power of the likelihood that leaves enough of them."""
    count = len(ratio)
    enough = min(max(OF_SAMPLES * count, OF_UNKNOWNS * unknowns), 0.5 * count)
    full = weights(ratio + likelihood)
    if effective(full) >= enough:
        return full
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if effective(weights(ratio + middle * likelihood)) >= enough else (low, middle)
    return weights(ratio + low * likelihood)
