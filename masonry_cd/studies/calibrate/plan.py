# SPDX-License-Identifier: GPL-3.0-or-later
"""A study file with ``[[observations]]`` becomes a calibration: what is unknown, what is observed, and the run of each sample."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from loads.readers.source import Request, Source
from loads.readers.tables import read_csv
from masonry_cd.analysis.calibration.observations import MISFITS, Observation
from masonry_cd.analysis.modal.measured_modes import read_measured
from masonry_cd.app.case import prepare
from masonry_cd.app.commands.modal import ModalOptions
from masonry_cd.app.scene_units import unit_of_key
from masonry_cd.foundation.errors import InputError, parse_table, suggest, values_in_si
from masonry_cd.studies.calibrate.predicted import History, ObservedValues, modal_values
from masonry_cd.studies.study.checks import check_first, scene_of_run
from masonry_cd.studies.study.designs import DesignedRun, Space, placed
from masonry_cd.studies.study.plan import Maker, StudyPlan
from masonry_cd.studies.study.study_case import space_of_study
from masonry_cd.studies.study.study_file import CalibrationTable, ReadStudy
from masonry_cd.studies.study.study_units import ROTATE

DESIGN = "calibrate"
MOTION, LEVEL = "motion", "level"  # unknowns that are no keys of the scene
PGA, PERIOD = "PGA", "period"  # of records, measured
OPTIONS = ("method", "poisson", "mesh_size", "restraint", "modes")  # of the modal analysis


@dataclass(frozen=True, eq=False)
class Calibration:
    """A calibration whose study is checked."""

    maker: Maker
    wanted: ObservedValues
    places: np.ndarray  # (d,) coordinates of the unit cube that are unknown; the others choose from one

    @classmethod
    def of(cls, study: ReadStudy) -> Calibration:
        """The calibration of a study file.

        Raises:
            InputError: another design, wrong observations, and what is wrong with any study.
        """
        with study.locating():
            if study.tables.design != DESIGN:
                raise InputError("design", f'is "{study.tables.design}", and a calibration has "{DESIGN}"')
            study, wanted = _with_gauges(study, _wanted(study))
        space = space_of_study(study)
        return cls(Maker(study, space), wanted, _unknown(space))

    @property
    def table(self) -> CalibrationTable:
        """How far it is sampled."""
        return self.maker.study.tables.calibration or CalibrationTable()

    @property
    def samples(self) -> int:
        """Number of samples of a round."""
        return self.maker.study.tables.samples or 1

    @property
    def line(self) -> str:
        """Describe how many samples there are at most."""
        table, observations = self.table, self.wanted.observations
        known = sum(one.known for one in observations)
        runs = "a run" if self.wanted.runs else "a modal analysis"
        return (
            f"{self.maker.study.title}: {len(self.places)} unknowns, {known} observations, {len(observations) - known} more predicted; "
            f"at most {table.rounds} rounds of {self.samples} samples, {runs} each"
        )

    def asked(self, u: np.ndarray) -> DesignedRun:
        """The run at a point of the cube of the unknowns (d,)."""
        whole = np.full(len(self.maker.space.varied.columns) + 2, 0.5)
        whole[self.places] = u
        return placed(self.maker.space, whole)

    def unknowns(self, asked: list[DesignedRun]) -> dict[str, list[Any]]:
        """The values of all unknowns in some runs, by key of the scene, motion and level."""
        space = self.maker.space
        found = {key: [one.values[key] for one in asked] for key in space.varied.columns}
        found |= {MOTION: [one.motion for one in asked]} if len(space.motions) > 1 else {}
        return found | ({LEVEL: [one.level for one in asked]} if len(space.levels) > 1 else {})

    def measured(self, asked: list[DesignedRun]) -> dict[str, list[float]]:
        """PGA [m/s2] and period 2 pi PGV / PGA [s] of the motions of some runs, where these are records."""
        records = self.maker.space.records
        if records is None or records.table.key is not None or not ({MOTION, LEVEL, ROTATE} & self.unknowns(asked).keys()):
            return {}
        every = [self.maker.measures(one) for one in asked]
        return {PGA: [one["PGA"] for one in every], PERIOD: [2.0 * math.pi * one["PGV"] / one["PGA"] for one in every]}

    @property
    def motion(self) -> tuple[str, str] | None:
        """The numbers of the motion that are drawn across and up a map: of loads the first two that are unknown, but for directions."""
        if self.measured([self.asked(np.full(len(self.places), 0.5))]):
            return PERIOD, PGA
        keys = [key for key in self.maker.space.varied.random if key.startswith("loads[") and not key.endswith(".direction")]
        return (keys[1], keys[0]) if len(keys) > 1 else None

    def units(self) -> dict[str, str]:
        """The units of keys that have one."""
        tables = self.maker.study.scene.tables
        own = {key: "degrees" if key == ROTATE else unit_of_key(tables, key) for key in self.maker.space.varied.columns}
        return own | {PGA: "m/s2", PERIOD: "s"}

    def check(self, plan: StudyPlan) -> tuple[str, ...]:
        """Prepare the first sample as a worker would.

        Returns:
            what its run would warn of.

        Raises:
            InputError: a gauge, block or mode that an observation names and that is not there, and what is wrong with any run.
        """
        study = self.maker.study
        scene = scene_of_run(self.maker.tables(plan.runs[0].asked), study.path)
        try:
            made = modal_values(self.wanted, scene)
        except InputError as error:
            raise InputError(study.path, f"the first sample: {error.unsourced()}") from None
        gauges, blocks = _there(scene) if self.wanted.runs else ({}, [])
        with study.locating():
            for i, one in enumerate(self.wanted.observations):
                _check(one, f"observations[{i}]", gauges, blocks)
                if made.get(one.title, 0.0) is None:
                    raise InputError(f"observations[{i}].mode", f"no mode of the model answers to mode {one.mode}; raise modal.modes")
        return check_first(plan) if self.wanted.runs else ()


def _wanted(study: ReadStudy) -> ObservedValues:
    """The observations with what their files hold."""
    given = {"method": "joints", **study.tables.modal}
    options = parse_table(ModalOptions, given, "modal")
    for key in options.model_fields_set - {*OPTIONS}:
        raise InputError(f"modal.{key}", f"does not apply to a calibration; of modal it takes {', '.join(OPTIONS)}")
    if options.method == "both":
        raise InputError("modal.method", 'should be "joints" or "continuum"')
    observations: list[Observation] = []
    files, histories = dict[str, str](), dict[str, History]()
    for i, one in enumerate(study.tables.observations):
        where = f"observations[{i}]"
        if one.title in (other.title for other in observations):
            raise InputError(f"{where}.name", f'"{one.title}" is another one, too; give each a name of its own')
        if one.modes is not None:
            files[one.title] = str((study.folder / one.modes).resolve())
        if one.file is not None:
            histories[one.title] = _history(study.folder / one.file, one, f"{where}.file")
        value = 0.0 if one.what in MISFITS else one.value if one.modes is None else _measured(files[one.title], one.mode, where)
        observations.append(one.model_copy(update={"value": value, "name": one.title}))
    return ObservedValues(tuple(observations), options.model_dump(include={*OPTIONS}), files, histories)


def _measured(path: str, mode: int | None, where: str) -> float:
    """The frequency of a measured mode [Hz]."""
    known = {one.mode: one.frequency for one in read_measured(path)}
    if mode not in known:
        raise InputError(f"{where}.mode", f"{path} has no mode {mode}; modes: {', '.join(map(str, known))}")
    return known[mode]


def _history(path: Path, one: Observation, where: str) -> History:
    """A measured history, in the unit of its column."""
    from masonry_cd.analysis.gauge_histories import unit_of_column

    with_unit = read_csv(Source.open(path, f"{where}: {one.file}"), Request())
    if with_unit.unit is None:
        raise InputError(where, f'{one.file}: its heading should say the unit, "{one.column} [mm]"')
    factor = float(values_in_si(f"1 {with_unit.unit}", lambda: unit_of_column(one.column or ""), where))
    values = factor * with_unit.values
    if not values.any():
        raise InputError(where, f"{one.file}: nothing but zeros")
    return with_unit.origin + with_unit.step * np.arange(len(values)), values


def _with_gauges(study: ReadStudy, wanted: ObservedValues) -> tuple[ReadStudy, ObservedValues]:
    """A joint that an observation names by its blocks becomes a gauge of the scene."""
    tables, made = copy.deepcopy(study.scene_tables), []
    for i, one in enumerate(wanted.observations):
        if one.joint is None:
            made.append(one)
            continue
        made.append(one.model_copy(update={"gauge": f"observed {i + 1}", "joint": None}))
        tables.setdefault("output", {}).setdefault("joint", []).append({"blocks": list(one.joint), "name": f"observed {i + 1}"})
    return replace(study, scene_tables=tables), replace(wanted, observations=tuple(made))


def _there(scene: Any) -> tuple[dict[str, tuple[str, ...]], list[str]]:
    """The gauges of a scene with their columns, and the names of its blocks."""
    from masonry_cd.analysis.gauge_histories import columns_of

    case = prepare(scene)
    return columns_of(case.gauges), [block.name for block in case.assembly.blocks]


def _check(one: Observation, where: str, gauges: dict[str, tuple[str, ...]], blocks: list[str]) -> None:
    """Check that a gauge with its column, or blocks, are there."""
    if one.gauge is not None:
        if one.gauge not in gauges:
            raise InputError(f"{where}.gauge", f'"{one.gauge}" is not a gauge of [output]{suggest(one.gauge, gauges)}')
        if (one.column or "opening") not in gauges[one.gauge]:
            raise InputError(f"{where}.column", f"the gauge {one.gauge} has {', '.join(gauges[one.gauge])}")
    for name in one.blocks or ():
        if name not in blocks:
            raise InputError(f"{where}.blocks", f'"{name}" is not a block{suggest(name, blocks)}')


def _unknown(space: Space) -> np.ndarray:
    """Coordinates of the cube that choose from more than one value, and follow no other."""
    varied = space.varied
    keys = [k for k in range(len(varied.keys)) if k not in varied.follow]
    lists = [len(varied.keys) + k for k, values in enumerate(varied.lists.values()) if len(values) > 1]
    last = len(varied.columns) + np.flatnonzero([len(space.motions) > 1, len(space.levels) > 1])
    return np.array([*keys, *lists, *last], dtype=np.int64)
