"""Accelerated sweeps of Gauss-Seidel by a team of threads; see accelerated.py for the method.

Each thread sweeps its share of the joints of a colour, and they wait for one another between colours. Sums are taken over parts of the
contacts, in their order, so the number of threads changes no bit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry, kernel
from masonry_cd.mechanics.friction.coulomb_law import P
from masonry_cd.mechanics.friction.local_operators import LocalArrays, local_residual
from masonry_cd.mechanics.linalg.small_blocks import copy_flat
from masonry_cd.mechanics.linalg.threads import ThreadTeam, share_of, wait
from masonry_cd.mechanics.solvers.local_kernels import local_table, sweep_local
from masonry_cd.mechanics.solvers.nlgs_kernels import COLOURS, ColouredJoints
from masonry_cd.mechanics.solvers.nlgs_sweep import sweep
from masonry_cd.mechanics.solvers.nlgs_table import ScaledProblem, error_of, squared_residuals_of

AHEAD = 4  # joints of one colour that are fetched ahead
PARTS = 64  # of the contacts, whose sums are added in their order


class AcceleratedSettings(NamedTuple):
    """When to stop."""

    tolerance: float  # natural map error
    limit: int  # sweeps
    every: int  # sweeps between two measurements of the error


class SweepHistory(NamedTuple):
    """What the extrapolation and the answer need beside the table."""

    p: np.ndarray  # (C, m) impulses after the last sweep
    y: np.ndarray  # (B + 1, n) G^T p of them
    best: np.ndarray  # (C, m) impulses of the smallest error
    sums: np.ndarray  # (PARTS, 2) squared norms of the residual and of q


@entry()
def accelerated_bodies(
    team: ThreadTeam, scaled: ScaledProblem, joints: ColouredJoints, history: SweepHistory, settings: AcceleratedSettings
) -> tuple[int, float]:
    """Accelerated sweeps over a ScaledProblem by a team. The table holds the start and then the best impulses, y what belongs to them.

    Returns the sweeps made and the natural map error of the best impulses.
    """
    smallest = error = measure_by_team(team, scaled, joints, history.sums)
    keep(team, scaled, history.best)
    keep(team, scaled, history.p)
    first, end = share_of(team, 0, len(scaled.y))
    copy_flat(scaled.y[first:end], history.y[first:end])
    wait(team)  # the others sweep over what is copied here
    sweeps, weight = 0, 1.0
    while smallest > settings.tolerance and sweeps < settings.limit:
        sweep_by_team(team, scaled, joints)
        sweeps += 1
        if sweeps % settings.every == 0 or sweeps == settings.limit:
            before, error = error, measure_by_team(team, scaled, joints, history.sums)
            if error < smallest:
                smallest = error
                keep(team, scaled, history.best)
            if not error <= before:
                weight = 1.0
        weight, factor = next_weight(weight)
        extrapolate(team, scaled, history, factor)
    restore(team, scaled, history.best)
    measure_by_team(team, scaled, joints, history.sums)  # and y with it
    return sweeps, smallest


@kernel(inline="always")
def next_weight(weight):
    """Nesterov's next weight, and the share of the last step by which the impulses are extrapolated."""
    after = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * weight * weight))
    return after, (weight - 1.0) / after


@kernel()
def sweep_by_team(team, scaled, joints):
    """One sweep, colour by colour. Joints of a colour share no body that moves, but for the last colour, whose joints one thread takes."""
    for colour in range(COLOURS):
        low, high = joints.colour[colour], joints.colour[colour + 1]
        if low == high:
            continue
        first, end = share_of_colour(team, colour, low, high)
        sweep(scaled.jacobian, scaled.y, scaled.bodies, scaled.table, joints.start, joints.order[first:end], AHEAD)
        wait(team)


@kernel(inline="always")
def share_of_colour(team, colour, low, high):
    """First and end of the thread's share of the joints low to high of a colour."""
    if colour < COLOURS - 1:
        return share_of(team, low, high)
    return (low, high) if team.rank == 0 else (low, low)


@kernel()
def measure_by_team(team, scaled, joints, sums):
    """Set y = G^T p of a ScaledProblem anew; returns the natural map error of its impulses."""
    rows, contacts = len(scaled.y), len(scaled.table)
    first, end = share_of(team, 0, rows)
    scaled.y[first:end] = 0.0
    wait(team)
    for colour in range(COLOURS):
        low, high = joints.colour[colour], joints.colour[colour + 1]
        if low < high:
            first, end = share_of_colour(team, colour, low, high)
            collect_joints(scaled, joints, first, end)
            wait(team)
    first, end = share_of(team, 0, PARTS)
    for part in range(first, end):
        begin, stop = contacts * part // PARTS, contacts * (part + 1) // PARTS
        sums[part, 0], sums[part, 1] = squared_residuals_of(scaled.jacobian, scaled.y, scaled.bodies, scaled.table, begin, stop)
    wait(team)
    residual, size = sums[:, 0].sum(), sums[:, 1].sum()
    wait(team)
    return error_of(residual, size)


@borrower()
def collect_joints(scaled, joints, first, end):
    """y += G^T p of the joints first to end in the order of the colours."""
    g, y, index, law = scaled.jacobian, scaled.y, scaled.bodies, scaled.table
    m, n = g.shape[2], g.shape[3]
    for place in range(first, end):
        joint = joints.order[place]
        for c in range(joints.start[joint], joints.start[joint + 1]):
            for side in range(2):
                body = index[c, side]
                for i in range(m):
                    for k in range(n):
                        y[body, k] += g[c, side, i, k] * law[c, P + i]


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
def keep(team, scaled, out):
    """Copy the impulses of the table into ``out`` (C, m)."""
    first, end = share_of(team, 0, len(out))
    for c in range(first, end):
        for i in range(out.shape[1]):
            out[c, i] = scaled.table[c, P + i]


@borrower()
def restore(team, scaled, p):
    """Copy impulses p (C, m) into the table."""
    first, end = share_of(team, 0, len(p))
    for c in range(first, end):
        for i in range(p.shape[1]):
            scaled.table[c, P + i] = p[c, i]
    wait(team)


@entry()
def accelerated_local(problem: LocalArrays, own: np.ndarray, p: np.ndarray, settings: AcceleratedSettings) -> tuple[int, float]:
    """Accelerated sweeps over a LocalProblem whose diagonal blocks are ``own`` (C, m, m). p (C, m) holds the start and then the answer.

    Returns the sweeps made and the natural map error of the answer.
    """
    data, indices, indptr, q, mu = problem.data, problem.indices, problem.indptr, problem.q, problem.mu
    law, order, last, best = local_table(own, mu), np.arange(len(p)), p.copy(), p.copy()
    smallest = error = local_residual(data, indices, indptr, q, mu, p, law)
    sweeps, weight = 0, 1.0
    while smallest > settings.tolerance and sweeps < settings.limit:
        sweep_local(problem, law, order, p)
        sweeps += 1
        if sweeps % settings.every == 0 or sweeps == settings.limit:
            before, error = error, local_residual(data, indices, indptr, q, mu, p, law)
            if error < smallest:
                smallest = error
                copy_flat(p, best)
            if not error <= before:
                weight = 1.0
        weight, factor = next_weight(weight)
        for c in range(len(p)):
            for i in range(p.shape[1]):
                new = p[c, i]
                p[c, i] = new + factor * (new - last[c, i])
                last[c, i] = new
    copy_flat(best, p)
    return sweeps, smallest
