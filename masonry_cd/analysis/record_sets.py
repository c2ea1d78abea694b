# SPDX-License-Identifier: GPL-3.0-or-later
r"""Sets of records whose spectra have a given mean and standard deviation (Jayaram, Lin & Baker, Earthquake Spectra 27(3), 2011).

Of candidate k, d_k(T) = ln Sa_k(T) - ln Sa_target(T) at m periods, to which a factor f adds ln f. A set of n has at each period the sample
mean m(T) and the sample standard deviation s(T) of d + ln f, and the misfit

    E = sum_T m(T)^2  +  w sum_T ( s(T) - sigma(T) )^2,        w = 0 where no sigma is requested.

Simulate    n spectra of the normal distribution of mean 0, deviation sigma and the correlation of Baker & Jayaram (2008), as a Latin
            hypercube; the best of TRIALS such sets, by E. Without sigma all n are the target itself.
Match       each simulated spectrum r takes the free candidate with the least sum_T ( d_k + ln f - r )^2, whose factor is
            ln f = mean_T ( r - d_k ), or the limit next to it.
Improve     one place after the other is given to the candidate, and the factor, that makes E least, until no place changes.

With sigma a place tries FACTORS factors between the limits, as the authors' own program does; without, each candidate has the factor that
brings it to the target. A set that no single replacement improves need not be the best: STARTS sets drawn at random are improved as well,
which takes a fifth off E of pools of some tens.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from loads.signal.spectral_correlation import correlation

WEIGHT = 2.0  # w, that of the authors' program
TRIALS = 20
FACTORS = 41
STARTS = 4
BETTER = 1.0 - 1e-9  # of E: less is rounding


@dataclass(frozen=True, eq=False)
class Pool:
    """k candidates at m periods, and what is wanted of a set of them."""

    periods: np.ndarray  # (m,) [s]
    differences: np.ndarray  # (k, m) d
    sigma: np.ndarray | None  # (m,) of ln Sa; None: the mean alone counts
    limits: tuple[float, float]  # of ln f
    events: np.ndarray  # (k,) number of the event of each
    per_event: int  # records of one event at most

    def free(self, members: np.ndarray) -> np.ndarray:
        """The candidates that may join a set, (k,)."""
        taken = np.bincount(self.events[members], minlength=int(self.events.max()) + 1)
        out = taken[self.events] < self.per_event
        out[members] = False
        return np.asarray(out)

    def fitted(self, spectrum: np.ndarray | float = 0.0) -> np.ndarray:
        """The ln f (k,) within the limits that brings each candidate nearest to a spectrum (m,), given as d."""
        return np.clip((spectrum - self.differences).mean(axis=1), *self.limits)

    def trials(self) -> np.ndarray:
        """The ln f that an improvement tries for each candidate, (trials, k)."""
        own = self.fitted()[None]
        if self.sigma is None or self.limits[0] == self.limits[1]:
            return own
        return np.vstack([own, np.repeat(np.linspace(*self.limits, FACTORS)[:, None], len(self.events), axis=1)])

    def misfit(self, total: np.ndarray, squares: np.ndarray, count: int) -> np.ndarray:
        """E of sets of ``count`` by the sums of d + ln f and of its squares, each (..., m)."""
        mean = total / count
        out = (mean**2).sum(axis=-1)
        if self.sigma is not None:
            variance = np.maximum(squares - count * mean**2, 0.0) / (count - 1)  # below zero by rounding alone
            out = out + WEIGHT * ((np.sqrt(variance) - self.sigma) ** 2).sum(axis=-1)
        return np.asarray(out)


@dataclass(frozen=True, eq=False)
class RecordSet:
    """n members of a pool with their factors."""

    members: np.ndarray  # (n,) places in the pool
    factors: np.ndarray  # (n,) ln f
    misfit: float  # E


def choose(pool: Pool, count: int, seed: int) -> RecordSet:
    """The best set that was found; equal seeds find the same one.

    Args:
        pool: of which ``count`` may be members together.
        count: members, two or more where a standard deviation is requested.
        seed: of the simulation and of the sets drawn.
    """
    random = np.random.default_rng(seed)
    starts = [matched(pool, simulated(pool, count, random))]
    starts += [drawn(pool, count, random) for _ in range(STARTS)]
    return min((improved(pool, start) for start in starts), key=lambda one: one.misfit)


def simulated(pool: Pool, count: int, random: np.random.Generator) -> np.ndarray:
    """Spectra (count, m) of the wanted distribution, as d."""
    m = len(pool.periods)
    if pool.sigma is None:
        return np.zeros((count, m))
    values, vectors = np.linalg.eigh(correlation(pool.periods))
    root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T  # some eigenvalues are below zero by rounding
    best, least = np.zeros((count, m)), math.inf
    for _ in range(TRIALS):
        places = random.permuted(np.tile(np.arange(count), (m, 1)), axis=1).T
        spectra = ndtri((places + random.random((count, m))) / count) @ root * pool.sigma
        misfit = float(pool.misfit(spectra.sum(axis=0), (spectra**2).sum(axis=0), count))
        if misfit < least:
            best, least = spectra, misfit
    return best


def matched(pool: Pool, spectra: np.ndarray) -> RecordSet:
    """A candidate for each spectrum (n, m), the nearest that is free."""
    members, factors = np.zeros(0, dtype=int), np.zeros(0)
    for spectrum in spectra:
        fitted = pool.fitted(spectrum)
        far = ((pool.differences + fitted[:, None] - spectrum) ** 2).sum(axis=1)
        nearest = int(np.where(pool.free(members), far, np.inf).argmin())
        members, factors = np.append(members, nearest), np.append(factors, fitted[nearest])
    return judged(pool, members, factors)


def drawn(pool: Pool, count: int, random: np.random.Generator) -> RecordSet:
    """A set at random, each member with the factor that brings it to the target."""
    members = np.zeros(0, dtype=int)
    for candidate in random.permutation(len(pool.events)):
        if len(members) < count and pool.free(members)[candidate]:
            members = np.append(members, candidate)
    return judged(pool, members, pool.fitted()[members])


def judged(pool: Pool, members: np.ndarray, factors: np.ndarray) -> RecordSet:
    """A set with its misfit."""
    d = pool.differences[members] + factors[:, None]
    return RecordSet(members, factors, float(pool.misfit(d.sum(axis=0), (d**2).sum(axis=0), len(members))))


def improved(pool: Pool, start: RecordSet) -> RecordSet:
    """A set of which no single member can be replaced for a better one."""
    found, trials, before = start, pool.trials(), math.inf
    while found.misfit < before:
        before = found.misfit
        for place in range(len(found.members)):
            other = _replaced(pool, found, place, trials)
            found = other if other.misfit < BETTER * found.misfit else found
    return found


def _replaced(pool: Pool, old: RecordSet, place: int, trials: np.ndarray) -> RecordSet:
    """A set with the best candidate at a place."""
    rest = np.delete(old.members, place)
    d = pool.differences[rest] + np.delete(old.factors, place)[:, None]
    total, squares = d.sum(axis=0), (d**2).sum(axis=0)
    free = np.flatnonzero(pool.free(rest))
    found = np.empty((len(trials), len(free)))
    for row, factors in zip(found, trials, strict=True):
        new = pool.differences[free] + factors[free, None]
        row[:] = pool.misfit(total + new, squares + new**2, len(old.members))
    trial, best = np.unravel_index(found.argmin(), found.shape)
    members, factors = old.members.copy(), old.factors.copy()
    members[place], factors[place] = free[best], trials[trial, free[best]]
    return judged(pool, members, factors)
