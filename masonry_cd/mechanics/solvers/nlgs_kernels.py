# SPDX-License-Identifier: GPL-3.0-or-later
"""Sweeps of Gauss-Seidel over bodies, plain and extrapolated, colour by colour by a team of threads; see nlgs.py and accelerated.py.

Each thread sweeps its share of the joints of a colour, and they wait for one another between colours. Sums are taken over parts of the
contacts, in their order, so the number of threads changes no bit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.coulomb_law import P
from masonry_cd.mechanics.friction.law_terms import PARTS, part_of
from masonry_cd.mechanics.friction.natural_map import error_of
from masonry_cd.mechanics.friction.operators import squared_map_norm_of
from masonry_cd.mechanics.friction.random_order import seeded, shuffle
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.sorting import sorted_by
from masonry_cd.mechanics.linalg.threads import ThreadTeam, share_of, wait
from masonry_cd.mechanics.solvers.nlgs_sweep import ScaledProblem, collect, impulses_of, sweep

COLOURS = 128  # at most; more joints than that hardly meet in a block, and those that find no colour share the last one, one by one


class SweepSettings(NamedTuple):
    """When to stop, and how to sweep."""

    tolerance: float  # natural map error
    limit: int  # sweeps
    every: int  # sweeps between two measurements of the error
    extrapolated: bool  # or else plain sweeps, in a random order
    seed: int  # of that order


class ColouredJoints(NamedTuple):
    """Joints by colour; those of one colour share no moving body."""

    start: np.ndarray  # (J + 1,) first contact of each joint
    order: np.ndarray  # (J,) the joints sorted by colour
    colour: np.ndarray  # (COLOURS + 1,) starts of the colours in that list; (J + 1,) where each joint has its own


class SweepHistory(NamedTuple):
    """Arrays that the extrapolation and the answer need in addition to the table."""

    p: np.ndarray  # (C, m) impulses after the last sweep
    y: np.ndarray  # (B + 1, n) G^T p of them
    best: np.ndarray  # (C, m) impulses of the smallest error
    sums: np.ndarray  # (PARTS,) squared norms of the residual


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
    for j in range(joints):
        a, b = index[start[j], 0], index[start[j], 1]
        for k in range(COLOURS):
            word, bit = k >> 6, np.uint64(1) << np.uint64(k & 63)
            if not ((taken[a, word] | taken[b, word]) & bit) or k == COLOURS - 1:
                break
        colour[j] = k
        for body in (a, b):
            if body < bodies:  # supports do not move: any number of joints may rest on them at once
                taken[body, word] |= bit
    order, begin = sorted_by(colour, COLOURS)
    return ColouredJoints(start[: joints + 1], order, begin)


@entry()
def sweep_bodies(
    team: ThreadTeam, scaled: ScaledProblem, joints: ColouredJoints, history: SweepHistory, settings: SweepSettings
) -> tuple[int, float]:
    """Sweeps over a ScaledProblem by a team. The table holds the start and then the best impulses, y what belongs to them.

    Returns the sweeps made and the natural map error of the best impulses.
    """
    smallest = error = measure_by_team(team, scaled, history.sums)
    impulses = impulses_of(scaled)
    copy_impulses(team, impulses, history.best)
    copy_impulses(team, impulses, history.p)
    first, end = share_of(team, 0, len(scaled.y))
    copy_flat(scaled.y[first:end], history.y[first:end])
    wait(team)  # the others sweep over what is copied here
    sweeps, weight, colours, state = 0, 1.0, np.arange(len(joints.colour) - 1), seeded(settings.seed)
    while smallest > settings.tolerance and sweeps < settings.limit:
        if not settings.extrapolated:
            shuffle(colours, state)
        sweep_by_team(team, scaled, joints, colours)
        sweeps += 1
        if sweeps % settings.every == 0 or sweeps == settings.limit:
            before, error = error, measure_by_team(team, scaled, history.sums)
            if error < smallest:
                smallest = error
                copy_impulses(team, impulses, history.best)
            if not error <= before:
                weight = 1.0
        if settings.extrapolated:
            last, weight = weight, 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * weight * weight))
            extrapolate(team, scaled, history, (last - 1.0) / weight)
    copy_impulses(team, history.best, impulses)
    wait(team)
    measure_by_team(team, scaled, history.sums)  # and y with it
    return sweeps, smallest


@kernel()
def sweep_by_team(team, scaled, joints, colours):
    """One sweep over the colours in an order. Joints of one share no body that moves, but for the last, whose joints one thread takes."""
    for colour in colours:
        first, end = joints.colour[colour], joints.colour[colour + 1]
        if first == end:
            continue
        if colour < len(joints.colour) - 2:
            first, end = share_of(team, first, end)
        elif team.rank > 0:
            first = end
        sweep(scaled, joints.start, joints.order[first:end])
        wait(team)


@kernel()
def measure_by_team(team, scaled, sums):
    """Set y of a ScaledProblem again; returns the natural map error of its impulses."""
    first, end = share_of(team, 0, len(scaled.factor))
    collect(scaled, first, end)
    wait(team)
    first, end = share_of(team, 0, PARTS)
    for part in range(first, end):
        begin, stop = part_of(part, len(scaled.table))
        sums[part] = squared_map_norm_of(scaled.problem, impulses_of(scaled), scaled.y, begin, stop)
    wait(team)
    residual = sums.sum()
    wait(team)
    return error_of(residual, scaled.size)


@borrower()
def extrapolate(team, scaled, history, factor):
    """p + factor (p - that of the last sweep), into the table, and likewise y; the last sweep's are replaced by this one's."""
    law, (first, end) = scaled.table, share_of(team, 0, len(scaled.table))
    for c in range(first, end):
        for i in range(history.p.shape[1]):
            new = law[c, P + i]
            law[c, P + i] = new + factor * (new - history.p[c, i])
            history.p[c, i] = new
    first, end = share_of(team, 0, len(scaled.y))
    for b in range(first, end):
        for k in range(scaled.y.shape[1]):
            new = scaled.y[b, k]
            scaled.y[b, k] = new + factor * (new - history.y[b, k])
            history.y[b, k] = new
    wait(team)


@borrower()
def copy_impulses(team, source, target):
    """The thread's share of target = source, both (C, m)."""
    first, end = share_of(team, 0, len(source))
    for c in range(first, end):
        for i in range(source.shape[1]):
            target[c, i] = source[c, i]


@entry()
def end_sweeps(scaled: ScaledProblem, v_free: np.ndarray, p: np.ndarray, v: np.ndarray) -> None:
    """The answer of a ScaledProblem: its impulses p (C, m), and v = v_free + L y (B, n)."""
    table, factor, y = scaled.table, scaled.factor, scaled.y
    for c in range(len(p)):
        for i in range(p.shape[1]):
            p[c, i] = table[c, P + i]
    for body in range(v.shape[0]):
        for i in range(v.shape[1]):
            total = v_free[body, i]
            for k in range(i + 1):
                total += factor[body, i, k] * y[body, k]
            v[body, i] = total
