# SPDX-License-Identifier: GPL-3.0-or-later
"""A run as asked becomes a scene, and gets its name: the digest of that scene and of the files that it reads.

Drawing is not part of it, nor is where files lie, so a study may be moved. What a run costs is guessed by its number of steps.
Other commands that make an ensemble of one scene make a study of it.
"""

from __future__ import annotations

import copy
import hashlib
import json
import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from masonry_cd.analysis.fragility.limits import LimitState
from masonry_cd.analysis.run_row import RunRow
from masonry_cd.app.inputs import file_digests
from masonry_cd.app.scene import Scene, scene_of
from masonry_cd.app.scene_text import assign, dump_toml
from masonry_cd.app.scene_units import scene_in_si
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.adaptive import AdaptiveStripes
from masonry_cd.studies.study.clusters import RunPlace, require_slurm
from masonry_cd.studies.study.designs import DESIGNS, DesignedRun, Space, next_level
from masonry_cd.studies.study.study_file import EnsembleTable, ReadStudy, RunTable, StudyTables
from masonry_cd.studies.study.study_units import ROTATE
from masonry_cd.studies.study.varied import Varied

THRESHOLDS = ("opened", "slid", "grades")  # keys of [report] that change the numbers of a run
NAME_LENGTH = 16  # hexadecimal digits of a run's name: two of a million runs share one with a chance of 3e-8
# of ensembles that another command makes of a scene
SIZE = 1e-9  # by which amplitudes of neighbouring members of an ensemble differ, relative; [m/s] of velocities in their place
TIMEOUT = 6 * 3600.0  # of a run [s]: small blocks and half a time step take several times as long as the scene itself
OWN_DRAW = ("velocities", "friction")  # what members differ by, instead of loads that have no size


@dataclass(frozen=True, slots=True)
class Planned:
    """A run of the plan."""

    name: str
    asked: DesignedRun
    weight: float  # steps of the loads


class Maker:
    """Makes scenes of what a design asks for."""

    def __init__(self, study: ReadStudy, space: Space) -> None:
        self.study, self.space = study, space
        self._base = _base_tables(study)
        self._digests: dict[str, str] = {}

    def base(self) -> dict[str, Any]:
        """The tables of the scene before anything varies; paths in it are absolute."""
        tables = copy.deepcopy(self._base)
        _make_absolute(tables, self.study.scene.folder)
        return tables

    def tables(self, asked: DesignedRun) -> dict[str, Any]:
        """The tables of a run's scene; paths in it are absolute.

        Raises:
            InputError: a key that the scene cannot have, or a motion that no factor brings to its level.
        """
        tables = copy.deepcopy(self._base)
        for key, value in asked.values.items():
            if key != ROTATE:
                _assign(tables, f'vary."{key}"', key, value)
        self._shake(tables, asked)
        if asked.change:
            self._perturb(tables, asked)
        _make_absolute(tables, self.study.scene.folder)
        return tables

    def planned(self, asked: DesignedRun) -> Planned:
        """The run with its name.

        Raises:
            InputError: a scene without [run].
        """
        self.study.scene.refuse_static()
        tables = self.tables(asked)
        run = tables["run"]
        step = run.get("dt") if isinstance(run.get("dt"), float) else 1.0
        return Planned(self.name(tables), asked, float(run.get("duration", 1.0)) / step)

    def name(self, tables: Mapping[str, Any]) -> str:
        """The digest of a scene."""
        unread = {"title"} if self.study.tables.asks == "limit" else {"title", "hazard"}
        plain = copy.deepcopy({key: value for key, value in tables.items() if key not in unread})
        plain["report"] = {key: value for key, value in plain.get("report", {}).items() if key in THRESHOLDS}
        plain["until_still"] = self.study.scene.until_still
        _replace_paths(plain, self._digest)
        return hashlib.sha256(json.dumps(plain, sort_keys=True, default=str).encode()).hexdigest()[:NAME_LENGTH]

    def measures(self, asked: DesignedRun) -> dict[str, float]:
        """The intensity measures of a run, by their columns."""
        records, intensity = self.space.records, self.study.tables.intensity
        if records is None or records.table.key is not None:
            return {intensity.measure: asked.level} if intensity is not None and asked.level is not None else {}
        motion, degrees = self.space.motion(asked.motion), self._degrees(asked)
        return records.scaled(motion, degrees, records.factor(motion, degrees, asked.level), asked.level)

    def _shake(self, tables: dict[str, Any], asked: DesignedRun) -> None:
        """Put the motion and its level into the scene."""
        records, intensity = self.space.records, self.study.tables.intensity
        if intensity is not None and intensity.key is not None and asked.level is not None:
            _assign(tables, "intensity.key", intensity.key, asked.level)
        if records is None:
            return
        motion = self.space.motion(asked.motion)
        if records.table.key is not None:
            _assign(tables, "records.key", records.table.key, motion.value)
            return
        degrees = self._degrees(asked)
        factor = records.factor(motion, degrees, asked.level)
        tables["loads"] = [*tables.get("loads", []), *records.loads(motion, degrees, factor)]
        if records.table.duration == "record":
            tables["run"]["duration"] = motion.duration + records.table.rest

    def _perturb(self, tables: dict[str, Any], asked: DesignedRun) -> None:
        """Make the scene that of a member of an ensemble."""
        ensemble = self.study.tables.ensemble or EnsembleTable()
        if ensemble.perturb == "velocities":
            assert asked.member is not None
            set_in_motion(tables, ensemble.size, asked.member)
        else:
            perturb(tables, ensemble.perturb, asked.change)

    def _degrees(self, asked: DesignedRun) -> float:
        """Return the angle by which the horizontal pair is turned [degrees]."""
        assert self.space.records is not None
        return float(asked.values.get(ROTATE, self.space.records.table.rotate))

    def _digest(self, path: str) -> str:
        """SHA-256 of a file, with those that it lists."""
        if path not in self._digests:
            self._digests[path] = " ".join(file_digests([{"path": path}], Path("/")).values())
        return self._digests[path]


