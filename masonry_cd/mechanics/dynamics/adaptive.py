# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps of a run whose length adapts: choose one, make it, judge it, and make it again if it has to be.

The rules are in ``step_control.py``, what they judge by in ``local_error.py``. A repeated step begins where it began: blocks,
joints, contacts remembered and energies are put back; only what the solver has learnt about its parameters stays.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.arrays import Stored
from masonry_cd.mechanics.dynamics.local_error import PASSING, VelocityChange, base_drift, fastest, landing_gap, load_variation, step_error
from masonry_cd.mechanics.dynamics.moreau_jean import RunStopped, Stepper, StepReport
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.dynamics.step_control import REPEAT, StepControl
from masonry_cd.mechanics.model.blocks import Assembly

TOLERANCE = 3e-5  # local error aimed at when the scene gives none, as a share of the smallest width of a block


def error_tolerance(settings: Run, assembly: Assembly) -> float:
    """The local error of a step that is aimed at [m]."""
    free_part = ~assembly.fixed[assembly.shapes.part_block]
    return settings.dt_tolerance or TOLERANCE * float(assembly.shapes.size[free_part].min())


class AdaptedStep(NamedTuple):
    """An accepted step, and its cost."""

    report: StepReport  # iterations and seconds with those of the attempts
    span: int  # ticks
    error: float  # local [m]
    repeated_error: int  # attempts undone for their local error
    repeated_solver: int  # and since the solver missed its tolerance
    too_long: bool  # of the shortest length, and yet beyond the tolerance of local errors or missed by the solver


class AdaptiveSteps:
    """Leads a stepper through steps whose length adapts."""

    def __init__(self, stepper: Stepper) -> None:
        settings, system = stepper.settings, stepper.system
        self.stepper, self.control = stepper, StepControl(settings.longest_ticks)
        self.tolerance = error_tolerance(settings, stepper.assembly)
        self.drift = np.zeros(system.loads.support_velocity.shape[1:])  # (S, 3 or 6) of the supports so far, see base_drift
        self.restart()

    def restart(self) -> None:
        """Go on with other blocks or loads: nothing is known of the last step."""
        system = self.stepper.system
        pull = system.loads.acceleration
        self._steady = system.loads.forces is None and bool((pull == pull[0]).all())  # no load but shaking varies
        self._last = VelocityChange(np.zeros((len(system.reach), 6)), np.zeros(3))

    def step(self, room: int) -> AdaptedStep:
        """Make one step of at most ``room`` ticks.

        Raises:
            RunStopped: a velocity is not finite, in a step of one tick.
        """
        stepper, control, repeated = self.stepper, self.control, [0, 0]
        span, seconds, iterations = control.next_span(stepper.motion.ticks, room, self._allows), 0.0, 0
        while True:
            start = stepper.begin_of_step() if span > 1 else None
            before = stepper.motion
            report = self._attempt(span)
            missed = report is None or not report.error <= stepper.settings.accepted
            change = VelocityChange.over(stepper.system, before, stepper.motion)
            error = np.inf if report is None else step_error(stepper.system, change, self._last)
            if report is not None:
                seconds, iterations = seconds + report.seconds, iterations + report.iterations
            shorter = control.judge(span, error / self.tolerance, missed, report is not None and report.apart)
            if report is not None and (start is None or not shorter):
                break
            assert start is not None
            stepper.undo(start)
            repeated[not error > REPEAT * self.tolerance] += 1
            span = shorter
        self._take(change)
        too_long = span == 1 and (missed or error > self.tolerance)
        total = report._replace(seconds=seconds, iterations=iterations)
        return AdaptedStep(total, span, error, repeated[0], repeated[1], too_long)

    def _attempt(self, span: int) -> StepReport | None:
        """Make a step; None where it cannot end, and is longer than the shortest."""
        try:
            return self.stepper.step(span)
        except RunStopped:
            if span == 1:
                raise
            return None

    def _take(self, change: VelocityChange) -> None:
        """Remember the step that stands."""
        stepper = self.stepper
        span = stepper.motion.span
        self._last = change
        self.drift = self.drift + base_drift(stepper.system.loads, stepper.settings.dt, stepper.load_step - span, span)

    def _allows(self, span: int) -> bool:
        """Return True if loads and motion let the next step have a length, see ``local_error.py``."""
        stepper = self.stepper
        system, k, tick = stepper.system, stepper.load_step, stepper.settings.dt
        if k + span >= len(system.loads.acceleration):
            return span == 1
        if span * tick * fastest(system, stepper.motion) > PASSING * system.width:
            return False
        longer = span / stepper.motion.span - 1.0
        if longer > 0.0 and 0.5 * longer * landing_gap(stepper) > self.tolerance:
            return False
        off = stepper.assembly.in_metres(base_drift(system.loads, tick, k, span))
        drift = float(np.sqrt((off**2).sum(axis=1)).max(initial=0.0))
        return drift <= self.tolerance and (self._steady or load_variation(system, k, span) <= self.tolerance)

    def snapshot(self) -> dict[str, np.ndarray]:
        """All that the next step depends on, as arrays for a checkpoint."""
        c = self.control
        own = {"control": np.array([c.span, c.quiet, c.missed], dtype=np.int64), "drift": self.drift}
        return own | {f"last_{name}": array for name, array in self._last._asdict().items()}

    def check(self, stored: Stored) -> None:
        """Check what :meth:`restore` takes.

        Raises:
            InputError: an array that no run of this scene leaves.
        """
        span, _, missed = stored.whole("control", 3, high=2**31).tolist()
        if span not in self.stepper.settings.spans or missed > 1:
            stored.refuse("control", "out of range")
        stored.real("drift", *self.drift.shape)
        stored.real("last_blocks", *self._last.blocks.shape)
        stored.real("last_base", 3)
        stored.check_all_read()

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take back what :meth:`snapshot` gave."""
        span, quiet, missed = arrays["control"].tolist()
        self.control = StepControl(self.control.longest, span, quiet, bool(missed))
        self.drift, self._last = arrays["drift"], VelocityChange(arrays["last_blocks"], arrays["last_base"])
