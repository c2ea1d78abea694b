"""The friction problem of a step, with all that it was assembled from."""

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

    @property
    def rigid(self) -> np.ndarray:
        """Indices of the contacts that are no springs: the overlap of a spring is the shortening of its joint."""
        return np.arange(len(self.rows.gap)) if self.springs is None else np.flatnonzero(~self.springs.elastic)

    @property
    def rigid_gap(self) -> np.ndarray:
        """Their gaps at q_m [m]."""
        return self.rows.gap if self.springs is None else self.rows.gap[~self.springs.elastic]
