# SPDX-License-Identifier: GPL-3.0-or-later
r"""How much of a fragility's scatter comes from the records, and how much from what varies in the model.

With z the numbers that vary from run to run, standardised, the latent variable of a fit gets them as regressors with ln IM:

    counts      P = Phi( a + b ln IM + c . z ),               beta_model = sqrt(c' C c) / b,      beta_record = 1 / b
    clouds      ln EDP = a + b ln IM + c . z + s e,           beta_model = sqrt(c' C c) / b,      beta_record = s / b
    IDA         ln IM_c = a + c . z + s e,                    beta_model = sqrt(c' C c),          beta_record = s

C is the correlation of z. It is the split of the variance into what z explains, linearly in z, and the rest, that from record to record;
the squares of both add up to the square of the total where z does not depend on the record. What z does in curves of a higher order
counts to the records.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.analysis.fragility.censored import ReplicateWeights, maximise, regression
from masonry_cd.analysis.fragility.cloud import Cloud
from masonry_cd.analysis.fragility.ida import Capacities

PER_COEFFICIENT = 10  # runs wanted for each coefficient


class Betas(NamedTuple):
    """The parts of beta, None where the design does not tell them, and why not."""

    record: float | None
    model: float | None
    note: str

    def as_dict(self) -> Mapping[str, Any]:
        """For JSON."""
        return {"beta_record": self.record, "beta_model": self.model, "note": self.note}


def standardised(columns: Sequence[np.ndarray]) -> np.ndarray:
    """(N, k) columns of zero mean and unit variance."""
    if not columns:
        return np.zeros((0, 0))
    z = np.column_stack(columns)
    return np.asarray((z - z.mean(axis=0)) / np.maximum(z.std(axis=0), 1e-300))


def without_model(beta: float, records: bool, text_varied: bool) -> Betas:
    """Where no number of the model varies."""
    note = "what varies is not a number: its share cannot be separated" if text_varied else "nothing but the records varies"
    if not records:
        return Betas(None, None, "no records: beta is of what varies alone" if not text_varied else note)
    return Betas(beta if not text_varied else None, None, note)


def of_counts(logs: np.ndarray, exceeded: np.ndarray, z: np.ndarray) -> Betas:
    """From runs (N,): ln IM, whether the limit state was exceeded, and what varied (N, k)."""
    if _are_few(len(logs), z):
        return _too_few(len(logs))
    design = np.column_stack([np.ones(len(logs)), logs - logs.mean(), z])
    one = exceeded[None].astype(float)
    found = maximise(design, ReplicateWeights(np.zeros_like(one), one, 1.0 - one), np.zeros((1, design.shape[1])), scaled=False)[0]
    return _parts(found[2:], z, found[1], 1.0)


def of_cloud(cloud: Cloud, z: np.ndarray) -> Betas:
    """From a cloud of N runs and what varied (N, k)."""
    if _are_few(int(cloud.exact.sum()), z):
        return _too_few(int(cloud.exact.sum()))
    x = np.column_stack([np.ones(len(z)), cloud.measure, z])
    kinds = ReplicateWeights(*(rows[None].astype(float) for rows in (cloud.exact, cloud.above, cloud.below)))
    c, scatter = regression(x, cloud.demand, kinds)
    return _parts(c[0, 2:], z, c[0, 1], float(scatter[0]))


def of_capacities(found: Capacities, z: np.ndarray) -> Betas:
    """From C capacities and what varied (C, k)."""
    exact = ~(found.above | found.below)
    if _are_few(int(exact.sum()), z):
        return _too_few(int(exact.sum()))
    x = np.column_stack([np.ones(len(z)), z])
    kinds = ReplicateWeights(*(rows[None].astype(float) for rows in (exact, found.above, found.below)))
    c, scatter = regression(x, np.log(found.intensity), kinds)
    return _parts(c[0, 1:], z, 1.0, float(scatter[0]))


def _are_few(runs: int, z: np.ndarray) -> bool:
    return runs < PER_COEFFICIENT * (2 + z.shape[1])


def _too_few(runs: int) -> Betas:
    return Betas(None, None, f"{runs} runs are too few to tell the records' share from the model's")


def _parts(c: np.ndarray, z: np.ndarray, slope: float, scatter: float) -> Betas:
    """Both parts from the coefficients of what varied, the slope over ln IM and the scatter that is left."""
    if not np.isfinite([*c, slope, scatter]).all() or slope <= 1e-6:
        return Betas(None, None, "the regression over what varied has no solution")
    model = float(np.sqrt(max(0.0, float(np.var(z @ c))))) / slope
    return Betas(float(scatter / slope), model, "what varies explains its part linearly; the rest is from record to record")
