# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulations: a scene that Python steps, looks into, pushes and changes between its steps.

A step of it is a step of ``masonry-cd run``, to the bit. Nothing is written before :meth:`Simulation.record` is called.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np

from masonry_cd.app.advance import Advance, Advanced
from masonry_cd.app.beginning import begin, events_of
from masonry_cd.app.case import acting_too, prepare
from masonry_cd.app.pair_joints import PairJoints
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.extras import require
from masonry_cd.foundation.signatures import require_call
from masonry_cd.interface.copies import Copies
from masonry_cd.interface.events import EVENTS, EventCallbacks
from masonry_cd.interface.frames import Frames
from masonry_cd.interface.joint_law import BoundLaw, JointLaw, law_of
from masonry_cd.interface.model_changes import without_waiting
from masonry_cd.interface.own_forces import OwnForces, Pushing, own_forces
from masonry_cd.interface.own_motions import driven
from masonry_cd.interface.scenes import Scene, scene
from masonry_cd.interface.simulation_state import SimulationState, checked_state, require_apart, with_first_velocities
from masonry_cd.interface.steppers import solved_by, stepper_of
from masonry_cd.mechanics.dynamics.moreau_jean import StepReport
from masonry_cd.mechanics.dynamics.own_friction import FrictionLaw
from masonry_cd.mechanics.dynamics.start import with_state
from masonry_cd.mechanics.model.state import State
from masonry_cd.mechanics.solvers import Solver

if TYPE_CHECKING:
    from xarray import Dataset

    from masonry_cd.interface.results import Run

BY_PYTHON = "forces, motions, velocities or calls of Python take part: the scene alone does not repeat this run, nor resume it"


