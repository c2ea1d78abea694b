# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulations: a scene that Python steps, looks into, pushes and changes between its steps.

A step of it is a step of ``masonry-cd run``, to the bit. Nothing is written before :meth:`Simulation.record` is asked for.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.app.advance import Advance, Advanced
from masonry_cd.app.beginning import begin, events_of
from masonry_cd.app.case import Case, acting_too, prepare
from masonry_cd.app.changes import without
from masonry_cd.app.pair_joints import PairJoints
from masonry_cd.app.step_contacts import Contacts, LinkForce, contacts_of, links_of, reactions_of
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.interface.copies import Copies
from masonry_cd.interface.events import EVENTS, Events
from masonry_cd.interface.joint_law import BoundLaw, JointLaw, law_of
from masonry_cd.interface.own_forces import OwnForces, Pushing, driven, own_forces
from masonry_cd.interface.scenes import Scene, scene
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.simulation_state import SimulationState, checked_state, require_apart, with_first_velocities
from masonry_cd.interface.structure import Structure
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper, StepReport
from masonry_cd.mechanics.dynamics.own_friction import FrictionLaw
from masonry_cd.mechanics.dynamics.planar import find_plane
from masonry_cd.mechanics.dynamics.start import with_state
from masonry_cd.mechanics.model.state import State

if TYPE_CHECKING:
    from masonry_cd.interface.results import Run
    from masonry_cd.mechanics.friction.problem import FrictionProblem
    from masonry_cd.mechanics.model.joints import Joints

BY_PYTHON = "forces, motions, velocities or calls of Python take part: the scene alone does not repeat this run, nor resume it"


