# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps as a run makes them: their length where it adapts, and rests that end early. Who records them is not asked here."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.dynamics.adaptive import AdaptedStep, AdaptiveSteps
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper, StepReport
from masonry_cd.mechanics.dynamics.pauses import Pauses
from masonry_cd.mechanics.model.shocks import Shock


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

    @classmethod
    def of(cls, stepper: Stepper, steps: int, frame_every: int, pauses: Pauses | None) -> Advance:
        """From the beginning of a run."""
        return cls(stepper, steps, frame_every, pauses, AdaptiveSteps(stepper) if stepper.settings.adaptive else None)

    @property
    def done(self) -> bool:
        """Whether all steps of the loads are made."""
        return self.stepper.load_step >= self.steps

    def step(self) -> Advanced:
        """Make a step.

        Raises:
            RunStopped: it cannot end.
        """
        stepper, before, shock = self.stepper, self.stepper.load_step, None
        earlier = stepper.state.velocity
        with np.errstate(over="ignore", invalid="ignore"):  # what is not finite stops the run by name
            adapted = None if self.pace is None else self.pace.step(self._room())
            report = stepper.step() if adapted is None else adapted.report
        applied = stepper.load_step
        if self.pauses is not None:
            stepper.load_step = self.pauses.next_step(applied, stepper.state, applied - before, earlier)
            shock = self.pauses.over(before, stepper.load_step)
        return Advanced(report, adapted, applied, shock)

    def _room(self) -> int:
        """Ticks to the next instant that a step has to end at: a frame, a beginning or end in the loads."""
        now = self.stepper.load_step
        stops = [self.steps] if self.pauses is None else [self.steps, *(stop for stop in self.pauses.stops if stop > now)]
        return min(self.frame_every - self.stepper.motion.ticks % self.frame_every, min(stops) - now)
