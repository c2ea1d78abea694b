# SPDX-License-Identifier: GPL-3.0-or-later
"""Equilibrium: elastic joints, blocks that deform and the ground below footings take up the weight, and ties their first tension, before
a run.

Implicit steps (theta = 1), long for the swing of a block on its joint or on itself, with the supports held and the gravity of the first
instant. Where the kinetic energy falls the motion has passed equilibrium: it is taken out, and the next swing begins from rest (kinetic
damping, Barnes, Comput. Struct. 30, 1988). What is low comes to rest in a step or two; a tall tower would creep in steps that each began
from rest. It has settled when a swing is short, or begins as fast as the last one did: that is rounding, or a slope without friction; or
when it ends where a former one did: a stone then rattles between its neighbours, by no more than ROUND_TRIP. Stiff planes within stones,
between rigid joints, shorten by so little that the tolerance moves stones as far: where the last swing and a hundredth of all of the
settling are less than UNSEEN, it has settled as well.

Ties pull with their first tension however the structure gives way, as held by a jack, and are locked as long as they then are: so the run
begins with that tension, and without a jolt. Their stiffness comes with the run, and so do point loads. Ties that are there from the start
pull by their stretch meanwhile, in steps no longer than those of the run, which are short enough for their stiffness.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.moreau_jean import RunStopped, Stepper
from masonry_cd.mechanics.dynamics.pair_stiffness import softest_spring
from masonry_cd.mechanics.model.blocks import Assembly

RADIANS, STEPS = 30.0, 400  # step of settling, in radians of the swing of a block on its joint, and most steps
ROUND_TRIP = 1e-2  # share of all of the settling by which swings that go round and round may move a block
UNSEEN = 1e-9  # movement that counts as none once all steps are taken [m]: a run's violations add up to hundreds of these
REMEMBERED = 8  # swings, to one of whose ends such a swing comes back
LONGEST = 40  # steps of a swing: a slower one goes on from rest, and still comes closer by a hundredth if it takes eleven times as many
SETTLED, ROUNDED = 1e-6, 1e-3  # at rest: the last swing is this share of all of it; or its first step this, and these shrink no more
SHARE, FINEST = 1e-2, 1e-12  # of the run's tolerance, to which steps of settling are solved, and the finest
COARSEST = 1e-8  # to which they are at the least: at 1e-5 joints that should stick creep on, and a church does not come to rest
IN_STONES = 1e-10  # likewise with planes within stones, ten and more times as stiff as joints: at 1e-8 a wall rattles on
SHIFTS = range(3)  # of the displacements of a footing
SUNK = 0.1  # share of the width of the thinnest block that no block sinks by while it settles


def settles(assembly: Assembly) -> bool:
    """Return True if anything of an assembly is elastic, and so can take up the weight."""
    return assembly.deformation is not None or assembly.footings is not None or bool(assembly.laws.elastic.any())


def settle(stepper: Stepper) -> int:
    """Bring a stepper to rest under its weight and ties, and return the steps that took. Where nothing is elastic there is nothing to do.

    Raises:
        InputError: the structure does not come to rest, or its motion is not finite.
    """
    assembly = stepper.assembly
    if not settles(assembly):
        return 0
    trial = _trial(stepper)
    begin, steps, sunk, first, still = trial.state.position.copy(), 0, 0.0, np.inf, False
    moved = np.inf
    ends: list[np.ndarray] = []
    most = STEPS * max(1.0, _step(stepper) / trial.settings.dt)
    deepest = SUNK * _thinnest(assembly) if assembly.footings is None else np.inf  # a structure goes down with its ground
    while not still and steps < most and sunk <= deepest:
        before, last = trial.state.position.copy(), first
        taken, first = _swing(trial)
        steps, sunk = steps + taken, _farthest(trial, begin)
        moved, ends = _farthest(trial, before), [*ends, before][-REMEMBERED:]
        back = moved <= ROUND_TRIP * sunk and any(_farthest(trial, end) <= SETTLED * sunk for end in ends)
        still = back or (first <= ROUNDED * sunk and first > 0.99 * last)
    if not still and max(moved, ROUND_TRIP * sunk) > UNSEEN:
        block = assembly.names[int(np.abs(trial.state.position - begin).max(axis=1).argmax())]
        under = "its weight and the tension of ties" if trial.tensions.any() else "its weight"
        tied = "; a tie with from_start = true holds it meanwhile" if _jacked(stepper).any() else ""
        raise InputError("run.settle", f'block "{block}" does not come to rest under {under}; settle = false starts the run without{tied}')
    stepper.begin_from(trial, stepper.settings.dt / trial.settings.dt)
    stepper.lock_ties()
    return steps


def _jacked(stepper: Stepper) -> np.ndarray:
    """Which ties keep their first tension while it settles, (T,) bool."""
    forces = stepper.system.loads.forces
    return np.ones(0, dtype=bool) if forces is None else forces.jacked


def _thinnest(assembly: Assembly) -> float:
    """Width of the thinnest free block; of one that is made of convex parts, which may be slivers, that of its thickest part [m]."""
    width = np.zeros(assembly.count)
    np.maximum.at(width, assembly.shapes.part_block, assembly.shapes.size)
    return float(width[~assembly.fixed].min())


def _farthest(trial: Stepper, since: np.ndarray) -> float:
    """How far a block is from where it was, positions (B, 3), along an axis at most [m]."""
    return float(np.abs(trial.state.position - since).max())


def _swing(trial: Stepper) -> tuple[int, float]:
    """Steps from rest until the motion has passed its fastest, where it is taken out; how many, and how far the first moved a block [m]."""
    begin, steps, first, fastest, faster = trial.state.position.copy(), 0, 0.0, 0.0, True
    while faster and steps < LONGEST:
        trial.lock_ties()
        trial.load_step = 0  # the weight stays that of the first instant
        try:
            trial.step()
        except RunStopped as broken:
            raise InputError("run.settle", f"{broken}; settle = false starts the run without") from None
        steps, faster, fastest = steps + 1, trial.energy["kinetic"] > fastest, trial.energy["kinetic"]
        first = _farthest(trial, begin) if steps == 1 else first
    trial.halt()
    return steps, first


def _trial(stepper: Stepper) -> Stepper:
    """A stepper of the same blocks and plane that settles."""
    a, settings = stepper.assembly, stepper.settings
    tolerance = max(min(SHARE * settings.tolerance, COARSEST if a.planes is None else IN_STONES), FINEST)
    own = {
        "dt": _step(stepper) if _jacked(stepper).all() else min(_step(stepper), settings.dt),
        "theta": 1.0,
        "tolerance": tolerance,
        "accept": tolerance,
        "max_iterations": None,
        "solver": "auto",
        "planar": False,
    }
    held, pull = stepper.system.loads.at_rest()
    laws = replace(a.laws, theta=np.ones_like(a.laws.theta), retardation=np.zeros_like(a.laws.retardation))  # dashpots would slow it
    footings = None if a.footings is None else a.footings.undamped
    damped = replace(a, laws=laws, deformation=None if a.deformation is None else a.deformation.without_swing(), footings=footings)
    forces = stepper.system.loads.forces
    ties = None if forces is None else forces.ties_alone()
    return Stepper(damped, held, pull, settings.model_copy(update=own), stepper.state, ties, stepper.plane)


def _step(stepper: Stepper) -> float:
    """Step in which the heaviest block would swing by RADIANS on the softest joint, or on a block as soft as the softest, or all of them on
    the softest footing [s]."""
    a, free = stepper.assembly, ~stepper.assembly.fixed
    size = libm.cbrt(a.volume)
    soft = [softest_spring(a.laws, stepper.system.masonry)]
    if a.deformation is not None:
        own = a.deformation
        soft.append(float((own.stiffness[:, 0, 0] / own.volume / size[own.block]).min()))
    longest = float(np.sqrt((a.mass[free] / size[free] ** 2).max() / min(soft)))
    if a.footings is not None:
        longest = max(longest, float(np.sqrt(a.mass[free].sum() / a.footings.stiffness[:, SHIFTS, SHIFTS].min())))
    return RADIANS * longest
