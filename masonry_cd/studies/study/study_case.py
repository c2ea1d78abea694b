# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the missing runs of a plan and writes what their rows say: a study's, an assessment's, an ensemble's."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from masonry_cd import __version__
from masonry_cd.analysis.calibration.observations import OF_KINDS
from masonry_cd.analysis.fragility.folder import StudyFacts
from masonry_cd.analysis.run_row import STATES
from masonry_cd.app.progress import Interrupt, Interrupted
from masonry_cd.app.result import Result, Say
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.io.lock import locked
from masonry_cd.studies.study.checks import check_varied
from masonry_cd.studies.study.clusters import RunPlace, connected
from masonry_cd.studies.study.designs import Space
from masonry_cd.studies.study.engine import ClusterLost, Engine
from masonry_cd.studies.study.folder import NAME, StudyFolder, digest_of
from masonry_cd.studies.study.plan import Maker, Planned, StudyPlan
from masonry_cd.studies.study.progress import StudyProgress
from masonry_cd.studies.study.records import find_records
from masonry_cd.studies.study.study_file import ReadStudy, read_study
from masonry_cd.studies.study.table import Rows
from masonry_cd.studies.study.task import Outcome, Task, run_task

REASONS = 5  # named at the end; the others are counted
KEPT = "finished runs are kept"


@dataclass(frozen=True)
class StudyOptions:
    """How a study is made; what the study file says of it is used where nothing is given."""

    where: RunPlace
    retry: bool = False  # make failed runs again
    force: bool = False  # begin again
    resume: bool = False  # refuse a folder that holds no study
    quiet: bool = False
    warn: Callable[[Sequence[str]], object] = lambda _: None  # called with what is doubtful of the first run, before any is made


@dataclass(frozen=True)
class RunActions:
    """Actions on the runs of a study; by default none but to make them."""

    write: Callable[[Path, StudyPlan, Rows], object]  # what is written of the runs that have ended
    function: Callable[[Task], Outcome] = run_task  # a run, on a worker
    check: Callable[[StudyPlan], Sequence[str]] = (
        lambda _: ()
    )  # refuses what is wrong with all runs before they begin, and says what is doubtful
    maps: bool = False  # whether the results of the first run are kept, for maps of its joints


@dataclass(frozen=True)
class StudyOutcome:
    """Outcome of the runs of a plan."""

    runs: int  # planned
    rows: Rows  # of those that have ended
    stopped: str = ""  # why there are not more
    signal: int = 0  # that ended it

    def count(self, status: str) -> int:
        """How many ended so."""
        return sum(row.status == status for row in self.rows.values())

    @property
    def line(self) -> str:
        """How many ended in which way."""
        done, failed, timeout = (self.count(status) for status in STATES)
        return f"{done} of {self.runs} runs done, {failed} failed, {timeout} timed out"

    def warnings(self, table: Path) -> list[str]:
        """Why runs have no result, the commonest reasons; the others are counted, and stand in a ``table``."""
        reasons = Counter(row.reason for row in self.rows.values() if not row.done).most_common()
        lost = sum(count for _, count in reasons)
        out = [f"{count} of {lost} runs without data: {reason}" for reason, count in reasons[:REASONS]]
        if others := reasons[REASONS:]:
            more = sum(count for _, count in others)
            out.append(f"{more} of {lost} runs without data, for {len(others)} other reasons: see {table}")
        return out

    def ended_early(self, lines: Sequence[str] = (), warnings: Sequence[str] = ()) -> Result[None]:
        """The result of a command whose runs are not all made; the same command makes the others."""
        said = f"{self.stopped}; {KEPT}"
        return Result(None, lines, [*warnings, said], stopped=self.stopped, signal=self.signal, resumable=True)


def plan_of(path: Path) -> StudyPlan:
    """The plan of a study file, checked; nothing is written.

    Raises:
        InputError: anything wrong with the study, its scene, or its records.
    """
    return plan_of_study(read_study(path))


