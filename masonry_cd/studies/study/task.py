# SPDX-License-Identifier: GPL-3.0-or-later
"""One run, as a worker makes it: a scene goes in, a row of numbers comes out.

The row depends on the scene alone, seconds and worker aside. Structures are kept from run to run, since in most studies only the loads
differ. A run ends after the step in which its time is up; watchdog.py ends those that hang. What fails is a row with its reason. For maps
of probability a run leaves arrays of its joints with its row.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import socket
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from masonry_cd.analysis.damage.grades import grade_number
from masonry_cd.analysis.outputs import STUDY, values_in
from masonry_cd.analysis.outputs.measured import Measured
from masonry_cd.analysis.run_row import DONE, FAILED, TIMEOUT, RunRow
from masonry_cd.analysis.verdict import DOUBTFUL
from masonry_cd.app.scene import Scene
from masonry_cd.foundation import own_files
from masonry_cd.foundation.errors import InputError, one_line
from masonry_cd.foundation.quantities import finite
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.model.joints import Joints
from reports.damage import damage_settings

ROWS = "rows"  # folder of a study with what each run came to
RESULTS = "result.h5"
SUMMARIES = ("summary.json", "joints.csv")  # what keep = "summary" keeps
STRUCTURES = 4  # that a worker keeps
SCENE = "scene.toml"


@dataclass(frozen=True)
class Task:
    """A task for a worker."""

    name: str  # of the run
    tables: Mapping[str, Any]  # of its scene
    timeout: float  # of the clock, for its steps [s]
    grace: float = 300.0  # beyond it, for all of the run, before the worker is ended [s]
    keep: str = "none"  # none | summary | all
    folder: str = ""  # of the study, where something is kept
    reference: bool = False  # send the result file back as well
    asks: str = "run"  # or limit


@dataclass(frozen=True)
class Outcome:
    """The answer of a worker."""

    name: str
    row: RunRow
    joints: Mapping[str, Any] | None = None  # arrays by name, of a run that is done
    reference: bytes | None = None  # the result file


Make = Callable[[Task, Path], tuple[RunRow, dict[str, Any] | None]]
"""Makes what a task asks for in a folder: a row, and arrays of joints where it was a run."""


def run_task(task: Task, make: Make | None = None) -> Outcome:
    """Make a run, or what else ``make`` does. Whatever goes wrong in it becomes a row."""
    begin = time.perf_counter()
    with TemporaryDirectory(prefix="masonry-cd-", dir=_scratch()) as scratch:
        folder = Path(scratch) / "run"
        joints, reference = None, None
        try:
            row, joints = (make or (run_scene if task.asks == "run" else _analysed))(task, folder)
            if joints is not None:
                reference = (folder / RESULTS).read_bytes() if task.reference else None
                _keep(task, folder)
        except InputError as error:
            row = RunRow(FAILED, str(error).replace(scratch, ""))
        except MemoryError:
            row = RunRow(FAILED, "not enough memory")
        except Exception as error:  # a defect of the program costs one run, not the study
            row = RunRow(FAILED, one_line(f"{type(error).__name__}: {error}").replace(scratch, ""))
    seconds, worker = time.perf_counter() - begin, f"{socket.gethostname()}:{os.getpid()}"
    return Outcome(task.name, replace(row, seconds=seconds, worker=worker), joints, reference)


def run_scene(task: Task, folder: Path) -> tuple[RunRow, dict[str, Any] | None]:
    """Run the scene; the row, and the arrays of its joints."""
    from masonry_cd.app.case import prepare
    from masonry_cd.app.run_case import run_case
    from masonry_cd.studies.study.checks import scene_of_run

    begin = time.perf_counter()
    scene = scene_of_run(dict(task.tables))
    case = prepare(scene, _structure(task, scene))
    set_up, processor = time.perf_counter() - begin, time.process_time()
    summary = run_case(case, folder, limit=task.timeout, pictures=task.keep == "all")
    ended, processor = time.perf_counter(), time.process_time() - processor
    if summary.timed_out:  # at which step that was says more of the machine than of the run
        return RunRow(TIMEOUT, f"timed out after {task.timeout:g} s"), None
    if summary.stopped:
        return RunRow(FAILED, summary.stopped), None
    found, parts, joints = numbers_of_run(folder / RESULTS, summary, scene)
    timing = {"set_up": set_up, "stepping": summary.stepping_seconds, "closing": time.perf_counter() - ended, "processor": processor}
    verdict = summary.verdict
    doubt = verdict.why if verdict is not None and verdict.verdict == DOUBTFUL else ""
    return RunRow(DONE, numbers=found, parts=parts, timing=timing, doubt=doubt), joints


def _analysed(task: Task, _: Path) -> tuple[RunRow, None]:
    """The row of a limit analysis."""
    from masonry_cd.studies.study.checks import scene_of_run
    from masonry_cd.studies.study.limit_runs import limit_row

    return RunRow(DONE, limit=limit_row(scene_of_run(dict(task.tables)))), None


_structures: dict[str, Any] = {}  # of this worker, by the tables that they are made of


def _structure(task: Task, scene: Any) -> Any:
    """The structure of a task's scene, one that is there already where the tables are the same."""
    from masonry_cd.app.case import structure_of

    made_of = json.dumps([task.tables.get(name) for name in ("structure", "structures", "material", "links")], sort_keys=True, default=str)
    if made_of not in _structures:
        if len(_structures) >= STRUCTURES:
            _structures.pop(next(iter(_structures)))
        _structures[made_of] = structure_of(scene)
    return _structures[made_of]


