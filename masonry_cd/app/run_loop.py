"""The run loop: step after step, written down as it goes, with a checkpoint now and then to resume from.

A checkpoint is taken whenever ``run.checkpoint_every`` seconds have passed, and at the end. It holds all that later steps depend on, so
when it was taken does not matter: a resumed run gives the same bits as an unbroken one (but for the seconds that steps took).
"""

from __future__ import annotations

import re
import signal
import time as clock
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.app.progress import Interrupted
from masonry_cd.contact.find_joints import joint_parts
from masonry_cd.dynamics.moreau_jean import ENERGIES, RunStopped, Stepper, StepReport
from masonry_cd.dynamics.pauses import Aftermath, Rests, Shock
from masonry_cd.errors import InputError
from masonry_cd.friction.infeasibility import find_jam, named
from masonry_cd.io import checkpoint
from masonry_cd.io.results import BONDED, JOINT_PEAKS, ResultWriter
from masonry_cd.model.joints import JointMeasures, JointPeaks, Joints, measure_joints

DEEP = 0.01  # overlap from which on its blocks are named, as a share of the smallest width
FASTER = 1.5  # times the closing speed that was last looked into: one that is looked into anew
ROWS_AT_ONCE = 256  # steps whose numbers are handed to the writer together
NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")


@dataclass
class RunReport:
    """What a run did, for its closing lines and summary.json."""

    steps: int = 0
    stepping_seconds: float = 0.0
    contacts_mean: float = 0.0
    contacts_max: int = 0
    iterations_mean: float = 0.0
    iterations_max: int = 0
    error_mean: float = 0.0
    error_max: float = 0.0
    steps_as_before: int = 0  # steps that the impulses of the step before solved: no iteration
    steps_missed: int = 0  # steps whose natural map error is above the tolerance
    steps_apart: int = 0  # steps that solved impacts apart from forces
    islands_mean: float = 0.0  # see islands.py
    islands_max: int = 0
    sleeping_mean: float = 0.0  # share of the blocks that slept
    penetration_max: float = 0.0  # [m]
    penetration_where: str = ""  # in words, of one that is DEEP
    steps_closing: int = 0  # steps missed that left a contact closing, so that overlaps grow
    closing_max: float = 0.0  # fastest of them [m/s]
    closing_seen: float = 0.0  # and of those that were looked into [m/s]
    jam: str = ""  # in words, what leaves them no solution; empty where nothing is known to
    energy: dict[str, float] = field(default_factory=dict)  # totals at the end [J]
    balance_max: float = 0.0  # largest |balance| so far [J]
    planar: bool = False
    solver_reasons: dict[str, int] = field(default_factory=dict)  # how often each reason was given, # for its numbers
    left_out: dict[str, int] = field(default_factory=dict)  # of the detection, see there
    stopped: str = ""  # why the run ended early; empty when it did not
    signal: int = 0  # the number of the one that stopped it

    work_max: float = 0.0  # largest work of the base, gravity or forces, or kinetic energy, so far [J]

    @property
    def balance_error(self) -> float:
        """Largest |balance| over the largest work done, or kinetic energy reached."""
        return self.balance_max / self.work_max if self.work_max > 0 else 0.0

    @property
    def lift_share(self) -> float:
        """Work of lifting blocks out of overlaps over the same: energy that the correction of positions puts in, beside the balance."""
        return abs(self.energy.get("correction", 0.0)) / self.work_max if self.work_max > 0 else 0.0

    def look(self, step: StepReport, stepper: Stepper) -> None:
        """Name the blocks of a step that overlap most, and what leaves them no way out."""
        assembly, time, closing = stepper.assembly, stepper.state.time, step.closing
        if step.penetration > max(self.penetration_max, DEEP * stepper.width):
            self.penetration_where = f"{named([assembly.names[b] for b in step.overlapping])} at {time:.4g} s"
        if closing is not None and closing.speed > FASTER * self.closing_seen:
            jam, self.closing_seen = find_jam(closing), closing.speed
            self.jam = self.jam if jam is None else f"{jam.in_words(assembly)} at {time:.4g} s"

    def add(self, step: StepReport, tolerance: float, energy: Mapping[str, float]) -> None:
        """Take in one step and the energies after it."""
        n = self.steps
        self.steps += 1
        self.stepping_seconds += step.seconds
        self.contacts_mean += (step.contacts - self.contacts_mean) / (n + 1)
        self.iterations_mean += (step.iterations - self.iterations_mean) / (n + 1)
        self.error_mean += (step.error - self.error_mean) / (n + 1)
        self.contacts_max = max(self.contacts_max, step.contacts)
        self.iterations_max = max(self.iterations_max, step.iterations)
        self.error_max = max(self.error_max, step.error)
        self.penetration_max = max(self.penetration_max, step.penetration)
        if step.closing is not None:
            self.steps_closing += 1
            self.closing_max = max(self.closing_max, step.closing.speed)
        self.steps_as_before += step.iterations == 0 and step.contacts > 0
        self.steps_missed += not step.error <= tolerance
        self.steps_apart += step.apart
        self.islands_mean += (step.islands - self.islands_mean) / (n + 1)
        self.islands_max = max(self.islands_max, step.islands)
        self.sleeping_mean += (step.sleeping - self.sleeping_mean) / (n + 1)
        kind = NUMBER.sub("#", step.reason)  # like counts with like, and the dict stays small
        self.solver_reasons[kind] = self.solver_reasons.get(kind, 0) + 1
        self.energy = dict(energy)
        works = (abs(energy[name]) for name in ("base_work", "gravity_work", "force_work"))
        self.work_max = max(self.work_max, *works, energy["kinetic"])
        self.balance_max = max(self.balance_max, abs(energy["balance"]))


