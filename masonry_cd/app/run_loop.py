# SPDX-License-Identifier: GPL-3.0-or-later
"""The run loop: step after step, written down as it goes, with a checkpoint now and then to resume from.

A checkpoint is taken whenever ``run.checkpoint_every`` seconds have passed, and at the end. It holds all that later steps depend on, so
when it was taken does not matter: a resumed run gives the same bits as an unbroken one (but for the seconds that steps took).
"""

from __future__ import annotations

import math
import signal
import time as clock
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.app.advance import Advance, Advanced
from masonry_cd.app.checkpoint_checks import KeptArrays, check_content
from masonry_cd.app.progress import Interrupted
from masonry_cd.app.recorder import Recorder
from masonry_cd.app.run_report import RunReport
from masonry_cd.foundation.errors import InputError
from masonry_cd.io import checkpoint
from masonry_cd.io.gauges import Gauges
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.mechanics.dynamics.adaptive import AdaptedStep, AdaptiveSteps
from masonry_cd.mechanics.dynamics.moreau_jean import RunStopped, Stepper, StepReport
from masonry_cd.mechanics.dynamics.pauses import Aftermath, Pauses
from masonry_cd.mechanics.dynamics.snapshot import part, prefixed
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import JointMeasures, Joints
from masonry_cd.mechanics.model.shocks import Shock

if TYPE_CHECKING:
    from masonry_cd.app.events import Events


@dataclass(frozen=True)
class RunPlan:
    """How far a run goes, and what it writes."""

    steps: int  # of the loads, how many in all, those before a resumption included
    frame_every: int = 1  # steps of length dt between two frames; the first and the last state are always written
    pauses: Pauses | None = None  # of loads that come as shocks in a row: steps of the loads may be left out
    stress: bool = False  # whether that of blocks and joints is kept
    follow: Callable[[Advance, Advanced], str] | None = None  # called after each step; what it returns as text ends the run
    gauges: Gauges | None = None  # what is kept in every step besides
    events: Events | None = None  # that change the model
    reported: Assembly | None = None  # as results have the blocks; None: the stepper's


@dataclass(frozen=True)
class Checkpoints:
    """The file of a run's checkpoints. The last is of the end, for who has more to do with the results."""

    path: Path
    resume: bool = False  # continue from the checkpoint there; the writer must come from ResultWriter.resumed


def run(
    stepper: Stepper,
    joints: Joints,
    writer: ResultWriter,
    plan: RunPlan,
    progress: Callable[[int], None] | None = None,
    checkpoints: Checkpoints | None = None,
) -> RunReport:
    """Advance to a number of steps of the loads, ticks where the time step adapts, and write the results as they arrive.

    A run that cannot go on, or whose ``progress`` raises KeyboardInterrupt, ends early: the report says why, and all frames so far
    are kept. Ctrl-C within a step is for the caller to hold back (:class:`masonry_cd.app.progress.Interrupt`): otherwise it ends the run
    without a checkpoint.

    Args:
        stepper: at the start of the run.
        joints: of the stepper's assembly at rest, see :func:`masonry_cd.mechanics.contact.find_joints.find_joints`.
        writer: of the result file.
        plan: how far it goes, and what it writes.
        progress: called after each step with the number of steps of the loads done.
        checkpoints: none are taken without.

    Raises:
        InputError: a checkpoint that is missing, unreadable, or of another scene.
    """
    pauses, save_to = plan.pauses, None if checkpoints is None else checkpoints.path
    changes, shocks = plan.events is not None, pauses is not None and pauses.has_shocks
    recorder = Recorder(writer, stepper, joints, shocks, plan.stress, plan.gauges, plan.reported, changes)
    report = RunReport(planar=stepper.plane is not None, fall=_fall(stepper))
    advance = Advance.of(stepper, plan.steps, plan.frame_every, pauses, plan.events)
    loop = _Loop(stepper, recorder, report, advance, save_to, plan.follow)
    if checkpoints is not None and checkpoints.resume:
        loop.resume(checkpoints.path)
    else:
        recorder.write_frame(recorder.now())
        writer.flush()
    try:
        while stepper.load_step < plan.steps and not loop.report.stopped:
            loop.step()
            loop.save_when_due()
            loop.report_progress(progress)
    except RunStopped as reason:
        loop.report.stopped, loop.save_to = str(reason), None  # nothing can go on from here
    except BaseException:
        with suppress(Exception):  # one that follows from the error must not hide it
            recorder.close()
        raise
    loop.end()
    return loop.report


