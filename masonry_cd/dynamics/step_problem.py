"""The friction problem of a step, with all that it was assembled from."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from masonry_cd.contact.detector import ContactSet
from masonry_cd.dynamics.contact_arrays import ContactRows
from masonry_cd.dynamics.free_motion import Prediction
from masonry_cd.dynamics.joint_law import Springs
from masonry_cd.friction.problem import FrictionProblem, Solution


@dataclass(frozen=True, eq=False)
class StepProblem:
    """The friction problem of a step and the C contacts that it is about."""

    predicted: Prediction  # the blocks at q_m
    found: ContactSet  # all contacts there
    rows: ContactRows  # those of the friction problem
    springs: Springs  # what the laws of elastic and bonded joints make of them
    problem: FrictionProblem
    start: Solution  # impulses and velocities of the last step, to start from

    @property
    def active(self) -> np.ndarray:
        """(C,) places of the problem's contacts among those found."""
        return self.rows.active

    @cached_property
    def gap(self) -> np.ndarray:
        """(C,) gaps at q_m [m]."""
        return self.found.gap[self.rows.active]

    @property
    def pair(self) -> np.ndarray:
        """(C,) which pair of parts each contact belongs to."""
        return self.found.pair[self.rows.active]

    @cached_property
    def rigid(self) -> np.ndarray:
        """Indices of the contacts that are no springs: the overlap of a spring is the shortening of its joint."""
        return np.flatnonzero(~self.springs.elastic)

    @cached_property
    def rigid_gap(self) -> np.ndarray:
        """Their gaps at q_m [m]."""
        return self.gap[self.rigid] if len(self.rigid) < len(self.gap) else self.gap