STEP_FIELDS = (
    "step_time", "load_step", "penetration", "solver/iterations", "solver/error", "solver/seconds", "solver/contacts",
    *(f"energy/{name}" for name in ENERGIES),
)  # fmt: skip
NAME_BYTES = 160  # of a shock, in UTF-8: 40 letters of any script


class Recorder:
    """Writes what the run yields: scalars of every step, frames at the chosen rate, peaks of the joints."""

    def __init__(self, writer: ResultWriter, stepper: Stepper, joints: Joints, shocks: bool = False) -> None:
        self._writer, self._stepper, self._joints = writer, stepper, joints
        self.frames = 0
        self.peaks = JointPeaks(joints)
        self._rows: list[tuple[float, ...]] = []  # of steps, not yet with the writer
        self._tensions: list[np.ndarray] = []  # likewise
        self._joint_of = {(a, b): j for j, (a, b) in enumerate(joint_parts(stepper.assembly).tolist())}
        self._pairs: np.ndarray | None = None
        self._pair_joint = np.empty(0, dtype=np.int64)
        writer.extend({name: np.empty(0) for name in STEP_FIELDS})  # every dataset exists before the first flush
        if len(stepper.tensions):
            writer.extend({"ties/tension": np.empty((0, len(stepper.tensions)))})
        if shocks:
            writer.extend({f"shocks/{name}": rows[:0] for name, rows in self._aftermath(Aftermath("", 0.0, 0.0, 0)).items()})

    def step(self, report: StepReport, load_step: int) -> JointMeasures:
        """Record a step, which applied a step of the loads; return the measures of the joints after it."""
        stepper = self._stepper
        solver = (report.iterations, report.error, report.seconds, report.contacts)
        self._rows.append((stepper.state.time, load_step, report.penetration, *solver, *(stepper.energy[name] for name in ENERGIES)))
        self._tensions.append(stepper.tensions)
        if len(self._rows) == ROWS_AT_ONCE:
            self._hand_over()
        now = measure_joints(self._joints, stepper.assembly, stepper.state)
        self.peaks.update(now, stepper.state.time)
        return now

    def frame(self, now: JointMeasures) -> None:
        """Write the state and the joints."""
        state, writer = self._stepper.state, self._writer
        writer.append({"time": state.time, "position": state.position, "orientation": state.orientation, "velocity": state.velocity})
        writer.append({f"joints/{name}": getattr(now, name) for name in ("opening", "sliding", "rotation", "contact_area")})
        force, point = self._stepper.joint_forces(self._joint_of_pairs(), self._joints.count)
        writer.append({"joints/normal_force": force[0], "joints/shear_force": force[1], "joints/force_point": point})
        if self._stepper.assembly.laws.apex.any():
            writer.append({f"joints/{BONDED}": self._stepper.joint_bonds(self._joint_of_pairs(), self._joints)})
        self.frames += 1

    def shock(self, shock: Aftermath) -> None:
        """Write when a shock acted, the frame at the end of its rest, and the peaks of the joints so far."""
        self._writer.extend({f"shocks/{name}": rows for name, rows in self._aftermath(shock).items()})

    def _aftermath(self, shock: Aftermath) -> dict[str, np.ndarray]:
        """A row of each dataset of /shocks."""
        row: dict[str, Any] = {"start": shock.start, "end": shock.end, "frame": shock.frame}
        row |= {name: getattr(self.peaks, name) for name in JOINT_PEAKS}
        name = np.array([shock.name.encode()], dtype=f"S{NAME_BYTES}")
        return {"name": name} | {key: np.asarray(value)[None] for key, value in row.items()}

    def flushed_rows(self) -> tuple[dict[str, int], str]:
        """Write all that waits, and the peaks, to the disc; return how many rows each dataset now has, and their mark."""
        self.close()
        self._writer.sync()
        return self._writer.rows(), self._writer.mark()

    def close(self) -> None:
        """Write the peaks and what waits in the buffers."""
        self._hand_over()
        self._writer.flush()
        self._writer.write_peaks({name: getattr(self.peaks, name) for name in JOINT_PEAKS})

    def _hand_over(self) -> None:
        """Give the numbers of the last steps to the writer."""
        if self._rows:
            self._writer.extend(dict(zip(STEP_FIELDS, np.array(self._rows).T, strict=True)))
            if len(self._tensions[0]):
                self._writer.extend({"ties/tension": np.array(self._tensions)})
            self._rows.clear()
            self._tensions.clear()

    def _joint_of_pairs(self) -> np.ndarray:
        """The joint of each pair of the detector, -1 for pairs that are none; made anew when the list of pairs is."""
        pairs = self._stepper.detector.pairs
        if pairs is not self._pairs:
            self._pair_joint = np.array([self._joint_of.get((a, b), -1) for a, b in pairs.tolist()], dtype=np.int64)
            self._pairs = pairs
        return self._pair_joint