@dataclass
class _Loop:
    """A run on its way."""

    stepper: Stepper
    recorder: Recorder
    report: RunReport
    advance: Advance
    save_to: Path | None
    follow: Callable[[Advance, Advanced], str] | None = None
    saved: float = field(default_factory=clock.monotonic)  # when the last checkpoint was taken [s]

    @property
    def pauses(self) -> Pauses | None:
        return self.advance.pauses

    @property
    def pace(self) -> AdaptiveSteps | None:
        return self.advance.pace

    def step(self) -> None:
        """Make a step and record it; after the last step of the loads, and at the end of a pause, with a frame."""
        stepper, recorder, made = self.stepper, self.recorder, self.advance.step()
        self.report.ended_still = self.advance.done and made.applied < stepper.load_step
        self._account(made.report, made.adapted)
        now = recorder.step(made.report, made.applied)
        if stepper.motion.ticks % self.advance.frame_every == 0 or self.advance.done or made.shock is not None:
            recorder.write_frame(now)
        if made.shock is not None:
            recorder.write_shock(_aftermath(made.shock, made.applied, stepper, recorder.frames - 1))
        if self.follow is not None:
            self.report.stopped = self.follow(self.advance, made)

    def _account(self, step: StepReport, adapted: AdaptedStep | None) -> None:
        """Take a step into the report."""
        stepper = self.stepper
        self.report.look(step, stepper)
        self.report.add(step, stepper.settings.tolerance, stepper.energy, stepper.motion.span)
        if adapted is not None and self.pace is not None:
            self.report.note_adapted(adapted, float(np.sqrt((self.pace.drift**2).sum(axis=1)).max(initial=0.0)))

    def save_when_due(self) -> None:
        """Take a checkpoint if the last one is old enough."""
        if self.save_to is not None and clock.monotonic() - self.saved > self.stepper.settings.checkpoint_every:
            self.save(self.save_to)
            self.saved = clock.monotonic()

    def report_progress(self, progress: Callable[[int], None] | None) -> None:
        """Report the steps done; where the answer is an interrupt, note it. It comes between steps, so nothing is torn."""
        asked = None
        try:
            if progress is not None:
                progress(self.stepper.load_step)
        except Interrupted as interrupted:
            asked = interrupted
        except KeyboardInterrupt:
            asked = Interrupted(signal.SIGINT)
        if asked is not None:
            self.report.stopped, self.report.signal = f"{asked} after step {self.report.steps}", asked.number

    def save(self, path: Path) -> None:
        """Write the results so far to disk, then a checkpoint that counts their rows."""
        rows, mark = self.recorder.flushed_rows()
        arrays = self.stepper.snapshot() | prefixed("peaks", vars(self.recorder.peaks))
        arrays |= prefixed("step_peaks", self.recorder.step_peaks.arrays)
        arrays |= {} if self.recorder.measured.rest is None else prefixed("rest", vars(self.recorder.measured.rest))
        arrays |= {} if self.recorder.stress is None else prefixed("stress", self.recorder.stress.snapshot())
        arrays |= {} if self.pace is None else prefixed("pace", self.pace.snapshot())
        arrays |= {} if self.advance.events is None else prefixed("events", self.advance.events.snapshot())
        numbers = {"report": asdict(self.report), "rows": rows, "mark": mark, "frames": self.recorder.frames}
        checkpoint.save(path, arrays, numbers | {"quiet": 0 if self.pauses is None else self.pauses.quiet})

    def resume(self, path: Path) -> None:
        """Put the stepper, the peaks and the report where a checkpoint left them.

        Raises:
            InputError: it is missing, unreadable, or of another scene.
        """
        arrays, numbers = checkpoint.load(path)
        try:
            kept = KeptArrays(
                self.recorder.blocks,
                len(self.recorder.peaks.opening),
                self.recorder.stress is not None,
                self.recorder.measured.rest is not None,
            )
            check_content(arrays, numbers, self.stepper, kept, self.advance.events)
        except InputError as reason:
            raise reason.under(path) from None
        self.stepper.restore(arrays)
        if self.advance.events is not None:
            self.advance.go_on()
        if self.pace is not None:
            self.pace.restore(part("pace", arrays))
        vars(self.recorder.peaks).update(part("peaks", arrays))
        self.recorder.step_peaks.restore(part("step_peaks", arrays))
        if self.recorder.measured.rest is not None:
            self.recorder.measured.restore(JointMeasures(**part("rest", arrays)))
        if self.recorder.stress is not None:
            self.recorder.stress.restore(part("stress", arrays))
        self.recorder.frames = numbers["frames"]
        if self.pauses is not None:
            self.pauses.quiet = numbers["quiet"]
        self.report = RunReport.read(numbers["report"] | {"stopped": "", "signal": 0})

    def end(self) -> None:
        """Write what is left to write; with a checkpoint for who has more to do with the results."""
        self.report.left_out = self.stepper.detector.left_out
        if self.save_to is None:
            self.recorder.close()
        else:
            self.save(self.save_to)


def _fall(stepper: Stepper) -> float:
    """The energy that a step of free fall, of length dt, would give to all free blocks [J]."""
    speed = math.hypot(*stepper.settings.gravity) * stepper.settings.dt
    return 0.5 * float(stepper.assembly.mass[~stepper.assembly.fixed].sum()) * speed * speed


def _aftermath(shock: Shock, applied: int, stepper: Stepper, frame: int) -> Aftermath:
    """A shock whose rest has ended with the step that came to a step of the loads, in the time of the run."""
    skipped, dt = applied - stepper.motion.ticks, stepper.settings.dt
    return Aftermath(shock.name, (shock.first - skipped) * dt, (shock.last - skipped) * dt, frame)
