r"""The Moreau-Jean step.

One step of length h from (q, v) to (q+, v+), theta in [1/2, 1] (Jean, Comput. Methods Appl. Mech. Engrg. 177, 1999):

    q_m    = q + h (1 - theta) v                                 contacts are found at q_m, supports moved as prescribed
    v_free = v + h M^-1 f(q_m, v)                                gravity, point loads, ties; the free rotation keeps the angular momentum
    M v+   = M v_free + H^T p,   0 <= u_n + max(g, 0)/h  _|_  p_n >= 0,   |p_t| <= mu p_n, opposed to the slip
    q+     = q_m + h theta v+

The gap enters the law over the step, so a block that lands stops where it lands, with perfectly plastic impact. A penetration g < 0
is not pushed out through the velocity: that would feed energy. Contacts of elastic joints are springs instead, see ``elastic``: there an
overlap is the shortening of the joint.

**Energy balance**, closed each step with mean velocities (exact for theta = 1/2 up to the turning of the inertia):

    kinetic + elastic + friction + impact + damping  =
        work of the supports + work of gravity + work of point loads and ties  (+ balance, what is left over)

What a tie stores in its stretch counts as work until it gives it back. elastic is the energy of the springs of elastic joints, damping
what they lost to the numerical damping of their theta and in breaking.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.app.scene import Run
from masonry_cd.contact.detector import ContactSet, Detector
from masonry_cd.contact.joints import Joints
from masonry_cd.dynamics import step_kernels
from masonry_cd.dynamics.block_forces import BlockForces
from masonry_cd.dynamics.impacts import open_contacts, solve_apart
from masonry_cd.dynamics.islands import Islands
from masonry_cd.dynamics.joint_history import CREEP, JointSprings, Touching, pretensioned
from masonry_cd.dynamics.planar import Plane, find_plane
from masonry_cd.friction.infeasibility import Closing
from masonry_cd.friction.operators import new_velocity
from masonry_cd.friction.problem import FrictionProblem, Solution, natural_map_error
from masonry_cd.io.checkpoint import part, prefixed
from masonry_cd.model.blocks import Assembly
from masonry_cd.model.state import State, rotation_matrices
from masonry_cd.solvers import SOLVERS, Options, cores

ENERGIES = (
    "kinetic", "elastic", "friction", "impact", "damping", "base_work", "gravity_work", "force_work", "correction", "balance",
)  # fmt: skip
WORKS = ("base_work", "gravity_work", "force_work")  # what is put in
LOSSES = ("kinetic", "elastic", "friction", "impact", "damping")  # where it went
TOUCHING = 1e-8  # gaps up to this share of the smallest width are none
OVERLAP = 1e-6  # overlaps up to this share of the smallest width are left alone
CORRECTED = 0.2  # share of what is beyond that which one step takes away


class RunStopped(RuntimeError):
    """The run cannot go on; what was computed is kept. The message names the step and the block."""


@dataclass(frozen=True)
class StepReport:
    """What one step cost and how well it was solved."""

    iterations: int
    error: float  # natural map error, measured outside the solver
    seconds: float  # of the whole step
    contacts: int
    penetration: float  # largest overlap of rigid contacts at q_m [m]
    reason: str  # the solver's word on it
    apart: bool = False  # impacts were solved apart from forces
    islands: int = 0  # see islands.py
    sleeping: float = 0.0  # share of the blocks whose island was not solved
    overlapping: tuple[int, int] = (-1, -1)  # the blocks of the largest overlap
    closing: Closing | None = None  # what a step that missed its tolerance has left closing


class Stepper:
    """Advances a state step by step.

    Args:
        assembly: the blocks.
        support_velocity: (N + 1, S, 3) velocity of support motion s at t_k = k h [m/s].
        acceleration: (N + 1, 3) body acceleration at t_k, gravity included [m/s2].
        settings: time step, theta, solver, tolerance, seed.
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
        self.assembly, self.settings = assembly, settings
        self.state = State.at_rest(assembly) if start is None else start.copy()
        self.steps = 0
        self.load_step = 0  # k of the loads; it may run ahead of the steps, see rests.py
        self.detector = Detector(assembly)
        self.plane = plane
        if plane is None and settings.planar:
            self.plane = find_plane(assembly, self.state, support_velocity, acceleration, forces)
        self.energy = dict.fromkeys(ENERGIES, 0.0)
        self._support_velocity, self._acceleration, self._forces = support_velocity, acceleration, forces
        self._columns = np.arange(6) if self.plane is None else self.plane.columns
        self._free_index = np.where(assembly.fixed, -1, np.cumsum(~assembly.fixed) - 1)
        self._support_block = int(np.argmax(assembly.fixed)) if assembly.fixed.any() else -1
        self._inverse_inertia = np.linalg.inv(assembly.inertia)
        self._rotation = rotation_matrices(self.state.orientation)  # at q_m of the last step
        now = (self.state.position, self._rotation, self.state.velocity)
        self.tensions = np.zeros(0) if forces is None else forces.tensions(*now)  # of the ties, as applied in the last step [N]
        inertia = self._rotation @ assembly.inertia @ self._rotation.transpose(0, 2, 1)
        self._spin = np.einsum("bij,bj->bi", inertia, self.state.velocity[:, 3:])  # angular momentum [kg m2/s]
        self.watch: Callable[[int, str, FrictionProblem], None] | None = None  # told the step and all that is solved in it, by name
        self._handover: np.ndarray | None = None  # generalised impulse left over from an impact, see impacts.py
        self._gravity = float(np.linalg.norm(acceleration, axis=1).max())
        self._pull = self._gravity  # largest acceleration of a block by gravity and forces, in this step [m/s2]
        bodies, n = int((~assembly.fixed).sum()), len(self._columns)
        self.islands = Islands(SOLVERS[settings.solver], bodies, settings.islands)
        self._reach = assembly.reach[~assembly.fixed]
        self.width = float(assembly.shapes.size[~assembly.fixed[assembly.shapes.part_block]].min())  # of the thinnest block [m]
        self._inverse_mass, self._v_free = np.empty((bodies, n, n)), np.empty((bodies, n))
        self._v = np.ascontiguousarray(self.state.velocity[~assembly.fixed][:, self._columns])
        self._v_old, self._push = np.zeros_like(self._v), np.zeros_like(self._v)  # _push: generalised impulse of the forces
        self.contacts = ContactSet.none()
        self.chosen = np.empty(0, dtype=np.int64)  # contacts of the friction problem; all, but half of them in a plane
        self.solution = Solution(np.zeros((0, self.rows)), None, 0)
        self._impulse = np.zeros((1, self.rows))  # of all contacts of the last step
        self._frames = np.empty((0, 3, 3))  # of the contacts of the friction problem: rows n, t1, t2
        self._free_mass = np.where(assembly.fixed, 0.0, assembly.mass)
        self.springs = JointSprings(assembly, self.rows)
        self.threads = min(settings.threads, cores())
        self._begun = self._kinetic()  # energy at the start of the run, that of springs then known from the first step on [J]

    @property
    def closed_gap(self) -> float:
        """Gaps up to this one are none [m]."""
        return TOUCHING * self.width

    @property
    def rows(self) -> int:
        """Rows per contact: 3 in space, 2 in a plane."""
        return 3 if self.plane is None else 2

    @property
    def _mirror(self) -> tuple[int, float]:
        """Axis and place of the plane, for the kernels; axis -1: none."""
        return (-1, 0.0) if self.plane is None else (self.plane.axis, self.plane.at)

    def step(self) -> StepReport:
        """Advance by one time step.

        Raises:
            RunStopped: a velocity is not finite.
        """
        begin = clock.perf_counter()
        h, theta, state = self.settings.dt, self.settings.theta, self.state
        before = state.position.copy()
        step_kernels.drift(state.position, state.orientation, state.velocity, h * (1.0 - theta))
        problem, start = self.friction_problem()
        handover = self._handover  # as far as it was taken
        lifted = self._correct_overlaps(problem)
        error = self._solve(problem, start)
        self._new_velocities(problem)
        step_kernels.drift(state.position, state.orientation, state.velocity, h * theta)
        self._balance(problem, state.position - before - lifted, handover)
        closing = None if error <= self.settings.tolerance else self._still_closing(problem)
        self.steps += 1
        self.load_step += 1
        state.time = self.steps * h
        penetration, overlapping = self._deepest_overlap()
        return StepReport(
            self.solution.iterations,
            error,
            clock.perf_counter() - begin,
            problem.contacts,
            penetration,
            self.solution.reason,
            self._handover is not None,
            self.islands.count,
            self.islands.sleeping,
            overlapping,
            closing,
        )

    def _still_closing(self, problem: FrictionProblem) -> Closing | None:
        """The rigid contact that closes fastest after a step, if the next ones do not take that away again."""
        rigid = np.flatnonzero(~self.springs.now.elastic) if self.springs.any else np.arange(problem.contacts)
        speed = -problem.relative_velocity(self._v)[rigid, 0]
        if not speed.max(initial=0.0) * self.settings.dt > OVERLAP * self.width:
            return None
        fastest = int(speed.argmax())
        return Closing(problem.subset(rigid), self.contacts.bodies[self.chosen[rigid]], fastest, float(speed[fastest]))

    def _deepest_overlap(self) -> tuple[float, tuple[int, int]]:
        """The largest overlap of rigid contacts at q_m, at least 0 [m], and the two blocks."""
        gap = self._rigid_gaps()
        if not len(gap):
            return 0.0, (-1, -1)
        at = int(np.argmin(gap))
        chosen = self.chosen[~self.springs.now.elastic] if self.springs.any else self.chosen
        first, second = self.contacts.bodies[chosen[at]].tolist()
        return max(0.0, -float(gap[at])), (first, second)

    def _rigid_gaps(self) -> np.ndarray:
        """Gaps of the contacts of the friction problem that are no springs, whose overlap is the shortening of the joint [m]."""
        gap = self.contacts.gap[self.chosen]
        return gap[~self.springs.now.elastic] if self.springs.any else gap

    def kick(self, velocity: np.ndarray) -> None:
        """Add velocities (B, 6) to those of the free blocks [m/s, rad/s], before a run."""
        free = ~self.assembly.fixed
        turn = rotation_matrices(self.state.orientation[free])
        inertia = turn @ self.assembly.inertia[free] @ turn.transpose(0, 2, 1)
        self.state.velocity[free] += velocity[free]
        self._spin[free] += np.einsum("bij,bj->bi", inertia, velocity[free, 3:])
        self._v += velocity[free][:, self._columns]
        self._begun = self._kinetic()

    def resting_loads(self) -> tuple[np.ndarray, np.ndarray]:
        """Support velocities (N + 1, S, 3) of none, and body accelerations (N + 1, 3) whose first two are the first of the run."""
        acceleration = self._acceleration.copy()
        acceleration[1] = acceleration[0]
        return np.zeros_like(self._support_velocity), acceleration

    def begin_from(self, other: Stepper, share: float) -> None:
        """Begin in the state of another stepper of the same blocks and plane, with a share of the impulses of its last step."""
        self.state, self._spin, self._v = other.state, other._spin, other._v
        self.detector, self.contacts, self.chosen, self._frames = other.detector, other.contacts, other.chosen, other._frames
        self.springs.begin_from(other.springs)
        self._impulse = share * other._impulse
        self.solution = Solution(share * other.solution.impulse, None, 0)
        self._begun = self._kinetic()

    def halt(self) -> None:
        """Take all motion out, and begin again at the time zero."""
        self.state.velocity[:], self._v[:], self._spin[:] = 0.0, 0.0, 0.0
        self._handover, self.steps, self.load_step, self.state.time = None, 0, 0, 0.0

    def _kinetic(self) -> float:
        """Kinetic energy of the free blocks [J]."""
        free = ~self.assembly.fixed
        velocity = self.state.velocity[free]
        linear = self.assembly.mass[free] @ (velocity[:, :3] ** 2).sum(axis=1)
        return 0.5 * float(linear + np.sum(self._spin[free] * velocity[:, 3:]))

    def _solve(self, problem: FrictionProblem, start: Solution) -> float:
        """Find the impulses of the step, impacts apart from forces; return the natural map error."""
        bond = self.springs.now.bond
        bonded = self.springs.any and bond.any()
        if bonded:
            v_free, offset = pretensioned(problem, bond)
            problem = replace(problem, v_free=v_free, offset=offset)
            start.impulse[:, 0] += bond
        error = self._solve_dry(problem, start)
        if bonded:
            self.solution.impulse[:, 0] -= bond
        return error

    def _solve_dry(self, problem: FrictionProblem, start: Solution) -> float:
        """The same for contacts whose cones begin at zero."""
        s = self.settings
        options = Options(s.tolerance, s.max_iterations, s.seed + self.steps, self.threads)
        gap = self.contacts.gap[self.chosen]
        impact = self._impact(problem, gap)
        self.islands.link(problem, start.impulse, s.tolerance)
        if impact is None:
            self.solution = self.islands.solve(problem, options, start)
            self._handover = None
            self._show("", problem)
            return natural_map_error(problem, self.solution.impulse) if self.solution.error is None else self.solution.error
        is_open, struck = impact
        both = solve_apart(
            problem, is_open, ~struck, gap, s.dt, start, lambda part, begin, kind: self.islands.solve(part, options, begin, kind)
        )
        self.solution, self._handover = both.solution, both.handover
        self._show("forces", both.forces)
        self._show("impacts", both.impacts)
        return both.error

    def _show(self, name: str, problem: FrictionProblem) -> None:
        """Let whoever watches see a problem that was solved: the only one of the step (no name), its forces or its impacts."""
        if self.watch is not None:
            self.watch(self.steps + 1, name, problem)

    def _impact(self, problem: FrictionProblem, gap: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """See :func:`masonry_cd.dynamics.impacts.open_contacts`; elastic and bonded contacts are never hit, their law spans the whole
        step."""
        pair, whole, step = self.contacts.pair[self.chosen], self.springs.now.whole, self.settings.dt
        if not (self.springs.any and whole.any()):
            return open_contacts(problem, gap, pair, step, self._pull)
        rigid = np.flatnonzero(~whole)
        among = open_contacts(problem.subset(rigid), gap[rigid], pair[rigid], step, self._pull)
        if among is None:
            return None
        is_open, struck = np.zeros((2, len(gap)), dtype=np.bool_)
        is_open[rigid], struck[rigid] = among
        return is_open, struck

    def friction_problem(self) -> tuple[FrictionProblem, Solution]:
        """The friction problem of the state, which stands at q_m, and the impulses and velocities of the last step to start from."""
        a, state, h = self.assembly, self.state, self.settings.dt
        gravity = self._acceleration[self.load_step + 1]
        self._rotation = rotation_matrices(state.orientation)
        step_kernels.free_motion(
            self._rotation, state.velocity, self._spin, a.mass, self._inverse_inertia, self._free_index, self._columns, gravity, h,
            self._inverse_mass, self._v_free,
        )  # fmt: skip
        self._apply_forces()
        self._take_handover()
        slack = 4.0 * h * h * self._pull + self.springs.stretch
        found = self.detector.detect(state.position, self._rotation, state.velocity, h, slack, self._support_displacement())
        self.contacts = found
        c, m, n = found.count, self.rows, len(self._columns)
        chosen, bodies, mu = np.empty(c, dtype=np.int64), np.empty((c, 2), dtype=np.int64), np.empty(c)
        jacobian, offset, impulse, frames = np.empty((c, 2, m, n)), np.empty((c, m)), np.empty((c, m)), np.empty((c, 3, 3))
        count = step_kernels.contact_rows(
            found.bodies, found.point, found.normal, found.gap, found.area, found.previous, self._impulse, *self._mirror, state.position,
            self._support_velocity[self.load_step + 1], a.support_of, self._free_index, a.group_of, a.friction, self._columns, h,
            self.closed_gap,
            chosen, bodies, frames, jacobian, offset, mu, impulse,
        )  # fmt: skip
        self.chosen, self._frames = chosen[:count], frames[:count]
        rigid = np.zeros((count, m))
        problem = FrictionProblem(self._inverse_mass, self._v_free, bodies[:count], jacobian[:count], offset[:count], mu[:count], rigid)
        problem = self.springs.load(problem, self._touching(), self._v, OVERLAP * self.width if self.steps == 0 else -1.0, h)
        return problem, Solution(impulse[:count], self._v, 0)

    def _apply_forces(self) -> None:
        """Add the impulses of the forces on single blocks to the free velocity and to the angular momentum."""
        if self._forces is None:
            return
        now, free = (self.state.position, self._rotation, self.state.velocity), ~self.assembly.fixed
        wrench = self._forces.wrench(*now, self.load_step + 1)[free]
        self.tensions = self._forces.tensions(*now)
        self._pull = self._gravity + float((np.linalg.norm(wrench[:, :3], axis=1) / self.assembly.mass[free]).max())
        self._push = self.settings.dt * wrench[:, self._columns]
        self._v_free += np.einsum("bij,bj->bi", self._inverse_mass, self._push)
        turning = self._columns >= 3
        self._spin[np.ix_(free, self._columns[turning] - 3)] += self._push[:, turning]

    def _touching(self) -> Touching:
        """The contacts of the friction problem, for the laws of the joints."""
        before, after = self._support_velocity[self.load_step : self.load_step + 2]
        return Touching(self.contacts, self.chosen, self._frames, self._rotation, self._mirror, self.closed_gap, before, after)

    def _take_handover(self) -> None:
        """Add what an impact of the last step left over to the free velocity.

        It is the weight of half a step at most. Where the impulses of the last step were a jam's, self-balanced and of any size, the
        part of them that is handed over must not become motion: no block gets more than gravity gives it in a step.
        """
        if self._handover is None:
            return
        gain = np.einsum("bij,bj->bi", self._inverse_mass, self._handover)
        turning = self._columns >= 3
        speed = np.linalg.norm(gain[:, ~turning], axis=1) + np.linalg.norm(gain[:, turning], axis=1) * self._reach
        share = np.minimum(1.0, self._pull * self.settings.dt / np.maximum(speed, 1e-300))[:, None]
        self._handover = share * self._handover
        self._v_free += share * gain
        self._spin[np.ix_(~self.assembly.fixed, self._columns[turning] - 3)] += self._handover[:, turning]

    def _support_displacement(self) -> np.ndarray:
        """How far the supports have moved, (3,) [m]: what moves with them has not moved for the broad phase."""
        b = self._support_block
        return self.state.position[b] - self.assembly.centre[b] if b >= 0 else np.zeros(3)

    def _correct_overlaps(self, problem: FrictionProblem) -> np.ndarray:
        """Take a share of the overlaps away by moving the blocks, without touching their velocities; return the shifts (B, 3) [m]."""
        moved = np.zeros_like(self.state.position)
        gap = self._rigid_gaps()
        if gap.min(initial=0.0) > -OVERLAP * self.width:
            return moved
        if len(gap) < problem.contacts:
            problem = problem.subset(~self.springs.now.elastic)
        shift = np.empty_like(problem.v_free)
        step_kernels.position_correction(
            gap, problem.bodies, problem.jacobian, problem.inverse_mass, OVERLAP * self.width, CORRECTED, 20, shift
        )  # fmt: skip
        velocity, free = np.zeros_like(self.state.velocity), ~self.assembly.fixed
        velocity[np.ix_(free, self._columns)] = shift
        before = self.state.position.copy()
        step_kernels.drift(self.state.position, self.state.orientation, velocity, 1.0)
        moved = self.state.position - before
        self.energy["correction"] -= float(self.assembly.mass @ (moved @ self._acceleration[self.load_step + 1]))
        return moved

    def _new_velocities(self, problem: FrictionProblem) -> None:
        """Take the impulses into the state.

        Raises:
            RunStopped: a velocity is not finite.
        """
        impulse, a = self.solution.impulse, self.assembly
        self._impulse = np.zeros((max(1, self.contacts.count), self.rows))
        self._impulse[self.chosen] = impulse
        self._v_old, self._v = self._v, self._v_old
        new_velocity(problem.arrays(), impulse, self._v)
        self.energy["kinetic"] = step_kernels.finish(
            self._v, problem.v_free, self._columns, self._free_index, a.support_of, self._support_velocity[self.load_step + 1],
            self._rotation, a.mass, a.inertia, self.state.velocity, self._spin,
        )  # fmt: skip
        if not np.isfinite(self.energy["kinetic"]):
            largest = np.abs(self.state.velocity).max(axis=1)  # NaN where one is
            block = int(np.argmax(np.where(np.isnan(largest), np.inf, largest)))
            what = "is too large for a finite energy" if np.isfinite(largest[block]) else "is not finite"
            raise RunStopped(f'step {self.steps + 1}: the velocity of block "{a.names[block]}" {what}{self._worst_contact()}')

    def _worst_contact(self) -> str:
        """In words, the contact whose impulse is the first that is not finite, or else the largest."""
        size = np.abs(self.solution.impulse).sum(axis=1)
        if not len(size):
            return "; no contact"
        broken = ~np.isfinite(size)
        c = int(np.argmax(broken if broken.any() else size))
        i, j = self.contacts.bodies[self.chosen[c]]
        names, what = self.assembly.names, "is not finite" if broken[c] else f"is the largest, {size[c]:.2g} N s"
        return f'; the impulse of a contact between "{names[i]}" and "{names[j]}" {what}'

    def _balance(self, problem: FrictionProblem, moved: np.ndarray, handover: np.ndarray | None) -> None:
        """Add the step's work and losses to the energy account."""
        a, energy, work = self.assembly, self.energy, np.zeros(3)
        step_kernels.dissipation(
            self.solution.impulse, self.chosen, self.contacts.bodies, self._frames, self.springs.now.elastic, problem.bodies,
            problem.jacobian, self._v_old, self._v, self._support_velocity[self.load_step], self._support_velocity[self.load_step + 1],
            a.support_of, work,
        )  # fmt: skip
        if handover is not None:
            work[1] -= 0.5 * float(np.sum(handover * (self._v_old + self._v)))
        if self.springs.any:
            self._unload_springs(problem)
        energy["friction"] += work[0]
        energy["impact"] += work[1]
        energy["base_work"] += work[2]
        energy["gravity_work"] += float(self._free_mass @ moved @ self._acceleration[self.load_step + 1])  # without the corrections
        if self._forces is not None:
            energy["force_work"] += 0.5 * float(np.sum(self._push * (self._v_old + self._v)))
        energy["balance"] = self._begun + sum(energy[name] for name in WORKS) - sum(energy[name] for name in LOSSES)

    def _unload_springs(self, problem: FrictionProblem) -> None:
        """Carry the slips and bonds of the joints over the step, and book their energy."""
        h, energy = self.settings.dt, self.energy
        still = max(CREEP, self.settings.tolerance) * self._pull * h
        taken, friction, stored, before = self.springs.unload(problem, self._touching(), self._v, self.solution.impulse, still, h)
        if self.steps == 0:
            self._begun += before
            energy["elastic"] = before
        energy["friction"] += friction
        energy["damping"] += taken - friction - (stored - energy["elastic"])
        energy["elastic"] = stored

    def snapshot(self) -> dict[str, np.ndarray]:
        """All that the next step depends on, as arrays for a checkpoint."""
        state = {name: getattr(self.state, name) for name in ("position", "orientation", "velocity")}
        own = {"spin": self._spin, "v": self._v, "impulse": self._impulse, "steps": np.array([self.steps, self.load_step])}
        own["energy"] = np.array([self._begun, *(self.energy[name] for name in ENERGIES)])
        if self._handover is not None:
            own["handover"] = self._handover
        memories = prefixed("detector", self.detector.snapshot()) | prefixed("joints", self.springs.snapshot())
        return state | own | memories | prefixed("islands", self.islands.snapshot())

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from what :meth:`snapshot` gave, in a stepper of the same scene."""
        self.steps, self.load_step = map(int, arrays["steps"])
        self.state = State(self.steps * self.settings.dt, arrays["position"], arrays["orientation"], arrays["velocity"])
        self._spin, self._v, self._impulse = arrays["spin"], arrays["v"], arrays["impulse"]
        self._begun, *energies = arrays["energy"].tolist()
        self.energy = dict(zip(ENERGIES, energies, strict=True))
        self._handover = arrays.get("handover")
        self.detector.restore(part("detector", arrays))
        self.springs.restore(part("joints", arrays))
        self.islands.restore(part("islands", arrays))

    def joint_forces(self, pair_joint: np.ndarray, joints: int) -> tuple[np.ndarray, np.ndarray]:
        """Normal and shear force of each joint over the last step, (2, J) [N], and where it crosses the joint's plane, (J, 3) [m].

        The places are those of q_m, in the middle of the step; NaN where a joint has no force. ``pair_joint`` names the joint of each
        pair or -1.
        """
        force, point = np.empty((2, joints)), np.empty((joints, 3))
        step_kernels.joint_forces(
            self.solution.impulse, self.chosen, self._frames, self.contacts.point, self.contacts.pair, pair_joint, *self._mirror,
            self.settings.dt, np.empty((joints, 4)), force, point,
        )  # fmt: skip
        return force, point

    def joint_bonds(self, pair_joint: np.ndarray, joints: Joints) -> np.ndarray:
        """Share of the area of each joint that is bonded, (J,); ``pair_joint`` names the joint of each pair or -1."""
        if not len(self.chosen):  # before the first step
            group = self.assembly.group_of
            return (self.assembly.laws.apex[group[joints.block_a], group[joints.block_b]] > 0.0).astype(float)
        return self.springs.bonded_shares(self.chosen, self.contacts.pair, pair_joint, joints)
