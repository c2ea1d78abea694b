# SPDX-License-Identifier: GPL-3.0-or-later
"""Stages: a run goes on with other blocks, joints or loads, from the motion in which it stands.

Blocks that are taken away stay in the arrays, at rest where they are, and meet nothing; so do blocks that are put in later, where they were
built. A support that is released becomes a free block with the velocity that it had. State of blocks and contacts is kept by their
numbers, which stay; the solver learns again where other blocks are free or hang together. Links of a block that is not there hold nothing.

What this puts in or takes out is booked as a work of its own: at once the kinetic energy of blocks that come and go, and in the step that
follows that of springs and strains, which are then those of the new stage.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.contact.detector import Detector
from masonry_cd.mechanics.dynamics.free_motion import angular_momenta
from masonry_cd.mechanics.dynamics.islands import Islands
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.start import kinetic_energy
from masonry_cd.mechanics.dynamics.system import NO_APPROACH, MotionState, RunLoads, System
from masonry_cd.mechanics.friction.problem import Solution
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.state import rotation_matrices


class StepperStage(NamedTuple):
    """The parts of a stepper that may change between two steps."""

    assembly: Assembly
    loads: RunLoads


def enter(stepper: Stepper, stage: StepperStage) -> None:
    """Have a stepper go on in a stage of the same blocks and the same kinds of joint laws."""
    before = stepper.system
    after = System.of(stage.assembly, stepper.settings, stage.loads, before.plane).with_step(before.constants.step)
    masonry = after.masonry
    detector = Detector(stage.assembly, facets=after.facets, stiffness=None if masonry is None else masonry.of_contacts)
    detector.go_on_from(stepper.detector)
    stepper.motion = _carried_over(before, after, stepper.motion)
    stepper.assembly, stepper.system, stepper.detector = stage.assembly, after, detector
    if after.linkage is not None or before.linkage is not None or not np.array_equal(before.free, after.free):
        stepper.islands = Islands(stepper.islands.solver, after.bodies, stepper.settings.islands)
    stepper.last, stepper.solution = None, Solution(np.zeros((0, after.rows)), None, 0)


def _carried_over(before: System, after: System, motion: MotionState) -> MotionState:
    """The motion as the blocks of another stage have it."""
    gone, freed = after.absent, after.free & ~before.free
    state, momentum = motion.state.copy(), motion.angular_momentum.copy()
    if gone is not None:
        state.velocity[gone], momentum[gone] = 0.0, 0.0
        if len(state.strain):
            state.strain[gone] = 0.0
    momentum[freed] = angular_momenta(after.blocks, rotation_matrices(state.orientation), state.velocity)[freed]
    new = motion._replace(
        approach=NO_APPROACH,
        state=state,
        angular_momentum=momentum,
        v=_rows(before, after, motion.v, state.velocity),
        carried_impulse=None if motion.carried_impulse is None else _rows(before, after, motion.carried_impulse),
    )
    put_in = _kinetic(after, new) - _kinetic(before, motion)
    if not motion.steps:
        return new._replace(energy=motion.energy._replace(begun=motion.energy.begun + put_in, changed=True))
    totals = dict(motion.energy.totals)
    totals["kinetic"] += put_in
    totals["change_work"] += put_in
    return new._replace(energy=motion.energy._replace(totals=totals, changed=True))


def _kinetic(system: System, motion: MotionState) -> float:
    """The energy of motion of the free blocks, their strains included [J]."""
    strains = system.strains
    own = 0.0 if strains is None else strains.work(motion.state.strain, motion.state.strain, motion.v, motion.v).kinetic
    return kinetic_energy(system, motion) + own


def _rows(before: System, after: System, rows: np.ndarray, velocity: np.ndarray | None = None) -> np.ndarray:
    """Rows (F, n) of the free blocks of one system as those of another: zeros of blocks that are absent, and of those that become free
    the velocities (B, 6), if there are any."""
    every = np.zeros((len(before.free), rows.shape[1]))
    every[before.free] = rows
    freed, rigid = after.free & ~before.free, after.blocks.columns
    if velocity is not None:
        every[np.ix_(freed, range(len(rigid)))] = velocity[freed][:, rigid]
    if after.absent is not None:
        every[after.absent] = 0.0
    return every[after.free]