def run(
    stepper: Stepper,
    joints: Joints,
    writer: ResultWriter,
    steps: int,
    frame_every: int = 1,
    progress: Callable[[int], None] | None = None,
    save_to: Path | None = None,
    resume: bool = False,
    rests: Rests | None = None,
) -> RunReport:
    """Advance to a number of steps of the loads and write the results as they come.

    A run that cannot go on, or whose ``progress`` raises KeyboardInterrupt, ends early: the report says why, and all frames so far
    are kept. Ctrl-C within a step is for the caller to hold back (:class:`masonry_cd.app.progress.Interrupt`): otherwise it ends the run
    without a checkpoint.

    Args:
        stepper: at the start of the run.
        joints: of the stepper's assembly at rest, see :func:`masonry_cd.contact.find_joints.find_joints`.
        writer: of the result file.
        steps: of the loads, how many in all, those before a resumption included.
        frame_every: steps between two frames; the first and the last state are always written.
        progress: called after each step with the number of steps of the loads done.
        save_to: file for checkpoints; None takes none. The last is of the end, for who has more to do with the results.
        resume: go on from the checkpoint in ``save_to``; the writer must come from :meth:`ResultWriter.resumed`.
        rests: of loads that come as shocks in a row: steps of the loads may be left out. None: each step is one of the loads.

    Raises:
        InputError: a checkpoint that is missing, unreadable, or of another scene.
    """
    report, recorder = RunReport(planar=stepper.plane is not None), Recorder(writer, stepper, joints, rests is not None)
    if resume and save_to is not None:
        report = _resumed(save_to, stepper, recorder, rests)
    else:
        recorder.frame(measure_joints(joints, stepper.assembly, stepper.state))
        writer.flush()
    saved, broken = clock.monotonic(), False
    try:
        while stepper.load_step < steps:
            with np.errstate(over="ignore", invalid="ignore"):  # what is not finite stops the run by name
                step = stepper.step()
            before, shock = stepper.load_step - 1, None
            if rests is not None:
                stepper.load_step = rests.next_step(stepper.load_step, stepper.state)
                shock = rests.over(before, stepper.load_step)
            report.look(step, stepper)
            report.add(step, stepper.settings.tolerance, stepper.energy)
            now = recorder.step(step, before + 1)
            if stepper.steps % frame_every == 0 or stepper.load_step == steps or shock is not None:
                recorder.frame(now)
            if shock is not None:
                recorder.shock(_aftermath(shock, before, stepper, recorder.frames - 1))
            if save_to is not None and clock.monotonic() - saved > stepper.settings.checkpoint_every:
                _save(save_to, stepper, recorder, report, rests)
                saved = clock.monotonic()
            if (asked := _asked_to_end(progress, stepper.load_step)) is not None:
                report.stopped, report.signal = f"{asked} after step {report.steps}", asked.number
                break
    except RunStopped as reason:
        report.stopped, broken = str(reason), True
    except BaseException:
        with suppress(Exception):  # one that follows from the error must not hide it
            recorder.close()
        raise
    report.left_out = stepper.detector.left_out
    if save_to is None or broken:
        recorder.close()
    else:
        _save(save_to, stepper, recorder, report, rests)
    return report


