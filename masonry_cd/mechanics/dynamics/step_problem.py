# SPDX-License-Identifier: GPL-3.0-or-later
"""The friction problem of a step, with all that it was assembled from, its solution, and what the springs of its joints did."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows
from masonry_cd.mechanics.dynamics.free_motion import Prediction
from masonry_cd.mechanics.dynamics.joint_law import Springs
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution


class StepProblem(NamedTuple):
    """The friction problem of a step and the C contacts that it is about."""

    predicted: Prediction  # the blocks at q_m
    found: ContactSet  # all contacts there
    rows: ContactRows  # those of the friction problem
    springs: Springs | None  # what the laws of elastic and bonded joints make of them; None: all joints are rigid and dry
    problem: FrictionProblem
    start: Solution  # impulses and velocities of the last step, to start from
    crushes: np.ndarray | None = None  # (C,) bool: contacts whose joint crushes in this step; None: no joint can

    @property
    def rigid(self) -> np.ndarray:
        """Indices of the contacts that are no springs: the overlap of a spring is the shortening of its joint."""
        return np.arange(len(self.rows.gap)) if self.springs is None else np.flatnonzero(~self.springs.elastic)

    @property
    def rigid_gap(self) -> np.ndarray:
        """Their gaps at q_m [m]."""
        return self.rows.gap if self.springs is None else self.rows.gap[~self.springs.elastic]


class Solved(NamedTuple):
    """The solution of the friction problem of a step."""

    solution: Solution
    error: float  # natural map error
    carried_impulse: np.ndarray | None = None  # (F, n) for the next step; None: no impacts were solved apart
    blow: np.ndarray | None = None  # (C, m) of the impulses, those of the impacts, likewise [N s]


class SpringWork(NamedTuple):
    """What the springs of a step did [J]."""

    taken: float = 0.0  # by elastic contacts from the blocks
    friction: float = 0.0  # of that used up by friction
    after: float = 0.0  # energy of all springs after the step
    before: float = 0.0  # and before it
    crushing: float = 0.0  # of what was taken used up in crushing
    crushed: np.ndarray | None = None  # (N,) by how much joints are shorter for good, at all contacts found [m]; None: none can be
