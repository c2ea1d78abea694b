# SPDX-License-Identifier: GPL-3.0-or-later
"""Events of a simulation, and the functions that are called when they happen."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import numpy as np

from masonry_cd.foundation.signatures import require_call
from masonry_cd.mechanics.dynamics.equilibrium import settles
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.pauses import fallen, standing_of
from masonry_cd.mechanics.model.joints import Joints, measure_joints
from masonry_cd.mechanics.model.state import State

EVENTS = {"step": "sim", "opening": "sim, joint", "fall": "sim, block"}  # what their functions are given


class EventCallbacks:
    """The functions by event. What no function asks for is not measured.

    Args:
        joints: of the structure as built.
        stepper: at the start of its run: an opening counts beyond those that it has settled with.
        opened: smallest opening that counts [m].
    """

    def __init__(self, joints: Joints, stepper: Stepper, opened: float) -> None:
        self._joints, self._assembly, self._opened = joints, stepper.assembly, opened
        self._rest = self._openings(stepper.state) if settles(stepper.assembly) else np.zeros(joints.count)
        self._standing = standing_of(stepper.assembly)
        self.functions: dict[str, list[Callable[..., None]]] = {event: [] for event in EVENTS}
        self.forget()

    def add(self, event: str, function: Callable[..., None]) -> None:
        """Have a function called.

        Raises:
            InputError: it cannot be called with what it would be given.
        """
        require_call(function, EVENTS[event], f"on {event}")
        self.functions[event].append(function)

    def forget(self) -> None:
        """Take it that nothing has opened or fallen yet."""
        self._open = np.zeros(self._joints.count, dtype=bool)
        self._down = np.zeros(self._assembly.count, dtype=bool)

    def parcel(self) -> tuple[Any, ...]:
        """The functions, and what has opened and fallen, for :meth:`take` of another one."""
        return self.functions, self._open, self._down

    def take(self, parcel: tuple[Any, ...]) -> None:
        """Continue from what :meth:`parcel` gave."""
        self.functions, self._open, self._down = parcel

    def copied(self) -> EventCallbacks:
        """A copy with the same functions, independent of this one."""
        other = copy.copy(self)
        other._open, other._down = self._open.copy(), self._down.copy()
        other.functions = {event: list(functions) for event, functions in self.functions.items()}
        return other

    def call(self, sim: Any, state: State) -> None:
        """Call the functions of what has happened with a step that led to a state."""
        functions = self.functions
        for function in functions["step"]:
            function(sim)
        if functions["opening"]:
            now = self._openings(state) - self._rest >= self._opened
            absent = sim.absent
            if absent.any():
                now &= ~(absent[self._joints.block_a] | absent[self._joints.block_b])
            self._tell(sim, "opening", np.flatnonzero(now & ~self._open).tolist())
            self._open |= now
        if functions["fall"]:
            down = fallen(self._assembly, self._standing, state) & ~self._assembly.fixed
            self._tell(sim, "fall", [self._assembly.names[b] for b in np.flatnonzero(down & ~self._down)])
            self._down |= down

    def _tell(self, sim: Any, event: str, what: list[Any]) -> None:
        for item in what:
            for function in self.functions[event]:
                function(sim, item)

    def _openings(self, state: State) -> np.ndarray:
        return measure_joints(self._joints, self._assembly, state).opening
