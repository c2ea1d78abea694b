"""Update: the impulses of a step become velocities, and these carry the blocks to the end of the step.

v+ = v_free + M^-1 H^T p,        L+ = L + I (w+ - w_free),        q+ = q_m + h theta v+
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.dynamics.block_arrays import BlockArrays
from masonry_cd.mechanics.dynamics.free_motion import drift, turned_tensor
from masonry_cd.mechanics.dynamics.joint_history import SpringWork, carried_over
from masonry_cd.mechanics.dynamics.overlaps import Overlap, correct_overlaps, deepest_overlap
from masonry_cd.mechanics.dynamics.step_problem import StepProblem
from masonry_cd.mechanics.dynamics.strain import StrainWork
from masonry_cd.mechanics.dynamics.system import Motion, System


class RunStopped(RuntimeError):
    """The run cannot go on; what was computed is kept. The message names the step and the block."""


class Update(NamedTuple):
    """The end of a step."""

    motion: Motion  # whose energies are still those of the last step
    kinetic: float  # energy of the free blocks [J]
    deepest: Overlap  # at q_m
    lifted: np.ndarray | None  # (B, 3) shifts that took overlaps away [m]
    springs: SpringWork
    strains: StrainWork


def update(system: System, last: Motion, made: StepProblem, impulse: np.ndarray, carried: np.ndarray | None) -> Update:
    """Take the impulses of a step (C, m) [N s] into the state.

    Args:
        system: of the run.
        last: motion before the step.
        made: the problem of the step.
        impulse: its solution.
        carried: (F, n) generalised impulse for the next step.

    Raises:
        RunStopped: a velocity is not finite.
    """
    predicted, h = made.predicted, system.constants.step
    every = np.zeros((max(1, len(made.found.gap)), system.rows))
    every[made.rows.active] = impulse
    v, state, momentum = made.problem.body_velocity(impulse), predicted.state.copy(), predicted.angular_momentum.copy()
    kinetic = take_velocities(
        system.blocks, predicted.rotation, v, made.problem.v_free, predicted.loads.support_after, state.velocity, momentum
    )
    if not math.isfinite(kinetic):
        raise RunStopped(f"step {last.steps + 1}: {_what_broke(system, made, state.velocity, impulse)}")
    deepest = deepest_overlap(made)
    lifted = correct_overlaps(system, made, deepest, state)
    drift(state.position, state.orientation, state.velocity, h * system.settings.theta)
    if system.strains is not None:
        state.strain = system.strains.after(state.strain, v)
    ticks = predicted.loads.ticks
    state.time = (last.ticks + ticks) * system.settings.dt
    joints, springs = carried_over(system, last, made, v, impulse)
    motion = last._replace(
        state=state, angular_momentum=momentum, v=v, impulse=every, carried_impulse=carried, joints=joints,
        tensions=predicted.tensions, yielded=predicted.yielded, steps=last.steps + 1, ticks=last.ticks + ticks,
    )  # fmt: skip
    strains = StrainWork() if system.strains is None else system.strains.work(last.state.strain, state.strain, last.v, v)
    return Update(motion, kinetic + strains.kinetic, deepest, lifted, springs, strains)


def _what_broke(system: System, made: StepProblem, velocity: np.ndarray, impulse: np.ndarray) -> str:
    """In words, the block whose velocity (B, 6) is not finite or too large, and the contact with the worst impulse (C, m)."""
    largest = np.abs(velocity).max(axis=1)  # NaN where one is
    block = int(np.argmax(np.where(np.isnan(largest), np.inf, largest)))
    what = "is too large for a finite energy" if np.isfinite(largest[block]) else "is not finite"
    return f'the velocity of block "{system.assembly.names[block]}" {what}{_worst_contact(system, made, impulse)}'


def _worst_contact(system: System, made: StepProblem, impulse: np.ndarray) -> str:
    """In words, the contact whose impulse is the first that is not finite, or else the largest."""
    size = np.abs(impulse).sum(axis=1)
    if not len(size):
        return "; no contact"
    broken = ~np.isfinite(size)
    c = int(np.argmax(broken if broken.any() else size))
    i, j = made.rows.blocks[c]
    names, what = system.assembly.names, "is not finite" if broken[c] else f"is the largest, {size[c]:.2g} N s"
    return f'; the impulse of a contact between "{names[i]}" and "{names[j]}" {what}'


@entry()
def take_velocities(
    blocks: BlockArrays,
    rotation: np.ndarray,
    v: np.ndarray,
    v_free: np.ndarray,
    support_velocity: np.ndarray,
    velocity: np.ndarray,
    momentum: np.ndarray,
) -> float:
    """Write velocities into the state: ``velocity`` (B, 6), and angular momenta (B, 3), to which I (w - w_free) is added.

    ``blocks``: BlockArrays; rotations (B, 3, 3) at q_m, velocities of the free blocks with contact and without (F, n), of the supports
    (S, 3).

    Returns:
        the kinetic energy of the free blocks [J].
    """
    free_index, columns = blocks.free_index, blocks.columns
    kinetic = 0.0
    world = np.empty((3, 3))
    change = np.zeros(6)
    for b in range(velocity.shape[0]):
        i = free_index[b]
        if i < 0:
            for d in range(3):
                velocity[b, d] = support_velocity[blocks.support_of[b], d]
            continue
        for j in range(columns.shape[0]):
            velocity[b, columns[j]] = v[i, j]
            change[columns[j]] = v[i, j] - v_free[i, j]
        turned_tensor(rotation[b], blocks.inertia[b], world)
        for d in range(3):
            momentum[b, d] += world[d, 0] * change[3] + world[d, 1] * change[4] + world[d, 2] * change[5]
            kinetic += 0.5 * (blocks.mass[b] * velocity[b, d] ** 2 + momentum[b, d] * velocity[b, 3 + d])
    return kinetic
