# SPDX-License-Identifier: GPL-3.0-or-later
r"""A posterior: samples of the unknowns with their weights, and what follows from them.

The model is checked by the posterior predictive probability of a misfit as large as the one found: of sum (y_j - f_j)^2 / s_j^2 over the
J observations with a normal or lognormal error, which for given unknowns is chi-squared with J degrees of freedom (Gelman, Meng & Stern,
Stat. Sinica 6, 1996):

    p = sum_i w_i P(chi^2_J >= misfit_i)

The largest distance D of the distribution functions of an unknown before and after says whether anything was learnt of it: nothing where D
is below 0.1, or where it is as large by chance with a probability of 0.05 or more, by Kolmogorov's distribution. As both weigh the same
samples, by v_i and w_i, 1 / sum (w_i - v_i)^2 stands for their effective number.

An observation j, made once more or for the first time, would take the share r_jk^2 V_j / (V_j + s_j^2) of the variance of unknown k, if all
were linear: r_jk is the correlation of unknown and prediction over the posterior, V_j the variance of the prediction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from masonry_cd.analysis.calibration.motion_map import MotionMap, motion_map
from masonry_cd.analysis.calibration.observations import SEEN, Observation
from masonry_cd.analysis.distributions import by_chance, distance, quantiles
from masonry_cd.analysis.verdict import DOUBTFUL, GOOD, LOOK, Verdict
from masonry_cd.foundation.quantities import counted

PREFIXES = (("G", 1e-9), ("M", 1e-6))  # in which large numbers with a unit are read
UNLIKELY = 0.05  # probability of a misfit below which the model does not explain what was observed
LEARNT = 0.1  # distance of an unknown's distributions below which nothing was learnt of it
FAR = 3.0  # standard deviations of an observation that is named


@dataclass(frozen=True, eq=False)
class Posterior:
    """N samples of D unknowns, and what is predicted for M observations."""

    title: str
    scene: str  # name of its file
    program: str  # version
    unknowns: Mapping[str, Sequence[Any]]  # by key of the scene, N values of each
    units: Mapping[str, str]  # of keys that have one
    rounds: np.ndarray  # (N,) int: from 1
    sizes: tuple[float, ...]  # effective number of samples after each round
    enough: float  # effective number below which there is no answer
    weights: np.ndarray  # (N,) of the posterior
    prior: np.ndarray  # (N,) of the prior, over the same samples
    observations: tuple[Observation, ...]
    predicted: np.ndarray  # (N, M), nan where there is none
    lost: int = 0  # samples whose run has no result
    motion: tuple[str, str] | None = None  # unknowns across and up the map of the motion

    @property
    def refused(self) -> str:
        """The reason why it is not an answer; empty where it is one."""
        if self.sizes[-1] >= self.enough:
            return ""
        if not self.weights.any():
            return "no sample is possible under what was observed"
        return f"{self.sizes[-1]:.3g} effective samples of {len(self.weights)}, and calibration.least asks for {self.enough:g}"

    @cached_property
    def ranges(self) -> dict[str, dict[str, float]]:
        """The range of 5, 50 and 95 % of each unknown that is a number, its mean and standard deviation, and its range before."""
        return {name: self._range(values) for name, values in self.numbers.items()}

    @cached_property
    def unlearnt(self) -> list[str]:
        """The unknowns of which the observations say nothing; those that are no numbers, as the motion, in the order of their values."""
        ranks = {name: np.unique([str(v) for v in values], return_inverse=True)[1] for name, values in self.unknowns.items()}
        every = {name: self.numbers.get(name, rank) for name, rank in ranks.items()}
        apart = {name: distance(values, self.weights, values, self.prior) for name, values in every.items()}
        twice = 2.0 / max(float(np.sum((self.weights - self.prior) ** 2)), 1e-300)
        return [name for name, of in apart.items() if of < LEARNT or by_chance(of, twice, twice) >= UNLIKELY]

    @cached_property
    def map(self) -> MotionMap | None:
        """The likelihood over two numbers of the motion; None where the motion is known, or one of them does not vary."""
        if self.motion is None or not self.weights.any():
            return None
        values = np.array([self.numbers[name] for name in self.motion])
        return motion_map(self.motion, values, self.weights, self.prior) if np.ptp(values, axis=1).all() else None

    @cached_property
    def numbers(self) -> dict[str, np.ndarray]:
        """The unknowns that are numbers, (N,) each."""
        every = {name: values for name, values in self.unknowns.items() if all(isinstance(v, (int, float)) for v in values)}
        return {name: np.array(values, dtype=float) for name, values in every.items()}

    def shown(self, name: str) -> tuple[str, float]:
        """The unit in which people read an unknown, and the factor into it: ``("GPa", 1e-9)``."""
        unit, largest = self.units.get(name, ""), float(np.abs(self.numbers[name]).max())
        prefix, factor = next(((word, factor) for word, factor in PREFIXES if unit and largest * factor >= 1.0), ("", 1.0))
        return f"{prefix}{unit}", factor

    @cached_property
    def shares(self) -> dict[str, dict[str, float]]:
        """The probabilities of the values of each other unknown, as the motion, the likeliest first."""
        found = {}
        for name in (name for name in self.unknowns if name not in self.numbers):
            of = [str(value) for value in self.unknowns[name]]
            sums = {value: float(self.weights[[one == value for one in of]].sum()) for value in dict.fromkeys(of)}
            found[name] = dict(sorted(sums.items(), key=lambda item: -item[1]))
        return found

    @cached_property
    def correlation(self) -> np.ndarray:
        """Correlation of the unknowns that are numbers, (D, D)."""
        return correlation(np.array([*self.numbers.values()]), self.weights)

    @cached_property
    def checks(self) -> list[dict[str, Any]]:
        """The value and error of each observation, what is predicted before and after, how far off that is, and how much it would help."""
        return [self._check(one, self.predicted[:, j]) for j, one in enumerate(self.observations)]

    @cached_property
    def misfit(self) -> float | None:
        """The probability p; None where no observation has a normal or lognormal error."""
        from scipy.stats import chi2

        measured = [j for j, one in enumerate(self.observations) if one.known and one.what not in SEEN]
        if not measured or not self.weights.any():
            return None
        there = self.weights > 0.0
        off = np.array([self.observations[j].off(self.predicted[there, j]) for j in measured])
        return float(np.sum(self.weights[there] * chi2.sf(np.sum(off**2, axis=0), len(measured))))

    def _range(self, values: np.ndarray) -> dict[str, float]:
        found = dict(zip(("low", "median", "high"), quantiles(values, self.weights), strict=True))
        mean = float(np.sum(self.weights * values))
        found |= {"mean": mean, "std": float(np.sqrt(np.sum(self.weights * (values - mean) ** 2)))}
        return found | dict(zip(("prior_low", "prior_median", "prior_high"), quantiles(values, self.prior), strict=True))

    def _check(self, one: Observation, predicted: np.ndarray) -> dict[str, Any]:
        there = np.isfinite(predicted)
        after, before = (weights[there] / max(weights[there].sum(), 1e-300) for weights in (self.weights, self.prior))
        values = predicted[there]
        mean = float(np.sum(after * values))
        variance = float(np.sum(after * (values - mean) ** 2))
        s = self._in_its_unit(one, mean)
        found: dict[str, Any] = {"name": one.title, "what": one.what, "value": one.value, "error": s}
        found |= dict(zip(("low", "median", "high"), quantiles(values, after), strict=True))
        found |= dict(zip(("prior_low", "prior_median", "prior_high"), quantiles(values, before), strict=True))
        measured = one.known and one.what not in SEEN
        found["off"] = (float(one.value or 0.0) - mean) / float(np.sqrt(s * s + variance)) if measured else None
        table = np.array([values, *(numbers[there] for numbers in self.numbers.values())])
        gained = correlation(table, after)[0, 1:] ** 2 * variance / (s * s + variance) if len(table) > 1 else np.zeros(0)
        return found | {"gain": float(gained.mean()) if len(gained) else None}

    @staticmethod
    def _in_its_unit(one: Observation, mean: float) -> float:
        """The standard deviation of an observation as its value has it; of what is seen, that of a right answer."""
        s = one.deviation(mean)
        if one.what in SEEN:
            return float(np.sqrt(len(one.blocks or (0,)) * s * (1.0 - s)))
        return s * abs(mean if one.value is None else float(one.value)) if one.spread == "lognormal" else s

    @property
    def verdict(self) -> Verdict:
        """The verdict on the whole."""
        if self.refused:
            return Verdict("", "", "", DOUBTFUL, "refused", self.refused)
        fit = "" if self.misfit is None else f"a misfit as large as this has the probability {self.misfit:.2g}"
        if self.misfit is not None and self.misfit < UNLIKELY:
            return Verdict("", "", "", DOUBTFUL, "the model does not explain what was observed", "; ".join([fit, *self._far()]))
        if len(self.unlearnt) == len(self.unknowns):
            return Verdict("", "", "", LOOK, "the observations do not tell", "every unknown is as uncertain as before")
        if warned := self.warnings:
            return Verdict("", "", "", LOOK, "check these points before you rely on it", "; ".join(warned))
        return Verdict("", "", "", GOOD, f"the model explains what was observed{f' ({fit})' if fit else ''}", "")

    def _far(self) -> list[str]:
        """The observations that are farthest from what is predicted."""
        far = [one for one in self.checks if one["off"] is not None and abs(one["off"]) > FAR]
        return [f"{one['name']} is {abs(one['off']):.1f} standard deviations off" for one in far]

    @property
    def lines(self) -> list[str]:
        """The closing lines, the verdict first."""
        rounds = f"{len(self.weights)} samples in {counted(len(self.sizes), 'round')}"
        out = [self.verdict.line, f"{self.title}: {self.sizes[-1]:.3g} effective of {rounds}"]
        if self.refused:
            return out
        for name, one in self.ranges.items():
            unit, factor = self.shown(name)
            low, middle, high, *before = (f"{factor * one[key]:.4g}" for key in ("low", "median", "high", "prior_low", "prior_high"))
            learnt = "; the observations say nothing of it" if name in self.unlearnt else ""
            out.append(f"{name}: {middle} ({low} to {high}){f' {unit}' if unit else ''}, before {' to '.join(before)}{learnt}")
        out += [f"{name}: " + ", ".join(f"{v} {100 * p:.0f} %" for v, p in list(of.items())[:5]) for name, of in self.shares.items()]
        if self.map is not None:
            shown = [(name, value, *self.shown(name)) for name, value in self.map.likeliest.items()]
            out.append("likeliest motion: " + ", ".join(f"{name} {factor * v:.3g} {unit}".strip() for name, v, unit, factor in shown))
        gains = [one for one in self.checks if one["gain"] is not None]
        if gains:
            best = max(gains, key=lambda one: one["gain"])
            again = "once more" if best["value"] is not None else "which is not measured yet"
            out.append(f"helps most: {best['name']}, {again}, takes {100 * best['gain']:.0f} % of the variance on average")
        return out

    @property
    def warnings(self) -> list[str]:
        """Warnings on the samples."""
        return [f"{counted(self.lost, 'sample')} without data count as impossible"] if self.lost else []

    def as_dict(self) -> dict[str, Any]:
        """For calibrate.json."""
        return {
            "title": self.title, "scene": self.scene, "program": self.program, "verdict": self.verdict.as_dict(),
            "samples": len(self.weights), "effective": list(self.sizes), "least": self.enough, "lost": self.lost, "misfit": self.misfit,
            "unknowns": self.ranges, "shares": self.shares, "correlation": {"keys": list(self.numbers), "values": self.correlation},
            "unlearnt": self.unlearnt, "motion": None if self.map is None else self.map.likeliest,
            "observations": self.checks, "lines": self.lines, "warnings": self.warnings,
        }  # fmt: skip


def correlation(rows: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Correlation of rows (D, N) with weights (N,), (D, D); 0 with what does not vary."""
    away = rows - np.sum(w * rows, axis=1, keepdims=True)
    covariance = (w * away) @ away.T
    std = np.sqrt(np.diag(covariance))
    scale = np.outer(std, std)
    found = np.divide(covariance, scale, out=np.zeros_like(covariance), where=scale > 1e-300)
    np.fill_diagonal(found, 1.0)
    return found
