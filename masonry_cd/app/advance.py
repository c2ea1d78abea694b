# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps as a run makes them: their length where it adapts, and rests that end early. Who records them is not asked here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from masonry_cd.mechanics.dynamics.adaptive import AdaptedStep, AdaptiveSteps
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper, StepReport
from masonry_cd.mechanics.dynamics.pauses import Pauses
from masonry_cd.mechanics.model.shocks import Shock

if TYPE_CHECKING:
    from masonry_cd.app.events import Events


class Advanced(NamedTuple):
    """A step that was made."""

    report: StepReport
    adapted: AdaptedStep | None  # where the time step adapts
    applied: int  # the step of the loads that it came to
    shock: Shock | None  # whose rest is over with it


@dataclass
class Advance:
    """Makes the steps of a run, one after the other."""

    stepper: Stepper
    steps: int  # of the loads, how many in all
    frame_every: int  # ticks between two frames, at each of which a step ends
    pauses: Pauses | None
    pace: AdaptiveSteps | None  # of steps that adapt
    events: Events | None = None  # that change the model
    at_work: bool = False  # in the middle of a step

    @classmethod
    def of(cls, stepper: Stepper, steps: int, frame_every: int, pauses: Pauses | None, events: Events | None = None) -> Advance:
        """From the beginning of a run."""
        return cls(stepper, steps, frame_every, pauses, AdaptiveSteps(stepper) if stepper.settings.is_adaptive else None, events)

    @property
    def done(self) -> bool:
        """Return True if all steps of the loads are made."""
        return self.stepper.load_step >= self.steps

    def step(self) -> Advanced:
        """Make a step.

        Raises:
            RunStopped: it cannot end.
        """
        stepper, before, shock = self.stepper, self.stepper.load_step, None
        if self.events is not None and self.events.before_step():
            self.go_on()
        earlier, self.at_work = stepper.state.velocity, True
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite stops the run by name
            adapted = None if self.pace is None else self.pace.step(self._room())
            report = stepper.step() if adapted is None else adapted.report
        applied, self.at_work = stepper.load_step, False
        if self.events is not None:
            self.events.after_step()
        if self.pauses is not None:
            stepper.load_step = self.pauses.next_step(applied, stepper.state, applied - before, earlier)
            shock = self.pauses.over(before, stepper.load_step)
        return Advanced(report, adapted, applied, shock)

    def go_on(self) -> None:
        """Have all that leads the steps go on with a model that has changed."""
        if self.pace is not None:
            self.pace.restart()
        if self.pauses is not None:
            self.pauses.watch(self.stepper.assembly)

    def _room(self) -> int:
        """Ticks to the next instant that a step has to end at: a frame, a beginning or end in the loads."""
        now = self.stepper.load_step
        stops = [self.steps] if self.pauses is None else [self.steps, *(stop for stop in self.pauses.stops if stop > now)]
        stops += [] if self.events is None else [stop for stop in self.events.stops if stop > now]
        return min(self.frame_every - self.stepper.motion.ticks % self.frame_every, min(stops) - now)
