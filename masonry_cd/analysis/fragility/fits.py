# SPDX-License-Identifier: GPL-3.0-or-later
"""The fits of a study: which method its design allows, for each limit state, with bands, betas and the warnings that belong to them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from masonry_cd.analysis.fragility import betas, fragility
from masonry_cd.analysis.fragility.betas import Betas
from masonry_cd.analysis.fragility.bootstrap import FEW, band, replicates
from masonry_cd.analysis.fragility.cloud import Cloud, CloudBend, Line, bend_of, cloud_of, fit_line, least_demand
from masonry_cd.analysis.fragility.folder import StudyResults
from masonry_cd.analysis.fragility.fragility import Lognormal, by_level, fit_counts
from masonry_cd.analysis.fragility.ida import Capacities, IdaCurve, capacities, capacity_quantiles, curves_of, fit_capacities
from masonry_cd.analysis.fragility.limits import LimitState
from masonry_cd.analysis.fragility.measures import with_unit

NEAR = 0.02  # a level is the run's own intensity where the two differ by less than this
SAME = 1e-6
ORDER = ("mle", "ida", "cloud", "probit")  # the first of these methods that a limit state has speaks for it
FEW_EVENTS = 5  # runs that exceed, or that do not


@dataclass(frozen=True, eq=False)
class Fit:
    """A lognormal fragility of a limit state by a method.

    Attributes:
        limit: the limit state.
        measure: the intensity measure.
        method: mle, probit, cloud or ida.
        curve: the fit, one row.
        replicated: of the bootstrap, R rows.
        runs: that entered it; of IDA its curves, one per record.
        exceeded: of these, how many exceeded the limit state.
        betas: the parts of beta.
        intensity: (N,) of the runs that entered.
        over: (N,) bool.
        found: of IDA.
    """

    limit: LimitState
    measure: str
    method: str
    curve: Lognormal
    replicated: Lognormal
    runs: int
    exceeded: int
    betas: Betas
    intensity: np.ndarray
    over: np.ndarray
    found: Capacities | None = None

    @property
    def theta(self) -> float:
        """Median, nan where there is none."""
        return float(self.curve.theta[0]) if self.is_fitted else np.nan

    @property
    def beta(self) -> float:
        """Standard deviation of the logarithm, nan where there is none."""
        return float(self.curve.beta[0]) if self.is_fitted else np.nan

    @property
    def is_fitted(self) -> bool:
        """Return True if the data carry the fit."""
        return bool(self.curve.state[0] == fragility.FITTED and np.isfinite(self.curve.theta[0]) and np.isfinite(self.curve.beta[0]))

    @property
    def theta_band(self) -> tuple[float, float]:
        """95 % band of the median."""
        return band(self.replicated.theta) if self.is_fitted else (np.nan, np.nan)

    @property
    def beta_band(self) -> tuple[float, float]:
        """95 % band of beta."""
        return band(self.replicated.beta) if self.is_fitted else (np.nan, np.nan)

    @property
    def quantiles(self) -> list[float]:
        """The 16, 50 and 84 % quantiles of IDA's capacities."""
        return capacity_quantiles(self.found) if self.found is not None else []


class CloudFit(NamedTuple):
    """A regression of a quantity, for its picture."""

    column: str
    measure: str
    cloud: Cloud
    line: Line
    replicated: Line
    limits: tuple[LimitState, ...]
    bend: CloudBend | None  # where one line does not do


@dataclass(frozen=True, eq=False)
class Fits:
    """All fits of a study, what its pictures need, and warnings."""

    fits: tuple[Fit, ...] = ()
    clouds: tuple[CloudFit, ...] = ()
    curves: tuple[IdaCurve, ...] = ()
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Sample:
    """Runs that enter the fits of a method."""

    study: StudyResults
    rows: np.ndarray  # (N,) of the table
    intensity: np.ndarray  # (N,)
    weights: np.ndarray  # (R, N) of the bootstrap

    @classmethod
    def of(cls, study: StudyResults, rows: np.ndarray, intensity: np.ndarray) -> Sample:
        """Runs ``rows`` (N,) with intensities (N,), and their bootstrap."""
        own = np.unique(study.clusters[rows], return_inverse=True)[1].reshape(-1)
        return cls(study, rows, intensity, replicates(own, study.asked.seed))

    def values(self, limit: LimitState) -> np.ndarray:
        """(N,) the quantity of a limit state."""
        return self.study.numbers(limit.column)[self.rows]

    def over(self, limit: LimitState) -> np.ndarray:
        """(N,) bool: exceeded; where blocks fell and the quantity has no value, it is."""
        values = self.values(limit)
        return limit.exceeded(values) | (np.isnan(values) & self.study.collapsed[self.rows])

    def known(self, limit: LimitState) -> Sample:
        """The runs of which it is known whether they exceed a limit state."""
        keep = np.isfinite(self.values(limit)) | self.study.collapsed[self.rows]
        return self if keep.all() else replace(self, rows=self.rows[keep], intensity=self.intensity[keep], weights=self.weights[:, keep])

    def z(self, rows: np.ndarray | None = None) -> np.ndarray | None:
        """(N, k) what varied, standardised; None where a number is missing."""
        rows = self.rows if rows is None else rows
        columns = [self.study.numbers(name)[rows] for name in self.study.spread(self.study.varied)]
        return betas.standardised(columns) if all(np.isfinite(column).all() for column in columns) else None


