# SPDX-License-Identifier: GPL-3.0-or-later
"""Many runs of one scene, as ``masonry-cd study`` makes them: their table, fragilities, and pictures."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from masonry_cd.analysis.fragility.findings import findings_in
from masonry_cd.analysis.fragility.measures import unit
from masonry_cd.analysis.fragility.rates import COLUMNS as RATES
from masonry_cd.analysis.fragility.sensitivity import COLUMNS
from masonry_cd.analysis.outputs import STUDY, numbers_in, units_in
from masonry_cd.app.result import said
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.interface.open_run import RESULTS
from masonry_cd.interface.plots import StudyPlots
from masonry_cd.interface.results import Run
from masonry_cd.interface.returned import RunWarning, closing_as_html, returned
from masonry_cd.interface.scenes import scene
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.tables import frame_of
from masonry_cd.interface.temporary import TemporaryFolder, place_of
from masonry_cd.interface.values import plain
from masonry_cd.studies.study.folder import StudyFolder
from masonry_cd.studies.study.plan import StudyPlan
from masonry_cd.studies.study.study_case import StudyOptions, plan_of, plan_of_study, require_own
from masonry_cd.studies.study.study_file import ReadStudy as CheckedStudy
from masonry_cd.studies.study.study_file import parse_study
from reports.study.joint_maps import JointStudy, joint_study
from reports.study.tables import COLUMNS_OF_FITS, row_of

if TYPE_CHECKING:
    from pandas import DataFrame

Made = TypeVar("Made")
COUNTS = ("seed", *(key for key, number in numbers_in(STUDY).items() if number.whole))  # columns of whole numbers
UNITS = {"level": "", **units_in(STUDY), "seconds": "s"}


class Study(Sealed):
    """The runs of a study and what follows from them. Made by :func:`masonry_cd.study` and :func:`masonry_cd.open_study`.

    Tables are DataFrames of pandas with columns as in the CSV files; ``table.attrs["units"]`` says their units. ``print(study)`` shows the
    closing lines of the command line.
    """

    folder: Path
    keeper: TemporaryFolder | None

    def __init__(self, folder: Path, keeper: TemporaryFolder | None = None) -> None:
        self.folder = Path(folder)
        """Where its files are."""
        self.keeper = keeper  # of a temporary folder
        self._findings = findings_in(self.folder)
        self._found = self._findings.study

    @property
    def title(self) -> str:
        """Title of pictures and closing lines."""
        return self._found.asked.title

    @cached_property
    def runs(self) -> DataFrame:
        """A row per run: what varied, intensity measures, damage, and how it ended; as in runs.csv."""
        found = self._found
        columns: dict[str, Any] = dict(found.columns)
        for name in (name for name in columns if name.rpartition(".")[2] in COUNTS and found.is_number(name)):
            if np.isfinite(columns[name]).all():
                columns[name] = columns[name].astype(np.int64)
        units = {name: unit(name) for name in found.measures} | {"level": unit(str(found.asked.measure or ""))}
        return _with_units(frame_of(columns, columns.pop("run"), "run"), units)

    @cached_property
    def fragility(self) -> DataFrame:
        """A row per limit state and method: median theta, beta, their 95 % bands, runs, how many exceeded; as in fragility.csv.

        Columns beta_record and beta_model are the parts of beta, where the design tells them apart.
        """
        rows = [row_of(fit) | {name: fit.betas.as_dict()[name] for name in ("beta_record", "beta_model")} for fit in self._findings.fits]
        measure = unit(self._found.asked.measure or "")
        table = _table(rows, (*COLUMNS_OF_FITS, "beta_record", "beta_model"), "limit_state")
        return _with_units(table, dict.fromkeys(("theta", "theta_low", "theta_high"), measure))

    @cached_property
    def frequencies(self) -> DataFrame:
        """A row per limit state: how often a year it is exceeded over the hazard of the scene, with the 95 % band, and in 50 years.

        ``frequency`` counts what lies beyond the rows of the hazard in full, ``frequency_least`` as little as it can. No rows without a
        table ``[hazard]``, or with one of another measure than the study's.
        """
        return _with_units(_table([rate.row() for rate in self._findings.rates], RATES, "limit_state"), {"frequency": "1/year"})

    @cached_property
    def sensitivity(self) -> DataFrame:
        """A row per quantity and variable: the rank correlation of the two, its band and p-value; as in sensitivity.csv."""
        return _table([row._asdict() for row in self._findings.correlations], COLUMNS, "variable")

    @cached_property
    def joint_probabilities(self) -> DataFrame:
        """A row per joint: the share of the runs in which it opened, slid, or was lost, and the median of its largest opening [m].

        Raises:
            InputError: the study has no run with joints, or a file of them is broken.
        """
        if self._joints is None:
            raise InputError(self.folder, "no run of the study is done whose joints are known")
        columns = self._joints.table
        joints = np.arange(len(columns["block_a"]))
        return _with_units(frame_of(columns, joints, "joint"), {"median_opening": "m"})

    @cached_property
    def stopped(self) -> str:
        """The reason why there are fewer runs than planned; empty where all were made. Repeating the call continues the study."""
        planned, made = self._found.asked.runs, self._found.count
        if planned is None:
            return f"{made} runs are made, and others follow from them"
        return "" if made == planned else f"{made} of {planned} runs are made"

    @property
    def lines(self) -> list[str]:
        """The closing lines of the runs, as on the command line."""
        return self._findings.lines

    @property
    def warnings(self) -> list[str]:
        """Warnings of the study, a line each."""
        return self._findings.warnings

    @property
    def plot(self) -> StudyPlots:
        """Its pictures: ``study.plot.fragility()``, ``.stripes()``, ``.tornado()``, ``.probability()``, ``.page()`` and others."""
        return StudyPlots(self._findings, lambda: self._joints)

    def run(self, name: str) -> Run:
        """A run whose folder was kept, with its tables and pictures.

        Args:
            name: from the index of :attr:`runs`.

        Raises:
            InputError: no such run, or one that was not kept.
        """
        names = self._found.text("run")
        if name not in names:
            raise InputError("run", f'the study has no run "{name}"{suggest(name, names)}')
        if not (self.folder / "runs" / name / RESULTS).is_file():
            raise InputError("run", f'"{name}" was not kept; a study with run = {{keep = "all"}} keeps the folders of its runs')
        return Run(self.folder / "runs" / name, self.keeper)

    @cached_property
    def _joints(self) -> JointStudy | None:
        return joint_study(self._found)

    def __str__(self) -> str:
        return "\n".join(self.lines)

    def __repr__(self) -> str:
        done, count = int(self._found.done.sum()), self._found.count
        some = "" if done == count else f", {done} of them done"
        end = f"; {self.stopped}" if self.stopped else ""
        return f'<Study "{self.title}": {self._found.asked.design}, {count} runs{some}{end}>'

    def _repr_html_(self) -> str:
        return closing_as_html(self.lines, self.warnings)


def study(
    source: str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str] | None = None,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    slurm: str | os.PathLike[str] | None = None,
    progress: bool = True,
    retry: bool = False,
    force: bool = False,
) -> Study:
    """Make the runs of a study, or those that are missing, on all cores of this machine or on a cluster.

    Args:
        source: a study file; or a dict with its tables, whose ``scene`` may be anything that :func:`masonry_cd.scene` takes, and whose
            paths begin in the working folder.
        folder: for the results, created if missing; runs that have ended there are not repeated. By default a temporary one that lasts as
            long as the study that is returned.
        workers: processes of this machine; ``run.workers`` of the study, or all cores, when not given.
        scheduler: address of a dask scheduler that runs, in their place.
        slurm: a file for workers as jobs of Slurm, in their place.
        progress: say on standard error how far it is.
        retry: make runs again that failed or timed out.
        force: begin again, whatever the folder holds.

    Everything is checked before anything runs. Runs are made in processes of their own; a script needs no guard for them. Ctrl-C, or the
    button that interrupts a notebook, ends the study: what is returned holds the runs that have ended, ``stopped`` says how many, and the
    same call goes on. Warnings are shown as :class:`RunWarning`.

    Raises:
        InputError: anything wrong with the study, its scene or its records; the folder of another study; a scheduler that does not answer.

    >>> import masonry_cd as mc
    >>> post = mc.scene("examples/trilithon.toml", "run.dt=2e-3", "run.duration=0.1")
    >>> tables = {
    ...     "scene": post,
    ...     "design": "grid",
    ...     "vary": {"loads[0].amplitude": [0.3, 0.6], "material.friction": [0.4, 0.7]},
    ... }
    >>> study = mc.study(tables, workers=1, progress=False)
    >>> study
    <Study "Trilithon": grid, 4 runs>
    >>> study.runs[["loads[0].amplitude", "material.friction", "status"]].values.tolist()
    [[0.3, 0.4, 'done'], [0.3, 0.7, 'done'], [0.6, 0.4, 'done'], [0.6, 0.7, 'done']]
    """
    from masonry_cd.studies.study.command import study as command

    place, keeper = place_of(folder)
    plan = _plan(source, place, force)
    where = plan.where(workers, scheduler, None if slurm is None else Path(slurm))
    with without_main():
        result = command(plan, place, StudyOptions(where, retry, force, quiet=not progress, warn=warn), said(progress))
    returned(result)
    return Study(place, keeper)


def open_study(folder: str | os.PathLike[str]) -> Study:
    """The study in a folder, made here or by the command line; also one that was interrupted.

    Raises:
        InputError: no study is there, or nothing of it can be read.
    """
    return Study(Path(folder))


def _plan(source: str | os.PathLike[str] | Mapping[str, Any], folder: Path, force: bool) -> StudyPlan:
    """The plan of a study, checked."""
    if isinstance(source, Mapping):
        return plan_of_tables(source, folder, force)
    if not isinstance(source, str | os.PathLike):
        raise InputError("study", f"a file or a dict of its tables is needed, got a {type(source).__name__}")
    return plan_of(Path(source))


@contextmanager
def without_main() -> Iterator[None]:
    """Hide the script that called from the processes that are started: they would import it, and so call again what it calls."""
    main = sys.modules["__main__"]
    hidden = {name: getattr(main, name) for name in ("__file__", "__spec__") if hasattr(main, name)}
    vars(main).pop("__file__", None)  # no None, over which the standard library's inspect stumbles, and with it pydantic
    main.__spec__ = None
    try:
        yield
    finally:
        for name, value in hidden.items():
            setattr(main, name, value)


def warn(lines: Iterable[str]) -> None:
    """Warn of doubtful runs before any of them is made."""
    for line in lines:
        warnings.warn(line, RunWarning, stacklevel=2)


def _table(rows: list[dict[str, Any]], columns: tuple[str, ...], index: str) -> DataFrame:
    """A DataFrame of rows, with its columns also where there are none."""
    found = {name: [row[name] for row in rows] for name in columns}
    return frame_of(found, found.pop(index), index)


def _with_units(table: DataFrame, units: Mapping[str, str]) -> DataFrame:
    """A table with the units of further columns, those of length of a study among them."""
    known = UNITS | dict(units)
    table.attrs["units"] |= {name: known[name] for name in table.columns if known.get(name)}
    return table


FILES = ("modes", "file")  # keys of observations
CALLED = "study"  # one made in Python, in messages
FILE = "study.toml"


def plan_of_tables(tables: Mapping[str, Any], folder: Path, force: bool) -> StudyPlan:
    """The plan of a study made in Python, see :func:`of_tables`."""
    return of_tables(tables, folder, force, plan_of_study, lambda plan: plan)


def of_tables(
    tables: Mapping[str, Any], folder: Path, force: bool, make: Callable[[CheckedStudy], Made], plan_in: Callable[[Made], StudyPlan]
) -> Made:
    """The value that is made of a study in Python; the files that hold its arrays are written into its folder, once all is checked.

    Args:
        tables: of a study file; ``scene`` may be anything that :func:`masonry_cd.scene` takes.
        folder: of the study.
        force: write over files of other arrays.
        make: makes it of the study.
        plan_in: the plan in it.

    Raises:
        InputError: anything wrong with the study or its scene; another study in the folder.
    """
    if "scene" not in tables:
        raise InputError(CALLED, "scene: missing")
    asked = scene(tables["scene"])
    inside, arrays = asked.portable()
    given = {name: value for name, value in tables.items() if name != "scene"}
    own = plain(given | ({"title": asked.title} if "title" not in given else {}), "")
    for table, key in [
        (own.get("records"), "folder"),
        (own.get("vary"), "from"),
        *((t, k) for t in own.get("observations", ()) for k in FILES),
    ]:
        if isinstance(table, dict) and isinstance(table.get(key), str):
            table[key] = str(Path(table[key]).absolute())
    text = dump_toml(own | {"scene": inside})
    if not arrays:
        return make(parse_study(text, folder / FILE, CALLED))
    made = make(parse_study(text, asked.checked.folder / FILE, CALLED))  # where the arrays lie now
    if not force:
        require_own(plan_in(made), folder)
    StudyFolder(folder).hold(arrays)
    for name, content in arrays.items():
        with replacing(folder / name) as part:
            part.write_bytes(content)
    return make(parse_study(text, folder / FILE, CALLED))
