# SPDX-License-Identifier: GPL-3.0-or-later
"""The rest after the loads of a run: the base stands still and forces keep their last values, until the structure is still.

The loads of a run of N steps are laid out over N + R, R the longest rest; the run loop leaves the rest early as it does those between
shocks (:mod:`masonry_cd.mechanics.dynamics.pauses`). The time for which the blocks have to be still counts from before step N where
nothing changes there: a run that is still at the end of its duration gets no step more.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from masonry_cd.mechanics.model.shocks import Pause

if TYPE_CHECKING:
    from loads import Loading

AFTER = "the loads"  # what such a rest comes after, as text
MOVING = 1e-3  # share of its largest speed above which the base counts as moving at the end of the loads


def base_moves_at_end(loading: Loading) -> bool:
    """Return True if a motion of the base is cut short by the end of the run, so that no rest can follow."""
    velocity = loading.support_velocity
    return bool(np.abs(velocity[-1]).max(initial=0.0) > MOVING * np.abs(velocity).max(initial=0.0))


def with_rest(loading: Loading, longest: int, speed: float, hold: int) -> Loading:
    """The loads followed by a rest of ``longest`` steps, which ends early once the blocks move slower than ``speed`` [m/s].

    Args:
        loading: of N steps, at whose end the base stands still.
        longest: R.
        speed: below which the structure counts as still [m/s].
        hold: steps that it has to be.
    """
    steps = len(loading.acceleration) - 1
    if longest < 1 or any(pause.last == steps for pause in loading.pauses):  # a sequence has a rest of its own at its end
        return loading
    velocity = np.pad(loading.support_velocity, ((0, longest), (0, 0), (0, 0)))
    acceleration = np.pad(loading.acceleration, ((0, longest), (0, 0)), mode="edge")
    forces = None if loading.forces is None else loading.forces.extended(longest)
    first = max(_steady_from(loading), steps - hold)
    pause = Pause(min(first, steps), steps + longest, speed, hold, AFTER)
    return replace(loading, support_velocity=velocity, acceleration=acceleration, forces=forces, pauses=(*loading.pauses, pause))


def _steady_from(loading: Loading) -> int:
    """The first step from which on nothing changes until the end of the loads."""
    steps = len(loading.acceleration) - 1
    moving = np.flatnonzero(loading.support_velocity.any(axis=(1, 2)))
    pulling = np.flatnonzero((loading.acceleration != loading.acceleration[-1]).any(axis=1))
    factors = [] if loading.forces is None else [load.factor for load in loading.forces.points]
    pushing = [np.flatnonzero(factor != factor[-1]) for factor in factors]
    return min(steps, 1 + max((int(found[-1]) for found in (moving, pulling, *pushing) if len(found)), default=-1))
