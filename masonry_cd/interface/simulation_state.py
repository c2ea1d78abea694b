# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of a simulation as Python reads and sets it, and the checks of one that is set."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.interface.own_forces import block_named, free_block
from masonry_cd.interface.values import numbers
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.overlaps import deepest_overlap
from masonry_cd.mechanics.dynamics.system import MotionState
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.state import State, rotation_matrices

UNIT = 1e-6  # by which the square of a quaternion that is set may differ from one; it is then made one
OVERLAP = 1e-3  # share of the smallest width by which blocks that are moved may overlap more than before


@dataclass(frozen=True, eq=False)
class SimulationState:
    """Where B blocks are and how they move, in the world frame; its arrays are read only.

    Attributes:
        time: [s].
        position: (B, 3) centres of mass [m].
        orientation: (B, 4) unit quaternions (w, x, y, z), body to world.
        velocity: (B, 6) linear [m/s] and angular [rad/s].
        names: of the blocks, in the order of the rows.
    """

    time: float
    position: np.ndarray
    orientation: np.ndarray
    velocity: np.ndarray
    names: tuple[str, ...]

    @classmethod
    def of(cls, state: State, names: Sequence[str]) -> SimulationState:
        """A copy of a state."""
        position, orientation, velocity = (_read_only(array.copy()) for array in (state.position, state.orientation, state.velocity))
        return cls(state.time, position, orientation, velocity, tuple(names))

    @property
    def rotation(self) -> np.ndarray:
        """(B, 3, 3) body to world."""
        return rotation_matrices(self.orientation)

    def index(self, block: str) -> int:
        """The row of a block.

        Raises:
            InputError: there is none of the name.
        """
        return block_named(block, self.names, "state")

    def changed(self, block: str | None = None, *, position: Any = None, orientation: Any = None, velocity: Any = None) -> SimulationState:
        """Another state, in which arrays are others: whole ones, or the rows of one block.

        A velocity of one block may be (3,), without the angular one, which then stays.

        Raises:
            InputError: no such block, or numbers that do not fit in.
        """
        return replace(
            self,
            position=self._array("position", position, block),
            orientation=self._array("orientation", orientation, block),
            velocity=self._array("velocity", velocity, block),
        )

    def _array(self, name: str, value: Any, block: str | None) -> np.ndarray:
        now: np.ndarray = getattr(self, name)
        if value is None:
            return now
        found = numbers(value, f"state.{name}", now.shape if block is None else None)
        if block is None:
            return _read_only(found)
        row = self.index(block)
        short = name == "velocity" and found.shape == (3,)
        if found.shape != now[row].shape and not short:
            raise InputError(f"state.{name}", f'of block "{block}" {now.shape[1]} numbers are needed, got an array of shape {found.shape}')
        out: np.ndarray = now.copy()
        out[row, : len(found)] = found
        return _read_only(out)


def with_first_velocities(state: State, given: Mapping[str, Any], assembly: Assembly) -> SimulationState:
    """A state in which free blocks have other velocities, by name.

    Raises:
        InputError: an unknown block, a support, or no velocity.
    """
    out = SimulationState.of(state, assembly.names)
    for name, velocity in given.items():
        free_block(name, assembly, "velocities")
        out = out.changed(name, velocity=velocity)
    return out


def checked_state(wanted: Any, stepper: Stepper) -> State:
    """A state that a stepper takes.

    Raises:
        InputError: names the array, and the block where one is at fault.
    """
    if not isinstance(wanted, SimulationState):
        raise InputError("state", f"one of this simulation is needed, changed; got a {type(wanted).__name__}")
    now, assembly, plane = stepper.state, stepper.assembly, stepper.plane
    if wanted.names != assembly.names:
        raise InputError("state", "is that of other blocks")
    if wanted.time != now.time:
        raise InputError("state", f"is of {wanted.time:g} s, and it is {now.time:g} s; copy or save a simulation to come back to a time")
    position, velocity = wanted.position.copy(), wanted.velocity.copy()
    orientation = _unit(wanted.orientation, now.orientation, assembly.names)
    for name, array, there in (("position", position, now.position), ("orientation", orientation, now.orientation)):
        _refuse(f"state.{name}", assembly.fixed & (array != there).any(axis=1), assembly.names, "is a support, which moves by its loads")
    pushed = assembly.fixed & (velocity != now.velocity).any(axis=1)
    _refuse("state.velocity", pushed, assembly.names, "is a support, which moves by its loads")
    if plane is not None:
        others = [d for d in range(3) if d != plane.axis]
        off = velocity[:, [plane.axis, *(3 + d for d in others)]].any(axis=1) | orientation[:, [1 + d for d in others]].any(axis=1)
        off |= position[:, plane.axis] != now.position[:, plane.axis]
        _refuse("state", off, assembly.names, "leaves the plane in which this scene moves; run.planar = false has it move in space")
    state, linkage = State(now.time, position, orientation, velocity, now.strain.copy()), stepper.system.linkage
    if linkage is not None:
        torn = linkage.largest_violation(state)
        if torn > max(OVERLAP * stepper.width, linkage.largest_violation(now)):
            raise InputError("state", f"a link would have to close {torn:.3g} m or rad: move linked blocks together")
    return state


def require_apart(stepper: Stepper, before: MotionState) -> None:
    """Check that blocks which were moved do not overlap.

    Raises:
        InputError: names the two that overlap most.
    """
    moved, stepper.motion = stepper.motion, before
    there = deepest_overlap(stepper.friction_problem()).depth
    stepper.motion = moved
    found = deepest_overlap(stepper.friction_problem())
    if found.depth > max(there, 0.0) + OVERLAP * stepper.width:
        a, b = (stepper.assembly.names[block] for block in found.blocks)
        raise InputError("state.position", f'blocks "{a}" and "{b}" would overlap by {found.depth:.3g} m')


def _unit(wanted: np.ndarray, now: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Unit quaternions; rows that are as they were stay so to the bit."""
    size = np.sqrt((wanted * wanted).sum(axis=1))
    _refuse("state.orientation", np.abs(size * size - 1.0) > UNIT, names, "has no unit quaternion (w, x, y, z)")
    return np.where((wanted == now).all(axis=1)[:, None], now, wanted / size[:, None])


def _refuse(where: str, bad: np.ndarray, names: Sequence[str], what: str) -> None:
    if bad.any():
        raise InputError(where, f'block "{names[int(np.argmax(bad))]}" {what}')


def _read_only(array: np.ndarray) -> np.ndarray:
    array.flags.writeable = False
    return array