def fit_study(study: StudyResults) -> Fits:
    """All fits that the design of a study and its data allow."""
    measure = study.asked.measure
    if measure is None or not study.limit_states or not study.done.any():
        return Fits()
    own, level = study.numbers(measure), study.numbers("level")
    if study.asked.design == "ida":
        return _ida(study, measure, np.where(np.isfinite(own), own, level))
    fits: list[Fit] = []
    clouds: tuple[CloudFit, ...] = ()
    known = study.done & np.isfinite(level) & (level > 0)
    measured = study.done & np.isfinite(own) & (own > 0)
    near = known.any() and bool((np.abs(own - level)[known & measured] <= NEAR * level[known & measured]).all())
    if near:
        sample = Sample.of(study, np.flatnonzero(known), level[known])
        fits += [_counted(sample.known(limit), limit, measure, "mle") for limit in study.limit_states]
    both = known & measured
    if measured.any() and (not near or (np.abs(own - level)[both] > SAME * level[both]).any()):
        sample = Sample.of(study, np.flatnonzero(measured), own[measured])
        fits += [_counted(sample.known(limit), limit, measure, "probit") for limit in study.limit_states]
        if not near:
            more, clouds = _clouds(sample, measure)
            fits += more
    bent = [_bent(cloud, cloud.bend) for cloud in clouds if cloud.bend is not None]
    return Fits(tuple(fits), clouds, (), (*(line for fit in fits for line in _warnings(fit)), *bent))


def _counted(sample: Sample, limit: LimitState, measure: str, method: str) -> Fit:
    """Fit by counts, at levels or run by run."""
    over, logs = sample.over(limit), np.log(sample.intensity)
    levels, exceeded, runs = by_level(sample.intensity, over, np.ones((1, len(over))))
    curve = fit_counts(levels, exceeded, runs)
    replicated = fit_counts(*by_level(sample.intensity, over, sample.weights))
    parts = _betas(sample.study, sample.z(), curve, lambda z: betas.of_counts(logs, over, z))
    return Fit(limit, measure, method, curve, replicated, len(over), int(over.sum()), parts, sample.intensity, over)


def _clouds(sample: Sample, measure: str) -> tuple[list[Fit], tuple[CloudFit, ...]]:
    """Fit by regressions, one per quantity and least demand."""
    fits, clouds = [], []
    continuous = [limit for limit in sample.study.limit_states if limit.is_continuous]
    for column, least in dict.fromkeys((limit.column, limit.least) for limit in continuous):
        limits = tuple(limit for limit in continuous if (limit.column, limit.least) == (column, least))
        here = sample.known(limits[0])
        cloud = cloud_of(here.intensity, here.values(limits[0]), here.study.collapsed[here.rows], [limit.bound for limit in limits], least)
        line, replicated = fit_line(cloud, np.ones((1, len(here.rows)))), fit_line(cloud, here.weights)
        clouds.append(CloudFit(column, measure, cloud, line, replicated, limits, bend_of(cloud)))
        for limit in limits:
            curve, over = line.fragility(limit.bound), here.over(limit)
            parts = _betas(here.study, here.z(), curve, lambda z, cloud=cloud: betas.of_cloud(cloud, z))
            more = (curve, replicated.fragility(limit.bound), len(over), int(over.sum()), parts, here.intensity, over)
            fits.append(Fit(limit, measure, "cloud", *more))
    return fits, tuple(clouds)


def _ida(study: StudyResults, measure: str, intensity: np.ndarray) -> Fits:
    """Fit by the capacities of records."""
    rows = np.flatnonzero(study.done & np.isfinite(intensity) & (intensity > 0))
    if not len(rows):
        return Fits()
    varied = [study.text(name) for name in study.varied]
    keys = [
        (int(study.clusters[k]) if study.motion[k] < 0 and not varied else study.text("motion")[k], *(v[k] for v in varied)) for k in rows
    ]
    fits, every, whole = [], tuple(curves_of(rows, keys, intensity[rows])), Sample.of(study, rows, intensity[rows])
    for limit in study.limit_states:
        values = study.numbers(limit.column)
        sample = whole.known(limit)
        kept = np.isin(rows, sample.rows).tolist()
        curves = curves_of(sample.rows, [key for key, there in zip(keys, kept, strict=True) if there], sample.intensity)
        found = capacities(curves, limit, np.where(study.collapsed & np.isnan(values), np.inf, values), study.collapsed)
        first = np.array([curve.rows[0] for curve in curves])
        own = Sample.of(study, first, found.intensity)
        curve = fit_capacities(found, np.ones((1, len(curves))))
        replicated = fit_capacities(found, own.weights)
        parts = _betas(study, sample.z(first), curve, lambda z, found=found: betas.of_capacities(found, z))
        reached = int((~found.above).sum())
        fits.append(Fit(limit, measure, "ida", curve, replicated, len(curves), reached, parts, found.intensity, ~found.above, found))
    return Fits(tuple(fits), (), every, tuple(line for fit in fits for line in _warnings(fit)))


