# SPDX-License-Identifier: GPL-3.0-or-later
r"""Sobol indices of an answer over all unknowns at once: which share of its variance each of them explains.

    S_i = Var(E[y | x_i]) / Var(y)            first order: x_i by itself
    T_i = 1 - Var(E[y | x_~i]) / Var(y)       total: x_i with all that it does together with others

(Sobol, Math. Comput. Simulation 55, 2001; Homma & Saltelli, Reliab. Eng. Syst. Saf. 52, 1996), by the estimators of Saltelli et al.
(Comput. Phys. Comm. 181, 2010), which scipy has. They take thousands of values of y, so these come from a surrogate: a Gaussian process
through the runs, with a Matern kernel of order 5/2, a length for each unknown, and noise (Rasmussen & Williams, Gaussian Processes for
Machine Learning, 2006).

The surrogate is fitted again ten times, each time without a tenth of the runs; its error e is that of the runs left out, over their
standard deviation. Above LARGEST_ERROR it explains less than three quarters of their variance, and there are no indices.

Bands are those of draws from its posterior, what few runs leave open (Le Gratiet, Cannamela & Iooss, SIAM/ASA J. Uncertain. Quantif. 2,
2014), and of what it does not explain: with y = s + r, r independent of s in each of Sobol's terms, Var(r) = e^2 Var(y), an index of y is

    (1 - e^2) S(s) + e^2 S(r),                S(r) from 0 to 1, as it is not known of which unknown r is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from masonry_cd.analysis.fragility.bootstrap import bands

if TYPE_CHECKING:
    from sklearn.gaussian_process import GaussianProcessRegressor

LARGEST_ERROR = 0.5  # of the cross-validation, over the standard deviation of the runs
FOLDS = 10
LEAST = 3  # runs that are data, for each unknown, for a surrogate
SAMPLES, DRAWS, OF_A_DRAW = 4096, 200, 256  # of the indices, of the posterior, of each draw; samples are powers of two
JITTER = 1e-8  # of the variance, on the diagonal of a covariance


class Unknown(NamedTuple):
    """A number that is uniform over a range in the coordinate of its samples, or one of several choices, all as likely."""

    name: str
    span: str  # of its values, as text
    choices: tuple[str, ...] = ()


class Indices(NamedTuple):
    """Indices of an answer by the d unknowns; all nan where they are refused."""

    first: np.ndarray  # (d,)
    total: np.ndarray  # (d,)
    first_band: tuple[np.ndarray, np.ndarray]  # (d,) each, 95 %
    total_band: tuple[np.ndarray, np.ndarray]
    error: float  # of the surrogate on runs left out, over their standard deviation; nan where there is none
    runs: int  # that are data
    refused: str = ""  # why there are none


def features(unknowns: Sequence[Unknown], u: np.ndarray) -> np.ndarray:
    """(N, k) what the surrogate sees of points (N, d) of the unit cube: ranges as they are, of choices whether it is each but the first."""
    columns = []
    for one, coordinate in zip(unknowns, u.T, strict=True):
        which = np.array([chosen(at, len(one.choices)) for at in coordinate])
        columns += [which == j for j in range(1, len(one.choices))] if one.choices else [coordinate]
    return np.column_stack(columns).astype(float)


def chosen(u: float, count: int) -> int:
    """Which of as many choices is at a coordinate from 0 to 1."""
    return min(int(u * count), count - 1)


def indices_of(unknowns: Sequence[Unknown], u: np.ndarray, y: np.ndarray, felt: float = 0.0, seed: int = 0) -> Indices:
    """Sobol indices of an answer.

    Args:
        unknowns: d of them.
        u: (N, d) the runs, points of the unit cube.
        y: (N,) the answer, nan where there is none.
        felt: range of the answer up to which it counts as none.
        seed: of folds, samples and draws.

    Raises:
        InputError: scikit-learn is not installed.
    """
    known = np.isfinite(y)
    count, least = int(known.sum()), LEAST * len(unknowns)
    none = np.full(len(unknowns), np.nan)
    empty = Indices(none, none, (none, none), (none, none), np.nan, count)
    if count < least:
        return empty._replace(refused=f"{count} runs are data, and {least} are wanted")
    if np.ptp(y[known]) <= felt:
        return empty._replace(refused="it hardly moves")
    x, scaled = features(unknowns, u[known]), (y[known] - y[known].mean()) / y[known].std()
    process, error = _fitted(x, scaled, seed)
    if error > LARGEST_ERROR:
        why = f"the surrogate misses runs left out by {100 * error:.0f} % of their spread, and {100 * LARGEST_ERROR:.0f} % is the limit"
        return empty._replace(error=error, refused=why)
    found = _sobol(process.predict(features(unknowns, _pick_freeze(len(unknowns), SAMPLES, seed)))[None], len(unknowns))[:, 0]
    mean, drawn = _drawn(process, features(unknowns, _pick_freeze(len(unknowns), OF_A_DRAW, seed)), seed)
    moved = _sobol(drawn, len(unknowns)) - _sobol(mean[None], len(unknowns))  # on the same samples, so that their own error is in neither
    first_band, total_band = (_of_all(bands(at + by), error) for at, by in zip(found, moved, strict=True))
    return Indices(found[0], found[1], first_band, total_band, error, count)


def _fitted(x: np.ndarray, y: np.ndarray, seed: int) -> tuple[GaussianProcessRegressor, float]:
    """A process through features (N, k) and standardised answers (N,), and its error on runs left out."""
    import warnings

    from masonry_cd.foundation.extras import require

    require("a surrogate", "sklearn")
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel
    from sklearn.model_selection import KFold, cross_val_predict

    kernel = ConstantKernel(1.0, (1e-2, 1e3)) * Matern(np.full(x.shape[1], 0.3), (0.05, 100.0), nu=2.5) + WhiteKernel(1e-2, (1e-6, 1.0))
    process = GaussianProcessRegressor(kernel, random_state=seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # a length at its bound is that of an unknown without effect
        process.fit(x, y)
        left_out = cross_val_predict(process, x, y, cv=KFold(FOLDS, shuffle=True, random_state=seed))
    return process, float(np.sqrt(np.mean((left_out - y) ** 2)))


def _of_all(band: tuple[np.ndarray, np.ndarray], error: float) -> tuple[np.ndarray, np.ndarray]:
    """A band of indices of the answer from one of those of its surrogate."""
    explained = 1.0 - error**2
    return explained * band[0], explained * band[1] + error**2


def _pick_freeze(d: int, count: int, seed: int) -> np.ndarray:
    """((d + 2) count, d) points A, B, and A with each column of B in turn."""
    from scipy.stats.qmc import Sobol

    a, b = np.split(Sobol(2 * d, rng=seed).random(count), 2, axis=1)
    mixed = [np.where(np.arange(d) == i, b, a) for i in range(d)]
    return np.concatenate([a, b, *mixed])


def _drawn(process: GaussianProcessRegressor, x: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """The mean (N,) of the function, without its noise, at features (N, k), and draws of it (DRAWS, N)."""
    from scipy.linalg import cholesky, solve_triangular

    kernel = process.kernel_.k1
    across = kernel(x, process.X_train_)
    half = solve_triangular(process.L_, across.T, lower=True)
    spread = kernel(x) - half.T @ half
    spread[np.diag_indices_from(spread)] += JITTER * kernel.diag(x[:1])[0]
    mean = across @ process.alpha_
    return mean, mean + np.random.default_rng(seed).standard_normal((DRAWS, len(x))) @ cholesky(spread)


def _sobol(values: np.ndarray, d: int) -> np.ndarray:
    """(2, R, d) first and total indices of values (R, (d + 2) n) in the order of :func:`_pick_freeze`."""
    from scipy.stats import sobol_indices

    parts = values.reshape(len(values), d + 2, -1).transpose(1, 0, 2)
    found = sobol_indices(func={"f_A": parts[0], "f_B": parts[1], "f_AB": parts[2:]}, n=parts.shape[2])
    return np.stack([found.first_order, found.total_order]).reshape(2, len(values), d)
