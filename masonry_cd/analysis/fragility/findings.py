# SPDX-License-Identifier: GPL-3.0-or-later
"""The findings of a study from all its runs: fits, correlations, a verdict, and their lines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.analysis.damage.grades import NAMES
from masonry_cd.analysis.damage.verdict import ENOUGH
from masonry_cd.analysis.fragility.bootstrap import LEVEL
from masonry_cd.analysis.fragility.fits import ORDER, Fit, Fits, fit_study
from masonry_cd.analysis.fragility.folder import StudyResults, read_study
from masonry_cd.analysis.fragility.measures import with_unit
from masonry_cd.analysis.fragility.rates import Rate, annual_loss, hazard_of, mismatch, rates_of
from masonry_cd.analysis.fragility.sensitivity import SIGNIFICANT, RankCorrelation, correlations
from masonry_cd.analysis.outputs import NUMBERS, STUDY_PAGE, lengths_in
from masonry_cd.analysis.run_row import STATES
from masonry_cd.analysis.verdict import DOUBTFUL, GOOD, LOOK, NOT_GRADED, UNKNOWN, Verdict
from masonry_cd.foundation.quantities import counted

PANELS = 3  # quantities looked at, as many as pictures have side by side
GENERAL = tuple(lengths_in(STUDY_PAGE))  # drawn where the limit states look at none that is continuous
NAMED = 3  # of what varied, in the line on what matters
FEW_RECORDS = 10  # with fewer the bands of fits are too narrow
MANY = 0.1  # share of runs without data or without a grade from which on fits are biased beyond what their bands say


class RunSpread(NamedTuple):
    """A quantity over the runs that are done."""

    median: float
    quartile_low: float
    quartile_high: float
    runs: int


class Flaw(NamedTuple):
    """Something in the runs that speaks against what is fitted to them."""

    what: str  # for the verdict
    so: str  # what follows, for a warning


@dataclass(frozen=True, eq=False)
class Findings:
    """A study with the results of its runs, each computed once, on first use."""

    study: StudyResults

    @cached_property
    def all_fits(self) -> Fits:
        """Fragilities, clouds and curves."""
        return fit_study(self.study)

    @property
    def fits(self) -> tuple[Fit, ...]:
        """Every limit state by every method that its data allow."""
        return self.all_fits.fits

    @cached_property
    def first_fits(self) -> list[Fit]:
        """One fit per limit state, by the method that its data suit best, of those that have one."""
        best: dict[Any, Fit] = {}
        for fit in sorted(filter(lambda fit: fit.is_fitted, self.fits), key=lambda fit: ORDER.index(fit.method)):
            best.setdefault(fit.limit, fit)
        return [best[limit] for limit in dict.fromkeys(fit.limit for fit in self.fits) if limit in best]

    @cached_property
    def rates(self) -> list[Rate]:
        """How often a year each of these fits is exceeded; none without the hazard of the site, and over another measure than its own."""
        hazard = hazard_of(self.study.asked.hazard)
        return [] if hazard is None or mismatch(hazard, self.study.asked.measure) else rates_of(self.first_fits, hazard)

    @property
    def annual_loss(self) -> float | None:
        """The mean annual loss over the cost of reconstruction; None without loss ratios, or without rates of their limit states."""
        return annual_loss(self.rates, self.study.asked.loss_ratios)

    @cached_property
    def correlations(self) -> list[RankCorrelation]:
        """Correlations of the varied keys and of the intensity with the quantities of the limit states."""
        return correlations(self.study)

    @property
    def counts(self) -> dict[str, int | None]:
        """Runs by their state."""
        words = self.study.text("status")
        return {"planned": self.study.asked.runs, "rows": self.study.count} | {state: words.count(state) for state in STATES}

    @property
    def lost(self) -> int:
        """Runs that failed or timed out."""
        return self.study.count - int(self.study.done.sum())

    @property
    def fell(self) -> int:
        """Runs in which blocks fell."""
        return int((self.study.collapsed & self.study.done).sum())

    @property
    def quantities(self) -> list[str]:
        """Columns worth a panel: those of continuous limit states, else what every run has; as many as fit."""
        study = self.study
        asked = dict.fromkeys(limit.column for limit in study.limit_states if limit.is_continuous)
        return [name for name in (asked or GENERAL) if np.isfinite(study.numbers(name)[study.done]).any()][:PANELS]

    @property
    def spreads(self) -> dict[str, RunSpread]:
        """Median and quartiles of each quantity."""
        out = {}
        for column in dict.fromkeys([*self.quantities, *(limit.column for limit in self.study.limit_states)]):
            values = self.study.numbers(column)[self.study.done]
            values = values[np.isfinite(values)]
            if len(values):
                low, middle, high = (float(value) for value in np.percentile(values, [25.0, 50.0, 75.0]))
                out[column] = RunSpread(middle, low, high, len(values))
        return out

    # --- how far the runs bear it out -------------------------------------------------------------------------------------------------

    @property
    def ungraded(self) -> int:
        """Runs that cannot be relied on."""
        return self.study.text("grade").count(NOT_GRADED) if "grade" in self.study.columns else 0

    @property
    def flaws(self) -> list[Flaw]:
        """Flaws of the runs that speak against the fits."""
        study, done = self.study, self.study.done
        missed, short = int((study.numbers("steps_missed")[done] > 0).sum()), int((study.numbers("loads_acted")[done] < ENOUGH).sum())
        few, of = bool(study.asked.measure) and 0 < len(study.motions) < FEW_RECORDS, f"of {int(done.sum())} runs"
        lost = f"{self.lost} of {study.count} runs failed or timed out"
        known = (
            (self.lost, lost, "they have no result, and where they are the strongest, fits are biased"),
            (self.ungraded, f"{self.ungraded} {of} cannot be relied on", f"they are {NOT_GRADED}, and fits by grade leave them out"),
            (missed, f"{missed} {of} missed the tolerance in some steps", ""),
            (few, f"{counted(len(study.motions), 'record')}, and {FEW_RECORDS} are wanted", "the bands are too narrow"),
            (short, f"{short} {of} ended before {100 * ENOUGH:g} % of a load had acted", "run.duration is too short"),
        )
        return [Flaw(what, so) for there, what, so in known if there]

    @property
    def warnings(self) -> list[str]:
        """Warnings, a line each."""
        none = [] if self.study.done.any() else ["no run has finished, so there is nothing to fit"]
        hazard = hazard_of(self.study.asked.hazard)
        other = [] if hazard is None else [*hazard.notes, *filter(None, [mismatch(hazard, self.study.asked.measure)])]
        return [*none, *(f"{flaw.what}: {flaw.so}" if flaw.so else flaw.what for flaw in self.flaws), *self.all_fits.warnings, *other]

    @property
    def verdict(self) -> Verdict:
        """The range of grades over the runs, and how far they bear out what is fitted to them."""
        if not self.study.done.any():
            return Verdict("", "", "", UNKNOWN, "no verdict: no run has finished", "")
        unfitted = dict.fromkeys(fit.limit.name for fit in self.fits if not fit.is_fitted)
        none = [f"no fit of {', '.join(unfitted)}"] if unfitted else []
        why, grade = "; ".join([*(flaw.what for flaw in self.flaws), *none, *self.all_fits.warnings]), self._grades()
        if self.lost + self.ungraded > MANY * self.study.count:
            return Verdict(grade, "", "", DOUBTFUL, "do not rely on this study until its runs are repeated", why)
        if why:
            return Verdict(grade, "", "", LOOK, "read what is fitted with care", why)
        return Verdict(grade, "", "", GOOD, "nothing in the runs speaks against what is fitted", "")

    def _grades(self) -> str:
        """``D0 to D4``; empty where no run is graded."""
        found = self.study.numbers("grade_number")[self.study.done]
        found = found[np.isfinite(found)].astype(int)
        if not len(found):
            return ""
        low, high = NAMES[found.min()], NAMES[found.max()]
        return low if low == high else f"{low} to {high}"

    # --- texts ---------------------------------------------------------------------------------------------------------------------

    @cached_property
    def lines(self) -> list[str]:
        """The closing lines, which the command prints and the page begins with."""
        fitted = [fit_line(fit) for fit in self.first_fits]
        spread = [_spread_line(column, found) for column, found in self.spreads.items() if not column.endswith("grade_number")]
        costs = [] if self.annual_loss is None else [f"mean annual loss {100 * self.annual_loss:.2g} % of the cost of reconstruction"]
        return [self._first(), *(fitted or spread), *(rate.line for rate in self.rates), *costs, *self._matters()]

    def _first(self) -> str:
        """How many runs there are."""
        study, found = self.study, self.counts
        other = [f", {found[state]} {words}" for state, words in (("failed", "failed"), ("timeout", "timed out")) if found[state]]
        planned = f" of {found['planned']}" if found["planned"] not in (None, found["done"]) else ""
        records = f" under {len(study.motions)} records" if study.motions else ""
        some = f"; blocks fell in {self.fell}" if self.fell else ""
        return f"{study.asked.title}: {found['done']}{planned} runs done{records}{''.join(other)}{some}"

    def _matters(self) -> Iterator[str]:
        """Which of what varied goes with which quantity, by the correlation that the intensity does not hide."""
        for column in dict.fromkeys(row.quantity for row in self.correlations):
            own = [row for row in self.correlations if row.quantity == column and row.kind == "varied"]
            clear = [row for row in own if row.p < SIGNIFICANT and row.low * row.high > 0]
            name = quantity(column)[0].split(" [")[0]
            if clear:
                found = ", ".join(f"{row.variable} ({row.rho:+.2f})" for row in clear[:NAMED])
                yield f"{name} goes with {found}, by rank correlation"
            elif own:
                yield f"{name} goes with nothing that varied clearly enough to show in these runs"


def findings_in(folder: Path) -> Findings:
    """The findings from the runs in a study's folder.

    Raises:
        InputError: something in the folder is missing or broken.
    """
    return Findings(read_study(folder))


def quantity(column: str) -> tuple[str, float]:
    """How an axis names a column, with its unit, and the factor into that unit."""
    part, _, name = column.rpartition(".")
    known, where = NUMBERS.get(name or column), f" of {part}" if part else ""
    if known is None:
        return f"{name or column}{where}", 1.0
    unit, factor = known.shown
    return f"{known.name}{where}{f' [{unit}]' if unit else ''}", factor


def fit_line(fit: Fit) -> str:
    """``collapse: median PGA 2.4 m/s² (95 %: 2.2 to 2.7), beta 0.43 (0.31 to 0.52), 45 of 320 runs exceed it``"""
    low, high = fit.theta_band
    found = f"{low:.3g} to {with_unit(high, fit.measure)}" if np.isfinite(high) else f"from {low:.3g} on, without an upper bound"
    of = "records reach" if fit.method == "ida" else "runs exceed"
    text = (
        f"{fit.limit.name}: median {fit.measure} {with_unit(fit.theta, fit.measure)} ({100 * LEVEL:.0f} %: {found}), "
        f"beta {fit.beta:.2f} ({fit.beta_band[0]:.2f} to {fit.beta_band[1]:.2f}), {fit.exceeded} of {fit.runs} {of} it"
    )
    parts = [f"{name} {value:.2f}" for name, value in (("records", fit.betas.record), ("model", fit.betas.model)) if value is not None]
    return text + (f"; of this beta {', '.join(parts)}" if len(parts) == 2 else "")


def _spread_line(column: str, found: RunSpread) -> str:
    """``largest opening: median 50.1 mm, quartiles 45.2 to 53 mm, over 50 runs``"""
    words, factor = quantity(column)
    name, _, rest = words.partition(" [")
    low, middle, high = (factor * value for value in (found.quartile_low, found.median, found.quartile_high))
    suffix = f" {rest.rstrip(']')}" if rest else ""
    return f"{name}: median {middle:.3g}{suffix}, quartiles {low:.3g} to {high:.3g}{suffix}, over {found.runs} runs"