def _keep(task: Task, folder: Path) -> None:
    """Put what is to be kept of a run into the folder of the study, whole or not at all."""
    if task.keep == "none":
        return
    from masonry_cd.app.scene_text import dump_toml

    if task.keep == "summary":
        for file in folder.iterdir():
            if file.name not in SUMMARIES:
                file.unlink()
    (folder / SCENE).write_text(dump_toml(task.tables), encoding="utf-8")
    own_files.adopt(folder)
    place = Path(task.folder) / "runs" / task.name
    part = place.with_name(f"{task.name}.{os.getpid()}.part")
    part.parent.mkdir(parents=True, exist_ok=True)
    shutil.copytree(folder, part)
    shutil.rmtree(place, ignore_errors=True)
    part.rename(place)


def _scratch() -> str | None:
    """The folder of this worker for files that come and go; that of the machine elsewhere."""
    from distributed import get_worker

    try:
        return str(get_worker().local_directory)
    except ValueError:
        return None


def numbers_of_run(results_file: Path, summary: Summary, scene: Scene) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """The numbers of a run that is done, those of its parts, and its joints' arrays.

    Args:
        results_file: result.h5 of the run.
        summary: that of the run.
        scene: whose ``[report]`` says what counts as damage.

    Returns:
        numbers by the columns of runs.csv, with the residual drift; by part {"grade_number", "drift"}; and
        opening, sliding (J,) float32 [m], the largest over the run, lost (J,) bool, and ``shape``, a digest of the joints at rest.
    """
    with Results.open(results_file) as results:
        run = Measured(results, damage_settings(scene.report), summary)
        found, table = values_in(STUDY, run) | {"residual_drift": finite(run.whole["residual_drift"])}, run.table
        arrays = {
            "opening": table.max_opening.astype(np.float32),
            "sliding": table.max_sliding.astype(np.float32),
            "lost": table.state == "separated",
            "shape": _digest(results.joints),
        }
        rows = run.damage.parts[:-1]
    parts = {row["part"]: {"grade_number": grade_number(row["grade"]), "drift": finite(row["max_drift"])} for row in rows}
    return found, parts, arrays


def _digest(joints: Joints) -> int:
    """A number that joints of the same blocks and corners share."""
    digest = hashlib.sha256()
    for array in (joints.block_a, joints.block_b, joints.polygon_start, joints.polygon):
        digest.update(np.ascontiguousarray(array).tobytes())
    return int.from_bytes(digest.digest()[:7], "little")