def plan_of_study(study: ReadStudy) -> StudyPlan:
    """The plan of a study whose tables are checked; nothing is written.

    Raises:
        InputError: see :func:`plan_of`.
    """
    with study.locating():
        if study.tables.design == "calibrate":
            raise InputError("design", '"calibrate" is what masonry-cd calibrate makes; a study of its posterior has [vary] from = "FILE"')
    space = space_of_study(study)
    with study.locating():
        return StudyPlan(Maker(study, space))


def space_of_study(study: ReadStudy) -> Space:
    """The space from which the runs of a study are chosen, once each value that varies has been tried on its scene.

    Raises:
        InputError: see :func:`plan_of`.
    """
    hazard_numbers(study)  # refused before anything is made
    space = Space(study.tables, find_records(study), study.varied)
    check_varied(study, space)
    return space


def make_runs(plan: StudyPlan, folder: Path, options: StudyOptions, say: Say, ways: RunActions) -> StudyOutcome:
    """Make the runs of a plan that are missing in a folder.

    Args:
        plan: from :func:`plan_of`, or of another command.
        folder: for the results, created if missing; runs that have ended there are not repeated.
        options: where and how.
        say: called with lines on what is done.
        ways: what a run is, and what is written of it.

    Raises:
        InputError: a bad study; the folder of another one; a scheduler that does not answer. Nothing is lost.
    """
    require("a study", "distributed", "dask", "pyarrow", "matplotlib")
    here = StudyFolder(folder)
    if options.resume and not (folder / NAME).exists():
        raise InputError("--resume", f"{folder} holds no study")
    if options.force:
        here.require_own()
    else:
        require_own(plan, folder)
    known = {} if options.force else here.finished(options.retry)
    if any(run.name not in known for run in plan.runs):
        options.warn(ways.check(plan))  # before anything is written
    with locked(folder):
        if options.force:
            here.clear()
        here.begin(plan.maker.study, _facts(plan))
        return _Making(plan, here, options, say, ways).make()


def require_own(plan: StudyPlan, folder: Path) -> None:
    """Refuse a folder that holds another study, or something else.

    Raises:
        InputError: names what differs.
    """
    StudyFolder(folder).require_same(_identity(plan))


class _Making:
    """A study on its way."""

    def __init__(self, plan: StudyPlan, folder: StudyFolder, options: StudyOptions, say: Say, ways: RunActions) -> None:
        self.plan, self.folder, self.options, self.say, self.ways = plan, folder, options, say, ways
        self.rows = folder.finished(options.retry)
        self.stopped, self.signal = "", 0

    def make(self) -> StudyOutcome:
        """Make the missing runs and write what they say."""
        missing, known = self._missing()
        more = " so far" if self.plan.adapts else ""
        self.say(f"{self.plan.maker.study.title}: {len(known)} runs{more}, {len(missing)} still to run")
        if missing:
            self.folder.forget_hangs(missing)
            try:
                self.execute(missing, len(known))
            except Interrupted as asked:
                self.stopped, self.signal = str(asked), asked.number
        if not self.stopped and self.ways.maps:
            self._complete_reference()
        runs = self.plan.ordered()
        self.ways.write(self.folder.path, self.plan, self.rows)
        self.folder.describe(_facts(self.plan, None if self.stopped else len(runs)))
        return StudyOutcome(len(runs), {run.name: self.rows[run.name] for run in runs if run.name in self.rows}, self.stopped, self.signal)

    def _missing(self) -> tuple[list[Planned], set[str]]:
        """The runs to be made, each once, in the order of the plan's choice; and the names of all that are known."""
        missing: dict[str, Planned] = {}
        queue, known = deque(self.plan.runs), set()
        while queue:
            run = queue.popleft()
            known.add(run.name)
            if run.name in self.rows:
                queue.extend(self.plan.after(run, self.rows[run.name]))
            else:
                missing.setdefault(run.name, run)
        made = list(missing.values())
        return [*made[:1], *self.plan.shuffled(made[1:])], known

    def execute(self, missing: list[Planned], known: int) -> None:
        """Make runs until there are none left, or a signal comes."""
        tables = self.plan.maker.study.tables
        progress = StudyProgress(known, known - len(missing), sum(run.weight for run in missing), self.options.quiet)
        with Interrupt(said=f"ending; {KEPT}") as interrupt, connected(self.options.where) as (client, words):
            self.say(words)

            def look(running: int, threads: int) -> None:
                progress.look(running, threads)
                interrupt.check()

            def ended(run: Planned, outcome: Outcome) -> Iterable[Planned]:
                self.folder.add(run, outcome)
                self.rows[run.name] = outcome.row
                progress.ended(run.weight, outcome.row)
                following = list(self._following(run))
                for more in following:
                    progress.planned(more.weight)
                return following

            first = self.plan.ordered()[0].name
            engine = Engine(
                client, lambda run: self._task(run, tables, run.name == first), ended, look, self.ways.function, self.options.where.patience
            )
            try:
                engine.execute(missing)
            except ClusterLost as lost:
                self.stopped = str(lost)
            finally:
                progress.close()

    def _following(self, run: Planned) -> Iterator[Planned]:
        """The runs still to be made that follow from one that has ended, and from those that a folder has of them."""
        for more in self.plan.after(run, self.rows[run.name]):
            if more.name in self.rows:
                yield from self._following(more)
            else:
                yield more

    def _task(self, run: Planned, tables: Any, reference: bool) -> Task:
        """Return the task of a worker."""
        folder = str(self.folder.path.resolve())
        asked, reference = tables.run, reference and self.ways.maps
        return Task(run.name, self.plan.maker.tables(run.asked), asked.timeout, asked.grace, asked.keep, folder, reference, tables.asks)

    def _complete_reference(self) -> None:
        """Have the first run of the plan that is done as the reference; it is rebuilt where another run was the first."""
        first = next((run for run in self.plan.ordered() if self.rows[run.name].done), None)
        if first is None or self.folder.has_reference(first.name):
            return
        outcome = run_task(replace(self._task(first, self.plan.maker.study.tables, True), keep="none"))
        if outcome.reference is not None:
            self.folder.write_reference(first.name, outcome.reference)