class StudyPlan:
    """The runs of a study: those known from the first, and those that follow from others that are done.

    Args:
        maker: of their scenes.
        asked: the runs, of a ``design`` of its own; those of the study's design when not given. The longest are then made first, so that
            no core waits for another at the end.
        design: what the folder calls it.
    """

    def __init__(self, maker: Maker, asked: Iterable[DesignedRun] | None = None, design: str = "") -> None:
        self.maker, self._study = maker, maker.study
        self.design = design or maker.study.tables.design
        table = self._study.tables.adaptive
        self.adaptive = None if table is None else AdaptiveStripes(maker.space, table)
        self._longest_first = asked is not None
        if asked is None:
            asked = DESIGNS[self.design](maker.space) if self.adaptive is None else self.adaptive.first()
        self.runs: list[Planned] = [maker.planned(one) for one in asked]
        self._found: dict[tuple[str, str], dict[float, bool | None]] = {}  # by motion and what varies: collapsed, by level

    def where(self, workers: int | None = None, scheduler: str | None = None, slurm: Path | None = None) -> RunPlace:
        """Where the runs are made: as asked, or else as the study says.

        Raises:
            InputError: more than one place is requested, no worker, or no jobs of Slurm can be submitted.
        """
        if (workers is not None) + (scheduler is not None) + (slurm is not None) > 1:
            raise InputError("workers, scheduler and slurm", "they exclude each other; give one of them")
        if workers is not None and workers < 1:
            raise InputError("workers", f"should be 1 or more, got {workers}")
        if slurm is not None:
            require_slurm(slurm)
        run = self._study.tables.run
        return RunPlace(scheduler, slurm, workers or run.workers, run.memory, run.timeout + run.grace)

    @property
    def line(self) -> str:
        """How many runs there are, as text."""
        more = ", and those that follow" if self.adapts else ""
        return f"{self._study.title}: {len(self.runs)} runs{more}, design {self.design}"

    @property
    def adapts(self) -> bool:
        """Return True if runs follow from others."""
        return self._study.tables.ida is not None or self.adaptive is not None

    def after(self, planned: Planned, row: RunRow) -> Iterator[Planned]:
        """The runs that follow from one that has ended; they become part of the plan."""
        tables = self._study.tables
        table = tables.ida or tables.adaptive
        if table is None:
            return
        exceeded = LimitState.of(table.limit_state, tables.limit_states[table.limit_state]).exceeded_by(row)
        for asked in self._hunted(planned.asked, exceeded) if self.adaptive is None else self.adaptive.after(planned.asked, exceeded):
            following = self.maker.planned(asked)
            self.runs.append(following)
            yield following

    def _hunted(self, asked: DesignedRun, exceeded: bool | None) -> list[DesignedRun]:
        """The next run of an IDA's motion, if there is one."""
        table = self._study.tables.ida
        assert table is not None and asked.level is not None
        found = self._found.setdefault((asked.motion, repr(sorted(asked.values.items()))), {})
        found[asked.level] = exceeded
        level = next_level(table, found)
        return [] if level is None else [DesignedRun(asked.motion, level, values=asked.values)]

    def shuffled(self, runs: Sequence[Planned]) -> list[Planned]:
        """Runs in the order in which they are made: a random one, so that those that are done stand for the others."""
        if self._longest_first:
            return sorted(runs, key=lambda run: -run.weight)
        made = list(runs)
        random.Random(self.maker.study.tables.seed).shuffle(made)
        return made

    def ordered(self) -> list[Planned]:
        """All runs in the order of the table: as the design lists them; where runs follow from others by motion, then level."""
        if not self.adapts:
            return self.runs
        place = {name: i for i, name in enumerate(self.maker.space.motions)}
        return sorted(self.runs, key=lambda run: (place[run.asked.motion], repr(sorted(run.asked.values.items())), run.asked.level or 0.0))


