# SPDX-License-Identifier: GPL-3.0-or-later
"""Overlaps of rigid contacts: a share of them is taken away in each step by moving the blocks, and what is left is reported.

A penetration g < 0 is not pushed out through the velocity: that would feed energy. Each step moves the blocks by the least displacement dq
in the norm of M that leaves

    g + H_n dq >= -allowed,     or the gap with a share of its overlap taken off, where that is deeper,

found by projected Gauss-Seidel on the normals alone. Velocities are not touched; what the blocks are lifted is booked as correction.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.dynamics.free_motion import drift
from masonry_cd.mechanics.dynamics.jams import Closing
from masonry_cd.mechanics.dynamics.step_problem import StepProblem
from masonry_cd.mechanics.dynamics.system import System
from masonry_cd.mechanics.friction.contact_geometry import fill_row, form_of, velocity_between
from masonry_cd.mechanics.friction.operators import ProblemArrays
from masonry_cd.mechanics.model.state import State

OVERLAP = 1e-6  # overlaps up to this share of the smallest width are left alone, or those of the joints as built
CORRECTED = 0.2  # share of what is beyond that which one step takes away
SWEEPS = 20  # of Gauss-Seidel
NOT_LIFTED = np.zeros((0, 3))


class Overlap(NamedTuple):
    """The largest overlap of some contacts at q_m."""

    depth: float = 0.0  # [m]
    blocks: tuple[int, int] = (-1, -1)  # of the contact with the smallest gap; -1: there is no contact


def left_alone(system: System) -> float:
    """The overlap that is not corrected [m]."""
    return max(OVERLAP * system.width, system.inexact)


def correct_overlaps(system: System, made: StepProblem, deepest: Overlap, state: State) -> np.ndarray:
    """Take a share of the overlaps away by moving the blocks of a state, in place, and what links are torn by.

    Returns:
        the shifts (B, 3) [m], (0, 3) for none.
    """
    allowed, linked = left_alone(system), made.predicted.linked
    velocity = np.zeros_like(state.velocity)
    if linked is not None:
        velocity[linked.linkage.used] = linked.shift
    elif deepest.depth < allowed:
        return NOT_LIFTED
    if deepest.depth >= allowed:
        gap, problem = made.rigid_gap, made.solved
        if len(gap) < problem.contacts:
            problem = problem.subset(made.rigid)
        k = len(system.blocks.columns) if linked is None else problem.v_free.shape[1]  # no strain is changed
        shift = np.empty((len(problem.v_free), k))
        lift(problem.arrays(), gap, allowed, shift)
        velocity[np.ix_(system.free, system.blocks.columns)] += shift if linked is None else linked.velocity(shift)
    before = state.position.copy()
    drift(state.position, state.orientation, velocity, 1.0)
    return state.position - before


def deepest_overlap(made: StepProblem) -> Overlap:
    """The largest overlap of rigid contacts in a step."""
    gap = made.rows.gap
    return _deepest(made, gap if made.springs is None else np.where(made.springs.elastic, np.inf, gap))


def largest_shortening(made: StepProblem) -> Overlap:
    """The largest shortening of springs in a step."""
    return Overlap() if made.springs is None else _deepest(made, np.where(made.springs.elastic, made.rows.gap, np.inf))


def _deepest(made: StepProblem, gap: np.ndarray) -> Overlap:
    """The largest overlap by gaps (C,), inf of contacts that do not count [m]."""
    at = int(gap.argmin()) if len(gap) else -1
    if at < 0 or gap[at] == np.inf:
        return Overlap()
    first, second = made.rows.blocks[at].tolist()
    return Overlap(max(0.0, -float(gap[at])), (first, second))


def still_closing(system: System, made: StepProblem, v: np.ndarray) -> Closing | None:
    """The rigid contact that closes fastest at the end of a step, velocities (F, n), if the next ones do not take that away again."""
    rigid = made.rigid
    speed = -made.problem.relative_velocity(v)[rigid, 0]
    if not speed.max(initial=0.0) * system.constants.step > left_alone(system):
        return None
    fastest = int(speed.argmax())
    return Closing(made.problem.subset(rigid), made.rows.blocks[rigid], fastest, float(speed[fastest]))


@entry()
def lift(problem: ProblemArrays, gap: np.ndarray, allowed: float, shift: np.ndarray) -> None:
    """Fill the displacements ``shift`` (F, k) that take a share of the overlaps away, see the head of this file.

    ProblemArrays, of whose unknowns the first k change; gaps (C,) and the overlap that is left alone [m].
    """
    contacts, n, bodies = gap.shape[0], shift.shape[1], problem.places
    multiplier, compliance = np.zeros(contacts), np.zeros(contacts)
    normal, row = np.empty(n), np.empty((contacts, 2, n))  # H_n, M^-1 H_n^T
    for c in range(contacts):
        for side in range(2):
            b = bodies[c, side]
            if b == len(shift):
                continue
            fill_row(form_of(problem.geometry), problem.geometry, c, side, 0, n, normal)
            for j in range(n):
                value = 0.0
                for k in range(n):
                    value += problem.inverse[b, j, k] * normal[k]
                row[c, side, j] = value
                compliance[c] += normal[j] * value
    shift[:] = 0.0
    for _ in range(SWEEPS):
        for c in range(contacts):
            wanted = gap[c] + CORRECTED * (-allowed - gap[c]) if gap[c] < -allowed else -allowed
            moved = gap[c] + velocity_between(bodies, problem.geometry, c, shift)[0]
            step = max(-multiplier[c], (wanted - moved) / compliance[c])
            multiplier[c] += step
            for side in range(2):
                b = bodies[c, side]
                if b < len(shift):
                    for j in range(n):
                        shift[b, j] += row[c, side, j] * step
