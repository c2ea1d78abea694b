# SPDX-License-Identifier: GPL-3.0-or-later
"""The command ``masonry-cd accuracy``: a problem file or a scene is measured, and what came out is written and said."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from masonry_cd.app.folders import free_folder
from masonry_cd.app.result import Result, Say
from masonry_cd.app.scene import Scene, read_scene
from masonry_cd.foundation import own_files
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.foundation.files import is_file
from masonry_cd.mechanics.solvers.by_name import require_solver
from masonry_cd.studies.accuracy import ensemble, scene_runs, solver_rows
from masonry_cd.studies.accuracy.picture import OUTPUTS, Measurement
from masonry_cd.studies.study.study_case import StudyOptions

LARGEST_STEP = 0.1  # [s]


@dataclass(frozen=True)
class AccuracyRequest:
    """A request for a measurement: lists as typed, None where nothing is."""

    solvers: str | None = None
    tolerances: str | None = None
    dts: str | None = None
    repeats: int | None = None
    duration: float | None = None  # of a scene [s]
    changes: tuple[str, ...] = ()  # of a scene, ``key=value``
    ensemble: int | None = None  # runs of each setting
    workers: int = 1  # of an ensemble
    force: bool = False  # overwrite what the folder holds; begin an ensemble again
    quiet: bool = False

    @property
    def overrides(self) -> list[str]:
        """All changes of the scene."""
        return [*self.changes, *([] if self.duration is None else [f"run.duration={self.duration!r}"])]

    @property
    def names(self) -> tuple[str, ...] | None:
        """The solvers, in the order in which they were typed."""
        names = None if self.solvers is None else [word.strip() for word in self.solvers.split(",")]
        for name in names or ():
            require_solver(name, "--solvers")
        return None if names is None else tuple(dict.fromkeys(names))

    @property
    def reach(self) -> tuple[float, ...] | None:
        """The tolerances, from loose to tight."""
        return _numbers(self.tolerances, "--tolerances", 1.0)

    @property
    def steps(self) -> tuple[float, ...] | None:
        """The time steps, from long to short [s]."""
        return _numbers(self.dts, "--dts", LARGEST_STEP)


def accuracy(source: Path, folder: Path, asked: AccuracyRequest, say: Say) -> Result[Measurement | None]:
    """Measure a problem file or a scene, and write the outputs into a folder, which is created if missing.

    Args:
        source: .npz or FCLIB HDF5, or a scene (TOML).
        folder: for the outputs; an ensemble that it holds is continued.
        asked: how it is measured.
        say: called with a line on how far it is.

    Raises:
        InputError: a bad file, scene or option; nothing is written then.
    """
    _check(asked)
    if asked.ensemble is None:
        free_folder(folder, OUTPUTS, asked.force)
    require("the picture of accuracy", "matplotlib")  # before the runs
    if not is_file(source):
        raise InputError(source, "no such file")
    if source.suffix != ".toml":
        return _written(_problem(source, asked, say), folder)
    scene = read_scene(source, asked.overrides)
    scene.refuse_static()
    if asked.ensemble is None:
        return _written(_scene(source, scene, asked, say), folder)
    return _ensemble(source, scene, folder, asked, say)


def _check(asked: AccuracyRequest) -> None:
    """Refuse options that contradict each other."""
    if asked.ensemble is None:
        if asked.workers > 1:
            raise InputError("--workers", "is for --ensemble; times of single runs are taken one after the other")
        return
    if asked.repeats:
        raise InputError("--ensemble and --repeats", "they exclude each other; leave one out")
    if asked.ensemble < ensemble.LEAST:
        raise InputError("--ensemble", f"{asked.ensemble} members show no bias, however large; at least {ensemble.LEAST} do")


def _problem(source: Path, asked: AccuracyRequest, say: Say) -> Measurement:
    """Measure the solvers on a problem file."""
    from masonry_cd.io.problem_files import read_problem

    of_scene = (("--dts", asked.dts), ("--duration", asked.duration), ("--set", asked.changes), ("--ensemble", asked.ensemble))
    for option, given in of_scene:
        if given:
            raise InputError(option, f"{source.name} is a friction problem; time steps, changes and ensembles are of a scene")
    names, tolerances = asked.names, asked.reach or solver_rows.TOLERANCES
    problem = read_problem(source)
    rows = solver_rows.solver_rows(problem, solver_rows.solvers_for(problem, names), tolerances, asked.repeats or solver_rows.REPEATS, say)
    return solver_rows.measured(problem, source.name, rows, every=names is None)


def _scene(source: Path, scene: Scene, asked: AccuracyRequest, say: Say) -> Measurement:
    """Measure single runs of a scene."""
    if scene.run.is_adaptive:
        raise InputError(source, 'run.dt is "auto", and accuracy compares fixed time steps; give it a scene with a number there')
    solvers, tolerances = asked.names or (scene.run.solver,), asked.reach or scene_runs.TOLERANCES
    dts = asked.steps or tuple(factor * scene.run.dt for factor in scene_runs.DT_FACTORS)
    rows = scene_runs.run_rows(source, asked.overrides, solvers, dts, tolerances, asked.repeats or 1, say)
    return scene_runs.measured(scene.title, rows)


def _ensemble(source: Path, scene: Scene, folder: Path, asked: AccuracyRequest, say: Say) -> Result[Measurement | None]:
    """Measure ensembles of a scene."""
    solvers, tolerances, dts = asked.names or (scene.run.solver,), asked.reach or ensemble.TOLERANCES, asked.steps
    if dts is None and scene.run.is_adaptive:
        raise InputError(source, 'run.dt is "auto"; name the time steps to compare by --dts')
    settings = ensemble.settings_of(solvers, dts or (scene.run.dt,), tolerances)
    assert asked.ensemble is not None
    plan = ensemble.EnsemblePlan(scene, settings, asked.ensemble)
    return ensemble.ensembles(plan, folder, StudyOptions(plan.where(asked.workers), retry=True, force=asked.force, quiet=asked.quiet), say)


def _written(found: Measurement, folder: Path) -> Result[Measurement]:
    """Write the files of a measurement."""
    own_files.begin(folder, OUTPUTS)
    return Result(found, found.lines, found.warnings, found.write(folder))


def _numbers(text: str | None, option: str, below: float) -> tuple[float, ...] | None:
    """Positive numbers as typed, from large to small, each once.

    Raises:
        InputError: something that is not a number, or out of range.
    """
    if text is None:
        return None
    found = set()
    for word in text.split(","):
        try:
            value = float(word)
        except ValueError:
            raise InputError(option, f'"{word.strip()}" is not a number; write 1e-4,1e-6') from None
        if not 0.0 < value < below:
            raise InputError(option, f"{value:g} should be between 0 and {below:g}")
        found.add(value)
    return tuple(sorted(found, reverse=True))
