# SPDX-License-Identifier: GPL-3.0-or-later
"""The friction problem of a step, with all that it was assembled from, its solution, and what the springs of its joints did."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows
from masonry_cd.mechanics.dynamics.free_motion import Prediction
from masonry_cd.mechanics.dynamics.joint_law import LawSprings
from masonry_cd.mechanics.dynamics.system import NO_APPROACH
from masonry_cd.mechanics.friction.problem import FrictionProblem, Solution

if TYPE_CHECKING:
    from masonry_cd.mechanics.dynamics.bonds import Bonds
    from masonry_cd.mechanics.dynamics.linked_bodies import LinkedContacts


class StepProblem(NamedTuple):
    """The friction problem of a step and the C contacts that it is about."""

    predicted: Prediction  # the blocks at q_m
    found: ContactSet  # all contacts there
    rows: ContactRows  # those of the friction problem
    springs: LawSprings | None  # what the laws of elastic and bonded joints make of them; None: all joints are rigid and dry
    problem: FrictionProblem
    start: Solution  # impulses and velocities of the last step, to start from
    crushes: np.ndarray | None = None  # (C,) bool: contacts whose joint crushes in this step; None: no joint can
    approach: np.ndarray = NO_APPROACH  # (N,) see Motion
    bonds: Bonds | None = None  # that soften; None: no joint has such a bond
    links: LinkedContacts | None = None  # the contacts as linked bodies feel them; None: nothing is linked

    @property
    def solved(self) -> FrictionProblem:
        """The problem that is solved for the same impulses: where blocks are linked that of what hangs together."""
        linked = self.predicted.linked
        return self.problem if linked is None or self.links is None else linked.problem(self.links, self.problem)

    def velocity(self, impulse: np.ndarray) -> np.ndarray:
        """v (F, n) of the free blocks after impulses (C, m)."""
        v, linked = self.solved.body_velocity(impulse), self.predicted.linked
        return v if linked is None else self.predicted.v_free + linked.velocity(v)

    def link_impulse(self, impulse: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the link impulses (F, n) [N s, N m s] on free blocks, for contact impulses (C, m) and the new velocities v (F, n)."""
        linked = self.predicted.linked
        assert linked is not None
        by_contacts = self.problem.body_velocity(impulse) - self.predicted.v_free
        return linked.impulse(v - linked.unlinked - by_contacts)

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


class GroundWork(NamedTuple):
    """Work of the ground below footings in a step [J]."""

    base: float = 0.0  # put in by its motion
    before: float = 0.0  # energy of its springs before the step
    after: float = 0.0  # and after it
    radiated: float = 0.0  # taken by its dashpots
    damping: float = 0.0  # left over


class SpringWork(NamedTuple):
    """Work of the springs in a step [J]."""

    taken: float = 0.0  # by elastic contacts from the blocks
    friction: float = 0.0  # of that used up by friction
    after: float = 0.0  # energy of all springs after the step
    before: float = 0.0  # and before it
    bond: float = 0.0  # of what was taken used up by bonds that soften
    crushing: float = 0.0  # of what was taken used up in crushing
    crushed: np.ndarray | None = None  # (N,) by how much joints are shorter for good, at all contacts found [m]; None: none can be
