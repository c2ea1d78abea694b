# SPDX-License-Identifier: GPL-3.0-or-later
r"""The local error of a step, and what is known of it beforehand; lengths in metres.

**Of a step made.** Over a step the positions follow (v + v+) h / 2. With the acceleration a = (v+ - v) / h of the step and a' of the one
before, the explicit extrapolation q + h v + h^2 a' / 2 is off by

    h^2 / 2 |a - a'|       ~ h^3 in a smooth motion (six times the error of the trapezoidal rule), h |jump| / 2 at an impact,

for each block |v| + R |w|, with R the distance of its farthest corner. A block that sticks to the base is exact with respect to it, one
that flies is exact in space: the smaller of the two counts. The error of the step is the root mean square over the free blocks.

**Of a step to come.** Supports follow the trapezoidal rule through the velocities of their motion at the ends of the step, which are
exact: so the step gets the whole momentum of the record whatever its length, and no acceleration within it is lost. What differs is the
displacement, by D - h (V + V+) / 2, D being that over ticks; of supports that turn, at their farthest corner. A body force or a point load
enters by its mean; one that varies within the step by da about it moves a block by up to h^2 da / 8 otherwise. Both stay below the
tolerance, and no block moves by more than PASSING of the smallest width.

**A longer step after this one.** A contact whose gap g closes over a step of length h is to land at the next q_m; if the next step has
the length r h, the two have moved on by (r - 1) g / 2 then, into one another. That too stays below the tolerance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.system import MotionState, RunLoads, System

PASSING = 0.25  # share of the smallest width of any block by which none may move in one step


class VelocityChange(NamedTuple):
    """How velocities changed over a step."""

    blocks: np.ndarray  # (F, 6) of the free blocks [m/s2, rad/s2]
    base: np.ndarray  # (3,) of the first support [m/s2]

    @classmethod
    def over(cls, system: System, before: MotionState, after: MotionState) -> VelocityChange:
        """Return the change over a step between two motions."""
        h = system.constants.step
        rate = (after.state.velocity - before.state.velocity) / h
        base = rate[system.support, :3] if system.support >= 0 else np.zeros(3)
        return cls(rate[system.free], base)


def step_error(system: System, change: VelocityChange, last: VelocityChange) -> float:
    """Local error of a step from its accelerations and those of the step before, see the head of this file [m]."""
    h = system.constants.step
    difference = change.blocks - last.blocks
    turning = system.reach * np.sqrt((difference[:, 3:] ** 2).sum(axis=1))
    in_space = (difference[:, :3] ** 2).sum(axis=1)
    with_base = ((difference[:, :3] - (change.base - last.base)) ** 2).sum(axis=1)
    error = np.sqrt(np.minimum(in_space, with_base)) + turning
    return 0.5 * h * h * float(np.sqrt(np.mean(error**2)))


def landing_gap(stepper: Stepper) -> float:
    """The largest gap of a rigid contact that the last step closes: one with an impulse [m]."""
    if stepper.last is None:
        return 0.0
    rigid = stepper.last.rigid
    hit = stepper.solution.impulse[rigid, 0] > 0.0
    return float(stepper.last.rows.gap[rigid][hit].max(initial=0.0))


def base_drift(loads: RunLoads, tick: float, k: int, span: int) -> np.ndarray:
    """How far supports are off after a step of ``span`` ticks from t_k on, (S, 3 or 6): over ticks less in one [m, rad]."""
    v = loads.support_velocity[k : k + span + 1]
    ends = v[0] + v[-1]
    return np.asarray(tick * (v.sum(axis=0) - 0.5 * ends - 0.5 * span * ends))


def load_variation(system: System, k: int, span: int) -> float:
    """Largest displacement by which what acts within a step differs from its mean, see the head of this file [m]."""
    loads, h = system.loads, span * system.settings.dt
    during = loads.acceleration[k + 1 : k + span + 1]
    spread = float(np.sqrt(((during - during.mean(axis=0)) ** 2).sum(axis=1)).max())
    if loads.forces is not None:
        spread += float(loads.forces.spread(k + 1, span, system.assembly))
    return spread * h * h / 8.0


def fastest(system: System, motion: MotionState) -> float:
    """The largest speed of a free block relative to the first support [m/s]."""
    velocity = motion.state.velocity[:, :3]
    relative = velocity[system.free] - (velocity[system.support] if system.support >= 0 else 0.0)
    return float(np.sqrt((relative**2).sum(axis=1).max(initial=0.0)))
