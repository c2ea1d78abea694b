# SPDX-License-Identifier: GPL-3.0-or-later
"""Update: the impulses of a step become velocities, and these carry the blocks to the end of the step.

v+ = v_free + M^-1 H^T p,        L+ = L + I (w+ - w_free),        q+ = q_m + h theta v+
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.dynamics.block_arrays import BlockArrays
from masonry_cd.mechanics.dynamics.bonds import BondMemory
from masonry_cd.mechanics.dynamics.free_motion import drift, turned_tensor
from masonry_cd.mechanics.dynamics.joint_history import carried_over
from masonry_cd.mechanics.dynamics.joint_law import JointMemory
from masonry_cd.mechanics.dynamics.overlaps import Overlap, correct_overlaps, deepest_overlap
from masonry_cd.mechanics.dynamics.step_problem import GroundWork, SpringWork, StepProblem
from masonry_cd.mechanics.dynamics.strain import StrainWork
from masonry_cd.mechanics.dynamics.system import MotionState, System
from masonry_cd.mechanics.model.state import State


class RunStopped(RuntimeError):
    """The run cannot go on; what was computed is kept. The message names the step and the block."""


class Update(NamedTuple):
    """The end of a step, but for its energies."""

    state: State
    angular_momentum: np.ndarray  # (B, 3) of the free blocks [kg m2/s]
    v: np.ndarray  # (F, n)
    impulse: np.ndarray  # (N, m) of all contacts found, one row at least [N s]
    joints: JointMemory
    bonds: BondMemory
    kinetic: float  # energy of the free blocks [J]
    deepest: Overlap  # at q_m
    lifted: np.ndarray  # (B, 3) shifts that took overlaps away [m]; (0, 3): there were none
    springs: SpringWork
    strains: StrainWork
    ground: GroundWork


class EndOfStep(NamedTuple):
    """Data that the kernel carries from q_m to the end of the step, for B blocks, and the impulses that it hands on."""

    position: np.ndarray  # (B, 3) [m]
    orientation: np.ndarray  # (B, 4)
    velocity: np.ndarray  # (B, 6) [m/s, rad/s]
    angular_momentum: np.ndarray  # (B, 3) [kg m2/s]
    impulse: np.ndarray  # (N, m) of all contacts found [N s]


def update(system: System, last: MotionState, made: StepProblem, impulse: np.ndarray) -> Update:
    """Take the impulses of a step (C, m) [N s] into the state.

    Args:
        system: of the run.
        last: motion before the step.
        made: the problem of the step.
        impulse: its solution.

    Raises:
        RunStopped: a velocity is not finite.
    """
    predicted, v = made.predicted, made.velocity(impulse)
    loads, middle, momentum = predicted.loads, predicted.state, predicted.angular_momentum.copy()
    time = (last.ticks + loads.ticks) * system.settings.dt
    state = State(time, middle.position.copy(), middle.orientation.copy(), middle.velocity.copy(), middle.strain)
    deepest = deepest_overlap(made)
    lifted = correct_overlaps(system, made, deepest, state)
    every = np.empty((max(1, len(made.found.gap)), system.rows))
    end, rest = EndOfStep(state.position, state.orientation, state.velocity, momentum, every), system.constants.step * system.settings.theta
    kinetic = move_on(system.blocks, predicted.rotation, v, made.problem.v_free, loads.support_after, made.rows.active, impulse, rest, end)
    if not math.isfinite(kinetic):
        raise RunStopped(f"step {last.steps + 1}: {_what_broke(system, made, state.velocity, impulse)}")
    if system.strains is not None:
        state.strain = system.strains.after(state.strain, v)
    joints, bonds, springs = carried_over(system, last, made, v, impulse)
    strains = StrainWork() if system.strains is None else system.strains.work(last.state.strain, state.strain, last.v, v)
    ground = GroundWork()
    if predicted.founded is not None:
        from masonry_cd.mechanics.dynamics.founding import stored_in_ground, work_of_ground

        stored = last.energy.totals["ground"] if last.steps else stored_in_ground(predicted.founded.footings, last.state)
        ground = work_of_ground(system, predicted.founded, stored, v, state)
    return Update(state, momentum, v, every, joints, bonds, kinetic + strains.kinetic, deepest, lifted, springs, strains, ground)


def _what_broke(system: System, made: StepProblem, velocity: np.ndarray, impulse: np.ndarray) -> str:
    """As text, the block whose velocity (B, 6) is not finite or too large, and the contact with the worst impulse (C, m)."""
    largest = np.abs(velocity).max(axis=1)  # NaN where one is
    block = int(np.argmax(np.where(np.isnan(largest), np.inf, largest)))
    what = "is too large for a finite energy" if np.isfinite(largest[block]) else "is not finite"
    return f'the velocity of block "{system.assembly.names[block]}" {what}{_worst_contact(system, made, impulse)}'


def _worst_contact(system: System, made: StepProblem, impulse: np.ndarray) -> str:
    """As text, the contact whose impulse is the first that is not finite, or else the largest."""
    size = np.abs(impulse).sum(axis=1)
    if not len(size):
        return "; no contact"
    broken = ~np.isfinite(size)
    c = int(np.argmax(broken if broken.any() else size))
    i, j = made.rows.blocks[c]
    names, what = system.assembly.names, "is not finite" if broken[c] else f"is the largest, {size[c]:.2g} N s"
    return f'; the impulse of a contact between "{names[i]}" and "{names[j]}" {what}'


@entry()
def move_on(
    blocks: BlockArrays,
    rotation: np.ndarray,
    v: np.ndarray,
    v_free: np.ndarray,
    support_velocity: np.ndarray,
    active: np.ndarray,
    impulse: np.ndarray,
    time: float,
    end: EndOfStep,
) -> float:
    """Move the blocks of ``end``, which are at q_m, for a time [s] by the velocities after contact, which it gets as well.

    Rotations (B, 3, 3) at q_m, velocities of the free blocks with contact and without (F, n), of the supports (S, 3 or 6); impulses (C, m)
    and the places of their contacts (C,) among all found. I (w - w_free) is added to the angular momenta.

    Returns:
        the kinetic energy of the free blocks [J].
    """
    free_index, columns, velocity, momentum = blocks.free_index, blocks.columns, end.velocity, end.angular_momentum
    kinetic = 0.0
    world = np.empty((3, 3))
    change = np.zeros(6)
    for b in range(velocity.shape[0]):
        i = free_index[b]
        if i < 0:
            for d in range(support_velocity.shape[1]):
                velocity[b, d] = support_velocity[blocks.support_of[b], d]
            continue
        for j in range(columns.shape[0]):
            velocity[b, columns[j]] = v[i, j]
            change[columns[j]] = v[i, j] - v_free[i, j]
        turned_tensor(rotation[b], blocks.inertia[b], world)
        for d in range(3):
            momentum[b, d] += world[d, 0] * change[3] + world[d, 1] * change[4] + world[d, 2] * change[5]
            kinetic += 0.5 * (blocks.mass[b] * velocity[b, d] ** 2 + momentum[b, d] * velocity[b, 3 + d])
    drift(end.position, end.orientation, velocity, time)
    end.impulse[:] = 0.0
    for c in range(len(active)):
        for i in range(impulse.shape[1]):
            end.impulse[active[c], i] = impulse[c, i]
    return kinetic
