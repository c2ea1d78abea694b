# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``masonry-cd calibrate``: rounds of samples by the engine of studies, until there are enough effective ones."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from scipy.special import ndtr

from masonry_cd import __version__
from masonry_cd.analysis.calibration.posterior import Posterior
from masonry_cd.analysis.calibration.weights import Proposal, log_ratio, next_proposal, weights
from masonry_cd.analysis.distributions import effective
from masonry_cd.app.result import Result, Say
from masonry_cd.studies.calibrate.plan import DESIGN, Calibration
from masonry_cd.studies.calibrate.predicted import PREDICTED, calibrate_task
from masonry_cd.studies.study.clusters import connected
from masonry_cd.studies.study.designs import DesignedRun
from masonry_cd.studies.study.folder import StudyFolder
from masonry_cd.studies.study.plan import StudyPlan
from masonry_cd.studies.study.study_case import RunActions, StudyOptions, make_runs
from masonry_cd.studies.study.table import Rows, write_parquet
from masonry_cd.studies.study.varied import WEIGHT

POSTERIOR = "posterior.parquet"


def calibrate(plan: Calibration, folder: Path, options: StudyOptions, say: Say) -> Result[Posterior | None]:
    """Sample the posterior of a calibration round by round; the samples of a folder are not repeated.

    Raises:
        InputError: a bad study; the folder of another one; a scheduler that does not answer. Nothing is lost.
    """
    from reports.calibrate.outputs import write_posterior

    sampling = Sampling(plan)
    ways = RunActions(lambda *_: None, partial(calibrate_task, plan.wanted), plan.check)
    with ExitStack() as kept:
        while True:
            made = make_runs(sampling.plan, folder, options, say, ways)
            if made.stopped:
                return made.ended_early()
            sampling.weigh(made.rows)
            say(f"round {len(sampling.sizes)}: {sampling.sizes[-1]:.3g} effective of {len(sampling.z)} samples")
            if sampling.ended:
                break
            sampling.go_on()
            options, ways = replace(options, force=False, retry=False), replace(ways, check=lambda _: ())
            if (
                options.where.scheduler is None
                and not {run.name for run in sampling.plan.runs} <= StudyFolder(folder).finished(False).keys()
            ):
                client, _ = kept.enter_context(connected(options.where))  # the workers of all rounds that follow
                options = replace(
                    options, where=replace(options.where, scheduler=str(client.scheduler_info()["address"]), slurm=None, workers=None)
                )
    found = sampling.posterior(made.rows)
    written = write_posterior(found, folder)
    if not found.refused:
        keys = [key for key in plan.maker.space.varied.columns if key in found.numbers]
        write_parquet(folder / POSTERIOR, {WEIGHT: found.weights.tolist(), **{key: list(found.numbers[key]) for key in keys}})
        written = [folder / POSTERIOR, *written]
    else:
        (folder / POSTERIOR).unlink(missing_ok=True)
    return Result(found, [made.line, *found.lines], [*made.warnings(folder / "samples.csv"), *found.warnings], written, found.refused)


class Sampling:
    """The samples of a calibration, round by round."""

    def __init__(self, calibration: Calibration) -> None:
        self.calibration = calibration
        self.proposals: list[Proposal] = []
        self.z = np.zeros((0, len(calibration.places)))
        self.sizes: list[float] = []
        self._next = Proposal.prior(len(calibration.places))
        self.asked: list[DesignedRun] = []
        self.plan = StudyPlan(calibration.maker, [], DESIGN)
        self.go_on()

    def go_on(self) -> None:
        """Draw the samples of the next round."""
        seed = (self.calibration.maker.study.tables.seed, len(self.proposals))
        self.proposals.append(self._next)
        drawn = self._next.draw(self.calibration.samples, seed)
        self.z = np.concatenate([self.z, drawn])
        asked = [self.calibration.asked(u) for u in ndtr(drawn)]
        self.asked += asked
        self.plan.runs += [self.calibration.maker.planned(one) for one in asked]

    def weigh(self, rows: Rows) -> None:
        """Weigh all samples by what their rows predict, and fit the next proposal to them."""
        self.ratio = log_ratio(self.z, self.proposals, [self.calibration.samples] * len(self.proposals))
        self.predicted = self._predicted(rows)
        observed = [(one, self.predicted[:, j]) for j, one in enumerate(self.calibration.wanted.observations) if one.known]
        likelihood = np.zeros(len(self.z))
        for one, values in observed:
            likelihood += one.log_likelihood(values)
        likelihood[~np.array([rows[run.name].done for run in self.plan.runs])] = -np.inf
        self.weights = weights(self.ratio + likelihood)
        self.sizes.append(effective(self.weights))
        self._next = next_proposal(self.z, self.ratio, likelihood)

    @property
    def ended(self) -> bool:
        """True where there are enough effective samples, or as many rounds as there may be."""
        table = self.calibration.table
        return self.sizes[-1] >= table.wanted or len(self.sizes) >= table.rounds

    def posterior(self, rows: Rows) -> Posterior:
        """The posterior of the samples."""
        calibration, study = self.calibration, self.calibration.maker.study
        return Posterior(
            title=study.title,
            scene=study.scene_name,
            program=__version__,
            unknowns=calibration.unknowns(self.asked) | calibration.measured(self.asked),
            units=calibration.units(),
            rounds=np.repeat(np.arange(1, len(self.proposals) + 1), calibration.samples),
            sizes=tuple(self.sizes),
            enough=calibration.table.least,
            weights=self.weights,
            prior=weights(self.ratio),
            observations=calibration.wanted.observations,
            predicted=self.predicted,
            motion=calibration.motion,
            lost=sum(not rows[run.name].done for run in self.plan.runs),
        )

    def _predicted(self, rows: Rows) -> np.ndarray:
        """The predictions of each sample for each observation (N, M), nan where it has none."""
        titles = [one.title for one in self.calibration.wanted.observations]
        every = [rows[run.name].number(PREDICTED) or {} for run in self.plan.runs]
        return np.array([[found.get(title) for title in titles] for found in every], dtype=float).reshape(len(self.z), len(titles))
