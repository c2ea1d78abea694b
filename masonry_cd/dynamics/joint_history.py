"""Springs and bonds of elastic and mortar joints over a run: into the friction problem of each step, and out of its solution again.

The law is told in ``elastic``. What a joint hands on from step to step is its elastic slip and whether it is still bonded.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.contact.detector import ContactSet
from masonry_cd.contact.joints import Joints
from masonry_cd.dynamics import joint_law
from masonry_cd.friction.problem import FrictionProblem
from masonry_cd.model.blocks import Assembly

CREEP = 1e-6  # slip and opening below this share of g h count as none when bonds are judged


@dataclass(eq=False)
class Springs:
    """The contacts of a friction problem whose law goes by area; C contacts with m rows each."""

    area: np.ndarray  # (C,) [m2], that of mirror images in a plane included
    elastic: np.ndarray  # (C,) bool
    bonded: np.ndarray  # (C,) bool: intact in this step
    bond: np.ndarray  # (C,) h tau A of intact contacts, else 0 [N s]
    slip: np.ndarray  # (C, m - 1) elastic slip s^0 in the contact frame [m]
    before: np.ndarray  # (C, m) relative velocity u at the beginning of the step [m/s]

    @classmethod
    def none(cls, contacts: int, rows: int) -> Springs:
        """Contacts that are rigid and dry."""
        off = np.zeros(contacts, dtype=np.bool_)
        return cls(np.zeros(contacts), off, off.copy(), np.zeros(contacts), np.zeros((contacts, rows - 1)), np.zeros((contacts, rows)))

    @property
    def whole(self) -> np.ndarray:
        """(C,) bool: the law holds for the impulse of the whole step, that of an impact included."""
        return self.elastic | self.bonded


@dataclass(frozen=True, eq=False)
class Touching:
    """What the laws of joints ask of the contacts of a step, and of the motion of the supports."""

    found: ContactSet
    chosen: np.ndarray  # (C,) those of the friction problem
    frames: np.ndarray  # (C, 3, 3) rows n, t1, t2
    rotation: np.ndarray  # (B, 3, 3) of the blocks at q_m
    mirror: tuple[int, float]  # axis and place of the plane of a planar scene; -1: none
    closed: float  # gaps up to this one are none [m]
    before: np.ndarray  # (S, 3) velocities of the supports at the beginning of the step [m/s]
    after: np.ndarray  # (S, 3) at its end


class JointSprings:
    """The springs and bonds of the joints of an assembly; ``memory`` arrays are over all contacts of the last set, one entry at least."""

    def __init__(self, assembly: Assembly, rows: int) -> None:
        self._assembly = assembly
        self._laws = joint_law.law_arrays(assembly.laws) if assembly.laws.by_area.any() else None
        self.stretch = assembly.laws.stretch  # by which a joint may open and still be bonded [m]
        self.now = Springs.none(0, rows)  # of the friction problem of the step
        self.slip = np.zeros((1, 3))  # elastic slip in the frame of the antagonist [m]
        self.bonded = np.zeros(1, dtype=np.bool_)

    @property
    def any(self) -> bool:
        """Whether a joint is elastic or bonded."""
        return self._laws is not None

    def load(self, problem: FrictionProblem, at: Touching, v: np.ndarray, bonding: float, step: float) -> FrictionProblem:
        """The problem with springs and bonds, from one of rigid contacts.

        Args:
            problem: of the step.
            at: its contacts.
            v: (B, n) velocities of the last step.
            bonding: gaps up to which new contacts are bonded; negative after the start [m].
            step: h [s].
        """
        self.now = Springs.none(problem.contacts, problem.dimension)
        if self._laws is None:
            return problem
        a, s, found = self._assembly, self.now, at.found
        compliance, offset = problem.compliance.copy(), problem.offset.copy()
        joint_law.spring_rows(
            self._laws, at.chosen, found.bodies, a.group_of, found.point, found.gap, found.area, found.previous, at.frames, *at.mirror,
            at.closed, bonding, self.slip, self.bonded, at.rotation, problem.bodies, problem.jacobian, v, at.before, at.after,
            a.support_of, step,
            compliance, offset, s.area, s.elastic, s.bonded, s.bond, s.slip, s.before,
        )  # fmt: skip
        return replace(problem, compliance=compliance, offset=offset)

    def unload(self, problem: FrictionProblem, at: Touching, v: np.ndarray, impulse: np.ndarray, still: float, step: float) -> np.ndarray:
        """Carry slips and bonds over the step; return its work.

        Args:
            problem: of the step, with springs.
            at: its contacts.
            v: (B, n) velocities at the end of the step.
            impulse: (C, m) of the step.
            still: speed of the largest fall in it [m/s], or of what the solver leaves undone.
            step: h [s].

        Returns:
            (4,) what elastic contacts took from the blocks, what of that friction used up, and the energy of all springs after and before
            the step [J].
        """
        work = np.zeros(4)
        if self._laws is None:
            return work
        a, s, found, count = self._assembly, self.now, at.found, max(1, at.found.count)
        self.slip, self.bonded = np.zeros((count, 3)), np.zeros(count, dtype=np.bool_)
        joint_law.spring_update(
            self._laws, at.chosen, found.bodies, a.group_of, found.pair, found.gap, at.frames, at.rotation, problem.bodies,
            problem.jacobian, v, problem.offset, problem.compliance, problem.mu, impulse, at.after, a.support_of, step, still, s.area,
            s.elastic, s.bonded, s.bond, s.slip, s.before,
            self.slip, self.bonded, work,
        )  # fmt: skip
        return work

    def bonded_shares(self, chosen: np.ndarray, pair: np.ndarray, pair_joint: np.ndarray, joints: Joints) -> np.ndarray:
        """Share of the area of each joint that is bonded, (J,).

        Args:
            chosen: contacts of the friction problem.
            pair: of all contacts of the last set.
            pair_joint: the joint of each pair or -1.
            joints: of the assembly.
        """
        whole = np.zeros(joints.count)
        joint_law.bonded_area(chosen, pair, pair_joint, self.now.area, self.bonded, whole)
        return np.minimum(1.0, whole / joints.area)

    def begin_from(self, other: JointSprings) -> None:
        """Take over what the springs of the same joints under other laws came to."""
        self.now, self.slip, self.bonded = other.now, other.slip, other.bonded

    def snapshot(self) -> dict[str, np.ndarray]:
        """All that goes from step to step, as arrays for a checkpoint."""
        return {"slip": self.slip, "bonded": self.bonded}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Take back what :meth:`snapshot` gave."""
        self.slip, self.bonded = arrays["slip"], arrays["bonded"]


def pretensioned(problem: FrictionProblem, bond: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Free velocity (B, n) and offset (C, m) of the problem in the impulses p + h tau A n, whose cones begin at zero."""
    pull = np.zeros_like(problem.offset)
    pull[:, 0] = bond
    return problem.body_velocity(-pull), problem.offset - problem.compliance * pull
