# SPDX-License-Identifier: GPL-3.0-or-later
r"""The likelihood of a motion over two of its numbers, as PGA and period, of weighted samples.

    L(x) = sum_i K(x - x_i) w_i / sum_i K(x - x_i) v_i

is the mean of the likelihood over all other unknowns, given what was thought possible of them before: w_i weighs a sample in the posterior,
v_i in the prior, and K is a normal kernel with the covariance of the posterior, times n^(-1/3) of its n effective samples (Scott,
Multivariate Density Estimation, 1992, in two dimensions). Within a region of 90 % lies this share of the posterior, at its highest
densities.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.distributions import effective

POINTS = 81  # of the grid, each way
SHARES = (0.5, 0.9)  # of the posterior, within the lines
LEAST = 1e-3  # of the largest density of samples, below which nothing is known
LEAST_WIDTH = 0.01  # of a kernel, of the range of the samples
AT_ONCE = 200  # samples whose kernels are held at a time, 10 MB


@dataclass(frozen=True, eq=False)
class MotionMap:
    """The likelihood over a grid of two unknowns."""

    names: tuple[str, str]  # across and up
    across: np.ndarray  # (G,)
    up: np.ndarray  # (G,)
    likelihood: np.ndarray  # (G, G) over its largest value, up first; nan where there are no samples
    density: np.ndarray  # (G, G) of the posterior, of whatever scale
    levels: tuple[float, ...]  # densities at the ends of the regions of SHARES

    @property
    def likeliest(self) -> dict[str, float]:
        """The point of the largest likelihood within the narrower region, where there are samples enough to tell."""
        inside = np.where(self.density >= max(self.levels), np.nan_to_num(self.likelihood), -1.0)
        row, column = np.unravel_index(int(inside.argmax()), inside.shape)
        return {self.names[0]: float(self.across[column]), self.names[1]: float(self.up[row])}


def motion_map(names: tuple[str, str], values: np.ndarray, posterior: np.ndarray, prior: np.ndarray) -> MotionMap:
    """The map of two unknowns.

    Args:
        names: of both, the one across first.
        values: theirs (2, N).
        posterior: weights (N,) whose sum is 1.
        prior: likewise.
    """
    across, up = (np.linspace(row.min(), row.max(), POINTS) for row in values)
    density, before = _densities(across, up, values, np.array([posterior, prior]))
    with np.errstate(divide="ignore", invalid="ignore"):
        likelihood = np.where(before > LEAST * before.max(), density / before, np.nan)
    ordered = np.sort(density, axis=None)[::-1]
    levels = tuple(float(ordered[int(np.searchsorted(np.cumsum(ordered), share * ordered.sum()))]) for share in SHARES)
    return MotionMap(names, across, up, likelihood / np.nanmax(likelihood), density, levels)


def _densities(across: np.ndarray, up: np.ndarray, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Sums (K, G, G), up first, of normal kernels about values (2, N) with K weights each (K, N), the first of which make their width."""
    w = weights[0]
    away = values - np.sum(w * values, axis=1, keepdims=True)
    least = np.diag((LEAST_WIDTH * np.ptp(values, axis=1)) ** 2)
    factor = np.linalg.cholesky((w * away) @ away.T + least) * effective(w) ** (-1.0 / 6.0)
    x, y = (np.linalg.solve(factor, of) for of in (np.stack(np.meshgrid(across, up)).reshape(2, -1), values))
    found = np.zeros((len(weights), x.shape[1]))
    for begin in range(0, len(w), AT_ONCE):
        some = slice(begin, begin + AT_ONCE)
        kernels = np.exp(-0.5 * ((x[0][:, None] - y[0, some]) ** 2 + (x[1][:, None] - y[1, some]) ** 2))
        found += np.stack([np.sum(kernels * one[some], axis=1) for one in weights])
    return found.reshape(-1, len(up), len(across))