def _identity(plan: StudyPlan) -> dict[str, str]:
    """Return the digests by which a study is recognised: all but how large its design is."""
    study, maker = plan.maker.study, plan.maker
    tables, intensity = study.tables, study.tables.intensity
    records = None if tables.records is None else tables.records.model_dump(exclude={"folder", "exclude", "factors", "values"})
    vary = {"keys": study.varied.columns, "random": {key: one.model_dump() for key, one in study.varied.random.items()}}
    observed = [one.model_dump(include={"what", "name", *OF_KINDS}) for one in tables.observations]
    return {
        "scene": maker.name(maker.base()),
        "design": plan.design + (" of limit analyses" if tables.asks == "limit" else ""),
        "seed": str(tables.seed),
        "intensity measure": digest_of(None if intensity is None else [intensity.measure, intensity.of, intensity.key]),
        "treatment of records": digest_of(records),
        "set of varied keys or distributions": digest_of([vary, [group.model_dump() for group in tables.correlation]]),
    } | ({"set of observations": digest_of([observed, tables.modal])} if observed else {})


def hazard_numbers(study: ReadStudy) -> dict[str, Any] | None:
    """The rows of the hazard of the study's scene; None without one, and of a life alone.

    Raises:
        InputError: a file of it that cannot be read.
    """
    found = study.scene.site
    return None if found is None or not found.known else found.numbers()


def _facts(plan: StudyPlan, runs: int | None = None) -> StudyFacts:
    """study.json, for the statistics."""
    study = plan.maker.study
    tables, intensity = study.tables, study.tables.intensity
    measured = intensity is not None or (tables.records is not None and tables.records.folder is not None)
    return StudyFacts(
        program=__version__,
        title=study.title,
        design=plan.design,
        seed=tables.seed,
        scene=study.scene_name,
        measure=(intensity.measure if intensity is not None else "PGA") if measured else None,
        levels=None if intensity is None else intensity.levels,
        varied=study.varied.columns,
        limit_states=tables.limit_states,
        hazard=hazard_numbers(study),
        loss_ratios=tables.loss_ratios,
        keep=tables.run.keep,
        plan=digest_of([run.name for run in plan.ordered()]),
        runs=runs if plan.adapts else len(plan.runs),
        identity=_identity(plan),
    )