class Simulation(Copies):
    """A scene, step by step.

    Args:
        source: a scene, or what :func:`masonry_cd.scene` makes one of.
        forces: in addition to those of the scene's loads: a dict of forces on single blocks by name, each a function of time that gives
            (3,) [N], or (6,) with the moment about the centre of mass [N m], or a pair of arrays, times (N,) [s] and values, or a
            :class:`masonry_cd.Force` with its point; or a field, a function ``f(now)`` of
            :class:`masonry_cd.interface.own_forces.Now` that gives (B, 3 or 6); or a list of such.
        motions: imposed on blocks by name: each a function of time that gives the velocity (3,) [m/s], or (6,) with the angular one
            [rad/s], or a pair of arrays, times and values, or a :class:`masonry_cd.Motion`. On top of what the loads do to all supports.
        velocities: that free blocks begin with, by name: (3,) [m/s], or (6,) with the angular ones [rad/s].
        law: of the joints, in addition to contact and friction; or the name of one that an installed package adds.
        friction: a function ``f(contacts)`` of :class:`masonry_cd.mechanics.dynamics.own_friction.SlidingContacts` that gives the
            coefficients (C,) of a step, as by slip rate, pressure or direction of the joint; those of the scene when not given.
        solver: of the friction problems of the steps, ``f(problem, options, start)`` as in :mod:`masonry_cd.mechanics.solvers.by_name`, in
            place of ``run.solver``, which names ours and those of installed packages.
        waiting: blocks or groups of the scene that are not there before :meth:`add` puts them in.

    Raises:
        InputError: anything wrong with the scene, or with what is given next to it; ``friction`` where joints have cohesion, whose cone the
            coefficient of the scene fixes.

    >>> import masonry_cd as mc
    >>> sim = mc.Simulation(mc.scene("examples/trilithon.toml", "run.duration=0.02"))
    >>> sim.run(until=0.01)
    >>> sim.steps, round(sim.time, 6), sim.done
    (20, 0.01, False)
    >>> weight = sum(force[2] for force in sim.reactions().values())
    >>> len(sim.contacts) > 0, bool(weight > 0.0)
    (True, True)
    """

    def __init__(
        self,
        source: Scene | str | os.PathLike[str] | Mapping[str, Any],
        *,
        forces: Any = None,
        motions: Mapping[str, Any] | None = None,
        velocities: Mapping[str, Any] | None = None,
        law: JointLaw | str | None = None,
        friction: FrictionLaw | None = None,
        solver: Solver | None = None,
        waiting: str | Sequence[str] | None = None,
    ) -> None:
        given = {"forces": forces, "motions": motions, "velocities": velocities, "law": law, "friction": friction, "solver": solver}
        given["waiting"] = waiting
        self._given = {name: value for name, value in given.items() if value is not None}
        self.scene = scene(source)
        """The scene that is stepped."""
        checked = self.scene.checked
        if solver is not None:
            checked = solved_by(solver, checked)
        structure, parts = driven(checked, motions) if motions else (None, [])
        self._case = without_waiting(prepare(checked, structure, parts), waiting)
        several = [] if forces is None else list(forces) if isinstance(forces, list | tuple) else [forces]
        assembly = self._case.assembly
        items: tuple[Pushing, ...] = tuple(own_forces(item, assembly) for item in several)
        self._case = acting_too(self._case, [one for item in items for one in getattr(item, "acted", ())])
        if law is not None:
            items = (*items, BoundLaw(law_of(law), self._case.joints, assembly, checked.run.longest_step))
        self._own = OwnForces(self._case.loading.forces, items, checked.run.dt, self._case.steps * checked.run.dt)
        first = with_first_velocities(State.at_rest(assembly), velocities or {}, assembly).velocity
        self._stepper = stepper_of(self._case, self._own, first, solver)
        if friction is not None:
            require_call(friction, "contacts", "friction")
        if friction is not None and assembly.laws.apex.any():
            raise InputError("friction", "joints with cohesion have the friction of the scene, which fixes the tip of their cone")
        self._stepper.friction = friction
        begin(self._stepper, self._case)
        if velocities:
            self._stepper.kick(first)
        self._touched = bool(items or motions or velocities or friction or solver or waiting)  # the scene alone does not repeat it
        self._changed = events_of(self._case, self._stepper)
        self._changed.follow = self._take_model
        self._advance = self._fresh_advance()
        self._pair_joints = PairJoints(assembly)
        self._events = EventCallbacks(self._case.joints, self._stepper, checked.report.opened)
        self._busy, self._asked_to_stop = False, ""
        self._report: StepReport | None = None
        self._frames: Frames | None = None  # kept in memory

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
            InputError: no such event, or a function that cannot be called so.
        """
        if event not in EVENTS:
            raise InputError("on", f'"{event}" is not an event{suggest(event, EVENTS)}; events: {", ".join(EVENTS)}')
        self._events.add(event, function)
        self._touched = True
        return function

    @overload
    def record(
        self, folder: str | os.PathLike[str] | None = None, *, progress: bool = True, force: bool = False, to: Literal["folder"] = "folder"
    ) -> Run: ...

    @overload
    def record(self, *, to: Literal["memory"]) -> Dataset: ...

    def record(
        self, folder: str | os.PathLike[str] | None = None, *, progress: bool = True, force: bool = False, to: str = "folder"
    ) -> Run | Dataset:
        """Run the scene to its end from its beginning, and write what ``masonry-cd run`` does; return the run.

        Args:
            folder: where the run is written; a temporary folder when not given.
            progress: whether to show how far it is.
            force: whether what is in the folder may be overwritten.
            to: "memory" writes nothing, and returns the frames, what ``run.to_xarray()`` has; :attr:`frames` has them during the run.

        There are no checkpoints, so a recorded simulation with functions of Python cannot be resumed.

        Raises:
            InputError: steps were made already, or xarray is not installed; see also :func:`masonry_cd.run`.
        """
        from masonry_cd.app.run_case import Own
        from masonry_cd.interface.running import recorded

        if self.steps or self._busy:
            raise InputError("record", "begins with the run, and this simulation has made steps; a new one has not")
        if to not in ("folder", "memory") or (to == "memory" and folder is not None):
            raise InputError("record", 'to is "folder", or "memory" without a folder')
        self._asked_to_stop = ""
        if to == "memory":
            require("record", "xarray")
            self._frames = Frames(self._stepper, self._case.joints, self._advance.frame_every)
            self.run()
            return self.frames
        own = Own(self._stepper, self._recorded_step, BY_PYTHON if self._touched else "", self._changed)
        return recorded(self._case, self.scene, folder, own, progress, force)

    def _recorded_step(self, advance: Advance, made: Advanced) -> str:
        """Continue after a step that the run loop made; return why the run should end."""
        self._advance = advance
        self._follow(made)
        return self._asked_to_stop

    def _make_step(self) -> None:
        if self._busy:
            raise InputError("step", "this simulation is in the middle of a step; a function that it calls cannot start another")
        self._follow(self._advance.step())

    def _follow(self, made: Advanced) -> None:
        """Keep what a step came to, and call the functions of what has happened in it."""
        self._report = made.report
        self._own.taken()
        if self._frames is not None:
            self._frames.after_step(self._stepper, self.done)
        self._busy = True
        try:
            self._events.call(self, self._stepper.state)
        finally:
            self._busy = False

    @property
    def absent(self) -> np.ndarray:
        """Blocks that are not there, (B,) bool."""
        found = self._stepper.assembly.absent
        return np.zeros(self._case.assembly.count, dtype=bool) if found is None else found.copy()

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

    def __repr__(self) -> str:
        return f'<Simulation "{self.scene.title}": {len(self._case.assembly.names)} blocks, {self.steps} steps, {self.time:g} s>'
