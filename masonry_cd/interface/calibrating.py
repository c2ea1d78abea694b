# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of a model that explain what was observed, as ``masonry-cd calibrate`` finds them: a posterior as weights over samples."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.analysis.calibration.posterior import Posterior
from masonry_cd.app.result import said
from masonry_cd.foundation.errors import InputError
from masonry_cd.interface.plots import Page, drawn
from masonry_cd.interface.returned import closing_as_html, returned
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.studies import of_tables, warn, without_main
from masonry_cd.interface.tables import frame_of_rows
from masonry_cd.interface.temporary import TemporaryFolder, place_of

if TYPE_CHECKING:
    from pandas import DataFrame
    from PIL.Image import Image


class Calibration(Sealed):
    """A calibration that is done. Made by :func:`masonry_cd.calibrate`; ``print`` shows the closing lines of the command line."""

    folder: Path
    keeper: TemporaryFolder | None

    def __init__(self, found: Posterior, folder: Path, keeper: TemporaryFolder | None = None) -> None:
        self.folder = folder
        """Where its files are, posterior.parquet for ``[vary] from`` among them."""
        self.keeper = keeper  # of a temporary folder
        self._found = found

    @property
    def title(self) -> str:
        """The title of the study."""
        return self._found.title

    @property
    def verdict(self) -> str:
        """The verdict in a line: whether there is an answer, and whether the model explains what was observed."""
        return self._found.verdict.line

    @property
    def refused(self) -> str:
        """The reason why there is no answer; empty where there is one."""
        return self._found.refused

    @property
    def effective(self) -> float:
        """The effective number of samples."""
        return self._found.sizes[-1]

    @property
    def unknowns(self) -> DataFrame:
        """A row per unknown: 5, 50 and 95 %, mean and standard deviation after, and the range before, in SI units."""
        return frame_of_rows([{"unknown": name} | one for name, one in self._found.ranges.items()], "unknown")

    @property
    def correlation(self) -> DataFrame:
        """The correlation of the unknowns."""
        names = [*self._found.numbers]
        rows = [{"unknown": name} | dict(zip(names, row, strict=True)) for name, row in zip(names, self._found.correlation, strict=True)]
        return frame_of_rows(rows, "unknown")

    @property
    def observations(self) -> DataFrame:
        """A row per observation: value and error, what is predicted after and before, how far it is off, and how much it would help."""
        return frame_of_rows([*self._found.checks], "name")

    @property
    def samples(self) -> DataFrame:
        """A row per sample: its round, weight, unknowns and predictions."""
        found = self._found
        columns = {"sample": range(len(found.weights)), "round": found.rounds, "weight": found.weights, **found.unknowns}
        columns |= {one.title: found.predicted[:, j] for j, one in enumerate(found.observations)}
        return frame_of_rows([dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)], "sample")

    @property
    def lines(self) -> list[str]:
        """The verdict, the ranges, the likeliest motion, and what would help most: the closing lines of the command line."""
        return self._found.lines

    @property
    def warnings(self) -> list[str]:
        """Samples that have no result."""
        return self._found.warnings

    def plot(self) -> Image:
        """The unknowns before and after, and the observations next to what is predicted.

        Raises:
            InputError: there is no answer.
        """
        from reports.calibrate.picture import draw_posterior

        if self.refused:
            raise InputError("", self.verdict)
        return drawn(lambda path: draw_posterior(self._found, path))

    def plot_motion(self) -> Image:
        """The likelihood of an unknown motion over two of its numbers, as PGA and period.

        Raises:
            InputError: there is no answer, or the motion is known.
        """
        from reports.calibrate.motion_picture import draw_motion_likelihood

        found, of = self._found, self._found.map
        if self.refused or of is None:
            raise InputError("", self.verdict if self.refused else "the motion is known, or only one number of it varies")
        return drawn(lambda path: draw_motion_likelihood(found, of, path))

    def page(self) -> Page:
        """calibrate.html with all of it, which needs no network."""
        from reports.calibrate.outputs import PAGE

        return Page(self.folder / PAGE)

    def __str__(self) -> str:
        return "\n".join(self.lines)

    def __repr__(self) -> str:
        return f'<Calibration "{self.title}": {self.verdict}>'

    def _repr_html_(self) -> str:
        return closing_as_html(self.lines, self.warnings)


def calibrate(
    source: str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str] | None = None,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    slurm: str | os.PathLike[str] | None = None,
    progress: bool = True,
    retry: bool = False,
    force: bool = False,
) -> Calibration:
    """Find which values of a model explain what was observed of a building.

    Args:
        source: a study file with design "calibrate" and observations; or a dict with its tables, as of :func:`masonry_cd.study`.
        folder: for the results, created if missing; samples that are there are not repeated. By default a temporary one that lasts as
            long as the calibration that is returned.
        workers: processes of this machine; ``run.workers`` of the study, or all cores, when not given.
        scheduler: address of a dask scheduler that runs, in their place.
        slurm: a file for workers as jobs of Slurm, in their place.
        progress: say on standard error how far it is.
        retry: make samples again that failed or timed out.
        force: begin again, whatever the folder holds.

    Raises:
        InputError: anything wrong with the study, its scene or its observations; the folder of another one; the call was interrupted, and
            the same call continues it.

    >>> import masonry_cd as mc
    >>> stone = {"masonry": "squared stone", "friction": 0.6}
    >>> pier = {"kind": "column", "height": 3.0, "diameter": 0.6, "drums": 6}
    >>> pier = {"structure": pier, "material": stone, "run": {"dt": 1e-3, "duration": 1e-3}}
    >>> tables = {"title": "Pier", "scene": pier, "design": "calibrate", "samples": 20, "calibration": {"rounds": 1, "least": 5.0}}
    >>> tables |= {"vary": {"material.masonry.E": {"distribution": "uniform"}}}
    >>> tables |= {"observations": [{"what": "frequency", "mode": 1, "value": 9.0, "share": 0.1}]}
    >>> found = mc.calibrate(tables, workers=1, progress=False)
    >>> found.refused, list(found.unknowns.index)
    ('', ['material.masonry.E'])
    """
    from masonry_cd.studies.calibrate import command
    from masonry_cd.studies.calibrate.plan import Calibration as CalibrationPlan
    from masonry_cd.studies.study.study_case import StudyOptions
    from masonry_cd.studies.study.study_file import read_study

    place, keeper = place_of(folder)
    if isinstance(source, Mapping):
        plan = of_tables(source, place, force, CalibrationPlan.of, lambda made: command.Sampling(made).plan)
    else:
        plan = CalibrationPlan.of(read_study(Path(source)))
    where = command.Sampling(plan).plan.where(workers, scheduler, None if slurm is None else Path(slurm))
    with without_main():
        result = command.calibrate(plan, place, StudyOptions(where, retry, force, quiet=not progress, warn=warn), said(progress))
    found = returned(result)
    if found is None:
        raise InputError(place, result.stopped)
    return Calibration(found, place, keeper)
