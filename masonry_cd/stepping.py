r"""The Moreau-Jean step.

One step of length h from (q, v) to (q+, v+), theta in [1/2, 1] (Jean, Comput. Methods Appl. Mech. Engrg. 177, 1999):

    q_m    = q + h (1 - theta) v                                 contacts are found at q_m, supports moved as prescribed
    v_free = v + h M^-1 f(q_m, v)                                gravity, point loads, ties; the free rotation keeps the angular momentum
    M v+   = M v_free + H^T p,   0 <= u_n + max(g, 0)/h  _|_  p_n >= 0,   |p_t| <= mu p_n, opposed to the slip
    q+     = q_m + h theta v+

The gap enters the law over the step, so a block that lands stops where it lands, with perfectly plastic impact. A penetration g < 0
is not pushed out through the velocity: that would feed energy.

**Energy balance**, closed each step with mean velocities (exact for theta = 1/2 up to the turning of the inertia):

    kinetic + friction + impact  =  work of the supports + work of gravity + work of point loads and ties  (+ balance, what is left over)

What a tie stores in its stretch counts as work until it gives it back.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from masonry_cd import kinematics
from masonry_cd.blocks import Assembly
from masonry_cd.checkpoint import part, prefixed
from masonry_cd.detection import ContactSet, Detector
from masonry_cd.forces import BlockForces
from masonry_cd.friction import FrictionProblem, Solution, natural_map_error
from masonry_cd.impacts import open_contacts, solve_apart
from masonry_cd.planar import find_plane
from masonry_cd.scene import Run
from masonry_cd.solvers import SOLVERS, Options
from masonry_cd.state import State, rotation_matrices

ENERGIES = ("kinetic", "friction", "impact", "base_work", "gravity_work", "force_work", "correction", "balance")
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
    penetration: float  # largest overlap at q_m [m]
    reason: str  # the solver's word on it


class Stepper:
    """Advances a state step by step.

    Args:
        assembly: the blocks.
        support_velocity: (N + 1, S, 3) velocity of support motion s at t_k = k h [m/s].
        acceleration: (N + 1, 3) body acceleration at t_k, gravity included [m/s2].
        settings: time step, theta, solver, tolerance, seed.
        start: where the run begins; None: at rest, as built.
        forces: on single blocks; None for none.
    """

    def __init__(
        self,
        assembly: Assembly,
        support_velocity: np.ndarray,
        acceleration: np.ndarray,
        settings: Run,
        start: State | None = None,
        forces: BlockForces | None = None,
    ) -> None:
        self.assembly, self.settings = assembly, settings
        self.state = State.at_rest(assembly) if start is None else start.copy()
        self.steps = 0
        self.load_step = 0  # k of the loads; it may run ahead of the steps, see rests.py
        self.detector = Detector(assembly)
        self.plane = find_plane(assembly, self.state, support_velocity, acceleration, forces) if settings.planar else None
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
        self._solver = SOLVERS[settings.solver]
        self.watch: Callable[[int, str, FrictionProblem], None] | None = None  # told the step and all that is solved in it, by name
        self._handover: np.ndarray | None = None  # generalised impulse left over from an impact, see impacts.py
        self._gravity = float(np.linalg.norm(acceleration, axis=1).max())
        self._pull = self._gravity  # largest acceleration of a block by gravity and forces, in this step [m/s2]
        bodies, n = int((~assembly.fixed).sum()), len(self._columns)
        self._radius = np.zeros(assembly.count)
        np.maximum.at(self._radius, assembly.shapes.part_block, assembly.shapes.radius)
        self._radius = self._radius[~assembly.fixed]
        self._width = float(assembly.shapes.size[~assembly.fixed[assembly.shapes.part_block]].min())
        self._inverse_mass, self._v_free = np.empty((bodies, n, n)), np.empty((bodies, n))
        self._v = self.state.velocity[~assembly.fixed][:, self._columns]
        self._v_old, self._push = np.zeros_like(self._v), np.zeros_like(self._v)  # _push: generalised impulse of the forces
        self.contacts = ContactSet.none()
        self.chosen = np.empty(0, dtype=np.int64)  # contacts of the friction problem; all, but half of them in a plane
        self.solution = Solution(np.zeros((0, self.rows)), None, 0)
        self._impulse = np.zeros((1, self.rows))  # of all contacts of the last step

    @property
    def closed_gap(self) -> float:
        """Gaps up to this one are none [m]."""
        return TOUCHING * self._width

    @property
    def rows(self) -> int:
        """Rows per contact: 3 in space, 2 in a plane."""
        return 3 if self.plane is None else 2

    def step(self) -> StepReport:
        """Advance by one time step.

        Raises:
            RunStopped: a velocity is not finite.
        """
        begin = clock.perf_counter()
        h, theta, state = self.settings.dt, self.settings.theta, self.state
        before = state.position.copy()
        kinematics.drift(state.position, state.orientation, state.velocity, h * (1.0 - theta))
        problem, start = self.friction_problem()
        handover = self._handover  # as far as it was taken
        lifted = self._correct_overlaps(problem)
        error = self._solve(problem, start)
        self._new_velocities(problem)
        kinematics.drift(state.position, state.orientation, state.velocity, h * theta)
        self._balance(problem, state.position - before - lifted, handover)
        self.steps += 1
        self.load_step += 1
        state.time = self.steps * h
        penetration = max(0.0, -float(self.contacts.gap.min(initial=0.0)))
        return StepReport(
            self.solution.iterations, error, clock.perf_counter() - begin, problem.contacts, penetration, self.solution.reason
        )

    def _solve(self, problem: FrictionProblem, start: Solution) -> float:
        """Find the impulses of the step, impacts apart from forces; return the natural map error."""
        s = self.settings
        options = Options(tolerance=s.tolerance, max_iterations=s.max_iterations, seed=s.seed + self.steps, threads=s.threads)
        gap = self.contacts.gap[self.chosen]
        is_open = open_contacts(problem, gap, self.contacts.pair[self.chosen], s.dt, self._pull)
        if is_open is None:
            self.solution = self._solver(problem, options, start)
            self._handover = None
            self._show("", problem)
            return natural_map_error(problem, self.solution.impulse) if self.solution.error is None else self.solution.error
        both = solve_apart(problem, is_open, gap, s.dt, start, lambda part, begin: self._solver(part, options, begin))
        self.solution, self._handover = both.solution, both.handover
        self._show("forces", both.forces)
        self._show("impacts", both.impacts)
        return both.error

    def _show(self, name: str, problem: FrictionProblem) -> None:
        """Let whoever watches see a problem that was solved: the only one of the step (no name), its forces or its impacts."""
        if self.watch is not None:
            self.watch(self.steps + 1, name, problem)

    def friction_problem(self) -> tuple[FrictionProblem, Solution]:
        """The friction problem of the state, which stands at q_m, and the solution of the last step to start from."""
        a, state, h = self.assembly, self.state, self.settings.dt
        gravity = self._acceleration[self.load_step + 1]
        self._rotation = rotation_matrices(state.orientation)
        kinematics.free_motion(
            self._rotation, state.velocity, self._spin, a.mass, self._inverse_inertia, self._free_index, self._columns, gravity, h,
            self._inverse_mass, self._v_free,
        )  # fmt: skip
        self._apply_forces()
        self._take_handover()
        slack = 4.0 * h * h * self._pull
        found = self.detector.detect(state.position, self._rotation, state.velocity, h, slack, self._support_displacement())
        self.contacts = found
        c, m, n = found.count, self.rows, len(self._columns)
        chosen, bodies, mu = np.empty(c, dtype=np.int64), np.empty((c, 2), dtype=np.int64), np.empty(c)
        jacobian, offset, impulse = np.empty((c, 2, m, n)), np.empty((c, m)), np.empty((c, m))
        axis, at = (-1, 0.0) if self.plane is None else (self.plane.axis, self.plane.at)
        count = kinematics.contact_rows(
            found.bodies, found.point, found.normal, found.gap, found.previous, self._impulse, axis, at, state.position,
            self._support_velocity[self.load_step + 1], a.support_of, self._free_index, a.group_of, a.friction, self._columns, h,
            self.closed_gap,
            chosen, bodies, jacobian, offset, mu, impulse,
        )  # fmt: skip
        self.chosen = chosen[:count]
        rigid = np.zeros((count, m))
        problem = FrictionProblem(self._inverse_mass, self._v_free, bodies[:count], jacobian[:count], offset[:count], mu[:count], rigid)
        return problem, Solution(impulse[:count], None, 0, memory=self.solution.memory)

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

    def _take_handover(self) -> None:
        """Add what an impact of the last step left over to the free velocity.

        It is the weight of half a step at most. Where the impulses of the last step were a jam's, self-balanced and of any size, the
        part of them that is handed over must not become motion: no block gets more than gravity gives it in a step.
        """
        if self._handover is None:
            return
        gain = np.einsum("bij,bj->bi", self._inverse_mass, self._handover)
        turning = self._columns >= 3
        speed = np.linalg.norm(gain[:, ~turning], axis=1) + np.linalg.norm(gain[:, turning], axis=1) * self._radius
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
        gap = self.contacts.gap[self.chosen]
        if not len(gap) or gap.min() > -OVERLAP * self._width:
            return moved
        shift = np.empty_like(problem.v_free)
        kinematics.position_correction(
            gap, problem.bodies, problem.jacobian, problem.inverse_mass, OVERLAP * self._width, CORRECTED, 20, shift
        )  # fmt: skip
        velocity, free = np.zeros_like(self.state.velocity), ~self.assembly.fixed
        velocity[np.ix_(free, self._columns)] = shift
        before = self.state.position.copy()
        kinematics.drift(self.state.position, self.state.orientation, velocity, 1.0)
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
        kinematics.new_velocity(impulse, problem.bodies, problem.jacobian, problem.inverse_mass, problem.v_free, self._v)
        self.energy["kinetic"] = kinematics.finish(
            self._v, problem.v_free, self._columns, self._free_index, a.support_of, self._support_velocity[self.load_step + 1],
            self._rotation, a.mass, a.inertia, self.state.velocity, self._spin,
        )  # fmt: skip
        if not np.isfinite(self.energy["kinetic"]):
            block = int(np.argmin(np.isfinite(self.state.velocity).all(axis=1)))
            raise RunStopped(f'step {self.steps + 1}: the velocity of block "{a.names[block]}" is not finite{self._worst_contact()}')

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
        kinematics.dissipation(
            self.solution.impulse, self.chosen, self.contacts.bodies, self.contacts.normal, problem.bodies, problem.jacobian, self._v_old,
            self._v, self._support_velocity[self.load_step], self._support_velocity[self.load_step + 1], a.support_of, work,
        )  # fmt: skip
        if handover is not None:
            work[1] -= 0.5 * float(np.sum(handover * (self._v_old + self._v)))
        free = ~a.fixed
        energy["friction"] += work[0]
        energy["impact"] += work[1]
        energy["base_work"] += work[2]
        energy["gravity_work"] += float(a.mass[free] @ (moved[free] @ self._acceleration[self.load_step + 1]))  # without the corrections
        energy["force_work"] += 0.5 * float(np.sum(self._push * (self._v_old + self._v)))
        put_in = energy["base_work"] + energy["gravity_work"] + energy["force_work"]
        energy["balance"] = put_in - energy["kinetic"] - energy["friction"] - energy["impact"]

    def snapshot(self) -> dict[str, np.ndarray]:
        """All that the next step depends on, as arrays for a checkpoint."""
        state = {name: getattr(self.state, name) for name in ("position", "orientation", "velocity")}
        own = {"spin": self._spin, "v": self._v, "impulse": self._impulse, "steps": np.array([self.steps, self.load_step])}
        own["energy"] = np.array([self.energy[name] for name in ENERGIES])
        if self._handover is not None:
            own["handover"] = self._handover
        return state | own | prefixed("detector", self.detector.snapshot()) | prefixed("memory", self.solution.memory)

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from what :meth:`snapshot` gave, in a stepper of the same scene."""
        self.steps, self.load_step = map(int, arrays["steps"])
        self.state = State(self.steps * self.settings.dt, arrays["position"], arrays["orientation"], arrays["velocity"])
        self._spin, self._v, self._impulse = arrays["spin"], arrays["v"], arrays["impulse"]
        self.energy = dict(zip(ENERGIES, arrays["energy"].tolist(), strict=True))
        self._handover = arrays.get("handover")
        self.detector.restore(part("detector", arrays))
        self.solution.memory = part("memory", arrays)

    def joint_forces(self, pair_joint: np.ndarray, joints: int) -> np.ndarray:
        """Normal and shear force of each joint over the last step, (2, J) [N]; ``pair_joint`` names the joint of each pair or -1."""
        out = np.zeros((2, joints))
        kinematics.joint_forces(
            self.solution.impulse, self.chosen, self.contacts.normal, self.contacts.pair, pair_joint, self.settings.dt,
            np.zeros((joints, 3)), out,
        )  # fmt: skip
        return out

    def force_points(self, pair_joint: np.ndarray, joints: int) -> np.ndarray:
        """Where the force of each joint over the last step crosses its plane, (J, 3) [m]; NaN where it has none.

        The places are those of q_m, in the middle of the step.
        """
        axis, at = (-1, 0.0) if self.plane is None else (self.plane.axis, self.plane.at)
        out = np.zeros((joints, 3))
        kinematics.force_points(
            self.solution.impulse, self.chosen, self.contacts.point, self.contacts.pair, pair_joint, axis, at, np.zeros(joints), out
        )
        return out