def _betas(study: StudyResults, z: np.ndarray | None, curve: Lognormal, split: object) -> Betas:
    """The parts of beta, by a function of what varied."""
    assert callable(split)
    if curve.state[0] != fragility.FITTED:
        return Betas(None, None, "no fit")
    if z is None:
        return Betas(None, None, "some runs lack a number of what varies")
    if z.shape[1] == 0:
        return betas.without_model(float(curve.beta[0]), bool(study.motions), any(len(set(study.text(name))) > 1 for name in study.varied))
    found: Betas = split(z)
    if not study.motions and found.model is not None:
        return Betas(None, found.model, "no records: what is left is scatter that no number explains")
    return found


# --- warnings -------------------------------------------------------------------------------------------------------------------


def _warnings(fit: Fit) -> list[str]:
    """List what the data cannot carry."""
    who, out = f"{fit.limit.name} ({fit.method})", []
    state = str(fit.curve.state[0])
    unit = "records" if fit.method == "ida" else "runs"
    if not fit.runs:
        return [f"{who}: no run says anything of it"]
    least, top = (with_unit(float(value), fit.measure) for value in (fit.intensity.min(), fit.intensity.max()))
    if state == fragility.NONE:
        return [f"{who}: none of {fit.runs} {unit} exceeded it, up to {fit.measure} {top}: no fragility; go higher"]
    if state == fragility.ALL:
        return [f"{who}: all {fit.runs} {unit} exceeded it, from {fit.measure} {least} on: no fragility; go lower"]
    if state == fragility.SEPARATED:
        return [f"{who}: {_between(fit)}: beta cannot be fitted; put levels in between"]
    if not fit.is_fitted:
        return [f"{who}: it is exceeded no more often as {fit.measure} grows: no fragility; another measure may order the runs better"]
    if fit.method == "mle":
        _, exceeded, runs = by_level(fit.intensity, fit.over, np.ones((1, len(fit.over))))
        if fragility.falls(exceeded[0], runs[0]):
            out.append(f"{who}: the share of runs that exceed it falls from one level to a higher one by more than chance explains")
    rare = min(fit.exceeded, fit.runs - fit.exceeded) if fit.method != "ida" else fit.runs
    if rare < FEW_EVENTS:
        which = "exceeded it" if fit.exceeded == rare else "stayed below it"
        out.append(f"{who}: only {rare} of {fit.runs} {unit} {which}: the fit hangs on them")
    if fit.theta > float(fit.intensity.max()):
        out.append(f"{who}: the median, {with_unit(fit.theta, fit.measure)}, lies beyond the strongest run, {top}")
    lost = float(np.mean(~np.isfinite(fit.replicated.beta)))
    if lost > FEW:
        out.append(f"{who}: {100 * lost:.0f} % of the bootstrap's samples could not be fitted: the bands are rough")
    return out


def _bent(fit: CloudFit, bend: CloudBend) -> str:
    """That one line is put through a cloud with two slopes."""
    names, at = ", ".join(limit.name for limit in fit.limits), f"{fit.measure} {with_unit(bend.measure, fit.measure)}"
    slopes = f"of slope {bend.below:.2g} below {at} and {bend.above:.2g} above"
    first = min(fit.limits, key=lambda limit: limit.bound)
    least = least_demand(fit.cloud, first.bound)
    remedy = f"least_demand = {least:.2g} in limit_states.{first.name} has it hold from there on" if least else "fit them by stripes"
    return f"{names} (cloud): the runs bend, {slopes}, so that theta and beta of one line are wrong: {remedy}"


def _between(fit: Fit) -> str:
    """Where data that separate change."""
    if fit.method == "ida":
        return "fewer than two records reached it within their runs"
    low, high = (with_unit(float(value), fit.measure) for value in (fit.intensity[~fit.over].max(), fit.intensity[fit.over].min()))
    if low == high:
        return f"only at {fit.measure} {high} do some runs exceed it and others not"
    return f"all runs up to {fit.measure} {low} stay below it, all from {high} on exceed it"
