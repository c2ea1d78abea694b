# SPDX-License-Identifier: GPL-3.0-or-later
"""A prepared case becomes results: the steps, result.h5 as they go, then damage, summary and pictures."""

from __future__ import annotations

import math
import os
import shutil
import signal
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from masonry_cd.app import time_step_checks
from masonry_cd.app.advance import Advance, Advanced
from masonry_cd.app.bed_checks import beds
from masonry_cd.app.beginning import begin as begin_run
from masonry_cd.app.beginning import events_of, pauses_of, stepper_of
from masonry_cd.app.case import Case
from masonry_cd.app.checkpoint_checks import KeptArrays, check_content
from masonry_cd.app.closing_lines import run_warnings
from masonry_cd.app.dump import Dump
from masonry_cd.app.explain import left_out
from masonry_cd.app.folders import is_run, names_of_run
from masonry_cd.app.inputs import digests, require_same
from masonry_cd.app.load_factor import outcome, tie_bars
from masonry_cd.app.per_step import QUANTITIES
from masonry_cd.app.progress import Interrupt, Progress, TimedOut
from masonry_cd.app.run_loop import Checkpoints, RunPlan
from masonry_cd.app.run_loop import run as run_steps
from masonry_cd.app.run_report import RunReport
from masonry_cd.app.summary import loads_acted, run_summary, tolerances
from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import part_of
from masonry_cd.foundation.errors import InputError
from masonry_cd.io import checkpoint
from masonry_cd.io.block_arrays import Meshes
from masonry_cd.io.lock import locked
from masonry_cd.io.result_writer import ResultWriter, require_rows
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.dynamics.equilibrium import settles
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import histories
from masonry_cd.mechanics.model.joints import Joints
from reports.files import known_files

if TYPE_CHECKING:
    from masonry_cd.app.events import Events

RESULTS = "result.h5"


def file_names() -> tuple[str, ...]:
    """Names of all files that a run may leave in its folder, crack maps at times and problems apart."""
    return tuple(known_files())


def run_case(
    case: Case,
    folder: Path,
    quiet: bool = True,
    resume: bool = False,
    dump: Sequence[int] = (),
    limit: float = math.inf,
    own: Own | None = None,
    pictures: bool = True,
) -> Summary:
    """Run a case and write everything into a folder, which is created if missing.

    Args:
        case: from :func:`prepare`.
        folder: for the results.
        quiet: no progress.
        resume: go on from the folder's checkpoint, with the scene that it was made by.
        dump: steps whose friction problems are written, see :mod:`masonry_cd.app.dump`.
        limit: the run ends after the step in which this time of the clock has passed since its first [s].
        own: of code that steps the case itself; such a run takes no checkpoints.
        pictures: draw the histories of its gauges.

    Ctrl-C, SIGTERM, SIGHUP and SIGQUIT end the run after its step; once the steps are done they raise Interrupted, and ``resume``
    finishes what was left to write.

    Raises:
        InputError: with ``resume``, a folder without a checkpoint or with one of another scene; a step to dump that the run does not make;
            a folder that another run writes into; results that do not fit on its disc.

    Returns:
        the summary; its ``stopped`` says why the run ended early, empty when it did not, ``signal`` the number of the signal that ended
        it, and ``timed_out`` that the limit did.
    """
    begin = time.perf_counter()
    scene = case.scene
    own_files.check(folder, names_of_run(), is_run)
    saved, dumped = folder / checkpoint.NAME, Dump(folder, dump)
    stepper = stepper_of(case) if own is None else own.stepper
    _check_disk_space(case, stepper, folder, resume)
    if not resume:
        dumped.check(1, case.steps)
        if own is None:
            begin_run(stepper, case)
    events = _events_of(case, stepper, own)
    with locked(folder), Interrupt() as interrupt:
        repaired = ""
        if resume:
            own_files.begin(folder, names_of_run(), is_run)
            repaired = _chosen(case, stepper, folder / RESULTS, saved, events)
            dumped.check(checkpoint.load(saved)[1]["report"]["steps"] + 1, case.steps)
        else:
            _clear(folder)
        stepper.watch = dumped if dump else None
        since = case.seconds - begin
        with _writer(case, folder / RESULTS, saved, resume) as writer:
            watch = _Watch(interrupt, limit)
            report = _steps(case, stepper, writer, saved, watch, quiet, resume, own, events)
            summary = run_summary(case, report) | Summary(
                events=() if events is None else events.rows(),
                timed_out=watch.timed_out,
                dumped=tuple(path.name for path in dumped.written),
                explanation=tuple(left_out(scene, stepper, report)),
                warnings=(*([repaired] if repaired else []), *case.warnings, *dumped.warnings()),
            )
            if own is not None and own.note:
                summary |= Summary(python=own.note)
            summary = _closing(case, writer, summary, since)
        interrupt.at_once = not report.signal  # from here on nothing is torn
        summary = _write_damage(case, folder, summary, since, pictures)
        if not report.stopped or report.signal == signal.SIGINT:  # who pressed Ctrl-C looks on; a second one ends the drawing
            interrupt.at_once = True
            summary = _write_asked(case, folder, summary, since)
        if not report.stopped:
            checkpoint.remove(saved)
        interrupt.at_once = False
    return summary


