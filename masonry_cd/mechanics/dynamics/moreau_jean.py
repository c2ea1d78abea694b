# SPDX-License-Identifier: GPL-3.0-or-later
r"""The Moreau-Jean step.

One step of length h from (q, v) to (q+, v+), theta in [1/2, 1] (Jean, Comput. Methods Appl. Mech. Engrg. 177, 1999):

    predict    q_m    = q + h (1 - theta) v                             supports moved as prescribed             free_motion.py
               v_free = v + h M^-1 f(q_m, v)                            gravity, point loads, ties
    detect     contacts, their frames and gaps g at q_m                                                          contact/
    assemble   u = H v + b                                              relative velocities of the contacts      contact_rows.py
    solve      M v+ = M v_free + H^T p,   0 <= u_n + max(g, 0)/h  _|_  p_n >= 0,
               |p_t| <= mu p_n, opposed to the slip                     impacts apart from forces                solving.py
    update     q+     = q_m + h theta v+                                overlaps corrected at position level     new_state.py, overlaps.py
    account    work and losses, and what the step leaves of the contact laws                                     energy.py, violations.py

The gap enters the law over the step, so a block that lands stops where it lands, with perfectly plastic impact. Contacts of elastic joints
are springs instead, see ``joint_law.py``: there an overlap is the shortening of the joint.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.arrays import Stored
from masonry_cd.foundation.freed_memory import keep_freed_memory
from masonry_cd.foundation.kernel_store import clock
from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.contact.faults import ContactFault
from masonry_cd.mechanics.dynamics import joint_forces
from masonry_cd.mechanics.dynamics.bonds import check_bonds
from masonry_cd.mechanics.dynamics.contact_rows import assemble
from masonry_cd.mechanics.dynamics.crushing import solve_crushing
from masonry_cd.mechanics.dynamics.driving import Driven, guided, measured
from masonry_cd.mechanics.dynamics.energy import account, at_start
from masonry_cd.mechanics.dynamics.energy_terms import ENERGIES
from masonry_cd.mechanics.dynamics.free_motion import Prediction, angular_momenta, predict
from masonry_cd.mechanics.dynamics.islands import Islands
from masonry_cd.mechanics.dynamics.jams import Closing
from masonry_cd.mechanics.dynamics.joint_history import bonded_shares, bonding_gap, largest_by_joint
from masonry_cd.mechanics.dynamics.new_state import RunStopped, update
from masonry_cd.mechanics.dynamics.overlaps import Overlap, largest_shortening, still_closing
from masonry_cd.mechanics.dynamics.own_friction import FrictionLaw, with_friction
from masonry_cd.mechanics.dynamics.planar import Plane
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.dynamics.snapshot import check_motion, motion_arrays, part, prefixed, restored_motion
from masonry_cd.mechanics.dynamics.softening import solve_softening, split
from masonry_cd.mechanics.dynamics.solving import Watch, solve
from masonry_cd.mechanics.dynamics.start import motion_at_start
from masonry_cd.mechanics.dynamics.step_problem import Solved, StepProblem
from masonry_cd.mechanics.dynamics.system import NO_APPROACH, MotionState, RunLoads, StepLoads, System, plane_of
from masonry_cd.mechanics.dynamics.violations import Violation, find_violations
from masonry_cd.mechanics.friction.problem import Solution
from masonry_cd.mechanics.model.block_forces import BlockForces
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import histories
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.state import State, body_maps, rotation_matrices
from masonry_cd.mechanics.solvers.by_name import step_solver

__all__ = ["ENERGIES", "RunStopped", "StepReport", "Stepper"]


class StepReport(NamedTuple):
    """Cost and accuracy of a step."""

    iterations: int
    error: float  # natural map error of the impulses, on the scale of error_scale.py
    seconds: float  # of the whole step
    contacts: int
    penetration: float  # largest overlap of rigid contacts at q_m [m]
    reason: str  # why the solver stopped
    apart: bool = False  # impacts were solved apart from forces
    islands: int = 0  # see islands.py
    sleeping: float = 0.0  # share of the blocks whose island was not solved
    overlapping: tuple[int, int] = (-1, -1)  # the blocks of the largest overlap
    closing: Closing | None = None  # what a step that missed its tolerance has left closing
    accepted: bool = False  # the step missed its tolerance, by no more than the scene accepts
    shortening: Overlap = Overlap()  # the largest one of springs
    violation: Violation = Violation()  # of the contact laws


class StepStart(NamedTuple):
    """State of a step at its beginning, as it was before."""

    motion: MotionState
    load_step: int
    detector: Detector
    last: StepProblem | None
    solution: Solution


# --- the phases that are not in files of their own ---------------------------------------------------------------------------


def detect(system: System, detector: Detector, predicted: Prediction, number: int) -> ContactSet:
    """The contacts at q_m in step ``number``, counted from 1. What moves with the supports has not moved for the broad phase.

    Raises:
        RunStopped: the meshes of two faces cross too often, or two blocks overlap by more than they can have moved.
    """
    h, support, state = system.constants.step, system.support, predicted.state
    slack = 4.0 * h * h * predicted.pull + system.stretch + predicted.swelling
    moved = state.position[support] - system.assembly.centre[support] if support >= 0 else np.zeros(3)
    threads = system.threads_for(detector.contacts)
    try:
        return detector.detect(state.position, predicted.maps, state.velocity, h, slack, moved, threads)
    except ContactFault as fault:
        a, b = (f'"{system.assembly.names[block]}"' for block in fault.blocks)
        raise RunStopped(f"step {number}: {fault.text.format(a, b)}") from None


# --- step after step -----------------------------------------------------------------------------------------------------------


class Stepper:
    """Advances a state step by step.

    Args:
        assembly: the blocks.
        support_velocity: (N + 1, S, 3 or 6) velocity of support motion s at t_k, k ticks of length dt, see :class:`Loads`.
        acceleration: (N + 1, 3) body acceleration at t_k, gravity included [m/s2].
        settings: time step, or the shortest where it adapts, theta, solver, tolerance, seed.
        start: where the run begins; None: at rest, as built.
        forces: on single blocks; None for none.
        plane: in which the scene moves, where that is known; None: looked for, if the settings want it.
    """

    def __init__(
        self,
        assembly: Assembly,
        support_velocity: np.ndarray,
        acceleration: np.ndarray,
        settings: Run,
        start: State | None = None,
        forces: BlockForces | None = None,
        plane: Plane | None = None,
    ) -> None:
        keep_freed_memory()
        state = State.at_rest(assembly) if start is None else start.copy()
        loads = RunLoads(support_velocity, acceleration, forces)
        plane = plane_of(assembly, state, settings, loads) if plane is None else plane
        self.assembly, self.settings, self.plane = assembly, settings, plane
        self.system = System.of(assembly, settings, loads, plane)
        self.motion = motion_at_start(self.system, state)
        masonry = self.system.masonry
        self.detector = Detector(assembly, facets=self.system.facets, stiffness=None if masonry is None else masonry.of_contacts)
        self.islands = Islands(step_solver(settings.solver), self.system.bodies, settings.islands)
        self.load_step = 0  # k of the loads; it may run ahead of the steps, see pauses.py
        self.watch: Watch | None = None  # sees each problem that is solved
        self.friction: FrictionLaw | None = None  # gives the coefficients of each step; None: those of the scene
        self.last: StepProblem | None = None  # of the last step
        self.solution = Solution(np.zeros((0, self.system.rows)), None, 0)  # of the last step

    def step(self, ticks: int = 1) -> StepReport:
        """Advance by one time step, of some ticks of length dt.

        Raises:
            RunStopped: a velocity is not finite, or see :func:`detect`.
        """
        begin = clock()
        self._set_length(ticks)
        system, last = self.system, self.motion
        predicted = self._predicted(last, system.loads.of_step(self.load_step, ticks))
        found = detect(system, self.detector, predicted, last.steps + 1)
        made, solved = self._solved(predicted, found)
        impulse = solved.solution.impulse
        new = update(system, last, made, impulse)
        if new.springs.crushed is not None:
            self.detector.crush(new.springs.crushed if made.bonds is None else made.bonds.of_detector(new.springs.crushed))
        energy = account(system, last, made, impulse, new)
        slipped = last.false_slip if made.bonds is None else made.bonds.false_slip
        violation, false_slip = find_violations(system, made, impulse if solved.blow is None else solved.blow, new.v, slipped)
        self.motion = MotionState(
            new.state, new.angular_momentum, new.v, new.impulse, solved.carried_impulse, false_slip, new.joints, predicted.tensions,
            predicted.yielded, energy, last.steps + 1, last.ticks + ticks, last.span, made.approach, new.bonds,
        )  # fmt: skip
        self.last, self.solution = made, solved.solution
        self.load_step += ticks
        return self._report(made, solved, new.deepest, violation, begin)

    def _set_length(self, ticks: int) -> None:
        """Make steps of some ticks from here on; the impulses that the next one starts from grow with its length."""
        if ticks != self.motion.span:
            self.system = self.system.with_step(ticks * self.settings.dt)
            share = ticks / self.motion.span
            self.motion = self.motion._replace(impulse=share * self.motion.impulse, span=ticks, bonds=self.motion.bonds.with_step(share))

    def begin_of_step(self) -> StepStart:
        """Keep the state that a step changes, so that it can be undone by :meth:`undo`; what the solver learns in it stays."""
        return StepStart(self.motion, self.load_step, self.detector.copied(), self.last, self.solution)

    def undo(self, start: StepStart) -> None:
        """Go back to the beginning of a step. The detector kept is used up: it serves once."""
        self.motion, self.load_step, self.detector, self.last, self.solution = start
        self.system = self.system.with_step(self.motion.span * self.settings.dt)

    def friction_problem(self) -> StepProblem:
        """The friction problem of the next step, were it as long as the last. Asking for it changes nothing."""
        predicted = self._predicted(self.motion, self.system.loads.of_step(self.load_step))
        detector = deepcopy(self.detector)
        return self._assembled(predicted, detect(self.system, detector, predicted, self.steps + 1), detector.pairs)

    def _predicted(self, last: MotionState, loads: StepLoads) -> Prediction:
        """The blocks at q_m, founded, guided and linked as they are."""
        free, footings = predict(self.system, last, loads), self.assembly.footings
        if footings is not None:
            from masonry_cd.mechanics.dynamics.founding import found

            free = found(self.system, footings, free)
        free = guided(self.system, free)
        if self.system.linkage is None:
            return free
        from masonry_cd.mechanics.dynamics.linking import link  # which others have no use for

        return link(self.system, self.system.linkage, last, free)

    def _solved(self, predicted: Prediction, found: ContactSet) -> tuple[StepProblem, Solved]:
        """The problem of the contacts found, and its solution."""
        system, number = self.system, self.motion.steps + 1

        def attempt(damage: np.ndarray | None) -> tuple[StepProblem, Solved]:
            made = self._assembled(predicted, found, self.detector.pairs, damage)
            return solve_crushing(system, made, lambda made: solve(system, made, self.islands, number, self.watch))

        return solve_softening(system, attempt) if system.softens else attempt(None)

    def _assembled(self, predicted: Prediction, found: ContactSet, pairs: np.ndarray, damage: np.ndarray | None = None) -> StepProblem:
        """The problem of the contacts found between pairs of parts (P, 2); ``damage``: least of each contact (N,), None: as computed."""
        last, bonds = self.motion, None
        if self.system.softens:
            last, found, bonds = split(self.system, last, found, bonding_gap(self.system, last), damage)
        made = assemble(self.system, last, predicted, found, pairs, bonds)
        return made if self.friction is None else with_friction(self.system, self.motion, made, self.friction)

    def _report(self, made: StepProblem, solved: Solved, deepest: Overlap, violation: Violation, begin: float) -> StepReport:
        """Return the cost of a step that began at a reading of the clock."""
        met = solved.error <= self.settings.tolerance
        closing = None if met else still_closing(self.system, made, self.motion.v)
        return StepReport(
            solved.solution.iterations,
            solved.error,
            clock() - begin,
            made.problem.contacts,
            deepest.depth,
            solved.solution.reason,
            solved.carried_impulse is not None,
            self.islands.count,
            self.islands.sleeping,
            deepest.blocks,
            closing,
            not met and solved.error <= self.settings.accepted,
            largest_shortening(made),
            violation,
        )

    @property
    def state(self) -> State:
        """Where the blocks are and how they move."""
        return self.motion.state

    @property
    def steps(self) -> int:
        """Steps done."""
        return self.motion.steps

    @property
    def energy(self) -> dict[str, float]:
        """The energies so far, by the names of ENERGIES [J]."""
        return self.motion.energy.totals

    @property
    def tensions(self) -> np.ndarray:
        """(T,) of the ties, as applied in the last step [N]."""
        return self.motion.tensions

    @property
    def width(self) -> float:
        """Smallest width of a free block [m]."""
        return self.system.width

    def kick(self, velocity: np.ndarray) -> None:
        """Add velocities (B, 6) to those of the free blocks [m/s, rad/s], before a run."""
        free, state, momentum = self.system.free, self.state.copy(), self.motion.angular_momentum.copy()
        added = np.where(free[:, None], velocity, 0.0)
        state.velocity += added
        momentum += angular_momenta(self.system.blocks, rotation_matrices(state.orientation), added)
        v = self.motion.v + self.system.unknowns_of(added)
        self.motion = self.motion._replace(state=state, angular_momentum=momentum, v=v, energy=at_start(self.system, state, momentum))

    def halt(self) -> None:
        """Take all motion out, and begin again at the time zero."""
        m = self.motion
        state = replace(m.state, time=0.0, velocity=np.zeros_like(m.state.velocity))
        self.motion = m._replace(
            state=state, angular_momentum=np.zeros_like(m.angular_momentum), v=np.zeros_like(m.v), carried_impulse=None,
            false_slip=np.zeros_like(m.false_slip), steps=0, ticks=0, approach=NO_APPROACH,
        )  # fmt: skip
        self.load_step = 0

    def cut_bonds(self, pairs: np.ndarray) -> None:
        """Break the bonds of all joints between pairs of groups, (G, G) bool."""
        gone, m = pairs[self.assembly.rows(*self.detector.blocks_of_contacts().T)], self.motion
        if not len(gone):
            return
        joints = m.joints
        if self.system.softens:
            gone = gone[np.cumsum(~m.bonds.twin) - 1]
            m, joints = m._replace(bonds=m.bonds.cut(gone)), m.bonds.freed(joints, gone)
        self.motion = m._replace(joints=joints._replace(bonded=joints.bonded & ~gone))

    def lock_ties(self) -> None:
        """Have the ties that are jacked pull with their first tension where the blocks now are."""
        forces, m = self.system.loads.forces, self.motion
        if forces is not None:
            maps = body_maps(self.assembly, m.state.orientation, m.state.strain)
            self.motion = m._replace(yielded=np.where(forces.jacked, forces.stretches(m.state.position, maps), m.yielded))

    def begin_from(self, other: Stepper, share: float) -> None:
        """Begin in the state of another stepper of the same blocks and plane, with a share of the impulses of its last step.

        The share is that of the step, or the shortest, over the other's.
        """
        m, forces = other.motion, self.system.loads.forces
        tensions = self.tensions if forces is None else np.where(forces.jacked, self.tensions, m.tensions)
        energy = at_start(self.system, m.state, m.angular_momentum)
        self.motion = m._replace(
            impulse=share * m.impulse, false_slip=np.zeros_like(m.false_slip), tensions=tensions, yielded=m.yielded,
            energy=energy, bonds=m.bonds.with_step(0.0),
        )  # fmt: skip
        self.detector, self.last = other.detector, other.last
        self.solution = Solution(share * other.solution.impulse, None, 0)

    def joint_forces(self, pair_joint: np.ndarray, joints: int) -> tuple[np.ndarray, np.ndarray]:
        """Normal and shear force of each joint over the last step, (2, J) [N], and where it crosses the joint's plane, (J, 3) [m].

        ``pair_joint`` names the joint of each pair of parts or -1; without a step there are no forces, and no places (NaN).
        """
        if self.last is None:
            return np.zeros((2, joints)), np.full((joints, 3), np.nan)
        return joint_forces.joint_forces(self.system, self.last, self.solution.impulse, pair_joint, joints)

    def driven(self) -> Driven:
        """Motion of the guides of blocks in the last step: forces, and how far they have gone."""
        rows = () if self.last is None else self.last.predicted.driven
        return measured(self.system, self.system.loads.guides, rows, self.motion.v, self.state)

    def joint_bonds(self, pair_joint: np.ndarray, joints: Joints) -> np.ndarray:
        """Share of the area of each joint that is bonded, (J,); ``pair_joint`` names the joint of each pair or -1."""
        if self.last is None:
            return (self.assembly.laws.apex[self.assembly.rows(joints.block_a, joints.block_b)] > 0.0).astype(float)
        return bonded_shares(self.last, self.motion, pair_joint, joints)

    def joint_histories(self, pair_joint: np.ndarray, joints: Joints) -> dict[str, np.ndarray]:
        """Return the records of the laws that some joint has, (J,) each by its name; ``pair_joint`` names the joint of each pair or -1."""
        measures = {"bonded": self.joint_bonds, "crushed": lambda *of: largest_by_joint(self.detector.most_crushed(), *of)}
        return {history.name: measures[history.name](pair_joint, joints) for history in histories(self.assembly.laws)}

    def snapshot(self) -> dict[str, np.ndarray]:
        """All that the next step depends on, as arrays for a checkpoint."""
        memories = prefixed("detector", self.detector.snapshot()) | prefixed("islands", self.islands.snapshot())
        memories |= prefixed("bonds", self.motion.bonds._asdict()) if self.system.softens else {}
        return motion_arrays(self.motion, self.load_step) | memories

    def check(self, stored: Stored) -> None:
        """Check what :meth:`restore` takes.

        Raises:
            InputError: an array that no run of this scene leaves.
        """
        contacts = int((stored.part("detector").whole("place", None, low=-1) >= 0).sum())
        copies = check_bonds(stored.part("bonds"), contacts) if self.system.softens else contacts
        check_motion(stored, self.system, self.motion, copies)
        self.detector.check(stored.part("detector"), contacts)
        self.islands.check(stored.part("islands"), self.system.unknowns_of_a_body)

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from what :meth:`snapshot` gave, in a stepper of the same scene."""
        self.motion, self.load_step = restored_motion(arrays, self.settings.dt, self.tensions)
        self.system = self.system.with_step(self.motion.span * self.settings.dt)
        self.detector.restore(part("detector", arrays))
        self.islands.restore(part("islands", arrays))