def _asked_to_end(progress: Callable[[int], None] | None, done: int) -> Interrupted | None:
    """Tell the steps done; return the interrupt by which that asks for the end. It comes between steps: nothing is torn."""
    try:
        if progress is not None:
            progress(done)
    except Interrupted as asked:
        return asked
    except KeyboardInterrupt:
        return Interrupted(signal.SIGINT)
    return None


def _aftermath(shock: Shock, load_step: int, stepper: Stepper, frame: int) -> Aftermath:
    """A shock whose rest has ended with the step that began at a step of the loads, in the time of the run."""
    skipped, dt = load_step - (stepper.steps - 1), stepper.settings.dt
    return Aftermath(shock.name, (shock.first - skipped) * dt, (shock.last - skipped) * dt, frame)


def _save(path: Path, stepper: Stepper, recorder: Recorder, report: RunReport, rests: Rests | None) -> None:
    """Write the results so far to disk, then a checkpoint that counts their rows."""
    rows, mark = recorder.flushed_rows()
    arrays = stepper.snapshot() | checkpoint.prefixed("peaks", vars(recorder.peaks))
    quiet = 0 if rests is None else rests.quiet
    checkpoint.save(path, arrays, {"report": asdict(report), "rows": rows, "mark": mark, "frames": recorder.frames, "quiet": quiet})


def _resumed(path: Path, stepper: Stepper, recorder: Recorder, rests: Rests | None) -> RunReport:
    """Put the stepper and the peaks where the checkpoint left them, and return the report so far."""
    arrays, numbers = checkpoint.load(path)
    if arrays["position"].shape != stepper.state.position.shape:
        raise InputError(f"{path}: made by another structure ({len(arrays['position'])} blocks); resume with the scene of that run")
    if (numbers["rows"]["step_time"], numbers["rows"]["time"]) != (numbers["report"]["steps"], numbers["frames"]):
        raise InputError(f"{path}: counts other steps than the results beside it hold: it cannot be resumed")
    stepper.restore(arrays)
    vars(recorder.peaks).update(checkpoint.part("peaks", arrays))
    recorder.frames = numbers["frames"]
    if rests is not None:
        rests.quiet = numbers["quiet"]
    report: dict[str, Any] = numbers["report"] | {"stopped": "", "signal": 0}
    return RunReport(**report)