def _events_of(case: Case, stepper: Stepper, own: Own | None) -> Events | None:
    """Those of a run whose model may change."""
    if own is not None:
        return own.events
    return events_of(case, stepper) if case.events else None


class Own(NamedTuple):
    """Forces, laws and solvers of code that steps a case itself."""

    stepper: Stepper  # at its beginning
    follow: Callable[[Advance, Advanced], str]  # called after each step; what it returns as text ends the run
    note: str = ""  # for the summary, where the scene alone does not repeat the run
    events: Events | None = None  # and changes of the model


class _Watch:
    """Ends a run between two steps: for a signal, or when its time is up."""

    def __init__(self, interrupt: Interrupt, limit: float) -> None:
        self._interrupt, self._limit, self._end = interrupt, limit, time.perf_counter() + limit
        self.timed_out = False

    def check(self) -> None:
        self._interrupt.check()
        self.timed_out = time.perf_counter() > self._end
        if self.timed_out:
            raise TimedOut(self._limit)


def _steps(
    case: Case,
    stepper: Stepper,
    writer: ResultWriter,
    saved: Path,
    watch: _Watch,
    quiet: bool,
    resume: bool,
    own: Own | None,
    events: Events | None,
) -> RunReport:
    """Make the steps of a run and write result.h5."""
    scene, settings = case.scene, case.scene.run
    show = Progress(settings.steps, quiet, tick=settings.dt if settings.is_adaptive else None)

    def progress(done: int) -> None:
        show(done)
        watch.check()

    with show:
        return run_steps(
            stepper,
            case.joints,
            writer,
            RunPlan(
                case.steps,
                settings.frame_every,
                pauses_of(case),
                stress=scene.stress,
                gauges=case.gauges,
                follow=None if own is None else own.follow,
                events=events,
                reported=case.reported,
            ),
            progress,
            Checkpoints(saved, resume=resume) if own is None else None,
        )


def _write_damage(case: Case, folder: Path, summary: Summary, since: float, pictures: bool = True) -> Summary:
    """Write joints.csv and summary.json; return the summary, whose seconds count from a reading of the clock."""
    from reports import damage as damage_files

    with Results.open(folder / RESULTS) as results:
        summary |= damage_files.write_joint_damage(results, folder, case.scene.report)
        if results.gauges.any:
            from reports.laboratory import write_laboratory

            summary |= write_laboratory(results, folder, pictures)
    summary |= Summary(wall_seconds=since + time.perf_counter())
    summary.write(folder)  # before the pictures, which may fail for want of a library
    return summary


def _write_asked(case: Case, folder: Path, summary: Summary, since: float) -> Summary:
    """Write the tables, pictures and the page that the scene asks for; return the summary with what they add."""
    if case.scene.report.asks or case.scene.stress:
        from reports import outputs

        with Results.open(folder / RESULTS) as results:
            summary = outputs.write_asked(results, folder, case.scene.report, summary)
        summary |= Summary(wall_seconds=since + time.perf_counter())
        summary.write(folder)
    return summary


def _closing(case: Case, writer: ResultWriter, summary: Summary, since: float) -> Summary:
    """Complete the summary but for the damage, and write it into the results, from which ``report`` can write it if a kill comes."""
    from masonry_cd.analysis.damage.joint_damage import displacement_max
    from masonry_cd.analysis.pushover import push_numbers, push_warnings

    settings = case.scene.run
    with Results.open(writer.path, sums=False) as results:
        summary |= outcome(case, results) | Summary(
            displacement_max=displacement_max(results),
            solver=summary.solver.model_copy(update=tolerances(case, results)),
            loads=summary.loads.model_copy(update={"acted": loads_acted(case, results)}),
        )
        fast = time_step_checks.after_run(case.assembly, results, settings.dt)
        gravity = math.hypot(*settings.gravity)
        of_beds = beds(case.assembly, results)
        restless = time_step_checks.restless(results, case.loading.pauses, gravity, settings.longest_step, settings.tolerance)
        pushed = push_warnings(push_numbers(results))
    summary |= Summary() if of_beds is None else Summary(beds=of_beds)
    summary |= Summary(
        warnings=(*pushed, *run_warnings(summary), *summary.warnings, *fast, *restless),
        doubts=(*pushed, *case.doubts, *restless),
        time_step_remarks=(*case.coarse, *fast),
        wall_seconds=since + time.perf_counter(),
    )
    writer.write_closing(summary)
    return summary


