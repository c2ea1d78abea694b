# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion that a run begins with, and the velocities that its blocks may be given before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.dynamics.energy import at_start
from masonry_cd.mechanics.dynamics.free_motion import angular_momenta
from masonry_cd.mechanics.dynamics.joint_law import JointMemory
from masonry_cd.mechanics.dynamics.settings import FirstVelocities
from masonry_cd.mechanics.dynamics.system import NO_APPROACH, MotionState, System
from masonry_cd.mechanics.model.state import State, rotation_matrices


def motion_at_start(system: System, state: State) -> MotionState:
    """Return the motion before the first step: no impulses, and the momenta and tensions of a state."""
    if system.strains is not None:
        state = replace(state, strain=system.strains.with_room(state.strain))
    rotation, forces = rotation_matrices(state.orientation), system.loads.forces
    tensions = np.zeros(0) if forces is None else forces.acting(state.position, rotation, state.velocity, 0).tension
    momentum: np.ndarray = angular_momenta(system.blocks, rotation, state.velocity)
    return MotionState(
        state=state,
        angular_momentum=momentum,
        v=system.unknowns_of(state.velocity),
        impulse=np.zeros((1, system.rows)),
        carried_impulse=None,
        false_slip=np.zeros((1, system.rows - 1)),
        joints=JointMemory.empty(0),
        tensions=tensions,
        yielded=np.zeros(len(tensions)),
        energy=at_start(system, state, momentum),
        steps=0,
        ticks=0,
        span=1,
    )


def with_state(system: System, motion: MotionState, state: State) -> MotionState:
    """The motion with another state of the same time, strains included, where a caller has moved or pushed blocks.

    What the energy of motion gains by it counts as there from the beginning, so that the balance still closes; the impulses of the last
    step stay, to start from, and what an impact left over is dropped.
    """
    momentum: np.ndarray = angular_momenta(system.blocks, rotation_matrices(state.orientation), state.velocity)
    v = motion.v.copy()
    rigid = len(system.blocks.columns)
    v[:, :rigid] = system.unknowns_of(state.velocity)[:, :rigid]
    energy = at_start(system, state, momentum)
    if motion.steps:
        totals = motion.energy.totals | {"kinetic": motion.energy.totals["kinetic"] + energy.begun - kinetic_energy(system, motion)}
        begun = motion.energy.begun + totals["kinetic"] - motion.energy.totals["kinetic"]
        energy = motion.energy._replace(totals=totals, begun=begun)
    return motion._replace(state=state, angular_momentum=momentum, v=v, carried_impulse=None, energy=energy, approach=NO_APPROACH)


def kinetic_energy(system: System, motion: MotionState) -> float:
    """The kinetic energy of the free blocks in a motion [J]."""
    return at_start(system, motion.state, motion.angular_momentum).begun


def drawn_velocities(system: System, asked: FirstVelocities) -> np.ndarray:
    """Velocities (B, 6) of the blocks [m/s, rad/s]: each component of the linear ones even between -size and size, the angular ones zero.

    A scene that moves in its plane gets none across it, so that it stays there. Other components are those that it would have in space.
    """
    out = np.zeros((system.assembly.count, 6))
    out[:, :3] = asked.size * np.random.Generator(np.random.PCG64(asked.seed)).uniform(-1.0, 1.0, (len(out), 3))
    if system.plane is not None:
        out[:, system.plane.axis] = 0.0
    return out
