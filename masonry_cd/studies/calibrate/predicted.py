# SPDX-License-Identifier: GPL-3.0-or-later
"""The predictions of a sample for the observations, as a worker makes them: one modal analysis, and a run where some need it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.calibration.observations import MODAL, Observation
from masonry_cd.analysis.run_row import DONE, RunRow
from masonry_cd.app.scene import Scene
from masonry_cd.studies.study.task import RESULTS, Outcome, Task, run_scene, run_task

PREDICTED = "predicted"  # key of a row
History = tuple[np.ndarray, np.ndarray]  # times [s] and values


@dataclass(frozen=True)
class ObservedValues:
    """The observations, and what their files hold."""

    observations: tuple[Observation, ...]
    modal: Mapping[str, Any]  # options of the modal analysis
    files: Mapping[str, str] = field(default_factory=dict)  # of measured modes, by the observation's title: where they lie
    histories: Mapping[str, History] = field(default_factory=dict)  # measured, likewise

    @property
    def runs(self) -> bool:
        """True where something needs a run."""
        return any(one.what not in MODAL for one in self.observations)


def calibrate_task(wanted: ObservedValues, task: Task) -> Outcome:
    """Make a sample."""
    return replace(run_task(task, partial(_make, wanted)), joints=None)


def _make(wanted: ObservedValues, task: Task, folder: Path) -> tuple[RunRow, dict[str, Any] | None]:
    """The row of a sample, with what it predicts by the observations' titles."""
    from masonry_cd.studies.study.checks import scene_of_run

    scene = scene_of_run(dict(task.tables))
    found = modal_values(wanted, scene)
    row, joints = run_scene(task, folder) if wanted.runs else (RunRow(DONE), None)
    if row.done and wanted.runs:
        found |= values_of_run(wanted, folder / RESULTS, row, scene)
    return replace(row, numbers={**row.numbers, PREDICTED: found}), joints


def modal_values(wanted: ObservedValues, scene: Scene) -> dict[str, float | None]:
    """Frequencies [Hz] and 1 - MAC of a scene; one modal analysis for each file of measured modes, and one for what needs none."""
    from masonry_cd.app.commands.modal import modal

    found: dict[str, float | None] = {}
    asked = [one for one in wanted.observations if one.what in MODAL]
    for file in dict.fromkeys(wanted.files.get(one.title) for one in asked):
        of = [one for one in asked if wanted.files.get(one.title) == file]
        count = max([int(wanted.modal.get("modes", 6)), *(one.mode or 0 for one in of)])
        options = {**wanted.modal, "modes": count} | ({} if file is None else {"reference": file})
        model = modal(scene, options).value["models"][wanted.modal["method"]]
        found |= {one.title: _of_modes(one, model) for one in of}
    return found


def _of_modes(one: Observation, model: Mapping[str, Any]) -> float | None:
    """A frequency [Hz] or 1 - MAC; None where no mode answers to the measured one."""
    if one.modes is None:
        k = int(np.argmax(model["participation"][one.direction])) if one.direction else (one.mode or 1) - 1
        return float(model["frequency_hz"][k]) if k < len(model["frequency_hz"]) else None
    pair = next(pair for pair in model["measured"] if pair["measured_mode"] == one.mode)
    if one.what == "frequency":
        return pair["computed_hz"]
    return None if pair["mac"] is None else 1.0 - pair["mac"]


def values_of_run(wanted: ObservedValues, file: Path, row: RunRow, scene: Scene) -> dict[str, float | None]:
    """The values that a run came to, by the titles of the observations of runs."""
    from masonry_cd.analysis.damage.joint_damage import fallen
    from masonry_cd.analysis.gauge_histories import gauge_histories
    from masonry_cd.io.results import Results
    from reports.damage import damage_settings

    found: dict[str, float | None] = {}
    with Results.open(file, sums=False) as results:
        gauges = gauge_histories(results)
        down = dict(zip((block.name for block in results.blocks), fallen(results, damage_settings(scene.report).thresholds), strict=True))
        for one in wanted.observations:
            if one.what == "quantity":
                value = row.number(one.quantity or "")
                found[one.title] = None if value is None else float(value)
            elif one.what == "fallen":
                found[one.title] = float(sum(down[name] for name in one.blocks or ()))
            elif one.what not in MODAL:
                found[one.title] = _of_gauge(one, gauges[one.gauge or ""], wanted.histories.get(one.title))
    return found


def _of_gauge(one: Observation, columns: Mapping[str, np.ndarray], measured: History | None) -> float | None:
    """A value of a gauge, 1 of a joint that is open and 0 of another, or the relative RMS of a history; None beyond the end of the run."""
    values = columns[one.column or "opening"]
    if measured is not None:
        time, history = measured
        if time[-1] > columns["time"][-1]:
            return None
        away = np.interp(time, columns["time"], values) - history
        return float(np.sqrt(np.sum(away**2) / np.sum(history**2)))
    value = float(np.abs(values).max()) if one.at == "largest" else float(values[-1])
    return float(value > one.above) if one.what == "open" else value