def _check_disk_space(case: Case, stepper: Stepper, folder: Path, resume: bool) -> None:
    """Refuse results that do not fit on the disc."""
    settings, file, meshes = case.scene.run, folder / RESULTS, Meshes.of(case.assembly, stepper.system.strains)
    of_meshes, frames = 0 if meshes is None else meshes.numbers, case.steps // settings.frame_every + 2
    needed = result_bytes(case.assembly, case.joints, frames, case.steps, case.scene.stress, of_meshes)
    with case.scene.locating():
        check_disc_space(folder, needed, float(file.stat().st_size) if resume and file.exists() else 0.0)


def _clear(folder: Path) -> None:
    """Take away what a former run left in a folder."""
    own_files.begin(folder, names_of_run(), is_run)
    own_files.remove(folder, names_of_run())
    for name in file_names():
        part_of(folder / name).unlink(missing_ok=True)
    saved = folder / checkpoint.NAME
    checkpoint.remove(saved)
    for growing in (folder / RESULTS, saved, checkpoint.before(saved)):
        own_files.note(growing, growing=True)


def _writer(case: Case, file: Path, saved: Path, resume: bool) -> ResultWriter:
    """The writer of a new result file, or of one that is resumed."""
    if not resume:
        place = os.path.relpath(case.scene.path, file.parent)
        return ResultWriter(
            file,
            case.reported,
            case.joints,
            case.scene.text,
            case.scene.title,
            digests(case),
            place,
            tie_bars(case),
            case.gauges,
            case.fills,
        )
    numbers = checkpoint.load(saved)[1]
    return ResultWriter.resumed(file, numbers["rows"], numbers["mark"], sums=False)


NUMBER = 8  # bytes
OF_BLOCK = 3 + 4 + 6  # numbers of a frame: position, orientation, velocity
OF_STRAIN = 9  # those of its gradient, where blocks deform
OF_STRESS = (6, 2)  # numbers of a frame: of a block, and of a joint
OF_SUPPORT = 6  # numbers of a frame: force and moment
OF_JOINT = 6 + 3 + 3  # numbers of a frame: six histories, the force and its place, see io/results.py; and those of their laws


def result_bytes(assembly: Assembly, joints: Joints, frames: int, steps: int, stress: bool = False, of_meshes: int = 0) -> float:
    """About how large result.h5 will be, its ties and shocks apart [B].

    ``stress``: it keeps stress; ``of_meshes``: numbers of a frame that meshed blocks then have as well, in single precision.
    """
    of_block = OF_BLOCK + (0 if assembly.deformation is None else OF_STRAIN)
    frame = 1 + of_block * assembly.count + (OF_JOINT + len(histories(assembly.laws))) * joints.count
    frame += OF_SUPPORT * int(assembly.fixed.sum())
    frame += (OF_STRESS[0] * assembly.count + OF_STRESS[1] * joints.count) * stress
    return float(NUMBER) * ((frame + 0.5 * of_meshes * stress) * frames + len(QUANTITIES) * steps)


def check_disc_space(folder: Path, needed: float, there: float = 0.0) -> None:
    """Refuse a run whose results do not fit on the disc.

    Args:
        folder: for the results; it need not exist.
        needed: of the results in all [B].
        there: what the folder holds of them already [B].

    Raises:
        InputError: names what is needed and what is free.
    """
    place = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    free = float(shutil.disk_usage(place).free)
    if needed - there > free:
        raise InputError(
            "run.frames_per_second",
            f"the results would take about {needed / 1e9:.3g} GB, {free / 1e9:.3g} GB are free where {folder} lies; "
            "fewer frames, larger steps or a shorter run take less",
        )


def _chosen(case: Case, stepper: Stepper, results: Path, saved: Path, events: Events | None) -> str:
    """Put the last checkpoint that can be gone on from in its place; return a line where it is not the last that was taken, or "".

    Args:
        case: as it is now.
        stepper: at its start.
        results: of the run.
        saved: the last checkpoint.

    Raises:
        InputError: other inputs than those of the results, or no checkpoint that can be gone on from. Nothing is changed.
    """
    with Results.open(results) as found:
        if found.scene != case.scene.text:
            raise InputError(results, "these results come from another scene; resume with the same scene file and the same --set")
        require_same(digests(case), found.inputs, results)

        def fits(arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> None:
            kept = KeptArrays(case.reported.blocks, case.joints.count, case.scene.stress, events is not None or settles(case.assembly))
            check_content(arrays, numbers, stepper, kept, events)
            require_rows(found, numbers["rows"], numbers["mark"])

        return checkpoint.repair(saved, fits)