def _base_tables(study: ReadStudy) -> dict[str, Any]:
    """The tables of the scene with what all runs have in common.

    Raises:
        InputError: the scene ends at a time of its own, and the motions at others.
    """
    base, given = copy.deepcopy(study.scene_tables), study.scene.run
    report = base.get("report", {})
    if study.tables.run.keep != "all":  # nothing is drawn that nobody sees
        graded = {"damage": True} if study.scene.until_still and given.until_still is None else {}
        report = {key: value for key, value in report.items() if key in THRESHOLDS} | graded
    records = study.tables.records
    if given.longest is not None and records is not None and records.folder is not None and records.duration == "record":
        raise InputError(
            "records.duration", 'the scene gives run.longest, and every motion has a duration of its own; duration = "scene" keeps it'
        )
    base |= {"report": report, "run": base["run"] | {"threads": 1, "checkpoint_every": 1e9}}
    base.setdefault("title", study.scene.title)
    return base


def _assign(tables: dict[str, Any], where: str, key: str, value: Any) -> None:
    """Give a key of the scene a value."""
    try:
        assign(tables, key, copy.deepcopy(value))
    except InputError as error:
        raise error.under(where) from None


def _make_absolute(tables: dict[str, Any], folder: Path) -> None:
    """Write the paths of files in full, so that a scene may lie anywhere."""
    _replace_paths(tables, lambda path: str((folder / path).resolve()))


def _replace_paths(table: Any, by: Callable[[str], str]) -> None:
    """Put something instead of the paths of files, in place, tables within tables included."""
    if isinstance(table, list):
        for item in table:
            _replace_paths(item, by)
    elif isinstance(table, dict):
        for key, value in table.items():
            if key == "path" and isinstance(value, str):
                table[key] = by(value)
            else:
                _replace_paths(value, by)


def set_in_motion(tables: dict[str, Any], size: float, member: int) -> None:
    """Have the blocks begin with velocities of at most ``size`` in each direction [m/s], those of a member, in place."""
    tables["run"]["first_velocities"] = {"size": size, "seed": member}


def perturb(tables: dict[str, Any], what: str, change: float) -> None:
    """Multiply the size of all motions of the base, or the friction, by 1 + change, in place.

    Raises:
        InputError: no load of the scene has a size that can be changed.
    """
    if what == "friction":
        material = tables["material"]
        material["friction"] = _times(material.get("friction"), 1.0 + change)
        return
    from loads import KINDS, kind_of

    given = tables.get("loads", [])
    grown = [None if (kind := kind_of(load)) is None else kind.grown for load in given]
    tables["loads"] = [load if grow is None else grow(load, 1.0 + change) for load, grow in zip(given, grown, strict=True)]
    if not any(grown):
        kinds = ", ".join(name for name, kind in KINDS.items() if kind.grown is not None)
        raise InputError("ensemble.perturb", f'no load is one of {kinds}; perturb = "friction" or "velocities" is for any scene')


def _times(friction: Any, factor: float) -> Any:
    """Friction, a number or one for each pair of groups, times a factor."""
    if isinstance(friction, dict):
        return {pair: _times(value, factor) for pair, value in friction.items()}
    if friction is None:
        raise InputError("ensemble.perturb", "the scene gives no material.friction")
    return float(friction) * factor


def tables_of(scene: Scene) -> dict[str, Any]:
    """The tables of a scene as numbers, without what only an assessment reads.

    Raises:
        InputError: a scene without [run].
    """
    scene.refuse_static()
    with scene.locating():
        tables = scene_in_si(scene.tables)
    tables.pop("assess", None)
    return tables


def space_of(scene: Scene, tables: dict[str, Any]) -> tuple[ReadStudy, Space]:
    """The study of a scene and its tables, and what its runs choose from: nothing by itself."""
    own = replace(scene_of(tables, scene.text, scene.path, scene.origin), quiet_checks=scene.quiet_checks)
    ensemble = EnsembleTable(perturb=_perturbs(tables), size=SIZE)
    top = StudyTables(scene=tables, design="ensemble", title=scene.title, ensemble=ensemble, run=RunTable(timeout=TIMEOUT))
    study = ReadStudy(scene.path, dump_toml(tables), top, own, tables, scene.path.name, Varied({}, {}, []), scene.origin)
    return study, Space(top, None, study.varied)


def _perturbs(tables: dict[str, Any]) -> Any:
    """The quantity by which members of an ensemble differ: the loads where they have a size, else first velocities, else friction."""
    try:
        perturb(copy.deepcopy(tables), "loads", SIZE)
    except InputError:
        return OWN_DRAW["first_velocities" in tables["run"]]
    return "loads"