class Simulation(Copies, Sealed):
    """A scene, step by step.

    Args:
        source: a scene, or what :func:`masonry_cd.scene` makes one of.
        forces: beside those of the scene's loads: a dict of forces on single blocks at their centres of mass, by name, each a function of
            time that gives (3,) [N] or a pair of arrays, times (N,) [s] and forces (N, 3); or a field, a function ``f(now)`` of
            :class:`masonry_cd.interface.own_forces.Now` that gives (B, 3), a force on each block; or a list of such.
        motions: imposed on blocks by name: each a function of time that gives the velocity (3,) [m/s], or a pair of arrays, times and
            velocities (N, 3). The blocks do not turn, and move on top of what the scene's loads do to all supports.
        velocities: that free blocks begin with, by name: (3,) [m/s], or (6,) with the angular ones [rad/s].
        law: of the joints, beside contact and friction; or the name of one that an installed package adds.
        friction: a function ``f(contacts)`` of :class:`masonry_cd.mechanics.dynamics.own_friction.SlidingContacts` that gives the
            coefficients (C,) of a step, as by slip rate, pressure or direction of the joint; those of the scene when not given.
        waiting: blocks or groups of the scene that are not there before :meth:`add` puts them in.

    Raises:
        InputError: anything wrong with the scene, the forces, the motions, the velocities or the law; ``friction`` where joints have
            cohesion, whose cone the coefficient of the scene fixes.

    >>> import masonry_cd as mc
    >>> sim = mc.Simulation(mc.scene("examples/trilithon.toml", "run.duration=0.02"))
    >>> sim.run(until=0.01)
    >>> sim.steps, round(sim.time, 6), sim.done
    (20, 0.01, False)
    >>> weight = sum(force[2] for force in sim.reactions().values())
    >>> len(sim.contacts) > 0, bool(weight > 0.0)
    (True, True)
    """

    scene: Scene

    def __init__(
        self,
        source: Scene | str | os.PathLike[str] | Mapping[str, Any],
        *,
        forces: Any = None,
        motions: Mapping[str, Any] | None = None,
        velocities: Mapping[str, Any] | None = None,
        law: JointLaw | str | None = None,
        friction: FrictionLaw | None = None,
        waiting: str | Sequence[str] = (),
    ) -> None:
        self.scene = scene(source)
        """The scene that is stepped."""
        checked = self.scene.checked
        structure, parts = driven(checked, motions) if motions else (None, [])
        self._case = _without(prepare(checked, structure, parts), waiting)
        given = [] if forces is None else list(forces) if isinstance(forces, list | tuple) else [forces]
        assembly = self._case.assembly
        items: tuple[Pushing, ...] = tuple(own_forces(item, assembly) for item in given)
        self._case = acting_too(self._case, [one for item in items for one in getattr(item, "acted", ())])
        if law is not None:
            items = (*items, BoundLaw(law_of(law), self._case.joints, assembly, checked.run.longest_step))
        self._own = OwnForces(self._case.loading.forces, items, checked.run.dt, self._case.steps * checked.run.dt)
        first = with_first_velocities(State.at_rest(assembly), velocities or {}, assembly).velocity
        self._stepper = _stepper(self._case, self._own, first)
        if friction is not None and assembly.laws.apex.any():
            raise InputError("friction", "joints with cohesion have the friction of the scene, which fixes the tip of their cone")
        self._stepper.friction = friction
        begin(self._stepper, self._case)
        if velocities:
            self._stepper.kick(first)
        self._touched = bool(items or motions or velocities or friction or waiting)  # by Python: the scene alone does not repeat it
        self._changed = events_of(self._case, self._stepper)
        self._advance = self._fresh_advance()
        self._pair_joints = PairJoints(assembly)
        self._events = Events(self._case.joints, self._stepper, checked.report.opened)
        self._busy, self._asked_to_stop = False, ""
        self._report: StepReport | None = None

    # --- steps ---------------------------------------------------------------------------------------------------------------

    def step(self, count: int = 1) -> StepReport:
        """Make some steps, and return what the last one cost.

        Raises:
            InputError: the scene has ended; a call from a function that this simulation calls.
            RunStopped: a velocity is not finite.
        """
        if count < 1:
            raise InputError("step", f"at least one step is made, not {count}")
        for _ in range(count):
            self._refuse_at_end("step")
            self._make_step()
        assert self._report is not None
        return self._report

    def run(self, until: float | None = None) -> None:
        """Make steps to the first that ends at a time or later [s], or to the end of the scene, or until a function asks to :meth:`stop`.

        Raises:
            InputError: a time that is over; see also :meth:`step`.
            RunStopped: a velocity is not finite.
        """
        if until is not None and not until >= self.time - 1e-9:
            raise InputError("run", f"until {until:g} s is over, it is {self.time:g} s")
        ticks = math.inf if until is None else math.ceil(until / self._stepper.settings.dt - 1e-6)
        self._asked_to_stop = ""
        while not self.done and not self._asked_to_stop and self._stepper.motion.ticks < ticks:
            self._make_step()

    def stop(self, why: str = "stopped by a function") -> None:
        """End :meth:`run` or :meth:`record` after the step at hand."""
        self._asked_to_stop = why or "stopped"

    def on(self, event: str, function: Callable[..., None]) -> Callable[..., None]:
        """Have a function called after each step in which something happens, in the order in which they were named.

        ``step``: ``f(sim)`` after every step. ``opening``: ``f(sim, joint)`` when a joint, by its number, is open for the first time by
        ``report.opened``. ``fall``: ``f(sim, block)`` when a block, by its name, has dropped by half its height or turned by 45 degrees.

        Raises:
            InputError: no such event.
        """
        if event not in EVENTS:
            raise InputError("on", f'"{event}" is no event{suggest(event, EVENTS)}; events: {", ".join(EVENTS)}')
        self._events.add(event, function)
        self._touched = True
        return function

    def record(self, folder: str | os.PathLike[str] | None = None, *, progress: bool = True, force: bool = False) -> Run:
        """Run the scene to its end from its beginning, and write what ``masonry-cd run`` does; return the run.

        Args:
            folder: where the run is written; a temporary folder when not given.
            progress: whether to show how far it is.
            force: whether what is in the folder may be overwritten.

        There are no checkpoints, so a recorded simulation with functions of Python cannot be resumed.

        Raises:
            InputError: steps were made already; see also :func:`masonry_cd.run`.
        """
        from masonry_cd.app.run_case import Own
        from masonry_cd.interface.running import recorded

        if self.steps or self._busy:
            raise InputError("record", "writes a run from its beginning, and this simulation has made steps; a new one has not")
        self._asked_to_stop = ""
        own = Own(self._stepper, self._recorded_step, BY_PYTHON if self._touched else "", self._changed)
        return recorded(self._case, self.scene, folder, own, progress, force)

    def _recorded_step(self, advance: Advance, made: Advanced) -> str:
        """What follows a step that the run loop made; why it should end, in words."""
        self._advance = advance
        self._follow(made)
        return self._asked_to_stop

    def _make_step(self) -> None:
        if self._busy:
            raise InputError("step", "this simulation is in the middle of one; a function that it calls cannot step it")
        self._follow(self._advance.step())

    def _follow(self, made: Advanced) -> None:
        """Keep what a step came to, and call the functions of what has happened in it."""
        self._report = made.report
        self._own.taken()
        self._busy = True
        try:
            self._events.call(self, self._stepper.state)
        finally:
            self._busy = False

    # --- how it stands -------------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Of the run [s]."""
        return self._stepper.state.time

    @property
    def steps(self) -> int:
        """Made so far."""
        return self._stepper.steps

    @property
    def done(self) -> bool:
        """Whether the scene has ended."""
        return self._advance.done

    @property
    def report(self) -> StepReport | None:
        """What the last step cost and how well it was solved: iterations, error, seconds, contacts, penetration; None before the first."""
        return self._report

    @property
    def structure(self) -> Structure:
        """The blocks, in the order of all arrays."""
        return Structure(self._case.assembly.blocks, self._case.notes)

    @property
    def absent(self) -> np.ndarray:
        """Blocks that are not there, (B,) bool."""
        found = self._stepper.assembly.absent
        return np.zeros(self._case.assembly.count, dtype=bool) if found is None else found.copy()

    @property
    def joints(self) -> Joints:
        """The joints as built: blocks, area, normal, polygons; their numbers are those of results."""
        return self._case.joints

    @property
    def state(self) -> SimulationState:
        """Positions (B, 3), orientations (B, 4) and velocities (B, 6) of all blocks; arrays that are read only.

        Set it between steps, by one that :meth:`SimulationState.changed` gives: ``sim.state = sim.state.changed("b1", velocity=(1, 0, 0))``
        Supports stay as they are, a scene that is solved in its plane stays in it, and blocks that would overlap are refused. The time, the
        strains of blocks and the slips and bonds of joints are not changed by it.
        """
        return SimulationState.of(self._stepper.state, self._case.assembly.names)

    @state.setter
    def state(self, wanted: SimulationState) -> None:
        self._refuse_at_end("state")
        stepper = self._stepper
        state = checked_state(wanted, stepper)
        before, stepper.motion = stepper.motion, with_state(stepper.system, stepper.motion, state)
        if not np.array_equal(state.position, before.state.position) or not np.array_equal(state.orientation, before.state.orientation):
            try:
                require_apart(stepper, before)
            except InputError:
                stepper.motion = before
                raise
        self._touched = True

    @property
    def contacts(self) -> Contacts:
        """The contacts of the last step, as arrays; none before the first."""
        return contacts_of(self._stepper, self._pair_joints.of(self._stepper.detector.pairs))

    def joint_forces(self) -> np.ndarray:
        """The force of each joint on its block b over the last step, (J, 3) [N]; its opposite acts on block a."""
        return self.contacts.of_joints(self._case.joints.count)

    def reactions(self) -> dict[str, np.ndarray]:
        """Force [N] and moment about its centre of mass [N m] of each support on what it carries, (6,) by its name; of the last step."""
        every = reactions_of(self._stepper, self.contacts)
        return {name: every[b] for b, name in enumerate(self._case.assembly.names) if self._case.assembly.fixed[b]}

    def links(self) -> list[LinkForce]:
        """Force [N] and moment [N m] of each link on its first block over the last step, in the order of the scene."""
        return links_of(self._stepper)

    @property
    def energy(self) -> dict[str, float]:
        """What was put in since the start, where it went, and the balance [J]."""
        return dict(self._stepper.energy)

    def problem(self) -> FrictionProblem:
        """The friction problem of the step that comes next; asking for it changes nothing.

        ``masonry_cd.io.problem_files.write_problem`` writes it as ``masonry-cd solve`` reads it.

        Raises:
            InputError: the scene has ended.
        """
        self._refuse_at_end("problem")
        return self._stepper.friction_problem().solved

    def _refuse_at_end(self, what: str) -> None:
        if self.done:
            raise InputError(what, f"the scene has ended, at {self.time:g} s; a longer run.duration continues it")

    def __repr__(self) -> str:
        return f'<Simulation "{self.scene.title}": {len(self._case.assembly.names)} blocks, {self.steps} steps, {self.time:g} s>'


def _without(case: Case, waiting: str | Sequence[str]) -> Case:
    """The case whose blocks of some names are not there at first."""
    if not waiting:
        return case
    return replace(case, assembly=without(case.assembly, [waiting] if isinstance(waiting, str) else waiting, "waiting"))


def _stepper(case: Case, own: OwnForces, velocity: np.ndarray) -> Stepper:
    """The stepper of a case with own forces, whose blocks will begin with some velocities (B, 6): in a plane where all of it is."""
    loading, settings, assembly = case.loading, case.scene.run, case.assembly
    forces = own if own.own else loading.forces
    start = replace(State.at_rest(assembly), velocity=velocity)
    plane = find_plane(assembly, start, loading.support_velocity, loading.acceleration, forces) if settings.planar else None
    if plane is None:
        settings = settings.model_copy(update={"planar": False})
    own.axis = -1 if plane is None else plane.axis
    return Stepper(assembly, loading.support_velocity, loading.acceleration, settings, forces=forces, plane=plane)
