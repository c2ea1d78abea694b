"""Gauss-Seidel over bodies, in one thread or colour by colour in several; see nlgs.py for the method."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import prange

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.friction.operators import ProblemArrays
from masonry_cd.mechanics.friction.random_order import seeded, shuffle
from masonry_cd.mechanics.solvers.nlgs_sweep import groups_of, sweep
from masonry_cd.mechanics.solvers.nlgs_table import ScaledProblem, measure_error, read_answer, scaled_problem

COLOURS = 128  # at most; more joints than that hardly meet in a block, and those that find no colour share the last one, one by one
AHEAD = 4  # joints of one colour that are fetched ahead


class NlgsSettings(NamedTuple):
    """When to stop, and the random order."""

    tolerance: float  # natural map error
    limit: int  # sweeps
    seed: int  # of the random order
    every: int  # sweeps between two measurements of the error


class ColouredJoints(NamedTuple):
    """Joints by colour; those of one colour share no moving body."""

    start: np.ndarray  # (J + 1,) first contact of each joint
    order: np.ndarray  # (J,) the joints sorted by colour
    colour: np.ndarray  # (COLOURS + 1,) starts of the colours in that list


@entry()
def nlgs_bodies(given: ProblemArrays, p: np.ndarray, v: np.ndarray, settings: NlgsSettings) -> tuple[int, float]:
    """Gauss-Seidel over ProblemArrays. p (C, m) holds the start and then the answer, v (B, n) the velocities.

    Returns the sweeps made and the natural map error measured last.
    """
    scaled = scaled_problem(given, p)
    starts = groups_of(scaled.bodies)
    order, state = np.arange(len(starts) - 1), seeded(settings.seed)
    error, sweeps = measure_error(scaled), 0
    while error > settings.tolerance and sweeps < settings.limit:
        for _ in range(min(settings.every, settings.limit - sweeps)):
            shuffle(order, state)
            sweep(scaled.jacobian, scaled.y, scaled.bodies, scaled.table, starts, order, 1)
            sweeps += 1
        error = measure_error(scaled)
    read_answer(scaled, given.v_free, p, v)
    return sweeps, error


@entry()
def colour_joints(index: np.ndarray, bodies: int) -> ColouredJoints:
    """Colour the joints so that no two of a colour share a body: greedily, in their order.

    Args:
        index: (C, 2) bodies of the contacts, those of a joint in a row.
        bodies: number of moving bodies; higher numbers are supports.
    """
    contacts = len(index)
    start = np.empty(contacts + 1, dtype=np.int64)
    joints = 0
    for c in range(contacts):
        if c == 0 or index[c, 0] != index[c - 1, 0] or index[c, 1] != index[c - 1, 1]:
            start[joints] = c
            joints += 1
    start[joints] = contacts
    taken = np.zeros((bodies + 1, COLOURS // 64), dtype=np.uint64)  # a bit for each colour
    colour = np.empty(joints, dtype=np.int64)
    count = np.zeros(COLOURS + 1, dtype=np.int64)
    for j in range(joints):
        a, b = index[start[j], 0], index[start[j], 1]
        for k in range(COLOURS):
            word, bit = k >> 6, np.uint64(1) << np.uint64(k & 63)
            if not ((taken[a, word] | taken[b, word]) & bit) or k == COLOURS - 1:
                break
        colour[j] = k
        count[k + 1] += 1
        for body in (a, b):
            if body < bodies:  # supports do not move: any number of joints may rest on them at once
                taken[body, word] |= bit
    for k in range(COLOURS):
        count[k + 1] += count[k]
    at, order = count[:-1].copy(), np.empty(joints, dtype=np.int64)
    for j in range(joints):
        order[at[colour[j]]] = j
        at[colour[j]] += 1
    return ColouredJoints(start[: joints + 1], order, count)


@entry(parallel=True)
def sweep_coloured(scaled, joints, colours, chunk):
    """One sweep over the joints of the colours in the given order; those of one colour in parallel, ``chunk`` joints to a piece of work.

    Joints of a colour share no body that moves, so the result does not depend on who takes which, nor on how many threads there are. Those
    of the last colour may, and are taken one by one.
    """
    g, y, index, law, start, order = scaled.jacobian, scaled.y, scaled.bodies, scaled.table, joints.start, joints.order
    for place in range(len(colours)):
        low, high = joints.colour[colours[place]], joints.colour[colours[place] + 1]
        if colours[place] == COLOURS - 1:
            sweep(g, y, index, law, start, order[low:high], AHEAD)
        else:
            for part in prange((high - low + chunk - 1) // chunk):
                begin = low + part * chunk
                sweep(g, y, index, law, start, order[begin : min(begin + chunk, high)], AHEAD)


@entry()
def begin_sweeps(given: ProblemArrays, p: np.ndarray) -> tuple[ScaledProblem, float]:
    """The :class:`ScaledProblem` of ProblemArrays and impulses p (C, m), and their natural map error."""
    scaled = scaled_problem(given, p)
    return scaled, measure_error(scaled)


@entry()
def error_after_sweeps(scaled: ScaledProblem) -> float:
    """Natural map error of a ScaledProblem, whose y is set anew."""
    return measure_error(scaled)


@entry()
def end_sweeps(scaled: ScaledProblem, v_free: np.ndarray, p: np.ndarray, v: np.ndarray) -> None:
    """The answer of a ScaledProblem: impulses p (C, m) and velocities v (B, n)."""
    read_answer(scaled, v_free, p, v)
